"""Equilibria and linear analyses: statics, modes, buckling, steady rotation, inverse dynamics.

In: a mechanism or its program. Out: records with positions, forces, frequencies, load factors. No step is taken.
"""
