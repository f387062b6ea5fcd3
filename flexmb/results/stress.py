"""Stresses of flexible bodies at the saved instants, and fatigue by them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from flexmb import checks
from flexmb.display import number_text
from flexmb.errors import InputError
from flexmb.fields import Input, field, not_negative, positive, record, record_with
from flexmb.late import Late, xr
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import ElasticBody
from flexmb.model.shape import BeamShape, MeshShape
from flexmb.parts.bodies.flexible import number_of, section_factors
from flexmb.results.drawing import beam_motion, nearest_to_each, pose, poses, surface, turned, turned_by

if TYPE_CHECKING:
    from flexmb.elastic.beams import fem as hermite
    from flexmb.elastic.planes import stress as plane
    from flexmb.elastic.reduced import accuracy as reduced
    from flexmb.results.solution import Solution
else:  # as in drawings
    hermite = Late("flexmb.elastic.beams.fem")
    plane, reduced = Late("flexmb.elastic.planes.stress"), Late("flexmb.elastic.reduced.accuracy")


def place_of_stress(sol: Solution, part: str, node: int) -> tuple[float, float] | None:
    """Place of a node in the reference configuration [m]; None where the solution does not know it."""
    if sol.mechanism is not None:
        body = sol.mechanism.find(part)
        return tuple(body.reference_points()[node].tolist()) if isinstance(body, ElasticBody) else None
    # points of a body with all nodes of its mesh are those of the reference configuration
    meshes = (shape for shape in sol.shapes if isinstance(shape, MeshShape) and shape.part == part and not shape.basis)
    return next((shape.points[node] for shape in meshes), None)


Wanted = Sequence[tuple[float, float] | int | str]
Stresses = tuple["Places", dict[str, np.ndarray]]
Times = Sequence[float] | None
ALONG = np.array([0.0, 0.5, 1.0])  # places of stresses along an element

MEANINGS = {  # names and meanings of the stresses
    "sx": "normal stress along x of the body",
    "sy": "normal stress along y of the body",
    "txy": "shear stress in the axes of the body",
    "principal_1": "larger principal stress in the plane",
    "principal_2": "smaller principal stress in the plane",
    "axial": "stress of the axial force",
    "bending": "stress of the bending moment in the outer fibre on the left",
    "bending_right": "stress of the bending moment in the outer fibre on the right",
    "signed": "normal stress that is largest by its absolute value",
    "von_mises": "von Mises stress",
}


class Places(NamedTuple):
    """Places of known stresses."""

    nodes: np.ndarray  # (m,) numbers of the nodes
    points: np.ndarray  # (m, 2) their places in the reference configuration [m]
    names: Mapping[str, int]  # numbers of the nodes by the names of nodes
    more: Mapping[str, tuple[np.ndarray, str]]  # further coordinates (m,), with their units


def stress(sol: Solution, body: str, points: Wanted | None, times: Times, mechanism: Mechanism | None) -> xr.Dataset:
    """Stresses of a flexible body over time; see `Solution.stress`."""
    known = moved_mechanism(sol, body, mechanism)
    part = known.find(body)
    if not isinstance(part, ElasticBody):
        raise InputError(f"{part.label} has no stresses. Name a flexible body of {known.name!r}.")
    if not part.whole_body.knows_stress:
        raise InputError(f"{part.label}: a section does not know its outer fibre. Give outer_fibre=... [m] to it.")
    if mechanism is not None:
        refuse_other_body(sol, part, known)
    instants = np.arange(len(sol.time)) if times is None else nearest_to_each(sol, np.asarray(times, dtype=float))
    if part.theory == "beams":
        places, fields = of_beams(sol, part, known, instants)
    else:
        shape = next(s for s in sol.shapes if isinstance(s, MeshShape) and s.part == part.name)
        places = Places(np.arange(len(shape.points)), part.reference_points(), {}, {})
        plate: Any = part
        moved = surface(sol, shape, instants)
        if part.whole_body is part:  # in axes that turn with it
            X, x = plate.mesh.points, moved.points
            along, across = turned_by(X - X.mean(axis=0), x - x.mean(axis=1, keepdims=True))
            whole = turned(moved.stress, -np.arctan2(across, along)[:, None])
        elif shape.fibres:  # of beams
            whole = turned(moved.stress, -reduced.deformed(shape, moved.poses)[1][:, None])
        else:  # sums of the stresses of its shapes, in its axes
            d, _ = reduced.deformed(shape, poses(sol, shape.part, shape.nodes, instants))
            e = reduced.shortened(d, plate.element.directions)
            whole = np.einsum("msi,ti->tms", plate.model.stresses(plate.basis.shapes), e, optimize=True)
        sx, sy, txy, _ = np.moveaxis(whole, -1, 0)
        larger, smaller, _ = plane.principal(whole[..., :3])
        signed = np.where(larger + smaller >= 0.0, larger, smaller)
        found = {"sx": sx, "sy": sy, "txy": txy, "principal_1": larger, "principal_2": smaller, "signed": signed}
        fields = {**found, "von_mises": plane.von_mises(whole)}
    chosen = np.arange(len(places.nodes)) if points is None else chosen_places(part.label, places, points)
    own = {"node": (places.nodes, ""), "x": (places.points[:, 0], "m"), "y": (places.points[:, 1], "m"), **places.more}
    columns = {name: (values, {"units": "Pa", "long_name": MEANINGS[name]}) for name, values in fields.items()}
    return at_places(sol, part.name, instants, chosen, own, columns)


def moved_mechanism(sol: Solution, name: str, mechanism: Mechanism | None) -> Mechanism:
    """The mechanism that moved, or the given one for a solution that was read from a file."""
    known = sol.mechanism if mechanism is None else mechanism
    if known is None:
        raise InputError(f"Solution of {sol.name!r}: files do not hold {name!r}. Give mechanism=..., as it moved.")
    return known


SAME_NUMBERS = 1e-6  # difference of numbers of the body over their largest, up to which they are equal
OF_MESH = ("points", "cells", "materials", "material_of", "basis", "fibres")
NUMBERS = {BeamShape: ("length", "axial", "ei"), MeshShape: OF_MESH}


def refuse_other_body(sol: Solution, body: Any, mechanism: Mechanism) -> None:
    """`InputError` for a body with other beams, or another mesh, materials or kept shapes, than the one that moved."""
    moved, given = (
        [np.array(getattr(s, n), float) for s in some for n in NUMBERS.get(type(s), ()) if s.part == body.name]
        for some in (sol.shapes, body.shapes(mechanism))
    )
    if [a.shape for a in moved] != [b.shape for b in given] or any(
        np.abs(a - b).max(initial=0.0) > SAME_NUMBERS * np.abs(b).max(initial=0.0)
        for a, b in zip(moved, given, strict=True)
    ):
        raise InputError(f"{body.label} is not the one that moved: its numbers differ. Give the mechanism that moved.")


def of_beams(sol: Solution, body: Any, mechanism: Mechanism, instants: np.ndarray) -> Stresses:
    """Stresses (n, 3 elements) at the start, in the middle and at the end of all elements."""
    shapes, axial, bending = body.shapes(mechanism), [], []
    for shape, factor in zip(shapes, np.concatenate([section_factors(b, ALONG) for b in body.beams]), strict=True):
        motion = beam_motion(sol, shape, instants)
        if motion is None:
            text = f"{body.label}: stresses need velocities and accelerations of the nodes, which were not saved"
            raise InputError(f"{text}. Add {body.name + '.*'!r} to simulate(..., signals=[...]).")
        start, end = (pose(sol, body.name, name, instants) for name in (shape.start, shape.end))
        forces = hermite.section_forces(start, end, shape, ALONG, motion)
        axial.append(forces.N * factor[:, 0])
        bending.append(-forces.M[..., None] * factor[:, 1:])
    nodes, pairs = body.nodes(), enumerate((number_of(shape.start), number_of(shape.end)) for shape in shapes)
    numbers = np.array([(first, len(nodes) + k, last) for k, (first, last) in pairs]).ravel()
    ends = [np.array(list(pairwise(beam.stations))) for beam in body.beams]
    stations = np.concatenate(ends) @ (1.0 - ALONG, ALONG)
    beam, element = np.repeat(np.arange(len(ends)), [3 * len(s) for s in ends]), np.repeat(np.arange(len(shapes)), 3)
    more = {"beam": (beam, ""), "element": (element, ""), "station": (stations.ravel(), "m")}
    known = {node.name: number_of(node.name) for node in nodes}
    known |= {alias: known[name] for alias, name in body.aliases.items()}
    places = Places(numbers, body.reference_points()[numbers], known, more)
    N, M = np.concatenate(axial, axis=1), np.concatenate(bending, axis=1)
    left, right = np.moveaxis(N[..., None] + M, -1, 0)
    larger, smaller = np.maximum(left, right), np.minimum(left, right)
    signed = np.where(larger + smaller >= 0.0, larger, smaller)
    own = {"axial": N, "bending": M[..., 0], "bending_right": M[..., 1]}
    return places, {**own, "signed": signed, "von_mises": np.abs(signed)}


def chosen_places(label: str, places: Places, points: Wanted) -> np.ndarray:
    """Numbers of the places at given nodes (numbers or names), or nearest to given points (x, y) [m]."""
    found: list[int] = []
    for point in points:
        if isinstance(point, str) and point in places.names:
            number = places.names[point]
        elif isinstance(point, int | np.integer):
            number = int(point)
        elif np.shape(point) == (2,) and not isinstance(point, str):
            gap = np.hypot(*(places.points - np.asarray(point, dtype=float)).T)
            number = int(places.nodes[np.argmin(gap)])
        else:
            number = -1
        own = np.flatnonzero(places.nodes == number)
        if not len(own):
            known = f"(x, y) [m] in the reference configuration, or numbers of nodes from 0 to {places.nodes.max()}"
            names = f", or names: {', '.join(list(places.names)[-3:])}" if places.names else ""
            raise InputError(f"{label}: {point!r} is no known point. Give {known}{names}.")
        found += own.tolist()
    return np.array(found, dtype=np.int64)


def at_places(
    sol: Solution, part: str, instants: np.ndarray, chosen: np.ndarray,
    coordinates: Mapping[str, tuple[np.ndarray, str]], columns: Mapping[str, tuple[np.ndarray, Mapping[str, str]]],
) -> xr.Dataset:  # fmt: skip
    """Values (n, m) with attributes, by name, over instants and chosen places; coordinates (m,) with their units."""
    time = xr.Variable("time", sol.time[instants], {"units": "s", "long_name": "time"})
    own = {name: ("place", values[chosen], {"units": unit}) for name, (values, unit) in coordinates.items()}
    found = {name: (("time", "place"), values[:, chosen], attrs) for name, (values, attrs) in columns.items()}
    return xr.Dataset(found, coords={"time": time, **own}, attrs={"mechanism": sol.name, "part": part})


PLANES = np.radians(np.arange(0.0, 180.0, 2.5))  # angles of the normals of planes whose stress is counted [rad]
CAPTURED = 0.98  # largest saved stress over the largest of all accepted steps, below which cycles are said to be missed


@record
class WoehlerLine(Input):
    """Cycles to failure over the amplitude of a stress: N = cycles (amplitude/sigma_a)^slope (Basquin).

    Raises
    ------
    InputError : a value out of its range.

    Notes
    -----
    The mean stress of a cycle has no influence; take the line of the load ratio that fits.
    Source: DIN 50100:2022, Load controlled fatigue testing.

    Examples
    --------
    >>> float(WoehlerLine(amplitude=100e6, slope=5.0).life(200e6))
    31250.0
    """

    amplitude: float = field("stress amplitude that is borne for `cycles`", "Pa", positive)
    slope: float = field("exponent k", rule=positive, default=5.0)
    cycles: float = field("number of cycles at this point of the line", rule=positive, default=1e6)
    limit: float = field("amplitude without damage; 0: every cycle counts", "Pa", not_negative, default=0.0)

    def life(self, amplitude: float | np.ndarray) -> np.ndarray:
        """Cycles to failure for stress amplitudes `amplitude` [Pa]; infinite up to the limit."""
        size = np.asarray(amplitude, dtype=float)
        bears = (size <= self.limit) | (size <= 0.0)
        ratio = self.amplitude / np.where(bears, self.amplitude, size)
        return np.asarray(np.where(bears, math.inf, self.cycles * ratio**self.slope))

    def damage(self, amplitudes: np.ndarray, counts: np.ndarray) -> float:
        """Sum of `counts` (n,) over cycles to failure of `amplitudes` (n,) [Pa], 1 at failure (Palmgren and Miner)."""
        return float(np.sum(counts / self.life(amplitudes)))


@record_with(eq=False)
class Fatigue:
    """Cycles of the stress at one point of a body during a run, and their damage.

    Notes
    -----
    Of meshes, the normal stress on planes at every 2.5 degrees across the plane of motion is counted, of beams that of
    both outer fibres in both sections at the node; the plane, or fibre, with the largest damage is kept.  Of ductile
    metals under shear alone, cracks may follow the planes of the largest shear, which this does not count.  Cycles are
    those of the saved instants, so save finely; `captured` tells what was missed.
    Source of the planes: D. F. Socie, G. B. Marquis, Multiaxial Fatigue, SAE 2000, chapter 5; of the count: ASTM
    E1049-85 (2017), section 5.4.4, by the package rainflow.
    """

    body: str = field("name of the body")
    node: int = field("number of the node")
    place: tuple[float, float] = field("its place as that of a peak", "m")
    ranges: np.ndarray = field("(n,) differences of the largest and smallest stress of each cycle", "Pa", repr=False)
    means: np.ndarray = field("(n,) their means", "Pa", repr=False)
    counts: np.ndarray = field("(n,) 1 of a full cycle, 0.5 of a half one", repr=False)
    duration: float = field("time over which cycles were counted", "s")
    woehler: WoehlerLine | None = field("the Woehler line; None: no damage")
    captured: float = field("largest saved stress over that of all steps; NaN at a chosen point", "1", default=math.nan)
    repeated: float = field("damage of each run if it is repeated: all cycles close", "1", default=math.nan)

    @property
    def damage(self) -> float:
        """Damage of the run, 1 at failure; NaN without a Woehler line."""
        return math.nan if self.woehler is None else self.woehler.damage(0.5 * self.ranges, self.counts)

    @property
    def life(self) -> float:
        """Time to failure if the run is repeated [s]; NaN without a Woehler line."""
        return self.duration / self.repeated if self.repeated != 0.0 else math.inf

    def __repr__(self) -> str:
        text = f"Fatigue of {self.body!r} at node {self.node}: {self.counts.sum():g} cycles in {self.duration:.6g} s"
        text += f", largest range {number_text(float(self.ranges.max(initial=0.0)))} Pa"
        if self.woehler is not None:
            text += f", damage {self.damage:.4g}, life {self.life:.4g} s"
        if self.captured < CAPTURED:
            text += f"; saved instants reach {self.captured:.2g} of the largest stress: save more"
        return text


def cycles_of(series: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ranges, means and counts of the cycles of a signal (n,) by rainflow counting."""
    rainflow = checks.package("rainflow", "fatigue", "Counting cycles")
    rows = [cycle[:3] for cycle in rainflow.extract_cycles(np.asarray(series, dtype=float).tolist())]
    ranges, means, counts = np.array(rows, dtype=float).reshape(-1, 3).T
    return ranges, means, counts


def fatigue(sol: Solution, body: str, woehler: Any, point: Any, mechanism: Mechanism | None) -> Fatigue:
    """Cycles and damage at a point of a body; see `Solution.fatigue`."""
    if woehler is not None:
        checks.instance("fatigue", "woehler", woehler, WoehlerLine, "a WoehlerLine(amplitude=..., slope=...)")
    peak, wanted = None, point
    if wanted is None:
        if f"{body}.von_mises" not in sol:
            text = f"fatigue: Solution of {sol.name!r} has no signal '{body}.von_mises', whose peak tells the point"
            raise InputError(f"{text}. Give point=..., or stress=True to the body.")
        peak = sol.peak(f"{body}.von_mises")
        wanted = peak.node
    own = stress(sol, body, [] if wanted is None else [wanted], None, mechanism)
    if "bending" in own:
        histories = np.hstack([(own["axial"] + own[fibre]).values for fibre in ("bending", "bending_right")])
    else:
        mean, half = 0.5 * (own["sx"].values + own["sy"].values), 0.5 * (own["sx"].values - own["sy"].values)
        histories = mean + half * np.cos(2.0 * PLANES) + own["txy"].values * np.sin(2.0 * PLANES)
    line = woehler if woehler is not None else WoehlerLine(1.0)
    found = [cycles_of(column) for column in histories.T]
    k = max(range(len(found)), key=lambda k: line.damage(0.5 * found[k][0], found[k][2]))
    ring = np.resize(np.roll(histories[:, k], -int(histories[:, k].argmax())), len(histories) + 1)
    again, _, many = cycles_of(ring)  # from the largest stress to the same one a run later
    repeated = math.nan if woehler is None else line.damage(0.5 * again, many)
    seen = math.nan if peak is None or peak.value == 0.0 else float(own["von_mises"].max()) / peak.value
    place, span = (float(own["x"][0]), float(own["y"][0])), float(sol.time[-1] - sol.time[0])
    return Fatigue(body, int(own["node"][0]), place, *found[k], span, woehler, seen, repeated)
