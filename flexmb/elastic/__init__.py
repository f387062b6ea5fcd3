"""Deformable bodies: beams, plane meshes, bodies by few coordinates.

In: sections, materials, meshes. Out: element matrices, kernels of elements, stresses. Weak forms are assembled by
scikit-fem when a program is compiled, never within a step.
"""
