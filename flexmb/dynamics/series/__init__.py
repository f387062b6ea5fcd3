"""Analysis of one sampled signal: spectrum, embedding, dimension, exponents, recurrence, 0-1 test.

In: a sampled signal, whatever it comes from. Out: records with errors, or the reason why there is no number.
"""
