"""Pages of the nine-bar study: convergence, exponents, sensitivity, threshold."""
