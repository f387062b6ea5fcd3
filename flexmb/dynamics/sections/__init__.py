"""Sections of flows: stroboscopic maps, and Poincare maps at the crossings of a level.

In: a flow. Out: maps, and their points as labelled tables.
"""
