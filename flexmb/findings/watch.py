"""Findings on a run while it lasts and when it fails: values that cannot be, vibrations that steps do not resolve."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from flexmb.engine.newmark.method import Newmark
from flexmb.engine.radau.method import RadauIIA
from flexmb.engine.state.record import DONE, NEWTON_FAILED, NOT_FINITE, RUNNING, SINGULAR, STEP_TOO_SMALL, kept_poses
from flexmb.engine.step.method import Method
from flexmb.engine.step.runge_kutta import RungeKutta4
from flexmb.engine.step.step_size import Adaptive, FixedStep
from flexmb.engine.system.state_evaluation import Instant, changed_contacts, failed_kernel
from flexmb.errors import USER_ERRORS, FlexmbError, KernelError
from flexmb.findings.dimensions import implausible_findings
from flexmb.findings.finding import NOTHING_MOVES, WHAT_MOVES, Finding, found
from flexmb.model.law import FrictionLaw, Law, Motion, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part, WatchedMotion
from flexmb.program.program import FRICTION_Z, NORMAL_Z, Program
from flexmb.results.contact_intervals import ContactLog
from flexmb.run.saving import all_peaks
from flexmb.run.stopping import Condition
from flexmb.statics.eigen import moves_most
from flexmb.statics.modes import Examination, LinearModes, State, Vibrations, fastest_bound, loop_modes

if TYPE_CHECKING:
    from flexmb.run.run import Run

# The part of the examination that costs next to nothing, of every run: laws and motions of users, tables, numbers

REMEMBERED = 512  # number of laws whose findings are remembered: a sweep declares the same ones again and again
TRIED_GAP = 1e-4  # size of the gaps at which normal laws are tried [m]


def cheap_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on laws and motions of users, on tables, and on implausible angles and gravity."""
    findings = implausible_findings(mechanism)
    for name, law in _laws(mechanism):
        kind: Any = type(law)
        if kind.findings is not Law.findings or kind.kernel.function.__module__.partition(".")[0] != "flexmb":
            try:
                findings += _of_law(name, law)
            except TypeError:  # a law with arrays, which is not remembered
                findings += _of_law.__wrapped__(name, law)
    return findings


def _laws(mechanism: Mechanism) -> Iterator[tuple[str, Law]]:
    """Laws and motions among the fields of all parts, and among several in one field, with the names of the parts."""
    for part in mechanism.parts:
        for value in vars(part).values():
            for one in value if type(value) is tuple else (value,):
                if isinstance(one, Law):
                    yield part.name, one


@lru_cache(maxsize=REMEMBERED)
def _of_law(name: str, law: Law) -> tuple[Finding, ...]:
    """Findings on one law or motion of a part."""
    from flexmb.findings.laws import friction_sign, is_ours, normal_sign, wrong_rates

    own = tuple(law.findings(name))
    if is_ours(law.kernel):
        return own
    if isinstance(law, Motion):
        return (*own, *wrong_rates(name, law))
    if isinstance(law, NormalLaw):
        return (*own, *normal_sign(name, law, TRIED_GAP))
    return (*own, *friction_sign(name, law)) if isinstance(law, FrictionLaw) else own


LEAST_STEPS = 4.0  # steps of an impact below which its restitution means nothing
# Share of the impulses of a contact in such impacts above which there is a finding, and above which the run is not ok.
SHARE, IMPOSSIBLE_SHARE = 0.01, 0.2
ONE_INSTANT = ("broken-kernel", "jumping-drive")  # codes on one instant, which a run that ends before does not meet


def watched_motion(run: Run) -> WatchedMotion:
    """Motion of a run that has ended, whatever is saved."""
    record, signals = run.record, run.stepper.reported.names.signals
    times, values, z, sizes, even = kept_poses(record.poses, float(run.flow.clock.t), record.signals, run.flow.z)
    return WatchedMotion(
        signals, times, values, z, sizes, even, peaks=all_peaks(run), reported=(record.peak, record.peak_time),
        lows={signals.names[k]: (low[0], low[1]) for k, low in zip(record.low_places, record.lows, strict=True)},
        fixed_step=run.step.size if isinstance(run.step, FixedStep) else None, failed=run.code in STEP_CODES,
    )  # fmt: skip


def watch_findings(mechanism: Mechanism, motion: WatchedMotion, contacts: ContactLog) -> Iterator[Finding]:
    """Findings on a run that has ended."""
    for finding in cheap_findings(mechanism):
        if finding.code not in ONE_INSTANT or finding.numbers.get("time", 0.0) <= motion.times[-1]:
            yield finding
    for name, part, size in _sizes(mechanism, contacts.names):  # journals, pins and sliders, pressed deep
        depth, when = motion.peak(f"{name}.penetration")
        if depth > part.deep_from * size:
            through = depth > part.lost_beyond * size
            text = f"At t = {when:.6g} s {part.label} is penetrated by {depth:.4g} m, its size is {size:.4g} m: "
            text += f"{part.lost_when if through else 'far beyond the validity of any law'}."
            remedy = "A stiffness in N/mm^1.5 is to be multiplied by 3.16e4; else take smaller steps."
            yield found("deep-contact", (part.name,), text, remedy, wrong=through, time=when, depth=depth, size=size)
    h = motion.fixed_step
    for k, name in enumerate(contacts.names if h is not None else ()):  # of a few fixed steps: an accident of the steps
        own = contacts.columns(k)
        lasted, impulse = own["end"] - own["start"], own["impulse"]
        coarse = lasted < LEAST_STEPS * (h or 0.0)  # NaN, of one that lasts, is not
        share = float(impulse[coarse].sum()) / float(impulse.sum()) if impulse.sum() > 0.0 else 0.0
        if share > SHARE:
            first, need = float(own["start"][coarse][0]), float(np.median(lasted[coarse])) / 32.0
            text = f"{int(coarse.sum())} of {len(coarse)} contacts of {name!r} last less than {LEAST_STEPS:g} of the"
            text += f" fixed steps ({h:.3g} s), the first at t = {first:.6g} s: their restitution is an accident of the"
            remedy, wrong = f"Take steps of {need:.2g} s, or Adaptive().", share > IMPOSSIBLE_SHARE
            owner = (name.partition(".")[0],)
            yield found("coarse-step", owner, f"{text} steps.", remedy, wrong=wrong, time=first, share=share)
    for part in mechanism.parts:
        yield from part.answers("findings_after", mechanism, motion)
    for name, law in _laws(mechanism):
        if isinstance(law, Motion):
            yield from law.findings_beyond(name, float(motion.times[-1]))
    if motion.peak("energy.kinetic")[0] == 0.0 and mechanism.bodies and not any(mechanism.gravity):
        yield found("nothing-moves", (), NOTHING_MOVES, WHAT_MOVES)


def _sizes(mechanism: Mechanism, contacts: Sequence[str]) -> Iterator[tuple[str, Part, float]]:
    """Contacts of parts with a size, and that size [m]."""
    for part in mechanism.parts if contacts else ():
        size = part.contact_size(mechanism)
        if size is not None:
            yield from ((name, part, size) for name in contacts if name.partition(".")[0] == part.name)


def impossible_penetrations(mechanism: Mechanism, contacts: Sequence[str]) -> list[Condition]:
    """Conditions that end a run at once: a journal that passes through its bearing, or parts through each other."""
    return [
        Condition(f"{name}.penetration", part.lost_beyond * size, 1, f"{part.label}: {part.lost_when}", is_fault=True)
        for name, part, size in _sizes(mechanism, contacts)
    ]


def law_findings_after(program: Program, z: np.ndarray, contacts: ContactLog, since: float) -> Iterator[Finding]:
    """Findings on normal laws by their histories z at the end; contacts from before `since` [s] are lasting."""
    for c, law in enumerate(program.normals):
        name, place = program.names.contacts[c], program.tables.contacts.z[c]
        history = z[place[NORMAL_Z] : place[FRICTION_Z]].tolist()
        told = [("left-validity", text) for text in law.remarks(history)]
        for code, text in (*told, *law.remarks_on(contacts.columns(c), history, since)):
            yield found(code, (name.partition(".")[0],), f"{name} ({type(law).__name__}): {text}.")


# Explanation of a run that failed: failed kernel, known cause, residuals, contacts, and a remedy that was tried

STEP_CODES = (SINGULAR, NOT_FINITE, NEWTON_FAILED, STEP_TOO_SMALL)  # codes of runs that ended because a step failed
SHOWN_RESIDUALS = 3  # number of the largest residuals in a note
LEAST_RESIDUAL = 1e-6  # residual relative to the largest force, below which a step did not fail by its residual
LEAST_RTOL = 1e-13  # tolerance relative to which round-off of the coordinates counts
TRIED_STEPS = 4000  # number of steps of a tried remedy at most


def kernel_that_failed(run: Run) -> Finding | None:
    """Finding on the kernel that raised or was not finite in the refused step of a run, or at its last state."""
    flow, trial, h = run.flow, run.trial, max(float(run.flow.clock.step_size), float(run.record.report.rejected_size))
    t, z = float(flow.clock.t), flow.z

    def instant(state: Any, ahead: float) -> Instant:
        q = state.q + ahead * state.v if state is flow else state.q
        return Instant(t + ahead, ahead, q, state.v, state.a, state.lam, z)

    instants = [instant(state, part * h) for state in (trial, flow) for part in (1.0, 0.5, 0.1, 2.0)]
    return failed_kernel(run.program, [*instants, instant(flow, 0.0)])


@contextmanager
def naming_kernels(run: Run) -> Iterator[None]:
    """Turn an exception of a user's kernel into a `KernelError` with part, kernel, time and arguments."""
    try:
        yield
    except FlexmbError:
        raise
    except USER_ERRORS as error:
        failed = kernel_that_failed(run)
        if failed is None:
            raise
        raise KernelError(failed.text) from error


def failure_findings(run: Run, mechanism: Mechanism, closed: Program, *, known: bool) -> Iterator[Finding]:
    """Findings on the causes of a failed run, which its status shows, and on its refused step."""
    # `closed` is the program with ideal joints for contacts and elastic joints; `known`: errors were seen in the
    # results. A run that reached its end or was stopped from outside has none.
    if run.code in (RUNNING, DONE) or run.note:
        return
    if run.code in STEP_CODES:
        yield from _refused_step(run)
        failed = kernel_that_failed(run)
        if failed is not None:
            yield failed
            return
    if known:
        return
    from flexmb.findings.check import causes_of_failure

    causes = causes_of_failure(mechanism, closed)
    yield from causes
    if not causes and run.code in STEP_CODES:
        yield from _other_remedies(run, mechanism)


def _refused_step(run: Run) -> Iterator[Finding]:
    """Findings on the largest residuals of the last evaluation, if they are large, and on contacts that change."""
    n, work, names = run.program.n_q, run.work, run.program.names.coordinates
    force, scale = work.r[:n] + work.Gl[:n], np.abs(np.concatenate([work.r[:n], work.Gl[:n]])).max(initial=0.0)
    if not np.isfinite(force).all():
        lost = ", ".join(repr(names[k]) for k in np.flatnonzero(~np.isfinite(force))[:SHOWN_RESIDUALS])
        yield found("refused-step", (), f"The forces of the refused step are not finite at {lost}.")
    elif np.abs(force).max(initial=0.0) > LEAST_RESIDUAL * scale:
        largest = np.argsort(-np.abs(force))[:SHOWN_RESIDUALS]
        units = np.where(np.asarray(run.program.tables.kind) == 1, "N m", "N")
        shown = ", ".join(f"{force[k]:.3g} {units[k]} at {names[k]!r}" for k in largest if force[k] != 0.0)
        yield found("refused-step", (), f"Largest residuals of the refused step: {shown}.")
    closed, opened = changed_contacts(run.program, run.flow.z, run.work.z_new)
    changes = [f"{name!r} closes" for name in closed] + [f"{name!r} opens" for name in opened]
    if changes:
        parts = dict.fromkeys(name.partition(".")[0] for name in (*closed, *opened))
        yield found("refused-step", tuple(parts), f"In the refused step {', '.join(changes)}.")


def _other_remedies(run: Run, mechanism: Mechanism) -> Iterator[Finding]:
    """Findings on a tolerance below round-off, and on the first of some steps that gets past the failed instant."""
    least = float(np.spacing(max(run.program.length, np.abs(run.flow.q).max(initial=0.0))))
    if isinstance(run.step, Adaptive) and (run.step.rtol < LEAST_RTOL or run.error < 10.0 * least):
        text = f"The tolerance (rtol = {run.step.rtol:g}, atol = {run.error:.3g} m) is below the round-off"
        text = f"{text} of the coordinates, {least:.3g} m."
        yield found("failed-step", (), text, "Give a larger rtol or atol.", atol=run.error, round_off=least)
    now = float(run.flow.clock.t)
    target = min(now + run.h_max, run.t_end)
    others: list[FixedStep | Adaptive]  # steps that may get past the failure, the cheapest first
    if isinstance(run.step, FixedStep):
        others = [run.step.finer(), FixedStep(0.1 * run.step.size), Adaptive(), Adaptive(rtol=1e-6)]
    else:
        least_step = None if run.step.min is None else 1e-3 * run.step.min
        finer, smaller = run.step.finer(), dataclasses.replace(run.step, min=least_step)
        coarser = dataclasses.replace(run.step, rtol=min(10.0 * run.step.rtol, 1e-2), atol=None)
        finest = dataclasses.replace(finer.finer(), min=least_step)
        others = [finer, *([] if least_step is None else [smaller]), coarser, finest]
    for step in others if target > now else ():
        if _passes(run, mechanism, step, target):
            values = {field.name: getattr(step, field.name) for field in dataclasses.fields(step)}
            given = ", ".join(f"{name}={value:.4g}" for name, value in values.items() if value is not None)
            text = f"Tried: with step={type(step).__name__}({given}) the run gets past this instant."
            yield found("failed-step", (), text)
            return


def _passes(run: Run, mechanism: Mechanism, step: FixedStep | Adaptive, target: float) -> bool:
    """Whether a run with another step goes from the last good state to a later instant [s]."""
    try:
        run.method.check("simulate", step, "refuse")
        other = type(run)(run.stepper.reported, run.method, step, run.t_end, run.period, mechanism=mechanism)
        other.resume(run.restart(), "simulate", redundant=run.redundant > 0)
        other.max_steps = int(other.record.count.steps) + TRIED_STEPS
        other.flow.clock.step_size = other.h_max if isinstance(step, FixedStep) else 1e-3 * other.h_max
        other.run_to(target, saving=None)
    except FlexmbError:
        return False
    return other.code == DONE and not other.note


# Error that a run accumulates in vibrations: phase and amplitude that the steps lose, also under driving. The modes
# about some states say how much of the energy is that of a vibration (`flexmb.statics.modes`), and the method's own
# factor how much of it the steps shift. The states are those that the run keeps, whatever is saved.


class Loss(NamedTuple):
    """Loss of a vibration in a number of steps."""

    phase: float  # lag behind the exact vibration at the end [rad]
    amplitude: float  # lost share of the amplitude; below 0 where it grows


def loss_of(method: Method, omega: float, h: float, steps: float, *, first_order: bool = False) -> Loss | None:
    """Loss of an undamped vibration in a number of equal steps; None for a method whose factor is not known."""
    factor = amplification(method, omega * h, first_order=first_order)
    if factor is None:
        return None
    with np.errstate(over="ignore"):
        kept = float(np.abs(factor) ** steps)
    return Loss(steps * (omega * h - float(np.angle(factor))), 1.0 - kept)


def amplification(method: Method, angle: float, *, first_order: bool = False) -> complex | None:
    """Factor by which a step multiplies a vibration exp(i omega t); exact is exp(i omega h)."""
    # Of Newmark's family the principal eigenvalue of the amplification matrix, of Runge-Kutta methods R(i omega h).
    # Sources: J. Chung, G. M. Hulbert, A time integration algorithm for structural dynamics with improved numerical
    # dissipation: the generalized-alpha method, Journal of Applied Mechanics 60 (1993) 371-375; E. Hairer, G. Wanner,
    # Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, IV.3.
    z = 1j * angle
    if isinstance(method, RungeKutta4):
        return 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))
    if isinstance(method, RadauIIA):
        return (1.0 + 0.4 * z + z**2 / 20.0) / (1.0 - 0.6 * z + 0.15 * z**2 - z**3 / 60.0)
    if not isinstance(method, Newmark):
        return None
    am, af, beta, gamma = method.alpha_m, method.alpha_f, method.beta, method.gamma
    if first_order:  # x1 = x + (1 - gamma) x' + gamma x1', in the unknowns x, h x'
        after = np.array([[1.0, -gamma], [-(1.0 - af) * z, 1.0 - am]])
        before = np.array([[1.0, 1.0 - gamma], [af * z, -am]])
    else:
        k = angle**2  # with a = -k q / h^2, in the unknowns q, h v, h^2 x at both ends of a step
        after = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1.0 - af) * k, 0.0, 1.0 - am]])
        before = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1.0 - gamma], [-af * k, 0.0, -am]])
    values = np.linalg.eigvals(np.linalg.solve(after, before))
    return complex(values[np.argmin(np.abs(values - np.exp(z)))])


# Number of coordinates above which modes would take too long, and of coordinates and states of control loops.
MOST_UNKNOWNS, MOST_CONTROLLED = 20_000, 150
FEWEST_STEPS = 2000  # steps of a run with contacts from which the estimate is made, which costs some hundred steps
# Number of poses that are looked at, also of large models; states from each on, and their distance over the run.
POSES, POSES_OF_LARGE, AROUND, DISTANCE = 6, 2, 4, 1e-3
# Number of coordinates from which there are fewer states from each pose on, and of a large model; these states.
MANY, LARGE, AROUND_OF_MANY = 40, 150, 2
FEWEST_INSTANTS, FEWEST_STATES = 12, 3  # kept states, all and those of the same contacts, that energies need
ENERGY_SHARE = 0.01  # share of the elastic energy, or of the square of a controller's state, from which a mode matters
DECAY = 0.1  # energy in the last third of a run over that in the first one, below which a vibration has died out
PART_OF_STEP = 0.1  # time of the differences along the motion, relative to a step
UNRESOLVED = 1.0  # angular frequency times step above which a vibration is not resolved
LOST_PHASE, LOST_AMPLITUDE = 0.1, 2e-3  # phase [rad] and share of the amplitude that may be lost without a remark
CLEAR_LOSS = 0.75  # part of the limits of losses below which a vibration is not looked at any closer
SAME = 0.05  # relative difference of angular frequencies up to which modes under other contacts are one vibration


class Mode(NamedTuple):
    """Mode that carries energy: angular frequency [rad/s], share of the energy, loss, and words for both."""

    omega: float
    share: float
    lost: Loss
    contacts: bytes  # contacts that are closed meanwhile
    moves: str
    kind: str
    energy: str


@dataclass(frozen=True)
class Looked:
    """Data of a run for a later examination of its vibrations."""

    program: Program
    method: Method
    begun: float  # instant at which the run began, its duration [s], its number of steps
    span: float
    steps: int
    fixed_step: float | None
    times: np.ndarray  # (n,) instants of the states that are looked at [s]
    motions: np.ndarray  # (n, 3, n_q) coordinates, their rates and those of these
    z: np.ndarray  # (n, n_z) histories
    first: np.ndarray  # (n,) whether they are the first ones from a pose on
    sizes: np.ndarray  # (m,) sizes of steps, evenly distributed [s]
    closed: np.ndarray  # (m, contacts) contacts that are closed after them
    largest: np.ndarray  # largest values of the states of controllers

    @staticmethod
    def at(run: Run, motion: WatchedMotion, begun: float) -> Looked:
        """Data of a run from `begun` [s] on and of its motion."""
        program, even, n = run.program, motion.even, run.program.n_q
        kept, rows, first = np.flatnonzero(even), np.zeros(0, dtype=int), np.zeros(0, dtype=bool)
        if n != program.n_c and len(kept) >= FEWEST_INSTANTS:  # something is free to move, and enough is kept
            poses = np.arange(POSES_OF_LARGE if n >= LARGE or program.names.contacts else POSES)
            times = motion.times[kept]
            later = np.arange(AROUND_OF_MANY if MANY <= n < LARGE else AROUND)[:, None]
            # At uneven distances; `first`: those that are the first ones from a pose on
            wanted = (poses + poses * 0.618034 % 1.0) / len(poses) + later * DISTANCE
            places = np.searchsorted(times, times[0] + wanted * (times[-1] - times[0]))
            places = np.minimum(np.maximum(places, places[0] + later), len(kept) - 1)
            chosen = np.unique(places)
            rows, first = kept[chosen], np.isin(chosen, places[0])
        return Looked(
            program, run.method, begun, float(run.flow.clock.t) - begun, int(run.record.count.steps), motion.fixed_step,
            motion.times[rows], motion.values[rows, : 3 * program.n_q].reshape(len(rows), 3, program.n_q),
            motion.z[rows], first, motion.sizes[even], program.closed_contacts(motion.z[even]),
            run.flow.largest_states.copy(),
        )  # fmt: skip

    def states(self, rows: Iterable[int]) -> list[State]:
        """States of some rows."""
        q, v, a = self.motions.swapaxes(0, 1)
        return [State(float(self.times[k]), q[k], v[k], a[k], self.z[k]) for k in rows]

    def loss(self, omega: float, decay: float, rows: Any = slice(None), *, first_order: bool = False) -> Loss:
        """Loss of a mode in some of the steps while damping lets it remember; the lost phase grows with h^2."""
        h = self.sizes[rows]
        size = float(np.sqrt((h**3).sum() / h.sum()))
        memory = min(self.span * float(h.sum() / self.sizes.sum()), 1.0 / max(decay, 1e-300))
        return loss_of(self.method, omega, size, memory / size, first_order=first_order) or Loss(0.0, 0.0)

    def is_small(self, omega: float, decay: float = 0.0) -> bool:
        """Whether steps resolve a vibration and lose little of it, as of all slower ones."""
        if not omega * float(self.sizes.max()) < UNRESOLVED:
            return False
        lost = self.loss(omega, decay)
        return abs(lost.phase) < CLEAR_LOSS * LOST_PHASE and abs(lost.amplitude) < CLEAR_LOSS * LOST_AMPLITUDE


def vibration_findings(looked: Looked) -> Iterator[Finding]:
    """Findings on the fastest vibration with energy of which steps lose a part."""
    program = looked.program
    if looked.steps < (FEWEST_STEPS if program.names.contacts else 1) or not len(looked.times):
        return
    if program.n_q > MOST_UNKNOWNS:
        text = f"With {program.n_q} coordinates nothing is known of the phase that vibrations lose in the steps."
        yield found("bookkeeping", (), text)
        return
    try:
        seen = Examination(program, PART_OF_STEP * looked.span / looked.steps)
        groups = [] if _are_resolved(looked, seen) else seen.groups(looked.states(range(len(looked.times))))
        modes = [*_modes(looked, groups), *_loops(looked)]
    except (FlexmbError, np.linalg.LinAlgError, ValueError):  # no modes: the run has said why
        return
    for mode in sorted(modes, key=lambda one: -one.omega):
        near = [one for one in modes if abs(one.omega - mode.omega) < SAME * mode.omega]
        same = {one.contacts: one.lost for one in sorted(near, key=lambda one: abs(one.lost.phase))}.values()
        lost = Loss(sum(one.phase for one in same), 1.0 - math.prod(1.0 - one.amplitude for one in same))
        if abs(lost.phase) >= LOST_PHASE or abs(lost.amplitude) >= LOST_AMPLITUDE:
            verb, part = "lose" if lost.amplitude >= 0.0 else "add", mode.moves.partition(".")[0]
            text = f"The {mode.kind} of {mode.omega / (2.0 * np.pi):.4g} Hz (mostly {mode.moves}) carries "
            text += f"{100.0 * min(mode.share, 1.0):.3g} % of the {mode.energy}; until the end the steps lose some "
            text += f"{abs(lost.phase):.2g} rad of its phase and {verb} {100.0 * abs(lost.amplitude):.3g} % of its "
            remedy = "A smaller rtol or step, or RadauIIA(), loses less."
            numbers = {**lost._asdict(), "share": mode.share}
            yield found("lost-vibration", (part,), f"{text}amplitude.", remedy, **numbers)
            return
    if looked.fixed_step is not None and groups and groups[0].states[0].t == looked.begun:
        yield from _unresolved_start(program, groups[0], looked.fixed_step)


def _are_resolved(looked: Looked, seen: Examination) -> bool:
    """Whether the steps resolve all vibrations, or all vibrations with energy at a few states."""
    _, others = np.unique(looked.program.closed_contacts(looked.z), axis=0, return_index=True)
    few = looked.states(np.union1d(np.flatnonzero(looked.first), others))
    if looked.is_small(fastest_bound(looked.program, few)):
        return True
    for _, energies, modes in seen.groups(few):
        # y^2 + y'^2 and y'^2 + y''^2 of a vibration are twice its energy at any phase: the limit has a margin of two.
        largest = (energies[:, 0:2] + energies[:, 1:3]).min(axis=1).max(axis=0)
        if looked.fixed_step is not None:
            largest = np.maximum(largest, energies[0, 2])
        carries = largest > ENERGY_SHARE * _of_kind(energies[:, 0].mean(axis=0), modes.elastic)
        if not all(looked.is_small(*pair) for pair in zip(modes.omega[carries], modes.decay[carries], strict=True)):
            return False
    return True


def _modes(looked: Looked, found: list[Vibrations]) -> Iterator[Mode]:
    """Modes that carry energy, with the loss of each in the steps while the same contacts are closed."""
    program = looked.program
    energy = "elastic energy of the motion" if program.drives or program.motions else "energy of vibration"
    for states, energies, modes in found:
        contacts = program.closed_contacts(states[0].z)
        rows = (looked.closed == contacts).all(axis=-1)
        # Largest shares in a third of the run, and whether modes die out.
        whole = _of_kind(energies[:, 0].mean(axis=0), modes.elastic)
        thirds = np.array([third.mean(axis=0).min(axis=0) for third in np.array_split(energies, 3) if len(third)])
        shares = np.divide(thirds.max(axis=0), whole, out=0.0 * whole, where=whole > 0.0)
        decayed = thirds[-1] < DECAY * thirds[0]
        for k in np.flatnonzero(shares > ENERGY_SHARE) if len(states) >= FEWEST_STATES else ():
            lost = looked.loss(float(modes.omega[k]), float(modes.decay[k]), rows)
            words = ("vibration", energy) if modes.elastic[k] else ("swing under its loads", "energy of swings")
            if not decayed[k] or lost.amplitude >= 0.5:
                known = float(modes.omega[k]), float(shares[k]), lost, contacts.tobytes()
                yield Mode(*known, _moves(program, modes, int(k)), *words)


def _loops(looked: Looked) -> Iterator[Mode]:
    """Vibrations of the states of controllers, with the loss of each in the steps."""
    program = looked.program
    if not len(looked.largest) or program.n_q > MOST_CONTROLLED:
        return
    names, (last,) = program.names.coordinates[program.tables.sizes.n_b :], looked.states([-1])
    for s, amplitudes in zip(*loop_modes(program, last), strict=True):
        shares = (amplitudes / np.maximum(looked.largest, 1e-300)) ** 2
        k = int(np.argmax(shares))
        if shares[k] > ENERGY_SHARE:
            lost = looked.loss(float(s.imag), -float(s.real), first_order=True)
            words = names[k], "vibration of a controller", f"square of {names[k]}"
            yield Mode(float(s.imag), float(shares[k]), lost, b"", *words)


def _unresolved_start(program: Program, group: Vibrations, h: float) -> Iterator[Finding]:
    """Finding on a vibration with which a run begins, where fixed steps of size h [s] are too long for its period."""
    whole = float(group.energies[:, 0].sum(axis=1).mean())
    begun = 0.5 * group.energies[0, 2]  # y less what slow loads give is -y''/omega^2
    coarse = np.flatnonzero((group.modes.omega * h > UNRESOLVED) & (begun > ENERGY_SHARE * whole))
    if not len(coarse):
        return
    k = int(coarse[np.argmax(begun[coarse])])
    period = 2.0 * np.pi / float(group.modes.omega[k])
    moves = _moves(program, group.modes, k)
    text = f"The run begins with a vibration of {1.0 / period:.4g} Hz (mostly {moves}), {h / period:.2g} of whose"
    text += f" period is one step of {h:.3g} s: its peaks are not resolved."
    remedy = f"Take steps of {period / 20.0:.1g} s, Adaptive(), or a drive that starts softly."
    yield found("coarse-step", (moves.partition(".")[0],), text, remedy, step=h, period=period)


def _moves(program: Program, modes: LinearModes, k: int) -> str:
    """Name of the coordinate that mode k moves most."""
    shape = modes.shapes[:, k]
    return moves_most(program.names.coordinates[: len(shape)], program.length, shape)


def _of_kind(each: np.ndarray, elastic: np.ndarray) -> np.ndarray:
    """Sums (k,) over all modes of the kind, elastic or not, of each mode."""
    return np.asarray(np.where(elastic, each[elastic].sum(), each[~elastic].sum()))
