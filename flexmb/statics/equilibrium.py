"""Static equilibrium: Newton with load steps, dynamic relaxation; contacts that carry; whether a model is the same.

In a frame that turns at constant speed, with the tangents K, C, M of r(q, v, a) at the instant at which it lies on the
fixed one, a motion y(t) obeys Equation (8.6) of docs/theory/equilibrium.md; S turns translations by a quarter and
leaves angles alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmb import arguments, checks, display
from flexmb import places as at
from flexmb.display import counted, cut, listed
from flexmb.engine.linalg.dense import bordered_solution
from flexmb.engine.linalg.large import null_vector, scaled
from flexmb.engine.system.constraints import call_joint_load, report_forces
from flexmb.engine.system.contacts import jacobians
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.engine.system.work import FORCE_X, FORCE_Y, JOINT_FRICTION_FORCE, MOMENT, MOTION_RATE, N_BY_GAP
from flexmb.errors import InputError, SolveError
from flexmb.fields import field, record
from flexmb.kernels import GAP_SIZE
from flexmb.late import sp
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Part, name_of, refuse_controllers
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import LOAD_KERNEL, Program, resolve
from flexmb.statics.eigen import is_stable
from flexmb.statics.start.consistent import check_independent

SPEED_TOLERANCE = 1e-9  # drives may turn at the speed of the frame or stand still, to this part of it


@dataclass(frozen=True)
class Spin:
    """Rotation of the frame: speed [rad/s] and centre [m]."""

    speed: float
    about: tuple[float, float]

    def motion(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Velocities and accelerations (n_q + 3,) of coordinates q and of the ground, all turning with the frame."""
        pose = np.append(q, np.zeros(3)).reshape(-1, 3)
        arm, v, a = pose[:, :2] - self.about, np.zeros_like(pose), np.zeros_like(pose)
        v[:, 0], v[:, 1], v[:, 2] = -self.speed * arm[:, 1], self.speed * arm[:, 0], self.speed
        a[:, :2] = -(self.speed**2) * arm
        return v.ravel(), a.ravel()

    def at(
        self, system: StateEvaluation, q: np.ndarray, lam: np.ndarray | None = None,
        weights: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> StateEvaluation:  # fmt: skip
        """Evaluate a program that turns with the frame."""
        return system.at(q, *self.motion(q), lam, weights=weights)

    def matrices(self, system: StateEvaluation, q: np.ndarray, lam: np.ndarray) -> tuple[sp.csc_matrix, ...]:
        """Stiffness, damping and mass (n_q, n_q) of motions in the frame; the system is left evaluated there."""
        M = self.at(system, q, lam, (0.0, 0.0, 1.0)).block()
        C = self.at(system, q, lam, (0.0, 1.0, 0.0)).block()
        K = self.at(system, q, lam, (1.0, 0.0, 0.0)).block()
        if not self.speed:
            return K, C, M
        quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # (x, y, theta) to (-y, x, 0)
        S, W = sp.csr_matrix(sp.block_diag([quarter] * (len(q) // 3))), self.speed
        return (K + W * (C @ S) + W**2 * (M @ S @ S)).tocsc(), (C + 2.0 * W * (M @ S)).tocsc(), M


def check_spin(owner: str, mechanism: Mechanism, program: Program, system: StateEvaluation, spin: Spin) -> None:
    """Refuse loads that are not steady in the rotating frame: gravity, and drives of another speed."""
    if not spin.speed:
        return
    if any(mechanism.gravity):
        text = f"{owner}: gravity is {mechanism.gravity} and spin is {spin.speed:g} rad/s; seen from the turning frame"
        raise InputError(f"{text} gravity turns, and nothing is steady. Set gravity to (0, 0), or simulate the motion.")
    driven = program.tables.constraints.motion >= 0
    # Sense of a driven coordinate: 1 body against ground, -1 ground against body, else 0. The ground as it is drawn
    # stands still, so only such a row may have the speed of the frame.
    sense = {}
    for contribution in mechanism.contributions().constraints:
        ends = (contribution.coordinates[0][0], contribution.coordinates[-1][0])
        way = 1 if ends[0] == GROUND.name else -1 if ends[1] == GROUND.name else 0
        for row in contribution.motions:
            name = f"{contribution.part}.{row.name}" if row.name else contribution.part
            sense[name] = way if row.units[0] == "rad" else 0
    for name, speed in zip(program.drives, system.work.drive[driven, MOTION_RATE], strict=True):
        if not speed or (sense[name] and abs(speed - sense[name] * spin.speed) <= SPEED_TOLERANCE * abs(spin.speed)):
            continue
        still = "It moves a body along, or against another body: stop it, or simulate the motion."
        remedy = "Give both the same speed." if sense[name] else still
        text = f"{owner}: drive {name!r} moves at {speed:g} and the frame turns at {spin.speed:g} rad/s;"
        raise InputError(f"{text} a steady rotation needs drives that stand still in it. {remedy}")


@record
class Equilibrium:
    """A static equilibrium.

    `equilibrium["rod.end.y"]` is a coordinate [m, rad]; `force("O")` the reaction of a joint.
    """

    q: np.ndarray = field("(n_q,) coordinates")
    lam: np.ndarray = field("(n_c,) multipliers")
    names: tuple[str, ...] = field("(n_q,) names of the coordinates")
    aliases: dict[str, str] = field("other names of nodes")
    reactions: dict[str, tuple[float, float, float]] = field(
        "(fx, fy, moment) on the second body of every joint, coupling and drive [N, N m], of a `Coupling` of its last "
        "joint; moment 0 where it carries none. What a body keeps within itself, as the rotation of a particle, is none"
    )
    iterations: int = field("Newton iterations of all load steps")
    spin: float = field("speed of the frame in which the mechanism is at rest, counter-clockwise", "rad/s", default=0.0)
    about: tuple[float, float] = field("centre of that rotation", "m", default=(0.0, 0.0))
    stable: bool | None = field("whether all stiffness is positive; None of follower forces", default=None)

    def __getitem__(self, name: str) -> float:
        place = resolve(name, self.aliases)
        return float(self.q[self.names.index(checks.one_of("Equilibrium", "coordinate", place, self.names))])

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)

    def __repr__(self) -> str:
        found = []
        for joint, (fx, fy, moment) in self.reactions.items():
            texts = [f"{force:.4g} N"] if (force := float(np.hypot(fx, fy))) or not moment else []
            texts += [f"{moment:.4g} N m"] if moment else []
            found.append(f"{joint} {' and '.join(texts)}")
        return "\n".join([self._title(), *([cut(f"  reactions: {', '.join(found)}")] if found else [])])

    def _title(self) -> str:
        kind = {True: "stable", False: "unstable", None: "stability unknown"}[self.stable]
        spin = f", turning at {self.spin:.6g} rad/s" if self.spin else ""
        text = f"{counted(len(self.q), 'coordinate')}, {counted(self.iterations, 'Newton iteration')}"
        return f"Equilibrium ({kind}{spin}): {text}"

    def _repr_html_(self) -> str:
        rows = [(joint, *(f"{value:.6g}" for value in values)) for joint, values in self.reactions.items()]
        coordinates = [(name, f"{value:.6g}") for name, value in zip(self.names, self.q, strict=True)]
        reactions = display.table(rows, ("reaction of", "fx [N]", "fy [N]", "moment [N m]"))
        return display.page(self._title(), "", reactions, display.folded("coordinates", display.table(coordinates)))

    def force(self, joint: Part | str) -> tuple[float, float, float]:
        """(fx, fy, moment) that a `joint`, or that of this name, exerts on its second body [N, N m]."""
        return self.reactions[checks.one_of("Equilibrium", "joint", name_of(joint), self.reactions)]


# Contacts of a mechanism at rest: the ones that carry and the ones left out, and their geometric stiffness
def carries(system: StateEvaluation) -> np.ndarray:
    """Whether each contact has a normal force at the last evaluation (contacts,)."""
    return np.asarray(system.work.contact[: len(system.program.names.contacts), at.NORMAL_FORCE] > 0.0)


def open_contacts(system: StateEvaluation) -> tuple[str, ...]:
    """Names of the contacts without a normal force at the last evaluation."""
    return tuple(name for name, held in zip(system.program.names.contacts, carries(system), strict=True) if not held)


def unpaired(mechanism: Mechanism) -> tuple[str, ...]:
    """Names of the parts of a mechanism with contacts that no ideal joint replaces."""
    found = mechanism.contributions()
    replaced = {c.part for c in found.constraints if c.holds == "closed"}
    return tuple(dict.fromkeys(c.part for c in found.contacts if c.part not in replaced))


def left_out_texts(left_out: tuple[str, ...], remedy: str) -> list[str]:
    """Sentence on contacts that a linearisation leaves out; none without such contacts."""
    return [f"Without stiffness here, since they do not carry: {listed(left_out)}. {remedy}"] if left_out else []


def contact_stiffness(system: StateEvaluation, u: np.ndarray) -> sp.csc_matrix:
    """Stiffness (n_q, n_q) by the normal forces that grow along displacements u (n_q,): -dN dJ_n/dq of each contact."""
    n, K = system.program.n_q, system.program.tables.contacts
    moved, rows, found = np.append(u, np.zeros(3)), np.zeros((2, 6)), sp.lil_matrix((n + 3, n + 3))
    for k in np.flatnonzero(carries(system)):
        dofs, out = K.dofs[6 * k : 6 * k + 6], system.work.contact[k, :GAP_SIZE]
        jacobians(out, rows)
        growth = system.work.slopes[k, N_BY_GAP] * float(rows[at.NORMAL] @ moved[dofs])
        # Derivatives of J_n by the coordinates; rows are entries of J_n.
        nx, ny, ax, ay, bx, by = out[[at.NORMAL_X, at.NORMAL_Y, at.ARM1_X, at.ARM1_Y, at.ARM2_X, at.ARM2_Y]]
        first = (at.NORMAL_X_Q, at.NORMAL_Y_Q, at.ARM1_X_Q, at.ARM1_Y_Q, at.ARM2_X_Q, at.ARM2_Y_Q)
        x, y, axq, ayq, bxq, byq = (out[place : place + 6] for place in first)
        turn1, turn2 = y * ax - x * ay + ny * axq - nx * ayq, y * bx - x * by + ny * bxq - nx * byq
        found[np.ix_(dofs, dofs)] -= growth * np.stack([x, y, turn1, -x, -y, -turn2])
    return found[:n, :n].tocsc()


BENT = 0.1  # difference of a gap from its tangents over the way along them, up to which nothing was passed through
LEAST_BENT = 1e-6  # the same over the size of the mechanism


def passes_through(system: StateEvaluation, q: np.ndarray, ahead: np.ndarray) -> bool:
    """Whether the way from q (n_q,) to a pose ahead may lead through a contact, by tangents of its gap at both ends."""
    # Straight on into a convex body its tangent plane is crossed first; beyond the body the gap grows again.
    moved = np.append(ahead - q, np.zeros(3))[system.program.tables.contacts.dofs.reshape(-1, 6)]
    (gap, change, way), rows = np.zeros((3, 2, len(moved))), np.zeros((2, 6))
    for end, pose in enumerate((q, ahead) if len(moved) else ()):
        for k, out in enumerate(system.at(pose).work.contact[: len(moved), :GAP_SIZE]):
            jacobians(out, rows)
            gap[end, k], change[end, k] = out[at.GAP], rows[at.NORMAL] @ moved[k]
            way[end, k] = np.abs(rows * moved[k]).sum()
    least = BENT * way.max(axis=0) + LEAST_BENT * system.program.length
    nearest = np.minimum(gap[0] + change[0], gap[1] - change[1])
    return bool(((nearest < least) & (abs(gap[1] - gap[0] - change).max(axis=0) > least)).any())


# Dynamic relaxation: equilibria in which loads alone resist some motions, as of pendulums

MOST_STRIDES = 400  # number of strides at most
STRIDE_ITERATIONS = 12  # number of Newton iterations of a stride at most
LARGEST_STRIDE = 0.5  # largest movement in a stride [rad, or relative to the size of the mechanism]
INDEPENDENCE = 1e-14  # diagonal beside rows of constraints of length 1, which keeps apart rows that repeat others
ROUND_OFF = 1e-15  # force of springs without load relative to their stiffness times the size of the mechanism
REST_STRIDE = 1e-9  # movement in a stride with little viscosity at rest [rad, or relative to the size of the mechanism]
# Coordinates (n_q,), multipliers (n_c,), number of iterations, first correction (n_q,).
Solved = tuple[np.ndarray, np.ndarray, int, np.ndarray]


def relax(program: Program, system: StateEvaluation, q: np.ndarray, spin: Spin) -> Solved | None:
    """Equilibrium under all loads after a motion with large viscosity from q (n_q,) on, or None."""
    # Strides of implicit Euler for eta D dq/ds + r(q) + G^T lam = 0, g(q) = 0, with a smaller eta after each success.
    # Every stride decreases the potential: it ends in a stable equilibrium, Newton's method at any stationary one.
    n, length, size = program.n_q, program.length, program.sizes
    diagonal = program.symbolic.positions(np.arange(n), np.arange(n))
    lam = balancing(program, system, q, spin)
    forces = float(np.abs(system.force * size).max(initial=0.0))
    unbalanced = float(np.abs((system.force + system.jacobian.T @ lam) * size).max(initial=0.0))
    system.at(q, weights=(1.0, 0.0, 0.0))
    stiffest = float((abs(system.block()) @ size * size).max(initial=0.0))
    if unbalanced <= max(1e-12 * forces, ROUND_OFF * stiffest):
        return _newton(program, system, q, lam, np.zeros(n), spin)  # an equilibrium already, or no load
    unit = forces / length**2
    eta, before, moved = unit, np.inf, np.inf
    for _ in range(MOST_STRIDES):
        found = _stride(program, system, (q, lam), eta * (length / size) ** 2, diagonal, spin)
        if found is None or passes_through(system, q, found[0]):
            eta *= 4.0
            still = moved <= min(REST_STRIDE, max(before, STEP_ROUND_OFF))
            if eta > 1e12 * unit or (still and stability(program, system, q, lam, spin) is False):
                return None  # the latter: on a saddle, as a straight column
            continue
        before, moved = moved, float(np.abs((found[0] - q) / size).max())
        q, lam = found
        if moved <= REST_STRIDE and eta <= 1e-3 * unit:
            return _newton(program, system, q, lam, np.zeros(n), spin)
        eta = max(eta / 3.0, 1e-14 * unit)
    return None


def stability(program: Program, system: StateEvaluation, q: np.ndarray, lam: np.ndarray, spin: Spin) -> bool | None:
    """Stability of a pose, as of `is_stable`."""
    K = spin.matrices(system, q, lam)[0] if spin.speed else system.at(q, lam=lam, weights=(1.0, 0.0, 0.0)).block()
    return is_stable(program, K, system.jacobian)


def balancing(program: Program, system: StateEvaluation, q: np.ndarray, spin: Spin) -> np.ndarray:
    """Multipliers (n_c,) of the least unbalanced forces at q (n_q,), where the system is left evaluated."""
    G, none = spin.at(system, q).jacobian, np.zeros(program.n_c)  # `INDEPENDENCE` keeps redundant rows regular
    lengths = np.sqrt(np.asarray(G.multiply(G).sum(axis=1)).ravel())
    scale, one = sp.diags_array(1.0 / np.where(lengths > 0.0, lengths, 1.0)), sp.eye_array(program.n_q)
    bordered = sp.block_array([[one, G.T @ scale], [scale @ G, -INDEPENDENCE * sp.eye_array(len(none))]])
    return np.asarray(scale @ sp.linalg.splu(bordered.tocsc()).solve(np.append(-system.force, none))[program.n_q :])


def _stride(
    program: Program, system: StateEvaluation, start: tuple[np.ndarray, np.ndarray], viscosity: np.ndarray,
    diagonal: np.ndarray, spin: Spin,
) -> tuple[np.ndarray, np.ndarray] | None:  # fmt: skip
    """One implicit stride from (q, lam); None if Newton fails or the viscosity is too small."""
    n, size = program.n_q, program.sizes
    q, lam = start
    first, last = q, np.inf
    for _ in range(STRIDE_ITERATIONS):
        system.at(q, *spin.motion(q), lam, weights=(1.0, 0.0, 0.0))
        system.work.lu[diagonal] += viscosity
        downhill = is_stable(program, system.block(), system.jacobian) is not False
        force = system.force + system.constraint_force + viscosity * (q - first)
        try:
            d = system.solve(-np.concatenate([force, system.residual]), "settling")
        except SolveError:
            return None
        step = float(np.abs(d[:n] / size).max())
        q, lam = q + d[:n], lam + d[n:]
        if not downhill or not step <= LARGEST_STRIDE or float(np.abs((q - first) / size).max()) > LARGEST_STRIDE:
            return None
        if step <= 1e-11 or (step <= 1e-7 and step >= 0.5 * last):
            return q, lam
        last = step
    return None


MOST_ITERATIONS, MOST_OF_LONG_STEP = 40, 10  # Newton iterations at most, and in a step longer than asked for
STEP_ROUND_OFF = 1e-11
# Change of multipliers relative to the largest, up to which forces by multipliers balance; else iterations at rest.
SAME_FORCES, RESTS = 1e-9, 4
# Accuracy of Newton's correction in a large model, which leaves its convergence as it is, and that of the tangent at
# the end of a load step, which is compared with factors of 4 and 10.
STEP_ACCURACY, TANGENT_ACCURACY = 1e-6, 1e-2
# Difference of a load step from those by the tangents at both its ends, relative to the step, up to which it may be
# longer than those that were asked for.
FOLLOWED = 0.25
# Length of a load step over its length by one of the tangents, above which the step is halved, and by both of them,
# above which the smallest step is refused. A string that is slack at first, u ~ s^(1/3), has 3.
LONG_LOAD_STEP, SNAP_LOAD_STEP = 4.0, 10.0
CLOSED_GAP = 1e-9  # gap of the joints relative to the size of the mechanism, below which they need no step of their own
LEAST_JUMP = 1e-8  # movement below which a load step is no jump [rad, or relative to the size of the mechanism]


@arguments.checked
def static_equilibrium(
    mechanism: Mechanism, load_steps: int = 10, spin: float = 0.0, about: tuple[float, float] = (0.0, 0.0)
) -> Equilibrium:
    """Static equilibrium, reached from the reference configuration under growing loads.

    Drives hold their position of t = 0.  A controller without states that acts at all times, such as a PD law, is a
    spring with the force of its law at t = 0.  Clearance joints are open unless the reference configuration presses
    them together, so replace them by `Revolute` for statics.

    With `spin` the equilibrium is one in a frame that rotates at that speed, with the ground and the loads: centrifugal
    forces stretch and stiffen the bodies.  The drive of the hub has the same speed or stands still.

    Equation (8.1) of docs/theory/equilibrium.md.

    Parameters
    ----------
    mechanism : the mechanism; every motion must be held by joints, drives, stiffness, or the loads themselves.
    load_steps : number of load steps where the answer bends away from its tangents; elsewhere steps are longer, up to
        all loads at once.  Each is halved, up to 8 times, when Newton fails.
    spin : speed of the frame, counter-clockwise [rad/s].
    about : centre of its rotation [m].

    Raises
    ------
    InputError : a spin with gravity, or with drives of another speed, which are not steady.
    SolveError : a motion without resistance (named), or no equilibrium found (load and coordinate named).
    ModelError, AssemblyError : redundant joints (named), always or in the reference configuration; controllers with
        states or samples, or in a turning frame.

    Notes
    -----
    With the force r0 of the reference configuration, r(q) - (1 - s) r0 + G^T lam = 0 and g = 0 are solved for s = 0 ..
    1; the square of the spin grows with s.  Follower forces are multiplied by s in r instead, since a rotated force
    cannot balance r0.  Motions without stiffness in the reference configuration (pendulums) are found by dynamic
    relaxation, and so is the pose to which loads move a mechanism that is unstable otherwise: a column with a small
    load to the side bends to this side.
    Limit points are not traced: a structure that snaps through ends with an error.  A straight column beyond its
    buckling load stays straight; `stable` says that it would not.  Not for beams so thin that rounding decides: 16
    elements still bend with EA L^2/EI = 1e11 (length over height 1e5), not with 1e13.
    """
    checks.count("static_equilibrium", "load_steps", load_steps)
    speed = checks.number("static_equilibrium", "spin", spin, "rad/s")
    full = Spin(speed, checks.point("static_equilibrium", "about", about))
    reason = "a controller with states of its own, or a sampled one, moves what it holds until its input fits"
    refuse_controllers(mechanism, "static_equilibrium", reason, with_memory=not full.speed)
    program = compile_mechanism(mechanism)
    system = StateEvaluation(program)
    check_spin("static_equilibrium", mechanism, program, system.at(program.reference.q), full)
    q, lam, total, stable = settled(mechanism, program, system, load_steps, full)
    forces, names = reactions(program, full.at(system, q, lam), q, lam), program.names
    return Equilibrium(q, lam, names.coordinates, names.aliases, forces, total, full.speed, full.about, stable)


def settled(
    mechanism: Mechanism, program: Program, system: StateEvaluation, load_steps: int, full: Spin
) -> tuple[np.ndarray, np.ndarray, int, bool | None]:
    """Equilibrium as of `at_rest`, or to which loads move a mechanism from an unstable pose; whether it is stable."""
    # An unstable pose may lie on a branch that growing loads do not reach: those of a bent column go to one side.
    reference = np.array(program.reference.q)

    def moved() -> Solved | None:
        there = relax(program, system, reference, full)
        return None if there is None or unresisted(program, system, *there[:2]) else there

    lam = balancing(program, system, reference, full)
    early = not full.speed and stability(program, system, reference, lam, full) is False
    found = (moved() if early else None) or at_rest(mechanism, program, system, load_steps, full)
    stable = stability(program, system, *found[:2], full)
    if stable is False and not early and not full.speed:
        found = moved() or found
        stable = stability(program, system, *found[:2], full)
    return *found[:3], stable


def at_rest(
    mechanism: Mechanism, program: Program, system: StateEvaluation, load_steps: int, full: Spin
) -> tuple[np.ndarray, np.ndarray, int]:
    """Coordinates (n_q,), multipliers (n_c,) and Newton iterations of an equilibrium, from the reference pose on."""
    q = np.array(program.reference.q)
    if free := unresisted(program, system, q):  # loads alone resist some motions
        found = relax(program, system, q, full)
        if found is None:
            check_independent(program, np.array(program.reference.q))
            raise SolveError(f"{free_motion_error(program, free)} Nor was a pose found in which the loads hold it.")
        if unresisted(program, system, *found[:2]):
            raise SolveError(free_motion_error(program, free))
        return found[:3]
    return _grow_loads(mechanism, program, system, q, load_steps, full)


def _grow_loads(
    mechanism: Mechanism, program: Program, system: StateEvaluation, q: np.ndarray, load_steps: int, full: Spin
) -> tuple[np.ndarray, np.ndarray, int]:
    """Coordinates, multipliers and iterations under full loads, which grow in steps."""
    # The first step tries all loads. One longer than 1/load_steps counts where the answer follows its tangents.
    lam, grow = np.zeros(program.n_c), load_growth(mechanism, program)
    system.program = grow(0.0)
    start = system.at(q).force
    if np.abs(system.residual).max(initial=0.0) > CLOSED_GAP * program.length:  # a drive stands elsewhere: first there
        closed = _newton(program, system, q, lam, start, Spin(0.0, full.about))
        q, lam = closed[:2] if closed is not None else (q, lam)
    done, stride, total, usual = 0.0, 1.0, 0, 1.0 / load_steps
    smallest = usual / 2**8
    while done < 1.0 - 1e-12:
        stride = min(stride, 1.0 - done)
        part = done + stride
        turning = Spin(full.speed * np.sqrt(part), full.about)
        system.program = grow(part)
        most = MOST_OF_LONG_STEP if stride > usual else MOST_ITERATIONS
        found = _newton(program, system, q, lam, (1.0 - part) * start, turning, most)
        jump, bend, snap, through = 0.0, 0.0, 0.0, False
        if found is not None:
            system.program, back = grow(done), Spin(full.speed * np.sqrt(done), full.about)
            through = passes_through(system, q, found[0])
            jump, bend, snap = _against_tangents(program, system, q, found, (1.0 - done) * start, back)
        if found is None or through or jump > LONG_LOAD_STEP or (bend > FOLLOWED and stride > usual):
            stride = max(stride / 2.0, usual) if stride > usual else stride / 2.0
            if stride >= smallest:
                continue
            if found is None or through or snap > SNAP_LOAD_STEP:
                check_independent(program, np.array(program.reference.q))
                rest = np.abs(system.force + system.constraint_force)
                text = f"no static equilibrium found beyond {100 * done:.3g} % of the loads; largest unbalance at"
                text += f" {program.names.coordinates[int(np.nanargmax(rest))]!r}. Use more load_steps; if that does"
                text += " not help, the structure buckles or snaps through there."
                raise SolveError(f"Mechanism {program.name!r}: {text}")
            stride *= 2.0
        q, lam, used, _ = found
        done, total = part, total + used
        stride *= 2.0 if bend <= 0.5 * FOLLOWED else 1.0
    system.program = program  # tangents at the start of the last step had a part of the follower loads
    return q, lam, total


def load_growth(mechanism: Mechanism, program: Program) -> Callable[[float], Program]:
    """Function of the load factor that returns the program with follower loads times that factor."""
    parts = [load.share(0.0) for load in mechanism.parts]
    if all(less is load for less, load in zip(parts, mechanism.parts, strict=True)):
        return lambda _part: program
    none, full = compile_mechanism(mechanism.with_loads(parts, mechanism.gravity)).tables.p, program.tables.p

    def grown(part: float) -> Program:
        """Parameters that the loads do not change are kept to the last digit: counts and places are among them."""
        p = np.where(none == full, full, (1.0 - part) * none + part * full)
        return replace(program, tables=program.tables.replaced(p=p))

    return grown


def _newton(
    program: Program, system: StateEvaluation, q: np.ndarray, lam: np.ndarray, held: np.ndarray, spin: Spin,
    most: int = MOST_ITERATIONS,
) -> Solved | None:  # fmt: skip
    """Solution for one load and speed, its iterations, and the first tangent's step (n_q,); None if Newton fails."""
    n, size, last, tangent, rest = program.n_q, program.sizes, np.inf, np.zeros(0), 0
    for iteration in range(1, most + 1):
        try:
            d = correction(system, q, lam, held, spin, STEP_ACCURACY)
        except SolveError:
            return None
        step = np.abs(d[:n] / size).max()
        if not np.isfinite(step) or (iteration > 8 and step > 10.0 * last):
            return None
        tangent = tangent if len(tangent) else d[:n]
        factor = min(1.0, 0.5 / step) if step > 0.5 else 1.0
        q, lam = q + factor * d[:n], lam + factor * d[n:]
        rest = rest + 1 if step <= STEP_ROUND_OFF or (step <= 1e-7 and step >= 0.5 * last) else 0
        same = np.abs(d[n:]).max(initial=0.0) <= SAME_FORCES * np.abs(lam).max(initial=0.0)
        if rest > (RESTS if program.tables.sizes.has_joint_friction and not same else 0):
            return q, lam, iteration, tangent
        last = step
    return None


def _against_tangents(
    program: Program, system: StateEvaluation, q: np.ndarray, found: Solved, held: np.ndarray, spin: Spin
) -> tuple[float, float, float]:
    """Length of a load step over the shorter one by the tangents at its ends, difference from both, snap-through."""
    # The system is evaluated at the start of the step. Towards a limit point the distances by the tangents grow; only a
    # snap-through is longer than both. Where a stop begins to carry, or ceases to, it is judged by the longer one.
    ahead, lam, _, tangent = found

    def length(move: np.ndarray) -> float:
        return float(np.abs(move / program.sizes).max())

    moved, before = ahead - q, carries(system.at(q))
    try:
        back = -correction(system, ahead, lam, held, spin, TANGENT_ACCURACY)[: program.n_q]
    except SolveError:
        return 0.0, np.inf, 0.0  # exactly at a limit point
    far = max(length(moved), LEAST_JUMP)
    ends = sorted((max(length(tangent), LEAST_JUMP), max(length(back), LEAST_JUMP)))
    bend = max(length(moved - tangent), length(moved - back)) / far
    return length(moved) / ends[0], bend, length(moved) / ends[int((before != carries(system)).any())]


def correction(
    system: StateEvaluation, q: np.ndarray, lam: np.ndarray, held: np.ndarray, spin: Spin, accuracy: float = 0.0
) -> np.ndarray:
    """Newton's correction of (q, lam), as accurate as `StateEvaluation.solve`; `SolveError` for a singular matrix."""
    K: Any = spin.matrices(system, q, lam)[0] if spin.speed else system.at(q, lam=lam, weights=(1.0, 0.0, 0.0))
    rest = np.concatenate([-(system.force - held + system.constraint_force), -system.residual])
    if not spin.speed:
        return system.solve(rest, "static equilibrium", accuracy)
    n, scale = len(q), abs(K).max()  # the turning matrix has its own pattern
    rest[:n] /= scale
    d = bordered_solution(K / scale, system.jacobian, rest)
    if d is None:
        raise SolveError("static equilibrium: the matrix is singular")
    d[n:] *= scale
    return d


def unresisted(program: Program, system: StateEvaluation, q: np.ndarray, lam: np.ndarray | None = None) -> str:
    """Name of the coordinate that moves most in a free motion; "" without free motions."""
    system.at(q, lam=lam, weights=(1.0, 0.0, 0.0))
    if system.is_regular():
        return ""
    scale, rows = scaled(K := system.block(), system.jacobian)
    free = null_vector(sp.vstack([scale @ K @ scale, rows]))
    return "" if free is None else program.names.coordinates[int(np.abs(free).argmax())]


def free_motion_error(program: Program, free: str) -> str:
    """Message on a motion without resistance, which moves this coordinate most."""
    text = f"Mechanism {program.name!r} has no static equilibrium: a motion that moves {free!r}"
    return f"{text} most is resisted by nothing. Add a joint, a drive or a spring that holds it."


def reactions(
    program: Program, system: StateEvaluation, q: np.ndarray, lam: np.ndarray, *, driving: bool = False
) -> dict[str, tuple[float, float, float]]:
    """Reactions (fx, fy, moment) of every joint at the last evaluation, at q (n_q,) with multipliers lam (n_c,)."""
    # Constraints of a body of its own are left out: rotations of particles and of nodes of meshes, averaged pins.
    # `driving`: the last number of a drive is its torque or force.
    work, C, full, own = system.work, program.tables.constraints, np.append(q, np.zeros(3)), set(program.names.bodies)
    report_forces(program.tables, lam, work)
    found: dict[str, tuple[float, float, float]] = {}
    for c in range(len(C.kernel)):
        name = program.names.rows[int(C.row[c])].partition("[")[0]
        if name in own:
            continue
        fx, fy, moment = work.joint[c, [FORCE_X, FORCE_Y, MOMENT]]
        if C.joint_friction[c, LOAD_KERNEL] >= 0 and C.forces[c] == 0 and C.second[c, 0] >= 0:  # teeth, strands
            dofs = C.dofs[C.dof[c] : C.dof[c + 1]]
            work.ql[: len(dofs)] = full[dofs]
            call_joint_load(program.tables, program.addresses, c, len(dofs), lam, work)
            push = work.joint_friction[c, JOINT_FRICTION_FORCE] * work.joint_friction_out[at.SLIDING + C.second[c]]
            fx, fy = fx + push[0], fy + push[1]
        if C.moment[c] < 0 and C.second[c, 0] < 0:  # rotations are coupled: the moment on the last of them
            moment *= work.G[C.pos_g[c + 1] - 1]
        elif C.moment[c] < 0 and not (driving and C.motion[C.row[c]] >= 0):
            moment = 0.0
        found[name] = (float(fx), float(fy), float(moment))
    return found


OTHER_MODEL_STEP = 1e-6  # Newton step over the mechanism's size, above which an equilibrium is of another model


def refuse_other_names(owner: str, program: Program, at: Equilibrium) -> None:
    """`InputError` when an equilibrium has other coordinates or joints than the model; `owner`: the caller."""
    sizes = ((len(at.q), program.n_q, "coordinates"), (len(at.lam), program.n_c, "equations of joints"))
    for given, own, noun in sizes:
        if given != own:
            raise InputError(f"{owner}: the equilibrium has {given} {noun}, the model {own}. Use its own.")
    if at.names != program.names.coordinates:
        other = next(a for a, b in zip(at.names, program.names.coordinates, strict=True) if a != b)
        raise InputError(f"{owner}: the equilibrium has a coordinate {other!r}, the model has none. Use its own.")


def refuse_other_forces(owner: str, program: Program, system: StateEvaluation, at: Equilibrium) -> None:
    """`InputError` when the pose is no equilibrium of this model; `owner`: the caller."""
    try:
        step = correction(system, at.q, at.lam, np.zeros(program.n_q), Spin(at.spin, at.about))[: program.n_q]
    except SolveError:
        return  # on the verge of buckling: nothing can be said
    step = np.abs(step) / program.sizes
    if step.max() > OTHER_MODEL_STEP:
        text = f"{owner}: the equilibrium given is none of mechanism {program.name!r}: its forces would move"
        text += f" {program.names.coordinates[int(step.argmax())]!r} by {step.max():.3g} (of the model's size, or rad)."
        raise InputError(f"{text} Compute it with the same mechanism.")
