"""Equilibria and linear analyses: statics, modes, buckling, steady rotation, inverse dynamics."""
