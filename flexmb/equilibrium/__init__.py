"""Equilibria and what is linear about them: statics, modes, buckling, steady rotation, inverse dynamics."""
