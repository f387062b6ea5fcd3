"""Radau's method of order 5 (Radau IIA, three stages).

In: an accepted state, a step. Out: a trial state with its error estimate, and states within the step.
"""
