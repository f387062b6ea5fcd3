"""Couplings of rotations and travels: gears, racks, belts, any linear relation, rods, cables, clutches."""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
