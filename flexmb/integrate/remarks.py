"""Remarks of contact laws on a run that has ended."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeGuard

import numpy as np

from flexmb.contact.normal.cylinder import CylinderLaw
from flexmb.contact.normal.hysteresis import HysteresisLaw
from flexmb.contact.onset import LARGEST
from flexmb.integrate.episodes import COLUMNS, ContactLog
from flexmb.model.law import NormalLaw
from flexmb.program.program import Program

SMALL_SHARE = 0.01
"""Share of impulses or losses in contacts slower than `least_approach` that goes without a remark."""

PLACE = {name: k for k, (name, _) in enumerate(COLUMNS)}


def contact_remarks(program: Program, z: np.ndarray, log: ContactLog, end: float, span: float) -> tuple[str, ...]:
    """Remarks of all normal laws, each with the name of its joint and law.

    Parameters
    ----------
    program : the compiled mechanism.
    z : histories at the end of the run.
    log : rows of the contacts that the run wrote down.
    end : time at the end of the run [s].
    span : time without an onset after which a contact is called lasting [s].
    """
    found = []
    for c, law in enumerate(program.normals):
        place = program.tables.contacts.z[c]
        history = tuple(float(x) for x in z[place[1] : place[2]])
        label = f"{program.names.contacts[c].partition('.')[0]} ({type(law).__name__})"
        texts = list(law.remarks(history))
        rows = log.rows[log.rows[:, 0] == c]
        texts += [*_slow(law, rows), *_lasting(law, rows, end, span)]
        found += [f"{label}: {text}." for text in texts]
    return tuple(found)


def _slow(law: NormalLaw, rows: np.ndarray) -> Iterator[str]:
    """A remark where contacts that began slower than `least_approach` carry a share of impulses or losses."""
    if not _damps(law):
        return
    slow = rows[:, PLACE["approach_speed"]] < law.least_approach
    shares = []
    for name in ("impulse", "dissipated_contact"):
        column = rows[:, PLACE[name]]
        whole = float(column.sum())
        shares.append(float(column[slow].sum()) / whole if whole > 0.0 else 0.0)
    if max(shares) > SMALL_SHARE:
        text = (
            f"{int(slow.sum())} of {len(rows)} contacts began at less than least_approach = {law.least_approach:g} m/s"
        )
        text = f"{text} and carry {100.0 * shares[0]:.3g} % of the impulse and {100.0 * shares[1]:.3g} % of the loss"
        yield f"{text}; their largest closing speed scales their damping. Try a smaller least_approach"


def _lasting(law: NormalLaw, rows: np.ndarray, end: float, span: float) -> Iterator[str]:
    """A remark on a contact that is closed at the end of the run and began more than `span` before."""
    for row in rows[np.isnan(rows[:, PLACE["end"]])]:
        start = row[PLACE["start"]]
        damped = damped_since_onset(law, row)
        if damped and not start > end - span:
            yield f"closed without a break since {'the start' if np.isnan(start) else f't = {start:.6g} s'}; {damped}"


def damped_since_onset(law: NormalLaw, row: np.ndarray) -> str:
    """What scales the damping of a contact that lasts, in a sentence; "" for a law without hysteresis damping.

    Parameters
    ----------
    law : its normal law.
    row : of the log of contacts.
    """
    if not _damps(law):
        return ""
    if law.reference_speed == LARGEST:
        return "the largest closing speed since then scales its damping"
    approach = row[PLACE["approach_speed"]]
    known = f", {approach:.3g} m/s," if np.isfinite(approach) else ""
    return f"the speed of that onset{known} still scales its damping (docs/contact.md)"


def _damps(law: NormalLaw) -> TypeGuard[HysteresisLaw | CylinderLaw]:
    """Whether the law has hysteresis damping: one with restitution 1 has none."""
    return isinstance(law, HysteresisLaw | CylinderLaw) and law.restitution != 1.0
