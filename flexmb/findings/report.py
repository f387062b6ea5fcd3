"""Report on a mechanism: degrees of freedom, mass, natural frequencies, and all findings."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from typing import Any

from flexmb import display
from flexmb.display import counted, cut
from flexmb.findings.finding import ERROR, SEVERITIES, Finding

LISTED_PARTS = 30
"""Number of parts at most whose signals are printed."""


@dataclass(frozen=True)
class Report:
    """Result of `check`; `print(report)` shows a small table.

    Numbers are 0 and names empty where a mechanism is too wrong to compute them.

    Parameters
    ----------
    name : the mechanism.
    findings : errors, warnings and notes, in this order.
    bodies, joints, contacts : names.
    coordinates : number of coordinates.
    rows : number of constraint rows, drives included.
    freedom : degrees of freedom of the bodies taken as rigid, clearance joints as ideal, without the drives.
    gruebler : degrees of freedom by the count of Gruebler: 3 for each body, less the constraint rows of the joints.
    drives : names of the drives.
    free : degrees of freedom that the drives leave.
    redundant : joints that repeat what others say.
    mass : total mass [kg].
    frequencies : lowest natural frequencies [Hz] in the reference configuration, drives held fast.
    signals : full names of all signals that a run reports.
    """

    name: str
    findings: tuple[Finding, ...] = ()
    bodies: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    contacts: tuple[str, ...] = ()
    coordinates: int = 0
    rows: int = 0
    freedom: int = 0
    gruebler: int = 0
    drives: tuple[str, ...] = ()
    free: int = 0
    redundant: tuple[str, ...] = ()
    mass: float = 0.0
    frequencies: tuple[float, ...] = ()
    signals: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether there is no error among the findings."""
        return all(finding.severity != ERROR for finding in self.findings)

    def of(self, *codes: str) -> tuple[Finding, ...]:
        """Findings with one of these codes."""
        return tuple(finding for finding in self.findings if finding.code in codes)

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {**asdict(self), "ok": self.ok, "findings": [finding.as_dict() for finding in self.findings]}

    def to_json(self) -> str:
        """The report as JSON text; keys are the names of the fields, and "ok"."""
        return json.dumps(self.as_dict(), indent=2)

    def _measured(self) -> list[tuple[str, list[str]]]:
        """Signals of joints, loads and other parts by name of the part."""
        found: dict[str, list[str]] = {}
        for part, _, signal in (name.rpartition(".") for name in self.signals):
            if part.partition(".")[0] not in self.bodies:
                found.setdefault(part, []).append(signal)
        shown = list(found.items())[:LISTED_PARTS]
        return [*shown, *([("...", [f"{len(found) - LISTED_PARTS} more parts"])] if len(found) > LISTED_PARTS else [])]

    def __repr__(self) -> str:
        sizes = f"{counted(len(self.bodies), 'body')}, {counted(self.freedom, 'degree')} of freedom, {self.free} free, "
        sizes += f"{self.mass:.6g} kg"
        return cut(f"Report on {self.name!r}: {_counted(self.findings)}; {sizes}")

    def _repr_html_(self) -> str:
        rows = [(f.severity, f.code, f.text, f.remedy) for f in self.findings]
        head = ("severity", "code", "finding", "remedy")
        details = display.folded("bodies, joints, signals", display.texts(str(replace(self, findings=())).splitlines()))
        return display.page(*repr(self).split(": ", 1), display.table(rows, head), details)

    def __str__(self) -> str:
        """A small table, and the findings."""
        lines = [
            f"Mechanism {self.name!r}: {_counted(self.findings)}",
            f"  bodies              {len(self.bodies)}: {_list(self.bodies)}",
            f"  mass                {self.mass:.6g} kg",
            f"  ideal joints        {len(self.joints)}: {_list(self.joints)}",
            f"  clearance joints    {len(self.contacts)}: {_list(self.contacts)}",
            f"  equations           {self.coordinates} coordinates, {self.rows} constraint rows",
            f"  degrees of freedom  {self.freedom} (rigid bodies, clearances closed; by Gruebler's count"
            f" {self.gruebler}), {len(self.drives)} driven{': ' + _list(self.drives) if self.drives else ''},"
            f" {self.free} free",
            f"  redundant joints    {_list(self.redundant) if self.redundant else 'none'}",
            f"  frequencies [Hz]    {', '.join(f'{f:.4g}' for f in self.frequencies) or 'none (nothing can vibrate)'}",
            f"  signals             {len(self.signals)}: {MOTION} of bodies and nodes;",
            *(f"    {part}: {', '.join(names)}" for part, names in self._measured()),
        ]
        return "\n".join([*(lines if self.bodies else lines[:1]), *(f"  {finding}" for finding in self.findings)])


MOTION = "x, y, theta, vx, vy, omega, ax, ay, alpha"
"""Signals of every body, and of every node of a flexible body."""


def _counted(findings: tuple[Finding, ...]) -> str:
    """Numbers of errors, warnings and notes in words."""
    counts = {severity: sum(f.severity == severity for f in findings) for severity in SEVERITIES}
    texts = [f"{count} {severity}{'' if count == 1 else 's'}" for severity, count in counts.items() if count]
    return ", ".join(texts) or "nothing to remark"


def _list(names: tuple[str, ...]) -> str:
    return ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
