"""Results of a run: signals, contact intervals, momenta, remarks, status, netCDF and VTK files.

In: rows, peaks and status of a run. Out: a `Solution`, and what follows from it at any instant: positions, stresses,
lines to draw. No step is taken.
"""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
