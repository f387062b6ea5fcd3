"""`flexmb check`: examination of a mechanism without simulation."""

from __future__ import annotations

from flexmb.doctor.check import check
from flexmb.model.mechanism import Mechanism

SOUND, WRONG = 0, 1
"""Exit codes: no error among the findings, at least one error."""


def check_mechanism(mechanism: Mechanism, *, as_json: bool = False) -> int:
    """Print degrees of freedom, mass, natural frequencies and all findings.

    Parameters
    ----------
    mechanism : the mechanism.
    as_json : whether the output is JSON.

    Returns
    -------
    int : exit code: 0 without errors among the findings, else 1.
    """
    report = check(mechanism)
    print(report.to_json() if as_json else report)
    return SOUND if report.ok else WRONG
