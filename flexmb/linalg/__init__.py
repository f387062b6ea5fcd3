"""Linear algebra: factors on a fixed pattern, their elimination order, solvers for small and large matrices."""
