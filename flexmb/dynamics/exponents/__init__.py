"""Lyapunov exponents from tangent vectors or from two trajectories, with their errors."""
