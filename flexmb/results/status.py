"""Status of a run, remarks on it, and its main signals."""

from typing import Any

import numpy as np

from flexmb.display import quoted
from flexmb.engine import energy
from flexmb.engine.state import record as ends
from flexmb.engine.state.flow import EnergyBalance, Flow, Trial
from flexmb.engine.state.record import RunRecord
from flexmb.engine.step.contact_events import IMPACT_STEP
from flexmb.engine.step.step_size import RTOL
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Body, Joint
from flexmb.program.program import COMMON_Z, LAST_GAP, LAST_GAP_RATE, Program
from flexmb.results.solution import Solution, largest_signals

MOST = 16  # largest number of main signals
PANELS = 6  # largest number of panels of the picture
GUIDES = ("Prismatic", "PrismaticClearance", "WornGuide")  # classes of joints whose second body is a slider


def followed(mechanism: Mechanism) -> tuple[Body | None, Any]:
    """The output body of a mechanism, and its guide: the first slider, else the last body, which has none."""
    for part in mechanism.parts:
        if isinstance(part, Joint) and part.is_guide and part.second.name != GROUND.name:
            return mechanism.body(part.second.name), part
    return mechanism.bodies[-1] if mechanism.bodies else None, None


def main_signals(sol: Solution) -> list[str]:
    """Names of the main signals: acceleration of the output body, if it is known, and the largest peaks."""
    # Accelerations of the output body: along the guide of a slider, angular for another body
    parts = sol.described().get("parts", [])
    names = [f"{part['name']}.alpha" for part in parts if part["kind"] == "body"][-1:]
    guides = [part["fields"] for part in parts if part["class"] in GUIDES]
    if guide := next((fields for fields in guides if fields["second"][0] != GROUND.name), None):
        along = np.array(guide["along"][0])
        share = np.abs(along) / np.hypot(*along)
        names = [f"{guide['second'][0]}.{axis}" for axis, s in zip(("ax", "ay"), share, strict=True) if s > 1e-6]
    return list(dict.fromkeys([*(name for name in names if name in sol), *largest_signals(sol)]))[:MOST]


def panels(sol: Solution, names: list[str] | None = None) -> list[list[str]]:
    """Main signals by panel, one kind of signal per panel."""
    kinds: dict[tuple[str, str], list[str]] = {}
    for name in main_signals(sol) if names is None else names:
        kinds.setdefault((name.rpartition(".")[2], sol.units(name)), []).append(name)
    return list(kinds.values())[:PANELS]


# Status of a run: a sentence on its end, with a remedy

TRY_FINER = "Try {finer}, so that impacts and vibrations are resolved."

SENTENCES = {
    ends.DONE: "Finished at {t}.",
    ends.SINGULAR: "Stopped at {t}: the matrix became singular at {lost!r} (a singular pose?), with a step of {h}.",
    ends.NOT_FINITE: "Stopped at {t}: the state is no longer finite{worst}, with a step of {h}. Try a smaller step.",
    ends.NEWTON_FAILED: (
        "Stopped at {t}: Newton did not converge with a step of {h}: last correction {last:.2g}, "
        "wanted {wanted:.2g}{worst}. Try a smaller step, or step=Adaptive()."
    ),
    ends.STEP_TOO_SMALL: (
        "Stopped at {t}: a step of {h}, the smallest one allowed, was refused; {cause}. "
        "Try Adaptive(...) without min, if it was given{remedy}."
    ),
    ends.ENERGY_MISSING: (
        "Not ok at {t}: the energies do not add up, {missing} are missing where {put_in} were put in and "
        "{scale} turned over. Try {finer}; if that changes little, the energies of "
        "a part do not belong to its forces: testing.check_part finds it."
    ),
    ends.ENERGY_MADE: (
        "Not ok at {t}: the steps made energy, {taken} where {put_in} were put in ({kinetic} are kinetic), "
        "{in_contacts} of {through} that went through contacts. " + TRY_FINER
    ),
    ends.ENERGY_LOST: (
        "Not ok at {t}: the steps took energy that no law took, {taken} of {scale} turned over or in motion, "
        "{in_contacts} of {through} that went through contacts. " + TRY_FINER
    ),
}
# Friction that grows with the forces it causes (P. Painleve, Lecons sur le frottement, 1895).
SELF_LOCKING = (
    " Friction in joints, which grows with their own forces, may lock the mechanism or have no solution above some "
    "coefficient: see whether a smaller one runs; joints with clearance have a solution at any."
)

WARNING_FRACTION = 0.2  # part of the limits of the balance of energies, above which a good run has a warning


def sentence(program: Program, code: int, flow: Flow, trial: Trial, record: RunRecord) -> str:
    """The status of a run that ended with `code`."""
    t, template = f"t = {flow.clock.t:.6g} s", SENTENCES.get(code, "Not finished, at {t}.")
    if code == ends.DONE:
        warned = balance_warnings(flow.ledger, flow.balance)
        return template.format(t=t) + held_rows_sentence(program, trial, record) + warned
    names = (*program.names.coordinates, *program.names.rows)
    cause, remedy = rejected_sentence(program, flow, trial, record)
    may_lock = code in (ends.NEWTON_FAILED, ends.STEP_TOO_SMALL, ends.ENERGY_MISSING)
    template += SELF_LOCKING if may_lock and program.tables.sizes.has_joint_friction else ""
    return template.format(
        t=t, h=f"{record.report.rejected_size or flow.clock.step_size:.3g} s", cause=cause,
        remedy=remedy, lost=names[int(record.count.lost_pivot)], last=record.report.correction,
        wanted=record.report.tolerance, finer=finer_steps(trial.control.rtol),
        worst=_last_correction(program, flow, trial), **energy_texts(flow.ledger, flow.balance),
    )  # fmt: skip


def finer_steps(rtol: float) -> str:
    """Words for finer steps than at `rtol`; 1: fixed steps."""
    if rtol >= 1.0:
        return "a smaller step, or step=Adaptive()"
    if rtol < RTOL:
        return f"another method, e.g. RadauIIA(), since rtol = {rtol:g} is small"
    return f"step=Adaptive(rtol={0.1 * rtol:.3g})"


def rejected_sentence(program: Program, flow: Flow, trial: Trial, record: RunRecord) -> tuple[str, str]:
    """Reason for a step below the smallest one, and remedies beside a smaller one."""
    met = int(record.count.rejecting_contact) - 1
    if met >= 0:
        needed = flow.impacts[met, IMPACT_STEP]
        why = f"the impact of {_contact_in_words(program, flow, met)} needs steps of {needed:.3g} s"
        return why, ", fewer impact_steps, or a softer contact"
    why = f"the error of the step was too large, or Newton did not converge{_last_correction(program, flow, trial)}"
    closed = any(flow.z[k] > 0.0 for k in program.tables.contacts.z[:, COMMON_Z])
    jump = ", or a contact law without a jump at the touch (KelvinVoigt: a ramp; friction: v0 > 0)" if closed else ""
    return why, f", or a larger rtol and atol{jump}"


def _contact_in_words(program: Program, flow: Flow, contact: int) -> str:
    """A contact with its gap and gap rate at the last good step."""
    k = program.tables.contacts.z[contact, COMMON_Z]
    gap, rate = flow.z[k + LAST_GAP], flow.z[k + LAST_GAP_RATE]
    return f"{program.names.contacts[contact]!r} (gap {gap:.3g} m, gap rate {rate:.3g} m/s)"


def held_rows_sentence(program: Program, trial: Trial, record: RunRecord) -> str:
    """Sentence on joints whose forces are not unique; "" without such joints."""
    if record.count.held_steps == 0:
        return ""
    rows = np.flatnonzero(record.held_rows)
    listed = quoted(list(dict.fromkeys(program.names.rows[k].partition("[")[0] for k in rows)))
    if len(trial.free_multipliers):
        return f" The joints {listed} repeat one another: their forces are those of least norm."
    when = f"t = {record.report.first_held_time:.6g} s"
    return f" Passed a singular position at {when}, where the forces of {listed} are not unique."


def energy_texts(ledger: np.ndarray, balance: EnergyBalance) -> dict[str, str]:
    """Energies as texts for the status [J]."""
    return {
        "missing": f"{ledger[energy.RESIDUAL]:.3g} J", "taken": f"{abs(ledger[energy.ALGORITHM]):.3g} J",
        "in_contacts": f"{abs(balance.lost_in_contacts):.3g} J", "through": f"{balance.through_contacts:.3g} J",
        "kinetic": f"{ledger[energy.KINETIC]:.3g} J", "scale": f"{energy.energy_scale(ledger, balance):.3g} J",
        "put_in": f"{energy.energy_supplied(ledger, balance):.3g} J",
    }  # fmt: skip


def balance_warnings(ledger: np.ndarray, balance: EnergyBalance) -> str:
    """Warning of a poor balance of energies; "" for a good one."""
    scale, found = energy.energy_scale(ledger, balance), ""
    through = balance.through_contacts + energy.LEAST_CONTACT_FRACTION * scale
    supplied = energy.energy_supplied(ledger, balance)
    if abs(ledger[energy.RESIDUAL]) > WARNING_FRACTION * balance.residual_limit * min(scale, supplied):
        found += " But the energies miss {missing}, where {put_in} were put in and {scale} turned over: {remedy}."
    if abs(ledger[energy.ALGORITHM]) > WARNING_FRACTION * energy.ALGORITHM_LIMIT * scale:
        found += " But the steps {verb} {taken} of {scale} turned over or in motion: {remedy}."
    elif abs(ledger[energy.ALGORITHM]) > energy.ALGORITHM_LIMIT * supplied:
        found += " But the steps {verb} {taken} where {put_in} were put in: {remedy}."
    elif abs(balance.lost_in_contacts) > WARNING_FRACTION * energy.CONTACT_LIMIT * through:
        found += " But the steps {in_verb} {in_contacts} of {through} that went through contacts: {remedy}."
    if ledger[energy.CONTACT] < -WARNING_FRACTION * energy.CONTACT_LIMIT * through:
        made = -ledger[energy.CONTACT]
        found += f" But the laws of contact made {made:.3g} J of {{through}} that went through contacts."
    if not found:
        return ""
    verb, in_verb = ("took" if x > 0.0 else "made" for x in (ledger[energy.ALGORITHM], balance.lost_in_contacts))
    remedy = "try smaller ones to see what changes"
    return found.format(**energy_texts(ledger, balance), verb=verb, in_verb=in_verb, remedy=remedy)


def _last_correction(program: Program, flow: Flow, trial: Trial) -> str:
    """The coordinate that moved most in the last Newton correction, and the contacts that are closed."""
    d = np.abs(trial.solution[: program.n_q])
    name = program.names.coordinates[int(np.argmax(np.where(np.isfinite(d), d, np.inf)))]
    phases = program.tables.contacts.z[:, COMMON_Z]
    closed = [_contact_in_words(program, flow, c) for c, k in enumerate(phases) if flow.z[k] > 0.0]
    touching = f"; in contact: {', '.join(closed)}" if closed else ""
    return f"; largest at {name!r}{touching}"
