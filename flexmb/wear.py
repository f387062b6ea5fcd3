"""Joints that wear, their laws, and the wear of a run."""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
