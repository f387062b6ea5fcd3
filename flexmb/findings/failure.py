"""Explanation of a run that failed: failed kernel, known cause, residuals, contacts, and a remedy that was tried."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.engine.state.record import DONE, NEWTON_FAILED, NOT_FINITE, RUNNING, SINGULAR, STEP_TOO_SMALL
from flexmb.engine.step.step_size import Adaptive, FixedStep
from flexmb.engine.system.failed_kernels import Instant, changed_contacts, failed_kernel
from flexmb.errors import USER_ERRORS, FlexmbError, KernelError
from flexmb.findings.finding import Finding, found

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism
    from flexmb.program.program import Program
    from flexmb.run.run import Run

STEP_CODES = (SINGULAR, NOT_FINITE, NEWTON_FAILED, STEP_TOO_SMALL)
"""Codes of runs that ended because a step failed."""

SHOWN_RESIDUALS = 3
"""Number of the largest residuals in a note."""

LEAST_RESIDUAL = 1e-6
"""Residual relative to the largest force, below which a step did not fail by its residual."""

LEAST_RTOL = 1e-13
"""Tolerance relative to which round-off of the coordinates counts."""

TRIED_STEPS = 4000
"""Number of steps of a tried remedy at most."""


def kernel_that_failed(run: Run) -> Finding | None:
    """Finding on the kernel that raised or was not finite in the refused step of a run, or at its last state."""
    flow, trial, h = run.flow, run.trial, max(float(run.flow.clock.step_size), float(run.record.report.rejected_size))
    t, z = float(flow.clock.t), flow.z

    def instant(state: Any, ahead: float) -> Instant:
        q = state.q + ahead * state.v if state is flow else state.q
        return Instant(t + ahead, ahead, q, state.v, state.a, state.lam, z)

    steps = [part * h for part in (1.0, 0.5, 0.1, 2.0)]
    return failed_kernel(
        run.program, [*(instant(state, s) for state in (trial, flow) for s in steps), instant(flow, 0.0)]
    )


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
    """Findings on the causes of a failed run, which its status shows, and on its refused step.

    `closed` is the program with ideal joints for contacts and elastic joints; `known`: errors were seen in the results.
    A run that reached its end or was stopped from outside has none.
    """
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
