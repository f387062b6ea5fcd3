"""The compiled engine: everything that runs within a step.

In: a `Program`. Out: accepted states, saved rows, counters. It knows tables, kernels and addresses, and no part.
"""
