"""Runs: simulation of a mechanism, at once or step by step.

In: a mechanism, a span, a method. Out: a `Solution`; checkpoints from which a run goes on with the same bits.
"""
