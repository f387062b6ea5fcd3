"""Periodic orbits by multiple shooting, their Floquet multipliers, and their continuation along a parameter."""
