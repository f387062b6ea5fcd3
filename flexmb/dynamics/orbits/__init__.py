"""Periodic orbits by multiple shooting, their Floquet multipliers, and their continuation along a parameter.

In: a flow or map, a start. Out: orbits, branches, events.
"""
