"""Design: derivatives by parameters, fits to measurements, better designs, tolerances.

In: a mechanism, or a function that returns one, and numbers of it. Out: what these numbers do to signals.
"""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
