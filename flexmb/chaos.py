"""Tools for chaos: Lyapunov exponents, Poincare sections, periodic orbits, basins, verdicts, analysis of signals."""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
