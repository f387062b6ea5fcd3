"""Flows and maps: sections, Lyapunov exponents, periodic orbits, basins of attraction, verdicts on motions.

In: mechanisms, equations, signals. Out: points, exponents, orbits, basins, verdicts with their evidence. What is made
of a mechanism is a flow first (`systems`); nothing else here knows its parts.
"""
