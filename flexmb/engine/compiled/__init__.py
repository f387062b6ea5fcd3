"""Compilation: records passed as one pointer, functions optimised as a whole, caches of machine code.

In: Python functions. Out: machine code, and notices while it is made. Private names of numba are in `pieces.py`.
"""
