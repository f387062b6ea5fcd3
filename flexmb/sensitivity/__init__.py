"""Small differences of a state, carried through the steps of a run."""
