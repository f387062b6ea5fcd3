"""Method of Dormand and Prince of order 8(5,3): explicit, for smooth motion to many digits.

In: an accepted state, a step. Out: a trial state with its error estimate, and states within the step.
"""
