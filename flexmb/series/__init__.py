"""Analysis of one sampled signal: spectrum, embedding, dimension, exponents, recurrence, 0-1 test."""
