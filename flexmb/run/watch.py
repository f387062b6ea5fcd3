"""Watch over a run: penetrations, contacts, strains and laws that cannot be right, with time, part and remedy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexmb.bodies.flexible import beam_elements
from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.couplings.cable import Cable
from flexmb.couplings.gear import Gear
from flexmb.couplings.one_way_clutch import OneWayClutch
from flexmb.doctor.cheap import cheap_findings
from flexmb.doctor.finding import ERROR
from flexmb.joints.revolute import Revolute
from flexmb.joints.stop import Stop
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part
from flexmb.model.signal import Signals
from flexmb.results.contact_intervals import COLUMNS, ContactLog
from flexmb.results.peaks import Peaks
from flexmb.run.basis_edge import basis_remarks, load_remarks
from flexmb.run.deformations import large_deformations
from flexmb.run.failure import STEP_CODES
from flexmb.run.stopping import Condition
from flexmb.run.strength import materials_of, source_of, strength_remarks
from flexmb.step.step_size import FixedStep

if TYPE_CHECKING:
    from flexmb.run.run import Run

DEEP, THROUGH = 0.2, 1.0
"""Penetration over the radius of the journal or pin: above the first there is a remark; above the second the journal
has passed its own centre, and the run is not ok."""

LEAST_STEPS = 4.0
"""Steps of an impact below which its restitution means nothing."""

SHARE = 0.01
"""Share of the impulses of a joint, or of the energy through it, above which something matters."""

LARGE_STRAIN, IMPOSSIBLE_STRAIN = 0.05, 0.2
"""Strain of a beam above which there is a remark, and above which the run is not ok."""

MOST_NUMBERS, MOST_OF_ALL = 20_000, 1_000_000
"""Number of poses of nodes that are looked at, of a beam and of all; of longer results every second, third, ...
instant."""

PASSES_THROUGH = "the journal passes through its bearing"

LARGE_WIND_UP = 0.5
"""Wind-up of a clutch above which there is a remark [rad]."""

PULL = 1e-3
"""Pull of an ideal pair of curves relative to its largest force, above which there is a remark."""

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


class Saved(NamedTuple):
    """Results of a run that are watched.

    Parameters
    ----------
    time : (n,) saved instants [s].
    values : (n, signals) saved signals.
    kept : (signals,) numbers of the saved signals among all; None: all.
    signals : names of all signals.
    aliases : other names of nodes.
    peaks : of all signals.
    contacts : contact intervals.
    fixed_step : size of the steps [s]; None: chosen by their errors.
    end : last instant that the run reached [s].
    coordinates : names of the coordinates.
    pose : (n_q,) coordinates at the last instant.
    failed : whether a step failed.
    """

    time: np.ndarray
    values: np.ndarray
    kept: np.ndarray | None
    signals: Signals
    peaks: Peaks
    contacts: ContactLog
    fixed_step: float | None
    end: float
    coordinates: Sequence[str]
    pose: np.ndarray
    failed: bool

    @staticmethod
    def of(run: Run) -> Saved:
        """Results of a run that has ended."""
        time, values = run.saved.finished()
        peaks = Peaks(run.record.peak, run.record.peak_time)
        fixed = run.step.size if isinstance(run.step, FixedStep) else None
        return Saved(
            time,
            values,
            run.kept,
            run.stepper.reported.names.signals,
            peaks,
            run.contact_log(),
            fixed,
            float(run.flow.clock.t),
            run.program.names.coordinates,
            run.flow.q,
            run.code in STEP_CODES,
        )


def watched(mechanism: Mechanism, saved: Saved) -> Watched:
    """Faults and notes on a run that has ended.

    Parameters
    ----------
    mechanism : the mechanism.
    saved : its results.
    """
    faults: list[str] = []
    notes: list[str] = []
    for finding in cheap_findings(mechanism):
        if finding.code in ONE_INSTANT and finding.numbers.get("time", 0.0) > saved.end:
            continue
        (faults if finding.severity == ERROR else notes).append(f"{finding.text} {finding.remedy}".rstrip())
    strains = (*_strains(mechanism, saved), *_strains_of_meshes(mechanism, saved))
    shapes = (*strains, *large_deformations(mechanism, saved))
    for wrong, text in (*_penetrations(mechanism, saved), *_coarse_contacts(saved), *shapes):
        (faults if wrong else notes).append(text)
    notes += [*yielding_couplings(mechanism, saved.signals, saved.peaks), *_pulling_curves(mechanism, saved)]
    notes += [*_parting_gears(mechanism, saved), *strength_remarks(mechanism, saved.signals, saved.peaks)]
    notes += basis_remarks(mechanism, saved)
    notes += load_remarks(mechanism)
    return Watched(tuple(faults), tuple(notes))


def _penetrations(mechanism: Mechanism, saved: Saved) -> Iterator[tuple[bool, str]]:
    """Journals, pins and sliders that are pressed deep into their bearings and guides."""
    for name, size, label, through_it, deep in _contact_sizes(mechanism, saved.contacts.names):
        place = saved.signals.places[f"{name}.penetration"]
        depth, when = float(saved.peaks.values[place]), float(saved.peaks.times[place])
        if depth > deep * size:
            through = depth > THROUGH * size
            text = f"At t = {when:.6g} s {label} is penetrated by {depth:.4g} m, its size is {size:.4g} m"
            text += f": {through_it}" if through else ": far beyond the validity of any law"
            yield through, f"{text}. A stiffness in N/mm^1.5 is to be multiplied by 3.16e4; else take smaller steps."


def _contact_sizes(mechanism: Mechanism, contacts: Sequence[str]) -> Iterator[tuple[str, float, str, str, float]]:
    """Contacts of parts with a size: name, radius or half height [m], label, words for a penetration by the size.

    Then the penetration over the size above which there is a remark; buffers of stops may yield.
    """
    for part in mechanism.parts if contacts else ():
        size = size_of_contact(mechanism, part)
        if size is not None:
            own = [name for name in contacts if name.partition(".")[0] == part.name]
            words = PASSES_THROUGH if getattr(part, "bearing_radius", None) else "the parts pass through each other"
            deep = THROUGH if isinstance(part, Stop) else DEEP
            yield from ((name, size, part.label, words, deep) for name in own)


def size_of_contact(mechanism: Mechanism, part: Part) -> float | None:
    """Size beside which the penetrations of a part are judged [m]; None where it has none.

    Of a joint with clearance and a pair of curves the radius or half height, of a stop the radius of its faces, so
    that the angle beyond the limit is judged, of teeth their module.

    Parameters
    ----------
    mechanism : the mechanism.
    part : one of its parts.
    """
    if isinstance(part, Stop):
        return part.radius if isinstance(mechanism.find(part.joint), Revolute) else None
    if isinstance(part, Gear):
        return None if part.backlash is None else part.module_of(mechanism)
    sizes = (getattr(part, name, None) for name in ("bearing_radius", "pin_radius", "half_height"))
    return next((size for size in sizes if isinstance(size, float)), None)


def impossible_penetrations(mechanism: Mechanism, contacts: Sequence[str]) -> list[Condition]:
    """Conditions that end a run at once: a journal that passes through its bearing, or parts through each other.

    Parameters
    ----------
    mechanism : the mechanism.
    contacts : names of its contacts.
    """
    return [
        Condition(f"{name}.penetration", THROUGH * size, 1, f"{label}: {words}", is_fault=True)
        for name, size, label, words, _ in _contact_sizes(mechanism, contacts)
    ]


def yielding_couplings(mechanism: Mechanism, signals: Signals, peaks: Peaks) -> list[str]:
    """Remarks on cables that stretch, and clutches that wind up, by more than such parts do.

    Parameters
    ----------
    mechanism : the mechanism.
    signals : names of all signals.
    peaks : their peaks.
    """
    found = []
    for part in mechanism.parts:
        if isinstance(part, Cable):
            length, place = part.slack_length, signals.places[f"{part.name}.penetration"]
            stretch, when = float(peaks.values[place]), float(peaks.times[place])
            if stretch > DEEP * length:
                found.append(
                    f"At t = {when:.6g} s {part.label} is stretched by {stretch:.4g} m, its length is {length:.4g} m. "
                    "The stiffness of a cable is E A/length, in N/m."
                )
        if isinstance(part, OneWayClutch):
            place = signals.places[f"{part.name}.torque"]
            angle, when = float(peaks.values[place]) / part.stiffness, float(peaks.times[place])
            if angle > LARGE_WIND_UP:
                text = f"At t = {when:.6g} s {part.label} is wound up by some {angle:.4g} rad."
                found.append(f"{text} Its stiffness is in N m/rad.")
    return found


def _parting_gears(mechanism: Mechanism, saved: Saved) -> Iterator[str]:
    """Remarks on ideal gear pairs whose axes leave the distance that their wheels are made for."""
    for part in mechanism.parts:
        if not isinstance(part, Gear) or part.backlash is not None or part.distance is not None:
            continue
        columns = saved_columns(saved, [f"{wheel.name}.{axis}" for wheel in (part.first, part.second) for axis in "xy"])
        if columns is None or not len(saved.time):
            continue
        x1, y1, x2, y2 = saved.values[:, columns].T
        apart, drawn = np.hypot(x2 - x1, y2 - y1), abs(sum(part.signed_radii(mechanism)))
        k = int(np.argmax(np.abs(apart - drawn)))
        if abs(apart[k] - drawn) > DEEP * part.module_of(mechanism):
            yield (
                f"At t = {saved.time[k]:.6g} s the centres of the wheels of {part.label} are {apart[k]:.4g} m apart; "
                f"its teeth mesh at {drawn:.4g} m. An ideal pair holds its ratio at any distance: hold the axes, "
                "or give backlash= and normal=."
            )


def _pulling_curves(mechanism: Mechanism, saved: Saved) -> Iterator[str]:
    """Remarks on ideal pairs of curves that pull, where a real follower would lift off."""
    for part in mechanism.parts:
        if getattr(part, "first_curve", None) is None or getattr(part, "normal", None) is not None:
            continue  # told by a field, since importing scipy.spatial with the curves takes long
        columns = saved_columns(saved, [f"{part.name}.force"])
        force = saved.values[:, columns[0]] if columns and len(saved.time) else np.zeros(1)
        k = int(np.argmin(force))
        if force[k] < -PULL * float(np.abs(force).max()):
            yield (
                f"At t = {saved.time[k]:.6g} s {part.label} pulls with {-force[k]:.4g} N, where a follower would lift "
                "off. Give normal=... for a contact that opens, or a stronger spring."
            )


def _coarse_contacts(saved: Saved) -> Iterator[tuple[bool, str]]:
    """Contacts of a few fixed steps, whose restitution is an accident of the steps."""
    if saved.fixed_step is None:
        return
    rows = saved.contacts.rows
    for k, name in enumerate(saved.contacts.names):
        own = rows[rows[:, COLUMN["contact"]] == k]
        impulse = own[:, COLUMN["impulse"]]
        steps = (own[:, COLUMN["end"]] - own[:, COLUMN["start"]]) / saved.fixed_step
        coarse = steps < LEAST_STEPS  # NaN, of one that lasts, is not
        share = float(impulse[coarse].sum()) / float(impulse.sum()) if impulse.sum() > 0.0 else 0.0
        if share > SHARE:
            first = float(own[coarse][0, COLUMN["start"]])
            text = f"{int(coarse.sum())} of {len(own)} contacts of {name!r} last less than {LEAST_STEPS:g} of the fixed"
            text = f"{text} steps ({saved.fixed_step:.3g} s), the first at t = {first:.6g} s: their restitution is an"
            need = float(np.median((own[:, COLUMN["end"]] - own[:, COLUMN["start"]])[coarse])) / 32.0
            yield share > 0.2, f"{text} accident of the steps. Take steps of {need:.2g} s, or Adaptive()."


def _strains(mechanism: Mechanism, saved: Saved) -> Iterator[tuple[bool, str]]:
    """Beams that strain beyond their yield stress, or by more than linear elasticity allows."""
    bodies = [body for body in mechanism.bodies if isinstance(body, FlexibleBody)]
    beams = sum(len(body.beams) for body in bodies)
    for body in bodies:
        found = strain_of(body, saved, min(MOST_NUMBERS, MOST_OF_ALL // beams))
        if found is None:
            continue
        strain, when = found
        limit = None if body.seeks_stress else body.material.yield_stress  # told by all steps
        stress = strain * body.material.young
        text = f"At t = {when:.6g} s {body.label} strains by {strain:.3g} ({stress:.3g} Pa)"
        wrong = strain > IMPOSSIBLE_STRAIN
        if limit is not None and stress > limit:
            yield wrong, f"{text}; it yields at {limit:.3g} Pa, and beams are linear elastic."
        elif strain > LARGE_STRAIN:
            yield wrong, f"{text}; beams are linear elastic, for small strains."


def _strains_of_meshes(mechanism: Mechanism, saved: Saved) -> Iterator[tuple[bool, str]]:
    """Plane bodies, reduced ones too, whose largest stress is more than linear elasticity allows."""
    for body in mechanism.bodies:
        place = saved.signals.places.get(f"{body.name}.von_mises")
        source = None if place is None else source_of(body)  # type: ignore[arg-type] # bodies with such a signal have one
        if place is None or source is None or isinstance(source, FlexibleBody):
            continue
        stress, when = float(saved.peaks.values[place]), float(saved.peaks.times[place])
        strain = stress / max(material.young for material in materials_of(source))
        if strain > LARGE_STRAIN:
            text = f"At t = {when:.6g} s {body.label} strains by some {strain:.3g} ({stress:.3g} Pa)"
            yield strain > IMPOSSIBLE_STRAIN, f"{text}; plane bodies are linear elastic, for small strains."


def strain_of(body: FlexibleBody, saved: Saved, most: int = MOST_NUMBERS) -> tuple[float, float] | None:
    """Largest strain of a body at the saved instants, and when [s]; None where its nodes were not saved.

    Parameters
    ----------
    body : the body.
    saved : results of the run.
    most : number of poses of nodes that are looked at for each beam.
    """
    nodes = {node.name: node for node in body.nodes()}
    largest, when = 0.0, 0.0
    for beam in body.beams:
        every = 1 + len(saved.time) * len(beam.nodes) // most
        columns = saved_columns(saved, [f"{body.name}.{n}.{axis}" for axis in ("x", "y", "theta") for n in beam.nodes])
        if columns is None or not len(saved.time):
            return None
        x, y, theta = np.split(saved.values[::every, columns], 3, axis=1)
        strains = beam_elements(beam, nodes).strains(x, y, theta).max(axis=1)
        k = int(np.argmax(strains))
        if strains[k] > largest:
            largest, when = float(strains[k]), float(saved.time[::every][k])
    return largest, when


def saved_columns(saved: Saved, names: Sequence[str]) -> list[int] | None:
    """Columns of the signals of these names among the saved ones; None where one was not saved."""
    places = [saved.signals.places.get(name, -1) for name in names]
    if saved.kept is not None:
        where = {int(place): k for k, place in enumerate(saved.kept)}
        places = [where.get(place, -1) for place in places]
    return None if min(places) < 0 else places
