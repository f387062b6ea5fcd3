"""Beams of flexible bodies: nodes, matrices, contributions to the equations of motion, shapes, deflection."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks, planar
from flexmb.beams.corotational import (
    AXIAL,
    B11,
    B12,
    B22,
    LENGTH,
    OFFSET1,
    OFFSET2,
    beam_account,
    beam_energy,
    beam_force,
    beam_kernel,
    beam_tangent,
)
from flexmb.beams.mass_damping import (
    damping_parameters,
    mass_damping_account,
    mass_damping_energy,
    mass_damping_force,
    mass_damping_kernel,
)
from flexmb.beams.section import Section
from flexmb.beams.stress import BeamElements, outer_fibres
from flexmb.bodies.bosses import Bosses
from flexmb.bodies.inertia import mean_mass, node_mass
from flexmb.errors import InputError
from flexmb.kernels import signal_kernel
from flexmb.model.contributions import Contribution, ElementContribution, Node, node_coordinates
from flexmb.model.material import Material
from flexmb.model.shape import BeamShape

if TYPE_CHECKING:
    from flexmb.beams.fem import BeamMatrices

Point = tuple[float, float]
Elements = int | tuple[float, ...]


@dataclass(frozen=True)
class Beam:
    """One straight beam between two corners: names of its nodes, their stations [m], section and material.

    rotary_inertia : of the sections [kg m]; None: rho I.
    """

    nodes: tuple[str, ...]
    start: Point
    end: Point
    stations: tuple[float, ...]
    section: Section
    material: Material
    rotary_inertia: float | None = 0.0

    @property
    def length(self) -> float:
        """Length [m]."""
        return math.dist(self.start, self.end)


def checked_elements(label: str, elements: object) -> Elements:
    """A number of elements, or increasing fractions of the length where inner nodes stand."""
    if isinstance(elements, (tuple, list, np.ndarray)):
        inner = tuple(checks.between(label, "elements", s, 0.0, 1.0) for s in elements)
        full = (0.0, *inner, 1.0)
        if any(b <= a for a, b in pairwise(full)):
            raise InputError(f"{label}: elements are {inner}; fractions must increase strictly between 0 and 1.")
        return inner
    return checks.count(label, "elements", elements)


def rotary_inertia_of(label: str, value: object) -> float | None:
    """Rotary inertia of a `Beam`: 0 for False, None (rho I) for True, or a number [kg m] >= 0."""
    if isinstance(value, bool):
        return None if value else 0.0
    return checks.not_negative(label, "rotary_inertia", value, "kg m")


@lru_cache(maxsize=64)
def fractions(elements: Elements) -> tuple[float, ...]:
    """Positions of all nodes as fractions of the length."""
    if isinstance(elements, int):
        return tuple(i / elements for i in range(elements + 1))
    return (0.0, *elements, 1.0)


REMEMBERED = 4096
"""Number of beams whose matrices are kept besides those of the present call."""

BeamKey = tuple[tuple[float, ...], Section, Material, bool | float]

_KNOWN: dict[BeamKey, BeamMatrices] = {}
"""Matrices of beams by their data."""


def matrices(beam: Beam) -> BeamMatrices:
    """Element matrices of a beam through scikit-fem, remembered for beams of equal data."""
    found = _KNOWN.get(_data_of(beam))
    if found is None:
        assemble([beam])
        found = _KNOWN[_data_of(beam)]
    return found


def assemble(beams: Iterable[Beam]) -> None:
    """Assemble the matrices of several beams in one mesh; beams of equal data are assembled once."""
    from flexmb.beams.fem import BeamData, assembled  # noqa: PLC0415 - scikit-fem is needed only here

    keys = {_data_of(beam): None for beam in beams}
    if len(_KNOWN) > REMEMBERED:
        kept = {key: _KNOWN[key] for key in keys if key in _KNOWN}
        _KNOWN.clear()
        _KNOWN.update(kept)
    new = [key for key in keys if key not in _KNOWN]
    data = [BeamData(np.array(stations), section, material, rotary) for stations, section, material, rotary in new]
    _KNOWN.update(zip(new, assembled(data), strict=True))


def _data_of(beam: Beam) -> BeamKey:
    """Data of a beam that its matrices depend on."""
    return beam.stations, beam.section, beam.material, True if beam.rotary_inertia is None else beam.rotary_inertia


def beam_parameters(beam: Beam, nodes: dict[str, Node], damping: float, gravity: Point) -> list[tuple[float, ...]]:
    """p of every element of a beam."""
    angle = direction(beam)
    # the offset makes theta + offset the direction of the element's axis in the reference configuration
    offsets = [angle - nodes[name].theta for name in beam.nodes]
    load, data = (float(damping), *map(float, gravity)), matrices(beam).parameters
    return [
        (*head, first, second, *load, *tail)
        for (head, tail), (first, second) in zip(data, pairwise(offsets), strict=True)
    ]


def beam_pieces(
    part: str, beams: Sequence[Beam], nodes: dict[str, Node], damping: float, gravity: Point
) -> list[Contribution]:
    """Element pieces of all beams of a body."""
    contributions: list[Contribution] = []
    for beam in beams:
        ends = [node_coordinates(part, node) for node in beam.nodes]
        for p, (first, second) in zip(beam_parameters(beam, nodes, damping, gravity), pairwise(ends), strict=True):
            contributions.append(
                ElementContribution(
                    part,
                    beam_kernel,
                    (*first, *second),
                    p,
                    energy=beam_energy,
                    force=beam_force,
                    tangent=beam_tangent,
                    account=beam_account,
                )
            )
    return contributions


def mass_damping_pieces(
    part: str, beams: Sequence[Beam], axis: Beam, zeta: float, lumps: Mapping[str, tuple[float, float]]
) -> list[Contribution]:
    """Contributions of mass-proportional damping, one an element; none when zeta is 0.

    The body's frame runs from the first to the last node of `axis`.  `lumps` are (mass [kg], inertia [kg m^2]) by node;
    each is counted with the first element that ends there.
    """
    if zeta == 0.0:
        return []
    left = dict(lumps)
    frame = tuple(c for k in (0, -1) for c in node_coordinates(part, axis.nodes[k])[:2])
    contributions: list[Contribution] = []
    for beam in beams:
        data = matrices(beam)
        angle = direction(beam) - direction(axis)
        for k, nodes in enumerate(pairwise(beam.nodes)):
            ends = tuple(left.pop(node, (0.0, 0.0)) for node in nodes)
            p = damping_parameters(zeta, angle, data.axial_mass[k], data.bending_mass[k], ends)
            coordinates = (*frame, *(c for node in nodes for c in node_coordinates(part, node)))
            contributions.append(
                ElementContribution(
                    part,
                    mass_damping_kernel,
                    coordinates,
                    p,
                    energy=mass_damping_energy,
                    force=mass_damping_force,
                    account=mass_damping_account,
                )
            )
    return contributions


def direction(beam: Beam) -> float:
    """Direction of a beam in the reference configuration [rad]."""
    return math.atan2(beam.end[1] - beam.start[1], beam.end[0] - beam.start[0])


def beam_elements(beam: Beam, nodes: Mapping[str, Node]) -> BeamElements:
    """Elements of a beam, for strains.

    Parameters
    ----------
    beam : the beam.
    nodes : nodes of its body by name.
    """
    angle = math.atan2(beam.end[1] - beam.start[1], beam.end[0] - beam.start[0])
    offsets = np.array([angle - nodes[name].theta for name in beam.nodes])
    stations = np.array(beam.stations)
    outer = outer_fibres(beam.section, stations / stations[-1])
    outer = np.maximum(outer[:-1], outer[1:])
    return BeamElements(np.diff(stations), np.array([offsets[:-1], offsets[1:]]), outer)


def beam_shapes(part: str, beams: Sequence[Beam], nodes: dict[str, Node]) -> tuple[BeamShape, ...]:
    """Drawing records of all elements."""
    shapes = []
    for beam in beams:
        data, depths = matrices(beam), 2.0 * outer_fibres(beam.section, np.array(beam.stations) / beam.stations[-1])
        for k, p in enumerate(beam_parameters(beam, nodes, 0.0, (0.0, 0.0))):
            ei = (float(data.ei[k, 0]), float(data.ei[k, 1]))
            depth = (float(depths[k]), float(depths[k + 1]))
            ends = (beam.nodes[k], beam.nodes[k + 1])
            bending = p[B11], p[B12], p[B22]
            shapes.append(BeamShape(part, *ends, p[LENGTH], p[OFFSET1], p[OFFSET2], p[AXIAL], bending, ei, depth))
    return tuple(shapes)


def mass_parts(beam: Beam) -> list[tuple[float, Point, float]]:
    """(mass, centre of mass, inertia about it) of every element of a beam, from its consistent mass."""
    data = matrices(beam)
    angle = direction(beam)
    parts = []
    for k, length in enumerate(data.lengths):
        ma, mb = data.axial_mass[k], data.bending_mass[k]
        mass = float(ma.sum())
        arm = float(ma[:, 1].sum()) * length / mass
        turn = np.array([0.0, 1.0, length, 1.0])
        inertia = float(turn @ mb @ turn) - mass * arm**2
        parts.append((mass, planar.from_frame(beam.start, angle, (beam.stations[k] + arm, 0.0)), inertia))
    return parts


def boss_pieces(part: str, corners: Sequence[str], bosses: Bosses, gravity: Point) -> list[Contribution]:
    """Contributions of the bosses at the corners and of the mass at their mean."""
    contributions: list[Contribution] = []
    for node, mass in zip(corners, bosses.masses, strict=True):
        if mass or bosses.inertia:
            contributions.append(node_mass(part, node, mass, bosses.inertia, gravity))
    if bosses.mean_mass:
        contributions.append(mean_mass(part, tuple(corners), bosses.mean_mass, gravity))
    return contributions


def nearest_node(label: str, owner: str, nodes: Sequence[Node], point: Point, size: float) -> Node:
    """The node at a world point of the reference configuration, or `InputError` that names the nodes nearby."""
    for node in nodes:
        if (node.x, node.y) == point:
            return node
    nearest = min(nodes, key=lambda n: planar.distance((n.x, n.y), point))
    if planar.distance((nearest.x, nearest.y), point) <= 1e-6 * size:
        return nearest
    by_distance = sorted(nodes, key=lambda n: planar.distance((n.x, n.y), point))
    near = ", ".join(f"{n.name} at ({n.x:.6g}, {n.y:.6g})" for n in by_distance[:3])
    gap = planar.distance((nearest.x, nearest.y), point)
    raise InputError(
        f"{owner}: the point ({point[0]:g}, {point[1]:g}) is no node of {label}; it lies {gap:.3g} m from the nearest. "
        f"Nodes nearby: {near}. Move the point there, or choose elements so that a node stands at the point."
    )


@signal_kernel
def deflection_kernel(p, t, q, v, a):
    """Distance of a point (x1, y1) from the chord (x0, y0)-(x2, y2), positive to the left of the chord."""
    dx, dy = q[4] - q[0], q[5] - q[1]
    return (dx * (q[3] - q[1]) - dy * (q[2] - q[0])) / math.sqrt(dx * dx + dy * dy)
