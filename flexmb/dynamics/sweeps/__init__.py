"""Sweeps over parameters on any executor, with persistent stores: bifurcation diagrams, grids and designs.

In: a function or a family of systems, values. Out: data sets; a store from which a stopped sweep goes on.
"""
