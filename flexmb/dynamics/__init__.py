"""Flows and maps, their sections, exponents, periodic orbits, and what signals say of them."""
