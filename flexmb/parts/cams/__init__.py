"""Cams: curves and outlines of bodies, lift laws, pairs that touch along them.

In: points or lift laws. Out: curves as numbers of kernels, constraints, gap kernels of pairs.
"""
