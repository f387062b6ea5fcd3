"""Loads and springs: forces at points, on edges and in bodies, torques, springs.

In: bodies, points, histories. Out: elements, and nodal forces on meshes (`elastic.planes`, `elastic.reduced`).
"""
