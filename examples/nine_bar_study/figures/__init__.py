"""Kinds of figures of a study: comparison, laws, path, phase, section, exponent, bifurcation."""
