"""Compilation: records passed as one pointer, functions optimised as a whole, caches of machine code."""
