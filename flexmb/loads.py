"""Loads and springs: forces at points, on edges and in bodies, torques, springs."""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
