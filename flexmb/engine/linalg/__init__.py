"""Linear algebra: factors on a fixed pattern, their elimination order, solvers for small and large matrices, rank.

In: patterns and values. Out: factors, solutions, ranks. It knows nothing of mechanics.
"""
