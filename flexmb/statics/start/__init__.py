"""Start values: closed loops; consistent positions, velocities, accelerations and multipliers.

In: a program, poses as declared. Out: a state that fulfils all constraints with their rates.
"""
