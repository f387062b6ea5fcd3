"""Radau's method of order 5 (Radau IIA, three stages)."""
