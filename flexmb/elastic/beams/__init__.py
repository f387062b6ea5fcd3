"""Beams: sections, element matrices from weak forms, line meshes, the corotational element, stresses.

In: sections, materials, poses of ends. Out: matrices, kernels, stresses along the axis.
"""
