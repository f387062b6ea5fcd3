"""Watch over a run: penetrations, contacts, strains and laws that cannot be right."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from flexmb.display import number_text
from flexmb.engine.state.record import kept_poses
from flexmb.engine.step.step_size import FixedStep
from flexmb.findings.cheap import cheap_findings
from flexmb.findings.failure import STEP_CODES
from flexmb.findings.finding import ERROR, NOTHING_MOVES, WHAT_MOVES
from flexmb.model.law import Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part, WatchedMotion
from flexmb.model.signal import Signals
from flexmb.parts.bodies.flexible import beam_elements
from flexmb.parts.bodies.flexible_body import FlexibleBody
from flexmb.parts.couplings.gear import Gear
from flexmb.parts.joints.revolute import Revolute
from flexmb.parts.joints.stop import Stop
from flexmb.results.contact_intervals import COLUMNS, ContactLog
from flexmb.results.solution import Peaks
from flexmb.run.saving import all_peaks
from flexmb.run.stopping import Condition

if TYPE_CHECKING:
    from flexmb.elastic.planes.plane_body import PlaneBody
    from flexmb.elastic.reduced.reduced import Reduced
    from flexmb.results.stress import STRESSED
    from flexmb.run.run import Run

# Deformations of reduced bodies at the poses that a run keeps, and remarks on large ones

LARGE_SHARE, IMPOSSIBLE_SHARE = 0.1, 0.5
"""Displacement in the frame of a reduced body over the size of the body [1], above which there is a remark, and above
which the run is not ok."""

MOST_POINTS = 100
"""Number of points of a body whose displacements are looked at."""


def deformations(mechanism: Mechanism, seen: Seen) -> Iterator[tuple[Reduced, np.ndarray, np.ndarray]]:
    """Each reduced body, instants (t,), and its deformations (t, n) in its frame, the first pin at 0.

    Instants are those of the poses that a run keeps.
    """
    module: Any = sys.modules.get("flexmb.elastic.reduced.reduced")  # no body is a reduced one before it is imported
    for body in mechanism.bodies if module is not None else ():
        if isinstance(body, module.Reduced):
            from flexmb.results.drawing import deformed

            names = [f"{body.name}.{node.name}.{axis}" for node in body.basis.nodes for axis in ("x", "y", "theta")]
            poses, time = seen.motion.rows(*names), seen.motion.times
            with np.errstate(all="ignore"):  # a run that blows up ends with numbers that are none
                d = deformed(body.moved_by, poses.reshape(len(time), -1, 3))[0]
                d[..., :2] -= d[:, :1, :2]
            yield body, time, d.reshape(len(time), -1)


def large_deformations(mechanism: Mechanism, seen: Seen) -> Iterator[tuple[bool, str]]:
    """A sentence on each reduced body that deforms by much of its size, and whether the run cannot be right."""
    for body, time, d in deformations(mechanism, seen):
        shares = _shares(body, d)
        large = np.flatnonzero(np.append(shares, np.inf) > LARGE_SHARE)[0] if seen.failed else 0
        lost = next((k for k in range(int(large)) if _inertia_is_lost(body, d[k])), None)
        if lost is not None:
            yield True, _lost_inertia(body, float(time[lost]), float(shares[lost]))
        elif shares.max() > LARGE_SHARE:
            wrong = bool(shares.max() > IMPOSSIBLE_SHARE) or seen.failed
            when = int(np.argmax(shares > min(IMPOSSIBLE_SHARE, 0.99 * shares.max())))
            yield wrong, _too_large(body, float(time[when]), float(shares[when]), wrong=wrong)


def _shares(body: Reduced, d: np.ndarray) -> np.ndarray:
    """(t,) largest displacements in the frame of a body over its size."""
    model = body.model
    points = np.linspace(0, len(model.points) - 1, min(MOST_POINTS, len(model.points))).astype(int)
    with np.errstate(all="ignore"):
        x, y = (d @ np.asarray(model.shape[2 * points + axis] @ body.basis.shapes).T for axis in (0, 1))
        shares = np.hypot(x, y).max(axis=1) / np.ptp(model.points, axis=0).max()
    return np.asarray(np.nan_to_num(shares, nan=np.inf))


def _inertia_is_lost(body: Reduced, d: np.ndarray) -> bool:
    """Whether the mass matrix of a body is not positive, since stiffening by rotation lessens its inertia."""
    matrices, Kc = body.element.matrices, body.element.centrifugal
    turning = np.zeros(len(d))
    turning[2] = 1.0
    if not body.basis.by_pin:
        shape = body.moved_by
        weights, poses = np.array(shape.weights), np.array(shape.poses) + d.reshape(-1, 3)
        size = (weights * poses[:, :2]).sum()
        turning = np.column_stack([-weights[:, 1], weights[:, 0], np.zeros(len(weights))]).ravel() / size
    across = np.outer(matrices["G"] @ d, turning)
    mass = matrices["M"] + across + across.T + np.outer(turning, turning) * (d @ (matrices["H"] - Kc) @ d)
    return bool(np.linalg.eigvalsh(mass)[0] < 0.0)


def _too_large(body: Reduced, time: float, share: float, *, wrong: bool) -> str:
    """The sentence on a large deformation."""
    moved = f"by {100.0 * share:.3g} % of its size" if share < 1.0 else "by more than its size"
    beyond = "beyond" if wrong else "at the edge of"
    chord = 'frame="chord", ' if body.basis.by_pin and body.basis.model.count > 3 else ""
    return (
        f"{body.label}: at t = {time:.6g} s it is deformed {moved}, {beyond} the small deformations that a reduced "
        "body is for; its errors grow with the square of that share. "
        f"Take {chord}more pins, or the body with all its nodes."
    )


def _lost_inertia(body: Reduced, time: float, share: float) -> str:
    """The sentence on an indefinite mass matrix."""
    follows = ", and its frame follows the vibrations of one pin" if body.basis.by_pin else ""
    return (
        f"{body.label}: at t = {time:.6g} s it is deformed by {100.0 * share:.3g} % of its size{follows}; stiffening "
        "by rotation then takes away more inertia than it has. Take a second pin, such as its other end, with "
        'frame="chord", or stiffening=False, or the body with all its nodes.'
    )


# Remarks of a run on reduced bodies: much strain energy in the highest modes, loads and rotations without shapes

EDGE_SHARE = 0.1
"""Share of the strain energy in the highest modes [1] from which a basis is said to be too small."""

AT_EDGE = 3
"""Number of the highest modes that are looked at."""

LEFT_OUT = 0.01
"""Share of the strain energy of a load, with all pins held, that the kept shapes may leave out [1]; stresses are then
off by some tenth."""

STEP_ERROR = 1e-8
"""Displacement by the highest modes over the size of a body [1], up to which it is the error of steps.

Default steps leave some 3e-9 in bodies that are so stiff that their deformation is smaller."""


def basis_remarks(mechanism: Mechanism, seen: Seen) -> Iterator[str]:
    """Sentences on each reduced body whose highest modes hold much of its strain energy, or that lacks that of a turn.

    Parameters
    ----------
    mechanism : the mechanism.
    seen : what is seen of the run.
    """
    for body, time, d in deformations(mechanism, seen):
        if np.isfinite(d).all():
            yield from _edge_remark(body, d, time, seen)


def load_remarks(mechanism: Mechanism) -> Iterator[str]:
    """A sentence on each load whose deflection the kept shapes of a reduced body cannot show.

    Parameters
    ----------
    mechanism : the mechanism.
    """
    if "flexmb.elastic.reduced.reduced" not in sys.modules:  # no body is reduced, and the import takes long
        return
    from flexmb.elastic.reduced.reduced import Reduced
    from flexmb.elastic.reduced.superelement import left_out
    from flexmb.parts.loads.mesh_loads import MeshLoad

    for load in mechanism.parts:
        body = mechanism.find(load.body.name) if isinstance(load, MeshLoad) else None
        if not isinstance(load, MeshLoad) or not isinstance(body, Reduced):
            continue
        whole, left = left_out(body, body.model.shape.T @ load.on(load.plane_of(body)).forces.ravel())
        if left > LEFT_OUT * whole:
            yield (
                f"{load.label} acts on {body.label}, whose kept shapes leave out {100.0 * left / whole:.3g} % of its "
                "strain energy: pins move rightly, but deflection and stress between them are too small. Keep its "
                f"shape: Reduced(..., load_shapes=({load.name},))."
            )


def _edge_remark(body: Reduced, d: np.ndarray, time: np.ndarray, seen: Seen) -> Iterator[str]:
    """The sentences on one body with the deformations d (t, n)."""
    from flexmb.results.drawing import shortened

    d = shortened(d.reshape(len(d), -1, 3), body.element.directions)
    whole = 0.5 * np.einsum("ti,ij,tj->t", d, body.element.matrices["K"], d).max()
    yield from _of_rotation(body, float(whole), seen)
    if body.basis.vibrations >= AT_EDGE:
        yield from _at_edge(body, d, time, float(whole))


def _at_edge(body: Reduced, d: np.ndarray, time: np.ndarray, whole: float) -> Iterator[str]:
    """The sentence on strain energy in the highest modes."""
    pins, last = body.basis.model.count, slice(d.shape[1] - AT_EDGE, None)
    eta = d[:, last] - d[:, :pins] @ body.basis.followed[-AT_EDGE:].T
    edge = 0.5 * np.einsum("ti,ij,tj->t", eta, body.element.matrices["K"][last, last], eta)
    when = int(np.argmax(edge))
    size = np.ptp(body.model.points, axis=0).max()
    moved = np.abs(eta * (1.0, 1.0, size)).max(axis=1)  # the shape of a rotation of 1 moves by the size
    share = float(edge[when]) / whole if moved[when] > STEP_ERROR * size else 0.0
    if share >= EDGE_SHARE:
        frequency, more = body.dropped_frequency, body.basis.vibrations + AT_EDGE
        beyond = f" The lowest one left out has {frequency:.4g} Hz with held pins." if np.isfinite(frequency) else ""
        yield (
            f"{body.label}: at t = {time[when]:.6g} s its three highest modes hold {100.0 * share:.3g} % of its "
            f"largest strain energy, so modes are missing.{beyond} Keep more: modes={more}."
        )


def _of_rotation(body: Reduced, whole: float, seen: Seen) -> Iterator[str]:
    """The sentence on centrifugal forces that the kept shapes leave out, beside the largest strain energy."""
    from flexmb.elastic.reduced.bases import inertia_loads
    from flexmb.elastic.reduced.superelement import left_out

    model, force = body.model, inertia_loads(body.model)["rotation"]
    speed, when = min(seen.motion.peak(f"{body.name}.{pin.name}.omega") for pin in model.pins)
    moved, size = np.abs(model.shape @ body.basis.static(force)).max(), np.ptp(model.points, axis=0).max()
    left = speed**4 * left_out(body, force)[1]
    if left > LEFT_OUT * (whole + left) and speed**2 * moved > STEP_ERROR * size:
        yield (
            f"{body.label}: at t = {when:.6g} s it turns at {speed:.4g} rad/s, and its kept shapes leave out "
            f"{100.0 * left / (whole + left):.3g} % of its strain energy, by centrifugal forces: stress inside is too "
            "small. Keep their shape, Reduced(..., inertia_shapes=True), or more modes."
        )


# Remarks of a run on the safety of flexible bodies against yield, by the largest stress of all accepted steps

LEAST = 1e-6
"""Stress over yield stress up to which nothing is said: round-off of a body without loads."""


def strength_remarks(mechanism: Mechanism, signals: Signals, peaks: Peaks) -> Iterator[str]:
    """A sentence on each body that looks for its largest stress and whose yield stress is known."""
    for body in mechanism.bodies:
        place = signals.places.get(f"{body.name}.von_mises")
        if place is not None:
            yield from _strength_remark(body, signals, peaks, place)


def _strength_remark(body: Any, signals: Signals, peaks: Peaks, place: int) -> Iterator[str]:
    """The sentence on one body."""
    from flexmb.results.stress import STRESSED, reference_points

    if not isinstance(body, STRESSED):
        return
    stress, limits = float(peaks.values[place]), yield_stresses(body)
    if not limits or not stress > LEAST * min(limits):
        return
    node = round(float(peaks.values[signals.places[f"{body.name}.von_mises_node"]]))
    x, y = reference_points(body)[node].tolist()
    kind = "normal stress in the outer fibres" if isinstance(source_of(body), FlexibleBody) else "von Mises stress"
    when = f"at t = {peaks.times[place]:.6g} s at node {node}, ({x:.4g}, {y:.4g}) m in the reference configuration"
    safety, weakest = min(limits) / stress, " of the weakest material, at least" * (len(limits) > 1)
    text = f"{body.label}: largest {kind} {number_text(stress)} Pa {when}"
    text += f": safety against yield{weakest} {safety:.3g}"
    if safety < 1.0:
        text += f"; it yields at {min(limits):.3g} Pa, and stresses are those of a linear elastic material"
    yield f"{text}."


def source_of(body: STRESSED) -> FlexibleBody | PlaneBody:
    """Body with all its nodes, of which a reduced body is made."""
    source: Any = getattr(body, "body", body)
    return source  # type: ignore[no-any-return]


def materials_of(source: FlexibleBody | PlaneBody) -> list[Material]:
    """Materials of a body with all its nodes."""
    if isinstance(source, FlexibleBody):
        return [source.material]
    from flexmb.elastic.meshes.mesh import by_region

    return [material for _, material in by_region(source.label, "material", source.material)]


def yield_stresses(body: STRESSED) -> set[float]:
    """Different yield stresses of the materials of a body [Pa]; empty where one is unknown."""
    known = {material.yield_stress for material in materials_of(source_of(body))}
    return {limit for limit in known if limit is not None} if None not in known else set()


# Watch over a run: penetrations, contacts, strains and laws that cannot be right, with time, part and remedy

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
