"""Watch over a run: contacts, motions of parts and laws that cannot be right, with time, part and remedy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from flexmb.engine.state.record import kept_poses
from flexmb.engine.step.step_size import FixedStep
from flexmb.findings.dimensions import implausible_findings
from flexmb.findings.failure import STEP_CODES
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

REMEMBERED = 512
"""Number of laws whose findings are remembered: a sweep declares the same ones again and again."""

TRIED_GAP = 1e-4
"""Size of the gaps at which normal laws are tried [m]."""

_TRIED: dict[type, bool] = {}
"""Whether values of a class are tried."""

_KNOWN: dict[tuple[str, Law], tuple[Finding, ...]] = {}
"""Findings by part and law."""


def cheap_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on users' laws and motions, on tables, and on implausible angles and gravity.

    flexmb's own laws are known to keep their signs.
    """
    findings = implausible_findings(mechanism)
    for part in mechanism.parts:
        for value in vars(part).values():
            kind = type(value)
            if kind not in _TRIED:
                _TRIED[kind] = _is_tried(kind)
            if _TRIED[kind]:
                findings += _remembered(part.name, value)
    return findings


def _is_tried(kind: type) -> bool:
    """Whether a class is one of laws and motions that are not flexmb's own, or that have findings on their numbers."""
    if not issubclass(kind, Law):
        return False
    ours = kind.kernel.function.__module__.partition(".")[0] == "flexmb"
    return not ours or kind.findings is not Law.findings


def _remembered(name: str, law: Law) -> tuple[Finding, ...]:
    """Findings on a law; of a law with arrays they are not remembered."""
    try:
        found = _KNOWN.get((name, law))
    except TypeError:
        return _of_law(name, law)
    if found is None:
        if len(_KNOWN) >= REMEMBERED:
            _KNOWN.clear()
        found = _KNOWN[name, law] = _of_law(name, law)
    return found


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


# Contacts, motions of parts and laws that cannot be right, by peaks, intervals and poses of a run

LEAST_STEPS = 4.0
"""Steps of an impact below which its restitution means nothing."""

SHARE, IMPOSSIBLE_SHARE = 0.01, 0.2
"""Share of the impulses of a contact in such impacts above which there is a finding, and above which the run is not
ok."""

ONE_INSTANT = ("broken-kernel", "jumping-drive")
"""Codes of findings on one instant of a motion, which a run that ends before does not meet."""


def watched_motion(run: Run) -> WatchedMotion:
    """Motion of a run that has ended, whatever is saved."""
    record, signals = run.record, run.stepper.reported.names.signals
    times, values, z, sizes, even = kept_poses(record.poses, float(run.flow.clock.t), record.signals, run.flow.z)
    return WatchedMotion(
        signals,
        times,
        values,
        z,
        sizes,
        even,
        peaks=all_peaks(run),
        reported=(record.peak, record.peak_time),
        lows={signals.names[k]: (low[0], low[1]) for k, low in zip(record.low_places, record.lows, strict=True)},
        fixed_step=run.step.size if isinstance(run.step, FixedStep) else None,
        failed=run.code in STEP_CODES,
    )


def watch_findings(mechanism: Mechanism, motion: WatchedMotion, contacts: ContactLog) -> Iterator[Finding]:
    """Findings on a run that has ended."""
    for finding in cheap_findings(mechanism):
        if finding.code not in ONE_INSTANT or finding.numbers.get("time", 0.0) <= motion.times[-1]:
            yield finding
    yield from _penetrations(mechanism, motion, contacts.names)
    yield from _coarse_contacts(motion, contacts)
    for part in mechanism.parts:
        yield from part.answers("findings_after", mechanism, motion)
    if motion.peak("energy.kinetic")[0] == 0.0 and mechanism.bodies and not any(mechanism.gravity):
        yield found("nothing-moves", (), NOTHING_MOVES, WHAT_MOVES)


def _sizes(mechanism: Mechanism, contacts: Sequence[str]) -> Iterator[tuple[str, Part, float]]:
    """Contacts of parts with a size, and that size [m]."""
    for part in mechanism.parts if contacts else ():
        size = part.contact_size(mechanism)
        if size is not None:
            yield from ((name, part, size) for name in contacts if name.partition(".")[0] == part.name)


def _penetrations(mechanism: Mechanism, motion: WatchedMotion, contacts: Sequence[str]) -> Iterator[Finding]:
    """Findings on journals, pins and sliders that are pressed deep into their bearings and guides."""
    for name, part, size in _sizes(mechanism, contacts):
        depth, when = motion.peak(f"{name}.penetration")
        if depth > part.deep_from * size:
            through = depth > part.lost_beyond * size
            text = f"At t = {when:.6g} s {part.label} is penetrated by {depth:.4g} m, its size is {size:.4g} m: "
            text += f"{part.lost_when if through else 'far beyond the validity of any law'}."
            remedy = "A stiffness in N/mm^1.5 is to be multiplied by 3.16e4; else take smaller steps."
            yield found("deep-contact", (part.name,), text, remedy, wrong=through, time=when, depth=depth, size=size)


def impossible_penetrations(mechanism: Mechanism, contacts: Sequence[str]) -> list[Condition]:
    """Conditions that end a run at once: a journal that passes through its bearing, or parts through each other."""
    return [
        Condition(f"{name}.penetration", part.lost_beyond * size, 1, f"{part.label}: {part.lost_when}", is_fault=True)
        for name, part, size in _sizes(mechanism, contacts)
    ]


def law_findings_after(program: Program, z: np.ndarray, contacts: ContactLog, since: float) -> Iterator[Finding]:
    """Findings on the validity of normal laws, by the histories z at the end of a run.

    Contacts that began before the instant `since` [s] are called lasting.
    """
    for c, law in enumerate(program.normals):
        name, place = program.names.contacts[c], program.tables.contacts.z[c]
        history = z[place[NORMAL_Z] : place[FRICTION_Z]].tolist()
        told = [("left-validity", text) for text in law.remarks(history)]
        for code, text in (*told, *law.remarks_on(contacts.columns(c), history, since)):
            yield found(code, (name.partition(".")[0],), f"{name} ({type(law).__name__}): {text}.")


def _coarse_contacts(motion: WatchedMotion, contacts: ContactLog) -> Iterator[Finding]:
    """Findings on contacts of a few fixed steps, whose restitution is an accident of the steps."""
    h = motion.fixed_step
    for k, name in enumerate(contacts.names if h is not None else ()):
        own = contacts.columns(k)
        lasted, impulse = own["end"] - own["start"], own["impulse"]
        coarse = lasted < LEAST_STEPS * (h or 0.0)  # NaN, of one that lasts, is not
        share = float(impulse[coarse].sum()) / float(impulse.sum()) if impulse.sum() > 0.0 else 0.0
        if share > SHARE:
            first, need = float(own["start"][coarse][0]), float(np.median(lasted[coarse])) / 32.0
            text = (
                f"{int(coarse.sum())} of {len(coarse)} contacts of {name!r} last less than {LEAST_STEPS:g} of the "
                f"fixed steps ({h:.3g} s), the first at t = {first:.6g} s: their restitution is an accident of the "
                "steps."
            )
            remedy, wrong = f"Take steps of {need:.2g} s, or Adaptive().", share > IMPOSSIBLE_SHARE
            yield found("coarse-step", (name.partition(".")[0],), text, remedy, wrong=wrong, time=first, share=share)
