"""Cams: curves of bodies, lift laws, pairs that touch along curves."""

from typing import Any
from warnings import warn

from flexmb.namespace import lazy_names

_public, __dir__, __all__ = lazy_names(__name__, __file__)


def __getattr__(name: str) -> Any:
    if name == "Circle":  # until version 0.2
        warn("cams.Circle is called cams.CircularCurve; fm.Circle is a beam section.", DeprecationWarning, stacklevel=2)
        name = "CircularCurve"
    return _public(name)
