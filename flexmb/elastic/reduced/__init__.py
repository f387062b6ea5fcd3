"""Bodies by few coordinates: Craig-Bampton bases, the element that they make, loads, accuracy.

In: a body of beams or a plane body. Out: one element with the coordinates of pins and modes, and its stresses.
"""
