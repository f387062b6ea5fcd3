"""Periodic orbits by shooting, their multipliers, and branches of them along a parameter."""
