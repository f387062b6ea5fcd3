"""Bodies: rigid bodies and links, particles, flexible links and frames.

In: masses, points, sections. Out: nodes, elements, shapes. Beams' matrices come from `elastic.beams`.
"""
