"""Watch over a run: contacts, motions of parts and laws that cannot be right; explanation of a run that failed."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.engine.state.record import DONE, NEWTON_FAILED, NOT_FINITE, RUNNING, SINGULAR, STEP_TOO_SMALL, kept_poses
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
                kind: Any = type(one)
                if _is_law(kind):
                    yield part.name, one


@cache
def _is_law(kind: type) -> bool:
    """Whether a class is one of laws and motions."""
    return issubclass(kind, Law)


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
    for step in _other_steps(run) if target > now else ():
        if _passes(run, mechanism, step, target):
            values = {field.name: getattr(step, field.name) for field in dataclasses.fields(step)}
            given = ", ".join(f"{name}={value:.4g}" for name, value in values.items() if value is not None)
            text = f"Tried: with step={type(step).__name__}({given}) the run gets past this instant."
            yield found("failed-step", (), text)
            return


def _other_steps(run: Run) -> list[FixedStep | Adaptive]:
    """Steps that may get past a failure, the cheapest first."""
    if isinstance(run.step, FixedStep):
        return [run.step.finer(), FixedStep(0.1 * run.step.size), Adaptive(), Adaptive(rtol=1e-6)]
    least = None if run.step.min is None else 1e-3 * run.step.min
    finer, smaller = run.step.finer(), dataclasses.replace(run.step, min=least)
    coarser = dataclasses.replace(run.step, rtol=min(10.0 * run.step.rtol, 1e-2), atol=None)
    return [finer, *([] if least is None else [smaller]), coarser, dataclasses.replace(finer.finer(), min=least)]


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
