"""Cams: curves of bodies, lift laws, pairs that touch along curves.

In: points or lift laws. Out: curves as numbers of kernels, constraints, gap kernels of pairs.
"""
