"""Sweeps over parameters on any executor, with persistent stores: bifurcation diagrams, grids and designs."""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
