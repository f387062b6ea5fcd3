"""`flexmb check`: examination of a mechanism without simulation."""

from __future__ import annotations

import argparse

from flexmb.commands.arguments.units import quantity
from flexmb.doctor.check import check as examined
from flexmb.model.mechanism import Mechanism

SOUND, WRONG = 0, 1
"""Exit statuses: no error among the findings, at least one error."""


def check(mechanism: Mechanism, name: str, options: argparse.Namespace) -> int:
    """`flexmb check`: print degrees of freedom, mass, natural frequencies and all findings.

    Returns 0 without errors among the findings, else 1.  `name` is for files, of which there are none.
    """
    report = examined(mechanism, None if options.step is None else quantity(options.step, "s", "--step"))
    print(report.to_json() if options.json else report)
    return SOUND if report.ok else WRONG
