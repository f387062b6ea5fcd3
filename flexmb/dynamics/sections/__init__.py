"""Sections of flows: stroboscopic maps, and Poincare maps at the crossings of a level."""
