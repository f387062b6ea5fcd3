"""Solvers at one state: linear systems, closing of loops, start values, statics, modes, inverse dynamics."""
