"""Watch over a run: penetrations, contacts, strains and laws that cannot be right, with time, part and remedy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexmb.bodies.flexible import beam_elements
from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.couplings.gear import Gear
from flexmb.doctor.cheap import cheap_findings
from flexmb.doctor.finding import ERROR, NOTHING_MOVES, WHAT_MOVES
from flexmb.joints.revolute import Revolute
from flexmb.joints.stop import Stop
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part
from flexmb.model.watched_motion import WatchedMotion
from flexmb.results.contact_intervals import COLUMNS, ContactLog
from flexmb.results.peaks import Peaks
from flexmb.run.basis_edge import basis_remarks, load_remarks
from flexmb.run.deformations import large_deformations
from flexmb.run.failure import STEP_CODES
from flexmb.run.peaks import all_peaks
from flexmb.run.stopping import Condition
from flexmb.run.strength import materials_of, source_of, strength_remarks
from flexmb.state.poses import kept_poses
from flexmb.step.step_size import FixedStep

if TYPE_CHECKING:
    from flexmb.run.run import Run

DEEP, THROUGH = 0.2, 1.0
"""Penetration over the radius of the journal or pin: above the first there is a remark; above the second the journal
has passed its own centre, and the run is not ok; a part may say `lost_beyond`."""

LEAST_STEPS = 4.0
"""Steps of an impact below which its restitution means nothing."""

SHARE = 0.01
"""Share of the impulses of a joint, or of the energy through it, above which something matters."""

LARGE_STRAIN, IMPOSSIBLE_STRAIN = 0.05, 0.2
"""Strain of a beam above which there is a remark, and above which the run is not ok."""

PASSES_THROUGH = "the journal passes through its bearing"

ONE_INSTANT = ("broken-kernel", "jumping-drive")
"""Codes of findings on one instant of a motion, which a run that ends before does not meet."""

COLUMN = {name: k for k, (name, _) in enumerate(COLUMNS)}


class Watched(NamedTuple):
    """Remarks of the watch.

    Parameters
    ----------
    faults : sentences on what cannot be right.
    notes : sentences on what deserves attention.
    """

    faults: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


class Seen(NamedTuple):
    """View of a run for its watch, whatever is saved.

    Parameters
    ----------
    motion : peaks over all steps, and poses of some steps.
    reported : peaks of the time that is saved.
    contacts : contact intervals.
    fixed_step : size of the steps [s]; None: chosen by their errors.
    failed : whether a step failed.
    even : (n,) whether the poses of `motion` are those that are evenly distributed over the steps.
    z : (n, n_z) histories at the poses.
    sizes : (n,) sizes of the steps that led there [s].
    """

    motion: WatchedMotion
    reported: Peaks
    contacts: ContactLog
    fixed_step: float | None
    failed: bool
    even: np.ndarray
    z: np.ndarray
    sizes: np.ndarray

    @staticmethod
    def of(run: Run) -> Seen:
        """View of a run that has ended."""
        record, signals = run.record, run.stepper.reported.names.signals
        fixed = run.step.size if isinstance(run.step, FixedStep) else None
        lows = {signals.names[place]: tuple(low) for place, low in zip(record.low_places, record.lows, strict=True)}
        times, values, z, sizes, even = kept_poses(record.poses, float(run.flow.clock.t), record.signals, run.flow.z)
        return Seen(
            WatchedMotion(signals, times, values, all_peaks(run), lows),
            Peaks(record.peak, record.peak_time),
            run.contact_log(),
            fixed,
            run.code in STEP_CODES,
            even,
            z,
            sizes,
        )


def watched(mechanism: Mechanism, seen: Seen) -> Watched:
    """Faults and notes on a run that has ended."""
    faults: list[str] = []
    notes: list[str] = []
    for finding in cheap_findings(mechanism):
        if finding.code in ONE_INSTANT and finding.numbers.get("time", 0.0) > seen.motion.times[-1]:
            continue
        (faults if finding.severity == ERROR else notes).append(f"{finding.text} {finding.remedy}".rstrip())
    strains = (*_strains(mechanism, seen.motion), *_strains_of_meshes(mechanism, seen.motion))
    shapes = (*strains, *large_deformations(mechanism, seen))
    for wrong, text in (*_penetrations(mechanism, seen), *_coarse_contacts(seen), *shapes):
        (faults if wrong else notes).append(text)
    notes += [text for part in mechanism.parts for text in part.remarks(mechanism, seen.motion)]
    notes += strength_remarks(mechanism, seen.motion.signals, seen.reported)
    notes += [*_nothing_moved(mechanism, seen), *basis_remarks(mechanism, seen)]
    notes += load_remarks(mechanism)
    return Watched(tuple(faults), tuple(notes))


def _nothing_moved(mechanism: Mechanism, seen: Seen) -> Iterator[str]:
    """A remark on a run without gravity in which no body ever moved."""
    if seen.motion.peak("energy.kinetic")[0] == 0.0 and mechanism.bodies and not any(mechanism.gravity):
        yield f"{NOTHING_MOVES} {WHAT_MOVES}"


def _penetrations(mechanism: Mechanism, seen: Seen) -> Iterator[tuple[bool, str]]:
    """Journals, pins and sliders that are pressed deep into their bearings and guides."""
    for name, size, label, through_it, deep, far in _contact_sizes(mechanism, seen.contacts.names):
        depth, when = seen.motion.peak(f"{name}.penetration")
        if depth > deep * size:
            through = depth > far * size
            text = f"At t = {when:.6g} s {label} is penetrated by {depth:.4g} m, its size is {size:.4g} m"
            text += f": {through_it}" if through else ": far beyond the validity of any law"
            yield through, f"{text}. A stiffness in N/mm^1.5 is to be multiplied by 3.16e4; else take smaller steps."


def _contact_sizes(
    mechanism: Mechanism, contacts: Sequence[str]
) -> Iterator[tuple[str, float, str, str, float, float]]:
    """Contacts of parts with a size: name, radius or half height [m], label, words for a penetration by the size.

    Then the penetrations over the size above which there is a remark, and a fault; buffers of stops may yield.
    """
    for part in mechanism.parts if contacts else ():
        size = size_of_contact(mechanism, part)
        if size is not None:
            own = [name for name in contacts if name.partition(".")[0] == part.name]
            words = PASSES_THROUGH if getattr(part, "bearing_radius", None) else "the parts pass through each other"
            deep = THROUGH if isinstance(part, Stop) else DEEP
            far = getattr(part, "lost_beyond", THROUGH)
            yield from ((name, size, part.label, words, deep, far) for name in own)


def size_of_contact(mechanism: Mechanism, part: Part) -> float | None:
    """Size beside which the penetrations of a part are judged [m]; None where it has none.

    Of a joint with clearance and a pair of curves the radius or half height, of a stop the radius of its faces, so
    that the angle beyond the limit is judged, of teeth their module.
    """
    if isinstance(part, Stop):
        return part.radius if part.joint and isinstance(mechanism.find(part.joint), Revolute) else None
    if isinstance(part, Gear):
        return None if part.backlash is None else part.module_of(mechanism)
    sizes = (getattr(part, name, None) for name in ("bearing_radius", "pin_radius", "half_height"))
    return next((size for size in sizes if isinstance(size, float)), None)


def impossible_penetrations(mechanism: Mechanism, contacts: Sequence[str]) -> list[Condition]:
    """Conditions that end a run at once: a journal that passes through its bearing, or parts through each other."""
    return [
        Condition(f"{name}.penetration", far * size, 1, f"{label}: {words}", is_fault=True)
        for name, size, label, words, _, far in _contact_sizes(mechanism, contacts)
    ]


def _coarse_contacts(seen: Seen) -> Iterator[tuple[bool, str]]:
    """Contacts of a few fixed steps, whose restitution is an accident of the steps."""
    if seen.fixed_step is None:
        return
    rows = seen.contacts.rows
    for k, name in enumerate(seen.contacts.names):
        own = rows[rows[:, COLUMN["contact"]] == k]
        impulse = own[:, COLUMN["impulse"]]
        steps = (own[:, COLUMN["end"]] - own[:, COLUMN["start"]]) / seen.fixed_step
        coarse = steps < LEAST_STEPS  # NaN, of one that lasts, is not
        share = float(impulse[coarse].sum()) / float(impulse.sum()) if impulse.sum() > 0.0 else 0.0
        if share > SHARE:
            first = float(own[coarse][0, COLUMN["start"]])
            text = f"{int(coarse.sum())} of {len(own)} contacts of {name!r} last less than {LEAST_STEPS:g} of the fixed"
            text = f"{text} steps ({seen.fixed_step:.3g} s), the first at t = {first:.6g} s: their restitution is an"
            need = float(np.median((own[:, COLUMN["end"]] - own[:, COLUMN["start"]])[coarse])) / 32.0
            yield share > 0.2, f"{text} accident of the steps. Take steps of {need:.2g} s, or Adaptive()."


def _strains(mechanism: Mechanism, motion: WatchedMotion) -> Iterator[tuple[bool, str]]:
    """Beams that strain beyond their yield stress, or by more than linear elasticity allows."""
    for body in mechanism.bodies:
        if not isinstance(body, FlexibleBody):
            continue
        strain, when = strain_of(body, motion)
        limit = None if body.seeks_stress else body.material.yield_stress  # told by all steps
        stress = strain * body.material.young
        text = f"At t = {when:.6g} s {body.label} strains by {strain:.3g} ({stress:.3g} Pa)"
        wrong = strain > IMPOSSIBLE_STRAIN
        if limit is not None and stress > limit:
            yield wrong, f"{text}; it yields at {limit:.3g} Pa, and beams are linear elastic."
        elif strain > LARGE_STRAIN:
            yield wrong, f"{text}; beams are linear elastic, for small strains."


def _strains_of_meshes(mechanism: Mechanism, motion: WatchedMotion) -> Iterator[tuple[bool, str]]:
    """Plane bodies, reduced ones too, whose largest stress is more than linear elasticity allows."""
    for body in mechanism.bodies:
        if f"{body.name}.von_mises" not in motion.signals.places:
            continue
        source = source_of(body)  # type: ignore[arg-type] # bodies with such a signal have one
        if isinstance(source, FlexibleBody):
            continue
        stress, when = motion.peak(f"{body.name}.von_mises")
        strain = stress / max(material.young for material in materials_of(source))
        if strain > LARGE_STRAIN:
            text = f"At t = {when:.6g} s {body.label} strains by some {strain:.3g} ({stress:.3g} Pa)"
            yield strain > IMPOSSIBLE_STRAIN, f"{text}; plane bodies are linear elastic, for small strains."


def strain_of(body: FlexibleBody, motion: WatchedMotion) -> tuple[float, float]:
    """Largest strain of a body at the poses of a motion, and when [s]."""
    nodes = {node.name: node for node in body.nodes()}
    largest, when = 0.0, 0.0
    for beam in body.beams:
        rows = motion.rows(*(f"{body.name}.{n}.{axis}" for axis in ("x", "y", "theta") for n in beam.nodes))
        strains = beam_elements(beam, nodes).strains(*np.split(rows, 3, axis=1)).max(axis=1)
        k = int(np.argmax(strains))
        if strains[k] > largest:
            largest, when = float(strains[k]), float(motion.times[k])
    return largest, when
