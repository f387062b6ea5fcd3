"""Declarations: parts, laws, mechanisms, and the records by which parts describe themselves."""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
