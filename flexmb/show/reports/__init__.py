"""Reports: one HTML page with the moving mechanism, plots, tables and checks of a run, a diagram or a motion.

In: solutions, data sets. Out: one file without access to a network; Python writes the data, `assets/` show them.
"""
