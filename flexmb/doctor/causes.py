"""Known causes of a run that failed, among the findings of the examination."""

from __future__ import annotations

from flexmb.doctor.finding import CODES, ERROR, Finding
from flexmb.doctor.laws import kernel_findings, law_findings
from flexmb.doctor.loops import locking_drives
from flexmb.doctor.motions import motion_findings
from flexmb.errors import FlexmbError
from flexmb.model.mechanism import Mechanism
from flexmb.program.program import Program
from flexmb.start.assemble import close_loops

MOST_CAUSES = 3
"""Number of causes in a status at most."""


def causes_of_failure(mechanism: Mechanism, closed: Program) -> tuple[Finding, ...]:
    """Findings that can end a run: motions that are not finite or jump, laws that pull or drive, loops that lock.

    Kernels of the user are compared with their contracts, since wrong tangents keep Newton from converging.  `closed`
    has ideal joints for contacts and elastic joints.
    """
    findings = [*motion_findings(mechanism), *law_findings(mechanism)]
    known = {name for finding in findings for name in finding.parts}
    findings += kernel_findings(mechanism, known)
    if not findings:
        try:
            findings = locking_drives(mechanism, closed, close_loops(closed, {})[0])
        except FlexmbError:
            findings = []
    return tuple(finding for finding in findings if CODES[finding.code][0] == ERROR)[:MOST_CAUSES]
