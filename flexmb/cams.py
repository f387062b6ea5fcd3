"""Cams: curves of bodies, lift laws, pairs that touch along curves."""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__, former={"Circle": ("CircularCurve", "0.3")})
