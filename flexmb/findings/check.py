"""Examination of a mechanism before it moves, and its report; known causes of failed runs."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import numpy as np

from flexmb import arguments, checks, display
from flexmb.display import counted, cut, listed, quoted
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import AssemblyError, FlexmbError, InputError, KernelError, SolveError
from flexmb.fields import field, record
from flexmb.findings import loops
from flexmb.findings.dimensions import dimension_findings, size_of
from flexmb.findings.finding import CODES, ERROR, NOTHING_MOVES, SEVERITIES, WHAT_MOVES, Finding, found
from flexmb.findings.laws import contacts_of, kernel_findings, law_findings, motion_findings, motions_by_part
from flexmb.model.law import Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, Joint
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program
from flexmb.statics.eigen import damped, moves_most
from flexmb.statics.equilibrium import Equilibrium, Spin, correction, static_equilibrium
from flexmb.statics.modes import Examination, Modes, State, modes
from flexmb.statics.start import consistent

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
        sizes = f"{counted(len(self.bodies), 'body')}, {counted(self.freedom, 'degree')} of freedom, {self.free} free"
        return cut(f"Report on {self.name!r}: {_counted(self.findings)}; {sizes}, {self.mass:.6g} kg")

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
            findings = loops.locking_drives(mechanism, closed, consistent.close_loops(closed, {})[0])
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
        q, _ = consistent.close_loops(closed, {})
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
        findings += load_findings(mechanism, int(numbers["free"]))
        findings += stability_findings(mechanism, ideal, q, found_modes)
        findings += [] if _is_broken(findings) else loop_findings(mechanism, moving, q)
        findings += [] if step is None else step_findings(mechanism, ideal, closed, q, step)
    findings += stiffness_findings(mechanism, ideal, q, found_modes)
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
        consistent.check_massless(mechanism, moving, q)
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
        consistent.check_massless(mechanism, moving, q)
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
    repeated = consistent.redundancy(moving, q)
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


# Stability of the reference configuration under the declared loads, gravity included

MOST_ITERATIONS = 20  # number of Newton iterations towards an equilibrium beside the reference configuration
# Distance of an equilibrium from the reference configuration up to which the mechanism is meant to rest there [rad, or
# relative to the size of the mechanism].
BESIDE = 0.05
BALANCED = 1e-7  # unbalanced force relative to the largest load, and gap relative to the size, of an equilibrium
MOST_LOADED_COORDINATES = 600  # number above which loads are left out, since their balance would take long
MOST_CONTROLLED = 150  # number of coordinates and states above which eigenvalues of control loops would take long
LEAST_GROWTH = 1e-4  # growth over the largest eigenvalue, below which it may be round-off of a multiple eigenvalue 0
MODES = 10  # number of modes that are looked at


def stability_findings(mechanism: Mechanism, ideal: Program, q: np.ndarray, bare: Modes | None) -> list[Finding]:
    """Finding on a small motion that runs away from the reference configuration."""
    # Where an equilibrium under the loads lies beside the reference configuration, its modes decide; else, and where
    # bodies are declared with velocities, those without the loads, since what begins to move is not meant to rest. The
    # pose (n_q,) is closed; `bare` modes are None where there are none.
    moves = np.nan_to_num(ideal.reference.v).any()  # NaN where no velocity is declared
    pose, loads = None if moves else equilibrium_beside(ideal, q), "Without loads"
    if pose is not None:
        at = Equilibrium(*pose, ideal.names.coordinates, ideal.names.aliases, {}, 0)
        try:
            bare, loads = modes(mechanism, count=MODES, at=at), "Under its loads, gravity included,"
        except FlexmbError:
            pose = None
    if bare is None or "unstable" not in bare.kinds:
        return []
    worst = int(np.argmin(bare.frequencies))
    rate = -float(bare.frequencies[worst]) * 2.0 * np.pi
    body = ideal.names.bodies[int(ideal.reference.body[bare.names.index(bare.moves[worst])])]
    text = f"{loads} a small motion away from the reference configuration, mostly of {bare.moves[worst]!r}, grows by"
    remedy = "It stands on its head, or is buckled: turn it over, or hold it by a spring, a joint or a"
    remedy += " stronger section."
    return [found("unstable-reference", (body,), f"{text} exp({rate:.4g} t), t in s.", remedy, rate=rate)]


def loop_findings(mechanism: Mechanism, program: Program, q: np.ndarray) -> list[Finding]:
    """Finding on control loops that act at all times and let a small motion about the pose (n_q,) grow."""
    # From the eigenvalues of mechanism and control laws together, at rest in the reference configuration; without the
    # stiffness of gravity in it. Sampled laws are left out.
    if not program.controls or program.n_q > MOST_CONTROLLED or program.names.contacts:
        return []
    system, q = StateEvaluation(program), np.append(q, program.reference.q[len(q) :])
    K, C, M = (system.at(q, weights=w).block() for w in np.eye(3))
    try:
        s, x = damped(K, C, M, system.jacobian, np.zeros((program.n_q, 0)), 2 * program.n_q)
    except (FlexmbError, np.linalg.LinAlgError, ValueError):  # no finite matrices: told by other findings
        return []
    worst = int(np.argmax(s.real)) if len(s) else 0
    if not len(s) or s[worst].real <= LEAST_GROWTH * np.abs(s).max():
        return []
    names = tuple(part.name for part in mechanism.controllers)
    moved = moves_most(program.names.coordinates, program.length, np.abs(x[: program.tables.sizes.n_b, worst]))
    text = f"With {quoted(names)} a small motion, mostly of {moved!r}, grows by exp({s[worst].real:.4g} t), t in s."
    remedy = "Check the sign of the feedback, and reduce the gains."
    rate, frequency = s[worst].real, abs(s[worst].imag) / (2.0 * np.pi)
    return [found("unstable-loop", names, text, remedy, rate=rate, frequency=frequency)]


def equilibrium_beside(program: Program, q: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Coordinates and multipliers of an equilibrium beside a pose (n_q,), stable or not; None where there is none."""
    if program.n_q > MOST_LOADED_COORDINATES:
        return None
    system, start, size = StateEvaluation(program), q, program.sizes
    force, G = system.at(q, weights=(1.0, 0.0, 0.0)).force, system.jacobian.toarray()
    lam, none = np.linalg.lstsq(G.T, -force, rcond=None)[0], np.zeros(program.n_q)
    for _ in range(MOST_ITERATIONS):
        system.at(q, lam=lam)
        rest, most = system.force + system.constraint_force, max(np.abs(system.force).max(), np.abs(force).max())
        closed = np.abs(system.residual).max(initial=0.0) <= BALANCED * program.length
        if closed and np.abs(rest).max() <= BALANCED * most:
            return q, lam
        try:
            d = correction(system, q, lam, none, Spin(0.0, (0.0, 0.0)))
        except SolveError:
            return None
        q, lam = q + d[: program.n_q], lam + d[program.n_q :]
        if not np.abs((q - start) / size).max() <= BESIDE:
            return None
    return None


# Loads as declared, at rest: stress of flexible bodies, buckling, penetration of contacts

SAFE_LOAD = 2.0  # buckling factor below which there is a remark


def load_findings(mechanism: Mechanism, free: int) -> list[Finding]:
    """Findings on a mechanism under its loads; statics are computed if drives prescribe all motions (`free` is 0)."""
    load, findings = typical_load(mechanism), list[Finding]()
    pose: Equilibrium | None = None
    ideal, parts = mechanism, tuple(part.idealised() for part in mechanism.parts)
    loaded = any(mechanism.gravity) or any(part.declared_load is not None for part in mechanism.parts)
    has_clearance = any(getattr(part, "clearance", None) is not None for part in parts)
    if not free and loaded and not has_clearance and any(body.is_elastic for body in mechanism.bodies):
        ideal = replace(mechanism, parts=parts)
        try:
            pose = static_equilibrium(ideal)
        except FlexmbError as error:
            findings.append(found("no-statics", (), f"The loads at rest were not examined: {error}"))
        findings += _buckling(ideal)
    own = [one for part in mechanism.parts for one in part.answers("findings_at_rest", ideal, load, pose)]
    return [*own, *findings]


def _buckling(ideal: Mechanism) -> list[Finding]:
    """Findings on a structure near its buckling load."""
    from flexmb.statics.buckling import buckling

    try:
        found_loads = buckling(ideal, count=1)
    except FlexmbError:
        return []
    positive = [float(f) for f in found_loads.factors if f > 0.0]
    if not positive or min(positive) >= SAFE_LOAD or found_loads.notes:
        return []
    least = min(positive)
    size, code = (f"1/{least:.3g} of", "near-buckling") if least >= 1.0 else (f"{1.0 / least:.3g} times", "buckled")
    remedy = "Reduce the loads, or stiffen the slender beams."
    return [found(code, (), f"The loads are {size} the buckling load.", remedy, factor=least)]


def typical_load(mechanism: Mechanism) -> float:
    """Sum of weights, declared forces, and inertia forces of all masses on half of the mechanism's size [N]."""
    mass = sum(getattr(body, "mass", None) or 0.0 for body in mechanism.bodies)
    forces = sum(part.declared_load or 0.0 for part in mechanism.parts)
    motions = [motion for part in mechanism.parts if isinstance(motion := vars(part).get("motion"), Motion)]
    speeds = [abs(float(motion.kernel(np.array(motion.parameters(), dtype=float), 0.0)[1])) for motion in motions]
    inertia = 0.5 * size_of(mechanism) * max(speeds, default=0.0) ** 2
    return float(mass * (math.hypot(*mechanism.gravity) + inertia) + forces)


UNRESOLVED = 1.0  # angular frequency times step above which a vibration is not resolved
LOADED_SHARE = 0.01  # share of the energy of the vibrations at the start above which a mode carries load
LEAST_STEPS = 4.0  # steps of an impact below which its restitution means nothing
MOST_VIBRATING_COORDINATES = 400  # number of coordinates above which modes would take too long
PART_OF_PERIOD = 0.05  # time of the differences along the motion, relative to the step


def step_findings(mechanism: Mechanism, ideal: Program, closed: Program, q: np.ndarray, h: float) -> list[Finding]:
    """Findings on a fixed step h [s] that is too long for contacts, or for vibrations with which a run begins."""
    # `ideal` has ideal joints for clearance joints; in `closed` start velocities are found; the pose (n_q,) is closed.
    findings = list(_short_contacts(mechanism, h))
    if ideal.n_q > MOST_VIBRATING_COORDINATES:
        return findings
    try:
        v = consistent.rigid_velocities(closed, q, 0.0, consistent.yielding_joints(ideal, closed))
        a, _ = consistent.accelerations(ideal, q, v, 0.0)
        vibrations = Examination(ideal, PART_OF_PERIOD * h).groups([State(0.0, q, v, a, ideal.reference.z)])
    except (FlexmbError, np.linalg.LinAlgError):
        return findings  # told by other findings
    if not vibrations:
        return findings
    ((_, energies, modes),) = vibrations
    begun = energies[0, 2]
    coarse = np.flatnonzero((modes.omega * h > UNRESOLVED) & (begun > LOADED_SHARE * begun.sum()))
    if not len(coarse):
        return findings
    k = int(coarse[np.argmax(begun[coarse])])
    period = 2.0 * math.pi / float(modes.omega[k])
    moves = moves_most(ideal.names.coordinates, ideal.length, modes.shapes[:, k])
    body = ideal.names.bodies[int(ideal.reference.body[ideal.names.coordinates.index(moves)])]
    text = f"A fixed step of {h:.3g} s is {h / period:.2g} periods of the vibration of {1.0 / period:.4g} Hz (mostly"
    text = f"{text} {moves}), which carries {100.0 * float(begun[k] / begun.sum()):.3g} % of what the start excites."
    remedy = f"Take steps of {period / 20.0:.1g} s, or Adaptive()."
    return [*findings, found("coarse-step", (body,), text, remedy, step=h, period=period)]


def _short_contacts(mechanism: Mechanism, h: float) -> Iterator[Finding]:
    """Findings on contacts that are shorter than a few steps: half a period of the lighter mass on the contact."""
    load, masses = typical_load(mechanism), {b.name: getattr(b, "mass", None) for b in mechanism.bodies}
    for part in mechanism.parts if load > 0.0 else ():
        if not isinstance(part, Joint) or isinstance(part, Body):
            continue
        inverse = sum(1.0 / m for m in (masses.get(b.name) for b in (part.first, part.second)) if m)
        for contact in contacts_of(part, mechanism) if inverse > 0.0 else ():
            depth = contact.normal.depth_under(load, max(contact.p[0], 1e-2))
            time = math.pi * math.sqrt(depth / (load * inverse))
            if time < LEAST_STEPS * h:
                text = f"A contact of {part.label} lasts some {time:.2g} s (a mass of {1.0 / inverse:.3g} kg, a force"
                text = f"{text} of {load:.3g} N at {depth:.2g} m), less than {LEAST_STEPS:g} fixed steps of {h:.3g} s."
                remedy = f"Take steps of {time / 32.0:.1g} s, or Adaptive(), which resolves impacts."
                yield found("coarse-step", (part.name,), text, remedy, step=h, contact_time=time)
                break


# Stiffnesses that floats cannot hold beside the loads or slow vibrations

ROUND_OFF_OF_LOADS = 1e-3  # round-off of the stiffest part relative to the loads, above which there is a remark
ROUND_OFF = 1e-13  # round-off of a mode shape relative to its largest entry: what it strains may have no other reason
LARGEST_RATIO = 1e15  # ratio of stiffnesses over masses, of the fastest mode to the slowest, that floats can hold


def stiffness_findings(mechanism: Mechanism, program: Program, q: np.ndarray, bare: Modes | None) -> list[Finding]:
    """Findings on stiffnesses whose round-off is felt beside loads or slow vibrations, at a pose q (n_q,)."""
    n, kind = program.tables.sizes.n_b, np.asarray(program.tables.kind)
    stiffness = np.where(kind[:n] == 1, 0.0, _diagonal(program, q)[:n])
    worst = int(np.argmax(stiffness))
    body, largest = program.names.bodies[int(program.reference.body[worst])], float(stiffness[worst])
    lost = float(np.finfo(float).eps * largest * max(program.length, abs(q[worst])))
    load = typical_load(mechanism)
    remedy = "Make a stiff spring a joint, or a stiff beam a rigid body; stiffnesses are in N/m."
    if not math.isfinite(largest) or lost > ROUND_OFF_OF_LOADS * load > 0.0:
        text = f"At {body!r} a stiffness of {largest:.3g} N/m turns the round-off of its coordinates into {lost:.2g} N"
        text = f"{text}; all loads, weights and inertia together have some {load:.2g} N."
        return [found("stiffness-ratio", (body,), text, remedy, stiffness=largest, round_off=lost, load=load)]
    if bare is None:
        return []
    # Elastic modes with more energy than the round-off of their shapes.
    sizes, stiffest = np.abs(bare.shapes).max(axis=0, initial=0.0), _diagonal(program, q).max()
    least, energy = stiffest * (ROUND_OFF * sizes) ** 2, np.abs(bare.eigenvalues) ** 2
    slow = [k for k, kind in enumerate(bare.kinds) if kind == "elastic" and energy[k] > least[k]]
    if not slow:
        return []
    M = _diagonal(program, q, mass=True)[:n]
    squares = _diagonal(program, q)[:n][M > 0.0] / M[M > 0.0]
    slowest, fastest = float(np.abs(bare.eigenvalues[slow[0]])), math.sqrt(float(np.max(squares, initial=0.0)))
    if fastest**2 <= LARGEST_RATIO * slowest**2:
        return []
    text = f"The slowest vibration, mostly of {bare.moves[slow[0]]!r}, has {slowest / (2.0 * math.pi):.3g} Hz, and"
    text = f"{text} the stiffness at {body!r} some {fastest / (2.0 * math.pi):.3g} Hz: the ratio of their squares is"
    text = f"{text} beyond the 16 digits of floats."
    return [found("stiffness-ratio", (body,), text, remedy, slowest=slowest, fastest=fastest)]


def _diagonal(program: Program, q: np.ndarray, *, mass: bool = False) -> np.ndarray:
    """Diagonal (n_q,) of the stiffness or the mass."""
    weights = (0.0, 0.0, 1.0) if mass else (1.0, 0.0, 0.0)
    return np.asarray(np.abs(StateEvaluation(program).at(q, weights=weights).block().diagonal()))
