"""Examination of mechanisms: findings on structure, loops, dimensions, motions, laws and loads."""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
