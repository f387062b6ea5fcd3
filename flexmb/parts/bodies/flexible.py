"""Beams of flexible bodies: nodes, matrices, contributions to a program, bosses, stresses, start values."""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, cast

import numpy as np

from flexmb import checks, planar
from flexmb.elastic.beams import corotational, stress
from flexmb.elastic.beams.mass_damping import damping_element
from flexmb.elastic.beams.section import Section
from flexmb.elastic.beams.stress import outer_fibres
from flexmb.errors import InputError
from flexmb.kernels import signal_kernel
from flexmb.late import scipy
from flexmb.model.contributions import Contribution, ElementContribution, Node, SignalContribution, node_coordinates
from flexmb.model.law import Material
from flexmb.model.shape import BeamShape
from flexmb.parts.bodies.rigid import checked_velocity, mean_mass, node_mass

if TYPE_CHECKING:
    from flexmb.elastic.beams.fem import BeamMatrices

# Fields along flexible bodies at the start: three numbers at every node

Triple = tuple[float, float, float]
Field = tuple[Triple, ...]
FieldLike = Sequence[Triple] | Callable[[float], Triple]
VELOCITY = ("(vx, vy, omega)", ("m/s", "m/s", "rad/s"))
DISPLACEMENT = ("(dx, dy, dtheta)", ("m", "m", "rad"))


def start_velocity(label: str, given: object, nodes: int, places: Sequence[float] | None) -> Triple | Field | None:
    """A start velocity: None, one triple for a rigid motion, or one a node, also by a function of `places`."""
    if given is None:
        return None
    if not callable(given) and isinstance(given, Iterable) and not isinstance(given, str):
        given = checks.sequence(label, "velocity", given, f"{VELOCITY[0]}, or one triple")
        if not any(isinstance(item, Iterable) for item in given):
            return checked_velocity(label, "velocity", given)
    elif not callable(given):
        return checked_velocity(label, "velocity", given)
    return field(label, "velocity", given, nodes, places, *VELOCITY)


def start_displacement(label: str, given: object, nodes: int, places: Sequence[float] | None) -> Field | None:
    """A start displacement: None, or a field with one triple a node; `places` as in `start_velocity`."""
    return None if given is None else field(label, "displacement", given, nodes, places, *DISPLACEMENT)


def field(
    label: str, name: str, given: object, nodes: int, places: Sequence[float] | None, form: str, units: Sequence[str]
) -> Field:
    """One checked triple a node, from a list or a function of the place."""
    if callable(given):
        if places is None:
            text = f"{label}: {name} is a function, but a frame has no coordinate along it."
            raise InputError(f"{text} Give one {form} per node, {nodes} in all, in the order of its nodes.")
        given = tuple(cast("Callable[[float], object]", given)(s) for s in places)
        whence = "the function returns {!r} at s = {:g}"
    else:
        given = checks.sequence(label, name, given, f"{form}, one per node")
        whence = ""
    if len(given) != nodes:
        text = f"{label}: {name} has {len(given)} entries, but the body has {nodes} nodes. Give one {form} per node"
        more = ", or a function of s, 0 at the start and 1 at the end" if places is not None else ""
        raise InputError(f"{text}{more}.")
    found = []
    for i, item in enumerate(given):
        values = tuple(item) if isinstance(item, Iterable) and not isinstance(item, str) else (item,)
        if len(values) != 3:
            wrong = whence.format(item, (places or ())[i]) if whence else f"entry {i} is {item!r}"
            raise InputError(f"{label}: {name}: {wrong}; it must be {form}.")
        found.append(tuple(checks.number(label, f"{name}[{i}][{k}]", values[k], units[k]) for k in range(3)))
    return cast("Field", tuple(found))


# End bosses: point masses that give a beam model a prescribed mass, centre of mass and moment of inertia exactly

Point = tuple[float, float]


@dataclass(frozen=True)
class RigidProperties:
    """Mass [kg], centre of mass [m] and moment of inertia about the centre [kg m^2] of a body as declared."""

    mass: float
    centre: Point
    inertia: float

    @staticmethod
    def of(parts: list[tuple[float, Point, float]]) -> RigidProperties:
        """Sum of rigid parts given as (mass, centre, inertia about the centre)."""
        masses, centres, inertias = map(np.array, zip(*parts, strict=True))
        mass = float(masses.sum())
        centre = masses @ centres / mass
        inertia = inertias.sum() + masses @ ((centres - centre) ** 2).sum(axis=1)
        return RigidProperties(mass, (float(centre[0]), float(centre[1])), float(inertia))


@dataclass(frozen=True)
class Bosses:
    """Masses at the corners [kg], moment of inertia of each boss [kg m^2], mass at the mean of the corners [kg]."""

    masses: tuple[float, ...]
    inertia: float
    mean_mass: float


def fit_bosses(label: str, beam: RigidProperties, wanted: RigidProperties, corners: list[Point]) -> Bosses:
    """Bosses that turn the mass properties of the bare `beam` into the `wanted` ones."""
    # Unknowns are one mass a corner, one moment of inertia common to all corners and, with three corners or more, a
    # mass at their mean; none may be negative. Among several solutions the one of least norm is taken. Wanted values
    # that cannot be reached by adding mass at these places are refused with the difference.
    points = np.array(corners)
    places = [*points, points.mean(axis=0)] if len(corners) > 2 else list(points)
    centre = np.array(wanted.centre)
    radius, mass = max(float(np.abs(points - centre).max()), 1e-12), wanted.mass - beam.mass
    if mass < -1e-9 * wanted.mass:
        text = f"{label}: mass is {wanted.mass:g} kg, but the beams alone weigh {beam.mass:g} kg."
        raise InputError(f"{text} Give a larger mass, a smaller section or density, or leave mass out.")
    moment = wanted.mass * centre - beam.mass * np.array(beam.centre)
    shift = np.array(beam.centre) - centre
    inertia = wanted.inertia - beam.inertia - beam.mass * float(shift @ shift)
    columns = [[1.0, *((p - centre) / radius), float((p - centre) @ (p - centre)) / radius**2] for p in places]
    columns.append([0.0, 0.0, 0.0, 1.0])  # the common moment of inertia, in units of mass radius^2
    A, b = np.array(columns).T, np.array([mass, *((moment - mass * centre) / radius), inertia / radius**2])
    x = _least_norm_not_negative(A, b, wanted.mass)
    if x is None:
        reach = [float((p - centre) @ (p - centre)) for p in places]
        low, high = mass * min(reach), mass * max(reach)
        advice = "Check the centre of mass: it must lie between the places where mass can be added."
        if inertia < low:
            advice = f"Masses there add at least {low:.4g} kg m^2: give a larger inertia or a lighter beam."
        elif inertia > high:
            advice = f"Masses there add about {high:.4g} kg m^2: check the inertia and the centre of mass."
        text = f"{label}: mass {wanted.mass:g} kg, inertia {wanted.inertia:g} kg m^2 with the centre of mass at "
        text += f"({wanted.centre[0]:.4g}, {wanted.centre[1]:.4g}) m cannot be reached by bosses at the corners: "
        raise InputError(f"{text}they have {mass:.4g} kg and {inertia:.4g} kg m^2 to add. {advice}")
    n = len(corners)
    return Bosses(tuple(float(v) for v in x[:n]), float(x[-1]) * radius**2 / n, float(x[n]) if n > 2 else 0.0)


def _least_norm_not_negative(A: np.ndarray, b: np.ndarray, scale: float) -> np.ndarray | None:
    """The x >= 0 of least norm with A x = b, or None."""
    small, n = 1e-7, A.shape[1]
    rough, _ = scipy.optimize.nnls(np.vstack([A, small * np.eye(n)]), np.concatenate([b, np.zeros(n)]))
    active, x = rough > 1e-6 * scale, np.zeros(n)
    x[active] = np.linalg.lstsq(A[:, active], b, rcond=None)[0]
    good = np.abs(A @ x - b).max() <= 1e-9 * scale and x.min() >= 0.0
    if not good:
        x, _ = scipy.optimize.nnls(A, b)
        good = np.abs(A @ x - b).max() <= 1e-9 * scale
    return x if good else None


# Beams of flexible bodies: nodes, matrices, contributions to the equations of motion, shapes, deflection

Array = np.ndarray
Elements = int | tuple[float, ...]


@dataclass(frozen=True)
class Beam:
    """One beam between two corners: names of its nodes, their stations along it [m], section and material."""

    nodes: tuple[str, ...]
    start: Point
    end: Point
    stations: tuple[float, ...]
    section: Section
    material: Material
    rotary_inertia: float | None = 0.0  # of the sections [kg m]; None: rho I
    shear: float | None = 0.0  # shear factor [1]; None: that of the section; 0: no shear
    turn: float = 0.0  # by which the beam turns from start to end along a circular arc [rad]; 0: straight

    @property
    def length(self) -> float:
        """Length along the beam [m]."""
        return math.dist(self.start, self.end) / corotational.chord_share(self.turn)

    @property
    def places(self) -> list[float]:
        """Fractions of the length at the nodes."""
        return [station / self.stations[-1] for station in self.stations]

    @property
    def points(self) -> list[Point]:
        """Points of the nodes in the reference configuration [m]."""
        return corotational.points(self.start, self.end, self.turn, self.places)

    @property
    def middles(self) -> list[Point]:
        """Points of the middles of the elements in the reference configuration [m]."""
        return corotational.points(self.start, self.end, self.turn, [0.5 * (a + b) for a, b in pairwise(self.places)])


def checked_elements(label: str, elements: object) -> Elements:
    """A number of elements, or increasing fractions of the length where inner nodes stand."""
    if isinstance(elements, (tuple, list, np.ndarray)):
        inner = tuple(checks.between(label, "elements", s, 0.0, 1.0) for s in elements)
        if any(b <= a for a, b in pairwise((0.0, *inner, 1.0))):
            raise InputError(f"{label}: elements are {inner}; fractions must increase strictly between 0 and 1.")
        return inner
    return checks.count(label, "elements", elements)


@lru_cache(maxsize=64)
def fractions(elements: Elements) -> tuple[float, ...]:
    """Positions of all nodes as fractions of the length."""
    return tuple(i / elements for i in range(elements + 1)) if isinstance(elements, int) else (0.0, *elements, 1.0)


REMEMBERED = 4096  # number of beams whose matrices are kept besides those of the present call
BeamKey = tuple[tuple[float, ...], Section, Material, float | None, float | None]
_KNOWN: dict[BeamKey, BeamMatrices] = {}  # matrices of beams by their data


def matrices(beam: Beam) -> BeamMatrices:
    """Element matrices of a beam through scikit-fem, remembered for beams of equal data."""
    found = _KNOWN.get(_data_of(beam))
    if found is None:
        assemble([beam])
        found = _KNOWN[_data_of(beam)]
    return found


def assemble(beams: Iterable[Beam]) -> None:
    """Assemble the matrices of several beams in one mesh; beams of equal data are assembled once."""
    from flexmb.elastic.beams.fem import BeamData, assembled  # noqa: PLC0415 - scikit-fem is needed only here

    keys = {_data_of(beam): None for beam in beams}
    if len(_KNOWN) > REMEMBERED:
        kept = {key: _KNOWN[key] for key in keys if key in _KNOWN}
        _KNOWN.clear()
        _KNOWN.update(kept)
    new = [key for key in keys if key not in _KNOWN]
    data = [
        BeamData(np.array(stations), section, material, True if rotary is None else rotary, shear is None or shear)
        for stations, section, material, rotary, shear in new
    ]
    _KNOWN.update(zip(new, assembled(data), strict=True))


def _data_of(beam: Beam) -> BeamKey:
    """Data of a beam that its matrices depend on."""
    # None, not True, which equals 1.0
    return beam.stations, beam.section, beam.material, beam.rotary_inertia, beam.shear


def beam_parameters(beam: Beam, nodes: dict[str, Node], damping: float, gravity: Point) -> list[tuple[float, ...]]:
    """p of every element of a beam."""
    load, data = (float(damping), *map(float, gravity)), matrices(beam)
    free = unstressed_shape(beam, data).tolist() if beam.turn else data.straight
    each = zip(data.parameters, pairwise(_offsets(beam, nodes)), free, strict=True)
    return [(*head, first, second, *load, *tail, *rest) for (head, tail), (first, second), rest in each]


def unstressed_shape(beam: Beam, data: BeamMatrices) -> Array:
    """l0, u10, u20 of the elements of a beam (n, 3); see `flexmb.elastic.beams.corotational`."""
    if not beam.turn:
        return np.array(data.straight)
    half = 0.5 * beam.turn * data.lengths / data.lengths.sum()
    chords = data.lengths * np.sinc(half / math.pi)
    return np.stack([chords + data.lengths / 30.0 * half * half * data.bow.sum(axis=1), -half, half], axis=1)


def _offsets(beam: Beam, nodes: Mapping[str, Node]) -> list[float]:
    """Directions of the beam at its nodes less theta of the nodes, in the reference configuration [rad]."""
    angles = corotational.tangents(beam.start, beam.end, beam.turn, beam.places if beam.turn else beam.stations)
    return [angle - nodes[name].theta for angle, name in zip(angles, beam.nodes, strict=True)]


def beam_pieces(
    part: str, beams: Sequence[Beam], nodes: dict[str, Node], damping: float, gravity: Point
) -> list[Contribution]:
    """Element pieces of all beams of a body."""
    element, kernels, found = corotational.BEAM.element, corotational.BEAM.by_name(), list[Contribution]()
    for beam in beams:
        ends = pairwise(node_coordinates(part, node) for node in beam.nodes)
        each = zip(beam_parameters(beam, nodes, damping, gravity), ends, strict=True)
        found += [ElementContribution(part, element, (*first, *second), p, **kernels) for p, (first, second) in each]
    return found


def mass_damping_pieces(
    part: str, beams: Sequence[Beam], axis: Beam, zeta: float, lumps: Mapping[str, tuple[float, float]]
) -> list[Contribution]:
    """Contributions of mass-proportional damping, one an element; none when zeta is 0."""
    # The body's frame runs from the first to the last node of `axis`. `lumps` are (mass [kg], inertia [kg m^2]) by
    # node; each is counted with the first element that ends there.
    if zeta == 0.0:
        return []
    left, frame = dict(lumps), tuple(c for k in (0, -1) for c in node_coordinates(part, axis.nodes[k])[:2])
    contributions: list[Contribution] = []
    for beam in beams:
        data, directions = matrices(beam), chord_directions(beam)
        for k, nodes in enumerate(pairwise(beam.nodes)):
            mass, ends = np.zeros((6, 6)), [left.pop(node, (0.0, 0.0)) for node in nodes]
            mass[np.ix_((0, 3), (0, 3))] = data.axial_mass[k]
            mass[np.ix_((1, 2, 4, 5), (1, 2, 4, 5))] = data.bending_mass[k]
            mass += np.diag([x for lump, inertia in ends for x in (lump, lump, inertia)])
            coordinates = (*frame, *(c for node in nodes for c in node_coordinates(part, node)))
            turn = directions[k] - planar.direction(axis.start, axis.end)
            contributions.append(damping_element(part, coordinates, zeta, 2, mass, turn))
    return contributions


def chord_directions(beam: Beam) -> list[float]:
    """Directions of the chords of the elements in the reference configuration [rad]."""
    return corotational.tangents(beam.start, beam.end, beam.turn, [0.5 * (a + b) for a, b in pairwise(beam.places)])


def beam_strains(beam: Beam, nodes: Mapping[str, Node], poses: Sequence[Array]) -> Array:
    """Largest strain (instants, elements) of the outer fibres of each element by x, y, theta of the nodes of a beam."""
    stations, data = np.array(beam.stations), matrices(beam)
    outer = outer_fibres(beam.section, stations / stations[-1])
    own = np.array(_offsets(beam, nodes)), np.maximum(outer[:-1], outer[1:]), data.shear_shares.T, data.bow.T
    return stress.strains(poses, np.diff(stations), *own, unstressed_shape(beam, data).T)


def beam_shapes(part: str, beams: Sequence[Beam], nodes: dict[str, Node], gravity: Point) -> tuple[BeamShape, ...]:
    """Drawing records of all elements."""
    shapes = []
    for beam in beams:
        data = matrices(beam)
        unstressed = unstressed_shape(beam, data)
        depths = 2.0 * outer_fibres(beam.section, np.array(beam.stations) / beam.stations[-1])
        for k, p in enumerate(beam_parameters(beam, nodes, 0.0, gravity)):
            ei, depth = (float(data.ei[k, 0]), float(data.ei[k, 1])), (float(depths[k]), float(depths[k + 1]))
            bending = p[corotational.B11], p[corotational.B12], p[corotational.B22]
            angles = p[corotational.OFFSET1], p[corotational.OFFSET2]
            own = p[corotational.LENGTH], *angles, p[corotational.AXIAL], bending, ei, depth
            mass = p[corotational.GRAVITY_X : corotational.BOW11]
            shape = BeamShape(part, beam.nodes[k], beam.nodes[k + 1], *own, mass=mass)
            shares, bow, free = (tuple(array[k].tolist()) for array in (data.shear_shares, data.bow, unstressed))
            plain = not any(shares) and not beam.turn
            shapes.append(shape if plain else replace(shape, shear=shares, bow=bow, unstressed=free))
    return tuple(shapes)


def mass_parts(beam: Beam) -> list[tuple[float, Point, float]]:
    """(mass, centre of mass, inertia about it) of every element of a beam, from its consistent mass."""
    data = matrices(beam)
    if beam.turn:
        # `mass_parts` of an arc: of r = (1 - xi) x1 + xi x2 + w n at rest
        parts, free = [], unstressed_shape(beam, data).tolist()
        ends = beam.points[:-1], chord_directions(beam)
        each = zip(free, data.lengths.tolist(), data.inertia_integrals.tolist(), *ends, strict=True)
        for (_, u1, u2), L, integrals, start, angle in each:
            m11, m12, m22, g11, g12, g21, g22, h11, h12, h22, J, *_ = integrals
            mass, chord = m11 + 2.0 * m12 + m22, L * corotational.chord_share(2.0 * u2)
            along, aside = chord * (m12 + m22) / mass, ((g11 + g21) * u1 + (g12 + g22) * u2) / mass
            inertia = chord**2 * m22 + h11 * u1 * u1 + 2.0 * h12 * u1 * u2 + h22 * u2 * u2 + J
            centre = planar.from_frame(start, angle, (along, aside))
            parts.append((mass, centre, inertia - mass * (along**2 + aside**2)))
        return parts
    angle, parts = planar.direction(beam.start, beam.end), []
    for k, length in enumerate(data.lengths):
        ma, mb = data.axial_mass[k], data.bending_mass[k]
        mass = float(ma.sum())
        arm, turn = float(ma[:, 1].sum()) * length / mass, np.array([0.0, 1.0, length, 1.0])
        inertia = float(turn @ mb @ turn) - mass * arm**2
        parts.append((mass, planar.from_frame(beam.start, angle, (beam.stations[k] + arm, 0.0)), inertia))
    return parts


def boss_pieces(part: str, corners: Sequence[str], bosses: Bosses, gravity: Point) -> list[Contribution]:
    """Contributions of the bosses at the corners and of the mass at their mean."""
    pairs, found = zip(corners, bosses.masses, strict=True), list[Contribution]()
    found += [node_mass(part, node, mass, bosses.inertia, gravity) for node, mass in pairs if mass or bosses.inertia]
    found += [mean_mass(part, tuple(corners), bosses.mean_mass, gravity)] if bosses.mean_mass else []
    return found


def nearest_node(
    label: str, owner: str, nodes: Sequence[Node], point: Point, size: float,
    remedy: str = "or choose elements so that a node stands at the point",
) -> Node:  # fmt: skip
    """The node at a world point of the reference configuration, or `InputError` that names the nodes nearby."""
    for node in nodes:
        if (node.x, node.y) == point:
            return node
    by_distance = sorted(nodes, key=lambda n: planar.distance((n.x, n.y), point))
    gap = planar.distance((by_distance[0].x, by_distance[0].y), point)
    if gap <= 1e-6 * size:
        return by_distance[0]
    near = ", ".join(f"{n.name} at ({n.x:.6g}, {n.y:.6g})" for n in by_distance[:3])
    text = f"{owner}: the point ({point[0]:g}, {point[1]:g}) is no node of {label}; it lies"
    raise InputError(f"{text} {gap:.3g} m from the nearest. Nodes nearby: {near}. Move the point there, {remedy}.")


@signal_kernel
def deflection_kernel(p, t, q, v, a):
    """Distance of a point (x1, y1) from the chord (x0, y0)-(x2, y2), positive to the left of the chord."""
    dx, dy = q[4] - q[0], q[5] - q[1]
    return (dx * (q[3] - q[1]) - dy * (q[2] - q[0])) / math.sqrt(dx * dx + dy * dy)


# Parameters of the deflection within an element: place, shear shares, those of the element; coordinates of its nodes
# stand behind those of both ends of the chord, and are so many.
ALONG, SHARE1, SHARE2, OWN = range(4)
ENDS, COORDINATES = 4, 10
SAME_PLACE = 1e-9  # part of the length of a beam within which a node is its middle


@signal_kernel
def inner_deflection_kernel(p, t, q, v, a):
    """Distance of a place on the axis of an element from the chord (x0, y0)-(x1, y1), positive to its left."""
    own, x = p[OWN:], q[ENDS:COORDINATES]
    _, c, s, _, u1, u2 = corotational.deformation(own, x)
    sheared, along = p[SHARE1] * u1 + p[SHARE2] * u2, p[ALONG]
    rest = 1.0 - along
    w = own[corotational.LENGTH] * along * rest * (rest * (u1 - sheared) - along * (u2 - sheared))
    dx, dy = q[2] - q[0], q[3] - q[1]
    px, py = rest * x[0] + along * x[3] - s * w - q[0], rest * x[1] + along * x[4] + c * w - q[1]
    return (dx * py - dy * px) / math.sqrt(dx * dx + dy * dy)


def deflection_signal(part: str, beam: Beam, nodes: Mapping[str, Node]) -> SignalContribution:
    """The signal `deflection` of the middle of a beam, which is a node or lies in an element."""
    places, first, last = beam.places, beam.nodes[0], beam.nodes[-1]
    ends = ((part, first, 0), (part, first, 1), (part, last, 0), (part, last, 1))
    k = bisect(places, 0.5 + SAME_PLACE) - 1
    if abs(places[k] - 0.5) < SAME_PLACE:
        middle = ((part, beam.nodes[k], 0), (part, beam.nodes[k], 1))
        return SignalContribution(part, "deflection", "m", deflection_kernel, (*ends[:2], *middle, *ends[2:]))
    along = (0.5 - places[k]) / (places[k + 1] - places[k])
    inner = tuple(c for node in beam.nodes[k : k + 2] for c in node_coordinates(part, node))
    own = beam_parameters(beam, dict(nodes), 0.0, (0.0, 0.0))[k]
    p = (float(along), *matrices(beam).shear_shares[k].tolist(), *own)
    return SignalContribution(part, "deflection", "m", inner_deflection_kernel, (*ends, *inner), p)


def knows_stress(section: Section) -> bool:
    """Whether a section knows its outer fibre."""
    try:
        section.outer_fibre_at(0.5)
    except InputError:
        return False
    return True


def number_of(node: str) -> int:
    """Number of a node of a body of beams: 3 of "node3"."""
    return int(node.removeprefix("node"))


def arc_factors(beam: Beam, places: Sequence[float] | np.ndarray = (0.0, 0.5, 1.0)) -> np.ndarray:
    """(..., 2) stress over -M in the outer fibres on the left and on the right of an arc [1/m^3]; NaN: no outline."""
    return stress.arc_factors(beam.section, np.asarray(places), beam.turn, beam.length)


THIN = 1e-6  # outer fibre over the radius of an arc, below which its stress is that of a straight beam


def section_factors(beam: Beam, along: np.ndarray) -> np.ndarray:
    """(elements, m, 3) stress over N, 1/A, and over -M in the outer fibres on the left and on the right [1/m^3]."""
    # At fractions (m,) along each element of a beam whose outer fibres are known.
    stations, section = np.array(beam.stations), beam.section
    at = (stations[:-1, None] + np.diff(stations)[:, None] * along) / stations[-1]
    A, I = (np.where(np.asarray(x) > 0.0, x, math.inf) for x in (section.area_at(at), section.second_moment_at(at)))
    left = np.asarray(section.outer_fibre_at(at)) / I  # 0 at the tip of a wedge
    both = np.stack([left, -left], axis=-1)
    if beam.turn and abs(beam.turn) > THIN * beam.length / np.max(section.outer_fibre_at(at)):
        curved = arc_factors(beam, at)
        both = np.where(np.isnan(curved), both, curved)
    return np.concatenate([1.0 / A[..., None], both], axis=-1)


def beam_stress_signal(
    part: str, beams: Sequence[Beam], nodes: Mapping[str, Node], gravity: Point
) -> SignalContribution:
    """The signals `von_mises` and `von_mises_node` of a body of beams, whose sections know their outer fibres."""
    coordinates = tuple(c for name in nodes for c in node_coordinates(part, name))
    place = {name: 3.0 * k for k, name in enumerate(nodes)}
    found: list[tuple[float, ...]] = []
    for beam in beams:
        factors = section_factors(beam, stress.PLACES).reshape(len(beam.nodes) - 1, -1).tolist()
        own = beam_parameters(beam, dict(nodes), 0.0, gravity)
        for ends, factor, parameters in zip(pairwise(beam.nodes), factors, own, strict=True):
            numbers = *(float(number_of(name)) for name in ends), float(len(nodes) + len(found))
            found.append((*(place[name] for name in ends), *numbers, *factor, *parameters))
    p = (float(len(found)), *(x for row in found for x in row))
    kernel = stress.beam_stress_kernel
    return SignalContribution(part, "von_mises", "Pa", kernel, coordinates, p, place="von_mises_node")
