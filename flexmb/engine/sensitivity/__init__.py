"""Small differences of a state, carried through the steps of a run.

In: the steps of a run, differences of its start or by parameters. Out: differences after each step, for exponents,
orbits, derivatives. `tangent_step` carries them through a step and an onset, `parameter_run` through a run.
"""
