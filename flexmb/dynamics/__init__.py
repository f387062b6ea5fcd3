"""Flows and maps: sections, Lyapunov exponents, periodic orbits, basins of attraction, verdicts on motions."""
