"""Plane meshes: cells, boundary, files, meshes of common outlines.

In: outlines or files. Out: `PlaneMesh`, checked. A mesh knows no material and no body.
"""
