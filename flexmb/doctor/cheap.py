"""The part of the examination that costs next to nothing: laws and motions of users, tables, linear cells, numbers."""

from __future__ import annotations

import sys

from flexmb.doctor.finding import Finding
from flexmb.doctor.implausible import implausible_findings
from flexmb.model.law import FrictionLaw, Law, Motion, NormalLaw
from flexmb.model.mechanism import Mechanism

REMEMBERED = 512
"""Number of laws whose findings are remembered: a sweep declares the same ones again and again."""

TRIED_GAP = 1e-4
"""Size of the gaps at which normal laws are tried [m]."""

_TRIED: dict[type, bool] = {}
"""Whether values of a class are tried."""

_KNOWN: dict[tuple[str, Law], tuple[Finding, ...]] = {}
"""Findings by part and law."""


def cheap_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on users' laws and motions, on tables, linear cells, and on implausible speeds and angles.

    flexmb's own laws are known to keep their signs.
    """
    findings = implausible_findings(mechanism)
    for part in mechanism.parts:
        for value in vars(part).values():
            kind = type(value)
            if kind not in _TRIED:
                _TRIED[kind] = _is_tried(kind)
            if _TRIED[kind]:
                findings += _remembered(part.name, value)
    if "flexmb.planes.plane_body" in sys.modules:  # no body has a mesh before it is imported, which takes long
        from flexmb.doctor.coarse_cells import coarse_cells

        findings += coarse_cells(mechanism)
    return findings


def _is_tried(kind: type) -> bool:
    """Whether a class is one of tables, or of laws and motions that are not flexmb's own."""
    if not issubclass(kind, Law):
        return False
    ours = kind.kernel.function.__module__.partition(".")[0] == "flexmb"
    return not ours or kind.__module__ == "flexmb.drives.table"


def _remembered(name: str, law: Law) -> tuple[Finding, ...]:
    """Findings on a law; of a law with arrays they are not remembered."""
    try:
        found = _KNOWN.get((name, law))
    except TypeError:
        return _of_law(name, law)
    if found is None:
        if len(_KNOWN) >= REMEMBERED:
            _KNOWN.clear()
        found = _KNOWN[name, law] = _of_law(name, law)
    return found


def _of_law(name: str, law: Law) -> tuple[Finding, ...]:
    """Findings on one law or motion of a part."""
    from flexmb.doctor.laws import friction_sign, normal_sign
    from flexmb.doctor.motions import overshoot, wrong_rates
    from flexmb.drives.table import Table

    if isinstance(law, Table):
        return tuple(overshoot(name, law))
    if isinstance(law, Motion):
        return tuple(wrong_rates(name, law))
    if isinstance(law, NormalLaw):
        return tuple(normal_sign(name, law, TRIED_GAP))
    return tuple(friction_sign(name, law)) if isinstance(law, FrictionLaw) else ()
