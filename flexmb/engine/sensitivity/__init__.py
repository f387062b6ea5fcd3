"""Small differences of a state, carried through the steps of a run.

In: the steps of a run, differences of its start. Out: differences after each step, for exponents and orbits.
"""
