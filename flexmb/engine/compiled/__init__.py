"""Compilation: records passed as one pointer, functions optimised as a whole, caches of machine code.

In: Python functions. Out: machine code, and notices while it is made. What rests on private names of numba is
`pieces.py`.
"""
