"""Results of a run: signals, contact intervals, momenta, remarks, status, netCDF and VTK files."""
