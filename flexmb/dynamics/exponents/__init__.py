"""Lyapunov exponents from tangent vectors or from two trajectories, with their errors.

In: a flow or map. Out: records with values, errors, history, verdict.
"""
