"""Examination of a mechanism before it moves, and its report; known causes of failed runs."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import numpy as np

from flexmb import arguments, checks, display
from flexmb.display import counted, cut, listed
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import AssemblyError, FlexmbError, InputError, KernelError
from flexmb.fields import field, record
from flexmb.findings import loads, loops
from flexmb.findings.dimensions import dimension_findings
from flexmb.findings.finding import CODES, ERROR, NOTHING_MOVES, SEVERITIES, WHAT_MOVES, Finding, found
from flexmb.findings.laws import kernel_findings, law_findings, motion_findings, motions_by_part
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program
from flexmb.statics.modes import Modes, modes
from flexmb.statics.start import consistent
from flexmb.statics.start.consistent import check_massless, close_loops, redundancy

LISTED_PARTS = 30  # number of parts at most whose signals are printed


@record
class Report:
    """Result of `check`; `print(report)` shows a small table.

    Numbers are 0 and names empty where a mechanism is too wrong to compute them.
    """

    name: str = field("the mechanism")
    findings: tuple[Finding, ...] = field("errors, warnings and notes, in this order", default=())
    bodies: tuple[str, ...] = field("names of the bodies", default=())
    joints: tuple[str, ...] = field("names of the joints", default=())
    contacts: tuple[str, ...] = field("names of the contacts", default=())
    coordinates: int = field("number of coordinates", default=0)
    rows: int = field("number of constraint rows, drives included", default=0)
    freedom: int = field("degrees of freedom, all bodies rigid, joints ideal, without drives", default=0)
    gruebler: int = field("degrees of freedom by Gruebler: 3 a body, less the rows of the joints", default=0)
    drives: tuple[str, ...] = field("names of the drives", default=())
    free: int = field("degrees of freedom that the drives leave", default=0)
    redundant: tuple[str, ...] = field("joints that repeat what others say", default=())
    mass: float = field("total mass", "kg", default=0.0)
    frequencies: tuple[float, ...] = field("lowest natural frequencies [Hz], drives held fast", default=())
    signals: tuple[str, ...] = field("full names of all signals that a run reports", default=())

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
        signals: dict[str, list[str]] = {}  # of joints, loads and other parts by name of the part
        for part, _, signal in (name.rpartition(".") for name in self.signals):
            if part.partition(".")[0] not in self.bodies:
                signals.setdefault(part, []).append(signal)
        lines = [
            f"Mechanism {self.name!r}: {_counted(self.findings)}",
            f"  bodies              {len(self.bodies)}: {listed(self.bodies)}",
            f"  mass                {self.mass:.6g} kg",
            f"  ideal joints        {len(self.joints)}: {listed(self.joints)}",
            f"  clearance joints    {len(self.contacts)}: {listed(self.contacts)}",
            f"  equations           {self.coordinates} coordinates, {self.rows} constraint rows",
            f"  degrees of freedom  {self.freedom} (rigid bodies, clearances closed; by Gruebler's count"
            f" {self.gruebler}), {len(self.drives)} driven{': ' + listed(self.drives) if self.drives else ''},"
            f" {self.free} free",
            f"  redundant joints    {listed(self.redundant) if self.redundant else 'none'}",
            f"  frequencies [Hz]    {', '.join(f'{f:.4g}' for f in self.frequencies) or 'none (nothing can vibrate)'}",
            f"  signals             {len(self.signals)}: {MOTION} of bodies and nodes;",
            *(f"    {part}: {', '.join(names)}" for part, names in list(signals.items())[:LISTED_PARTS]),
        ]
        lines += [f"    ...: {len(signals) - LISTED_PARTS} more parts"] if len(signals) > LISTED_PARTS else []
        return "\n".join([*(lines if self.bodies else lines[:1]), *(f"  {finding}" for finding in self.findings)])


MOTION = "x, y, theta, vx, vy, omega, ax, ay, alpha"  # signals of every body, and of every node of a flexible body


def _counted(findings: tuple[Finding, ...]) -> str:
    """Numbers of errors, warnings and notes in words."""
    counts = {severity: sum(f.severity == severity for f in findings) for severity in SEVERITIES}
    return ", ".join(counted(count, severity) for severity, count in counts.items() if count) or "nothing to remark"


MOST_CAUSES = 3  # number of causes in a status at most


def causes_of_failure(mechanism: Mechanism, closed: Program) -> tuple[Finding, ...]:
    """Findings that can end a run: motions that are not finite or jump, laws that pull or drive, loops that lock."""
    # Kernels of the user are compared with their contracts, since wrong tangents keep Newton from converging. `closed`
    # has ideal joints for contacts and elastic joints.
    findings = [*motion_findings(mechanism), *law_findings(mechanism)]
    findings += kernel_findings(mechanism, {name for finding in findings for name in finding.parts})
    if not findings:
        try:
            findings = loops.locking_drives(mechanism, closed, close_loops(closed, {})[0])
        except FlexmbError:
            findings = []
    return tuple(finding for finding in findings if CODES[finding.code][0] == ERROR)[:MOST_CAUSES]


LISTED_FREQUENCIES = 10  # number of natural frequencies in a report


@arguments.checked
def check(mechanism: Mechanism, step: float | None = None) -> Report:
    """Examine a mechanism before it moves.

    Structure (bodies that hang on nothing, joints that repeat or contradict one another, drives too many, dead
    centres), loops along a period of the drives, dimensions and units, laws, drives and kernels, loads at rest.

    Parameters
    ----------
    mechanism : the mechanism.
    step : fixed step that a run is to take [s]: contacts and vibrations that it would not resolve are told; None: none.

    Returns
    -------
    Report : `ok` is False where a run would be refused or could not be right; `findings` holds all findings at once,
        each with code, parts, text and remedy.

    Raises
    ------
    InputError : something that is no mechanism; a step that is not > 0.
    """
    if not isinstance(mechanism, Mechanism):
        raise InputError(f"check: {mechanism!r} is not a Mechanism.")
    h = None if step is None else checks.positive("check", "step", step, "s")
    with np.errstate(all="ignore"):  # numbers beyond all bounds become findings
        return _examined(mechanism, h)


def _examined(mechanism: Mechanism, step: float | None) -> Report:
    """Report on a mechanism, and on a fixed step [s]."""
    findings = [*loops.free_bodies(mechanism), *loops.left_out_links(mechanism), *dimension_findings(mechanism)]
    findings += [*motion_findings(mechanism), *_attempt(mechanism, law_findings)]
    try:
        moving, ideal = compile_mechanism(mechanism), compile_mechanism(mechanism, closed=True)
        closed = compile_mechanism(mechanism, start=True)
    except FlexmbError as error:
        return Report(mechanism.name, sorted_findings([*findings, of_error("not-compilable", error, mechanism)]))
    named = {name for finding in findings if finding.severity == ERROR for name in finding.parts}
    findings += _attempt(mechanism, partial(kernel_findings, known=named))
    try:
        StateEvaluation(moving).at(moving.reference.q)  # compiles the kernels
        q, _ = close_loops(closed, {})
    except KernelError as error:  # a kernel that numba does not take
        more = [] if _is_broken(findings) else [of_error("not-compilable", error, mechanism)]
        return Report(mechanism.name, sorted_findings([*findings, *more]))
    except AssemblyError as error:
        q = np.array(ideal.reference.q)
        findings += [*loops.open_loops(closed, error), *_without_closing(mechanism, moving, ideal, q)]
        return Report(mechanism.name, sorted_findings(findings), **_numbers(moving, ideal, q, ()))
    structure = loops.redundancies(moving, ideal, q)
    findings += [*structure, *loops.other_branch(closed, q)]
    found_modes, more = _modes(mechanism)
    findings += more
    numbers = _numbers(moving, ideal, q, tuple(float(f) for f in found_modes.frequencies) if found_modes else ())
    findings += loops.free_motions(ideal, q)
    if not any(finding.severity == ERROR for finding in structure):
        start = start_findings(mechanism, moving, closed, q)
        findings += [f for f in start if f.code == "forbidden-velocity" or not _is_broken(findings)]
        findings += [] if structure else loops.locking_drives(mechanism, closed, q)
        findings += loads.load_findings(mechanism, int(numbers["free"]))
        findings += loads.stability_findings(mechanism, ideal, q, found_modes)
        findings += [] if _is_broken(findings) else loads.loop_findings(mechanism, moving, q)
        findings += [] if step is None else loads.step_findings(mechanism, ideal, closed, q, step)
    findings += loads.stiffness_findings(mechanism, ideal, q, found_modes)
    return Report(mechanism.name, sorted_findings(findings), **numbers)


def _is_broken(findings: list[Finding]) -> bool:
    """Presence of a broken kernel among findings, which would make other findings of its numbers."""
    return any(finding.code == "broken-kernel" for finding in findings)


def _attempt(mechanism: Mechanism, examine: Callable[[Mechanism], list[Finding]]) -> list[Finding]:
    """Findings of an examination; one that fails is a finding, too."""
    try:
        return examine(mechanism)
    except FlexmbError as error:
        return [of_error("not-compilable", error, mechanism)]


def of_error(code: str, error: FlexmbError, mechanism: Mechanism, remedy: str = "") -> Finding:
    """The finding of an error, with the parts that its text names in quotes."""
    names = dict.fromkeys(re.findall(r"'([^']+)'", str(error)))
    return found(code, [name for name in names if name in mechanism.names], str(error), remedy)


def sorted_findings(findings: list[Finding]) -> tuple[Finding, ...]:
    """Errors first, then warnings and notes; each finding once."""
    once = list({(f.code, f.parts, f.text): f for f in findings}.values())
    return tuple(sorted(once, key=lambda finding: SEVERITIES.index(finding.severity)))


def _without_closing(mechanism: Mechanism, moving: Program, ideal: Program, q: np.ndarray) -> list[Finding]:
    """Findings that need no closed pose, at the reference configuration."""
    structure = [f for f in loops.redundancies(moving, ideal, q) if f.code != "singular-pose"]
    try:
        check_massless(mechanism, moving, q)
    except FlexmbError as error:
        structure.append(of_error("no-inertia", error, mechanism))
    return structure


def start_findings(mechanism: Mechanism, moving: Program, closed: Program, q: np.ndarray) -> list[Finding]:
    """Findings on start velocities and accelerations at a closed pose."""
    try:
        v = consistent.rigid_velocities(closed, q, 0.0, consistent.yielding_joints(moving, closed))
    except AssemblyError as error:
        return [of_error("forbidden-velocity", error, mechanism)]
    try:
        check_massless(mechanism, moving, q)
        a, _ = consistent.accelerations(moving, *consistent.with_states(moving, q, v), 0.0)
    except FlexmbError as error:
        return [of_error("no-inertia", error, mechanism, "Give every body some mass and inertia.")]
    if not np.isfinite(a).all():
        return [found("not-solvable", (), "The first accelerations are not finite.")]
    driven = any(motions_by_part(mechanism)) or mechanism.controllers
    at_rest = not driven and not np.any(np.abs(v) > 0.0) and not np.any(np.abs(a) > 0.0)
    is_free = at_rest and consistent.degrees_of_freedom(closed, q)[0] > 0
    return [found("nothing-moves", (), NOTHING_MOVES, WHAT_MOVES)] if is_free else []


def _modes(mechanism: Mechanism) -> tuple[Modes | None, list[Finding]]:
    """Natural modes in the reference configuration, or a finding on why there are none."""
    try:
        return modes(mechanism, count=LISTED_FREQUENCIES), []
    except FlexmbError as error:
        text = f"No frequencies: {str(error).removesuffix(' Ask for fewer modes.')}"
        return None, [found("no-frequencies", (), text)]


def _numbers(moving: Program, ideal: Program, q: np.ndarray, frequencies: tuple[float, ...]) -> dict[str, Any]:
    """Fields of the report that are computed from programs."""
    free, freedom = consistent.degrees_of_freedom(ideal, q)
    repeated = redundancy(moving, q)
    driven = int((np.asarray(ideal.tables.constraints.motion) >= 0).sum())
    held = int((ideal.reference.turns == 0.0).sum())  # rotations that mesh nodes do not have, held by a row each
    joints = dict.fromkeys(row.partition("[")[0] for row in moving.names.rows)
    drives = {name.partition(".")[0] for name in moving.drives}
    along = np.where(np.arange(ideal.n_q) % 3 == 0, 1.0, 0.0)  # a uniform velocity along x carries the whole mass
    return {
        "bodies": ideal.names.bodies,
        "joints": tuple(name for name in joints if name not in drives and name not in ideal.names.bodies),
        "contacts": moving.names.contacts, "coordinates": moving.n_q, "rows": moving.n_c, "freedom": freedom,
        "gruebler": 3 * len(ideal.names.bodies) - (ideal.n_c - driven - held), "drives": moving.drives, "free": free,
        "redundant": tuple(sorted(repeated.parts)) if repeated else (),
        "mass": float(along @ (StateEvaluation(ideal).mass(q) @ along)), "frequencies": frequencies,
        "signals": moving.reported.names,
    }  # fmt: skip
