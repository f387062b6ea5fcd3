"""Live page of a mechanism: declared numbers and choices, runs in a thread, a server on this machine alone.

In: a mechanism or a function that returns one. Out: a page whose sliders run it anew.
"""
