"""Pictures and films of runs, diagrams, orbits and spectra.

In: solutions, mechanisms, data sets. Out: figures of matplotlib, windows of pyvista, GIF, MP4 and glTF files.
"""
