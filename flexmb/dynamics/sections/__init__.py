"""Sections of flows: once a period, or at the crossings of a level."""
