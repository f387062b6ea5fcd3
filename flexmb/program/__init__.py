"""Compiler of mechanisms: numbering, packing, check of kernels, names, tables.

In: contributions of parts. Out: a `Program`, with numbered coordinates, packed tables, names, kernels. It knows
contracts of kernels, and no class of parts.
"""
