"""Compiler of mechanisms: numbering, packing, check of kernels, names, tables."""
