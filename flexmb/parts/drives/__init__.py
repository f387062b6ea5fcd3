"""Drives: prescribed motion of a joint, by formulas or by points in time.

In: speeds, tables. Out: kernels s(t) with two derivatives, and the instants at which they jump.
"""
