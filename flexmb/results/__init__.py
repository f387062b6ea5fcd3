"""Results of a run: signals, contact intervals, momenta, remarks, status, netCDF and VTK files."""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
