"""Reports: one HTML page with the moving mechanism, plots, tables and checks of a run."""
