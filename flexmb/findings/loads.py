"""Findings on loads at rest and on stiffness: stress, buckling, stability, long fixed steps."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flexmb.display import quoted
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import FlexmbError, SolveError
from flexmb.findings.dimensions import size_of
from flexmb.findings.finding import Finding, found
from flexmb.findings.laws import contacts_of
from flexmb.model.law import Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, Joint
from flexmb.program.program import Program
from flexmb.statics.eigen import damped, moves_most
from flexmb.statics.equilibrium import Equilibrium, Spin, correction, static_equilibrium
from flexmb.statics.modes import Examination, Modes, State, modes
from flexmb.statics.start.consistent import accelerations, rigid_velocities, yielding_joints

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
        v = rigid_velocities(closed, q, 0.0, yielding_joints(ideal, closed))
        a, _ = accelerations(ideal, q, v, 0.0)
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
