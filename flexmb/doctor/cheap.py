"""The part of the examination that costs next to nothing: kernels of users and tables, once a mechanism's laws."""

from __future__ import annotations

from functools import lru_cache

from flexmb.doctor.finding import Finding
from flexmb.doctor.laws import friction_sign, is_ours, normal_sign
from flexmb.doctor.motions import overshoot, wrong_rates
from flexmb.drives.table import Table
from flexmb.model.law import FrictionLaw, Law, Motion, NormalLaw
from flexmb.model.mechanism import Mechanism

REMEMBERED = 512
"""Number of laws whose findings are remembered: a sweep declares the same ones again and again."""

TRIED_GAP = 1e-4
"""Size of the gaps at which normal laws are tried [m]."""


def cheap_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on users' laws and motions, and on tables; flexmb's own laws are known to keep their signs.

    Parameters
    ----------
    mechanism : the mechanism.
    """
    findings: list[Finding] = []
    for part in mechanism.parts:
        for value in vars(part).values():
            if isinstance(value, Table) or (isinstance(value, Law) and not is_ours(value.kernel)):
                findings += _remembered(part.name, value)
    return findings


def _remembered(name: str, law: Law) -> tuple[Finding, ...]:
    """Findings on a law; of a law with arrays they are not remembered."""
    try:
        return _of_law(name, law)
    except TypeError:
        return _of_law.__wrapped__(name, law)


@lru_cache(maxsize=REMEMBERED)
def _of_law(name: str, law: Law) -> tuple[Finding, ...]:
    """Findings on one law or motion of a part."""
    if isinstance(law, Table):
        return tuple(overshoot(name, law))
    if isinstance(law, Motion):
        return tuple(wrong_rates(name, law))
    if isinstance(law, NormalLaw):
        return tuple(normal_sign(name, law, TRIED_GAP))
    return tuple(friction_sign(name, law)) if isinstance(law, FrictionLaw) else ()
