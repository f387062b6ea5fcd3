"""`flexmb check`: examination of a mechanism without simulation."""

from __future__ import annotations

from flexmb.commands.units import quantity
from flexmb.doctor.check import check
from flexmb.model.mechanism import Mechanism

SOUND, WRONG = 0, 1
"""Exit codes: no error among the findings, at least one error."""


def check_mechanism(mechanism: Mechanism, *, step: str | None = None, as_json: bool = False) -> int:
    """Print degrees of freedom, mass, natural frequencies and all findings.

    Parameters
    ----------
    mechanism : the mechanism.
    step : fixed step that a run is to take, with its unit; None: none.
    as_json : whether the output is JSON.

    Returns
    -------
    int : exit code: 0 without errors among the findings, else 1.
    """
    report = check(mechanism, None if step is None else quantity(step, "s", "--step"))
    print(report.to_json() if as_json else report)
    return SOUND if report.ok else WRONG
