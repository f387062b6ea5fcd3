"""Flexible bodies of any planar shape, by finite elements of plane stress or plane strain.

In: a mesh, a material, pins. Out: cells, constraints of pins, loads, stresses at nodes.
"""
