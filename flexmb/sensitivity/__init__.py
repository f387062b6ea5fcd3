"""Small differences of a state, carried through the very steps of a motion."""
