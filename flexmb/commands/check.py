"""`flexmb check`: examine a mechanism before it moves."""

from __future__ import annotations

from flexmb.doctor.check import check
from flexmb.model.mechanism import Mechanism

SOUND, WRONG = 0, 1
"""Exit codes: no errors among the findings, or some."""


def check_mechanism(mechanism: Mechanism, *, as_json: bool = False) -> int:
    """Print degrees of freedom, mass, natural frequencies and all findings.

    Parameters
    ----------
    mechanism : the mechanism.
    as_json : as JSON, for programs.

    Returns
    -------
    int : exit code: 0 without errors among the findings, else 1.
    """
    report = check(mechanism)
    print(report.to_json() if as_json else report)
    return SOUND if report.ok else WRONG
