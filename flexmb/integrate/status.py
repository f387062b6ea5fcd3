"""How a run ended, as a sentence that says what to try."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.arrays import DONE, NEWTON_FAILED, NOT_FINITE, SINGULAR, STEP_TOO_SMALL, Flow, Record, Trial
from flexmb.integrate.landing import STEP
from flexmb.program.program import Program

SENTENCES = {
    DONE: "Finished at {t}.",
    SINGULAR: "Stopped at {t}: the matrix became singular at {lost!r} (a singular pose?), with a step of {h}.",
    NOT_FINITE: "Stopped at {t}: the state is no longer finite{worst}, with a step of {h}. Try a smaller step.",
    NEWTON_FAILED: (
        "Stopped at {t}: Newton did not converge with a step of {h}: last correction {last:.2g}, "
        "wanted {wanted:.2g}{worst}. Try a smaller step, or step=Adaptive()."
    ),
    STEP_TOO_SMALL: (
        "Stopped at {t}: a step of {h}, the smallest one allowed, was refused; {cause}. "
        "Try Adaptive(...) with a smaller min{remedy}."
    ),
}

EXCHANGED = ("kinetic", "strain", "drive_work", "load_work")
MOST = 8
"""Joints that are listed."""

POOR_BALANCE = 0.05
"""Largest residual of the energies, as part of the largest energy exchanged, that goes without a warning."""


def sentence(program: Program, code: int, flow: Flow, trial: Trial, record: Record) -> str:
    """The status of a run that ended with `code`."""
    names = (*program.names.coordinates, *program.names.rows)
    template = SENTENCES.get(code, "Not finished, at {t}.")
    cause, remedy = refused(program, flow, trial, record)
    text = template.format(
        t=f"t = {flow.clock[0]:.6g} s",
        h=f"{record.extreme[8] or flow.clock[1]:.3g} s",
        cause=cause,
        remedy=remedy,
        lost=names[int(record.count[6])],
        last=record.extreme[2],
        wanted=record.extreme[3],
        worst=_worst(program, flow, trial),
    )
    return text + not_unique(program, trial, record) + balance(program, record) if code == DONE else text


def refused(program: Program, flow: Flow, trial: Trial, record: Record) -> tuple[str, str]:
    """What asked for a smaller step than the smallest one, and what helps beside a smaller one."""
    met = int(record.count[11]) - 1
    if met >= 0:
        needed = flow.impacts[met, STEP]
        why = f"the impact of {_seen(program, flow, met)} needs steps of {needed:.3g} s"
        return why, ", fewer impact_steps, or a softer contact"
    why = f"the error of the step was too large, or Newton did not converge{_worst(program, flow, trial)}"
    closed = any(flow.z[k] > 0.0 for k in program.tables.contacts.z[:, 0])
    jump = ", or a contact law without a jump at the touch (KelvinVoigt: a ramp; friction: v0 > 0)" if closed else ""
    return why, f", or a larger rtol and atol{jump}"


def _seen(program: Program, flow: Flow, contact: int) -> str:
    """A contact with its gap and gap rate at the last good step."""
    k = program.tables.contacts.z[contact, 0]
    return f"{program.names.contacts[contact]!r} (gap {flow.z[k + 2]:.3g} m, gap rate {flow.z[k + 4]:.3g} m/s)"


def not_unique(program: Program, trial: Trial, record: Record) -> str:
    """Which joints had forces that are not unique, and why; "" when there are none."""
    if record.count[7] == 0:
        return ""
    rows = np.flatnonzero(record.held)
    joints = list(dict.fromkeys(program.names.rows[k].partition("[")[0] for k in rows))
    listed = ", ".join(repr(joint) for joint in joints[:MOST]) + (", ..." if len(joints) > MOST else "")
    if len(trial.free):
        return f" The joints {listed} repeat one another: their forces are those of least norm."
    when = f"t = {record.extreme[6]:.6g} s"
    return f" Passed a singular position at {when}, where the forces of {listed} are not unique."


def balance(program: Program, record: Record) -> str:
    """A warning when the energies do not add up, so that nobody takes too coarse a run for a good one; else ""."""
    size = {s.name: float(p) for s, p in zip(program.names.signals, record.peak, strict=True)}
    moved = max(size[f"energy.{name}"] for name in EXCHANGED)
    # heights count from an arbitrary level: only their round-off says something
    scale = max(moved, 1e-6 * size["energy.gravity"])
    residual = size["energy.residual"]
    if residual <= POOR_BALANCE * scale:
        return ""
    return (
        f" But the balance of energy misses {residual:.2g} J where {scale:.2g} J were exchanged, so do not trust it: "
        "try a smaller step, or Adaptive(rtol=...) with a smaller rtol."
    )


def _worst(program: Program, flow: Flow, trial: Trial) -> str:
    """The coordinate that moved most in the last Newton correction, and the contacts that are closed."""
    d = np.abs(trial.d[: program.n_q])
    name = program.names.coordinates[int(np.argmax(np.where(np.isfinite(d), d, np.inf)))]
    phases = program.tables.contacts.z[:, 0]
    closed = [_seen(program, flow, c) for c, k in enumerate(phases) if flow.z[k] > 0.0]
    touching = f"; in contact: {', '.join(closed)}" if closed else ""
    return f"; largest at {name!r}{touching}"
