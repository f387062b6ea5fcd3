"""Remarks of contact laws on a run that has ended."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeGuard

import numpy as np

from flexmb.contact.normal.cylinder import CylinderLaw
from flexmb.contact.normal.hysteresis import HysteresisLaw
from flexmb.contact.onset import LARGEST
from flexmb.model.law import NormalLaw
from flexmb.program.program import Program
from flexmb.results.contact_intervals import COLUMNS, ContactLog

SMALL_SHARE = 0.01
"""Share of impulses or losses in contacts slower than `least_approach`, up to which there is no remark."""

APPROACH_PLACE = 3
"""Place of the approach speed in the history of a law with hysteresis damping."""

COLUMN = {name: k for k, (name, _) in enumerate(COLUMNS)}


def contact_remarks(program: Program, z: np.ndarray, log: ContactLog, end: float, span: float) -> tuple[str, ...]:
    """Remarks of all normal laws, each with the name of its joint and law, by histories z at the end of the run [s].

    `span` is the time without an onset after which a contact is called lasting [s].
    """
    found = []
    for c, law in enumerate(program.normals):
        place = program.tables.contacts.z[c]
        history = tuple(float(x) for x in z[place[1] : place[2]])
        label = f"{program.names.contacts[c]} ({type(law).__name__})"
        texts = list(law.remarks(history))
        rows = log.rows[log.rows[:, 0] == c]
        texts += [*_slow(law, rows), *_lasting(law, history, rows, end, span)]
        found += [f"{label}: {text}." for text in texts]
    return tuple(found)


def _slow(law: NormalLaw, rows: np.ndarray) -> Iterator[str]:
    """A remark where contacts that began slower than `least_approach` carry a share of impulses or losses.

    Those that were closed from the start have no approach speed, whatever that number is, and go without.
    """
    if not _damps(law) or law.reference_speed == LARGEST:
        return
    slow = rows[:, COLUMN["approach_speed"]] < law.least_approach
    shares = []
    for name in ("impulse", "dissipated_contact"):
        column = rows[:, COLUMN[name]]
        whole = float(column.sum())
        shares.append(float(column[slow].sum()) / whole if whole > 0.0 else 0.0)
    if max(shares) > SMALL_SHARE:
        text = f"{int(slow.sum())} of {len(rows)} contacts began below least_approach = {law.least_approach:g} m/s"
        text = f"{text}, and have {100.0 * shares[0]:.3g} % of the impulse and {100.0 * shares[1]:.3g} % of the loss"
        text = f"{text}; their damping follows the largest speed while they last, that of the others the speed at which"
        yield f"{text} the surfaces met. reference_speed='largest' treats all alike"


def _lasting(law: NormalLaw, history: Sequence[float], rows: np.ndarray, end: float, span: float) -> Iterator[str]:
    """A remark on a contact that is closed at the end of the run and began more than `span` before."""
    for row in rows[np.isnan(rows[:, COLUMN["end"]]) & (rows[:, COLUMN["peak_force"]] > 0.0)]:
        start = row[COLUMN["start"]]
        damped = damped_since_onset(law, history)
        if damped and not start > end - span:
            since = "the start" if np.isnan(start) else f"t = {start:.6g} s"
            yield f"the surfaces have touched without a break since {since}; {damped}"


def damped_since_onset(law: NormalLaw, history: Sequence[float]) -> str:
    """Sentence on the speed that scales the damping of a lasting contact; "" without hysteresis damping."""
    if not _damps(law):
        return ""
    approach = history[APPROACH_PLACE]
    if law.reference_speed == LARGEST or approach < law.least_approach or approach <= 0.0:
        return "its damping follows the largest speed since then"
    return f"its damping still follows the speed at which its surfaces met, {approach:.3g} m/s (docs/contact.md)"


def _damps(law: NormalLaw) -> TypeGuard[HysteresisLaw | CylinderLaw]:
    """Whether the law has hysteresis damping: one with restitution 1 has none."""
    return isinstance(law, HysteresisLaw | CylinderLaw) and law.restitution != 1.0
