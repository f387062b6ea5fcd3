"""A flexible frame: beams, straight or arcs, welded at corners."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY
from functools import cached_property

import numpy as np

from flexmb import checks, planar
from flexmb.beams.arc import checked_turn
from flexmb.beams.section import Section
from flexmb.bodies.bosses import Bosses, RigidProperties, fit_bosses
from flexmb.bodies.edges import Edges
from flexmb.bodies.fields import Field, Triple
from flexmb.bodies.flexible import Beam, Elements, checked_elements, fractions
from flexmb.bodies.flexible_body import FlexibleBody, beam_of_mesh
from flexmb.docstrings import documented
from flexmb.errors import InputError
from flexmb.model.contributions import Node
from flexmb.model.material import Material

Point = tuple[float, float]


@documented
class FlexibleFrame(FlexibleBody, Edges):
    """Beams between corners, straight or arcs, welded there; theta of every node is 0 in the reference configuration.

    Nodes are called node0, node1, ...: first the corners in the order of `points`, then the inner nodes edge by edge.
    The body's own signals are the signals of node0.

    Parameters
    ----------
    name : the frame's name.
    points : corners in the reference configuration [m], unstressed.
    edges : pairs of corner numbers, one a beam.
    section : cross section of all beams, or one a beam.
    turns : by which an unstressed beam turns from its first corner to its second along a circular arc [rad],
        counter-clockwise > 0, between -2 pi and 2 pi; one for all edges, or one an edge; 0: straight.  Turns of a
        smooth curve through the corners: `flexmb.bodies.smooth_turns`.
    elements : elements a beam (number, or fractions of the length where inner nodes stand), or one entry a beam.
    mass : total mass [kg]; bosses at the corners and their mean add the rest.  None: the beams' own.
    inertia : moment of inertia about the centre of mass [kg m^2].  None: the beams' own.
    centre : centre of mass in the reference configuration [m], when mass or inertia is given.  None: the beams' own.
    velocity : (vx, vy, omega) of node0 at the start, the frame moving as a rigid body, or one (vx, vy, omega) per node;
        None: as driven.
    displacement : (dx, dy, dtheta) per node at the start [m, rad], added to the reference configuration; None: no
        displacement.

    Raises
    ------
    InputError : values out of range, corners that no edge reaches, an edge twice, mass properties out of reach, fields
        with another number of entries than nodes.

    Notes
    -----
    A mass at the mean of the corners moves with the mean of their velocities, as if held by light spokes.
    Beams with small strains and any rotation; without `shear` not for deep beams (length over height below 10).
    Elements of an arc are arcs; they should turn by less than 0.5 rad each.

    `mass_damping` acts on the velocity against a frame that has its origin at the first corner of the first edge and
    points to the second one, on the mass of the beams and of the bosses on corners, not on a mass at the mean of the
    corners; no rigid motion is damped.  A mode of angular frequency omega that leaves those two corners in place has
    the damping ratio xi = zeta1/(2 omega) + zeta2 omega/2, when nothing lies at the mean of the corners.
    Source of the ratio: R. W. Clough, J. Penzien, Dynamics of Structures, 2nd ed., McGraw-Hill 1993, section 12-5.

    Fields of velocity and displacement: see `FlexibleLink`.  The frame is unstressed without its displacement.
    """

    _: KW_ONLY
    centre: Point | None = None
    turns: float | tuple[float, ...] = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.section, tuple) and len(self.section) != len(self.edges):
            raise InputError(f"{self.label}: {len(self.section)} sections for {len(self.edges)} edges; give one each.")
        object.__setattr__(self, "elements", self._checked_elements())
        object.__setattr__(self, "turns", self._checked_turns())
        if self.centre is not None:
            object.__setattr__(self, "centre", checks.point(self.label, "centre", self.centre))
        self._check_fields(len(self.nodes()), None)
        _ = self._bosses  # refuses mass properties out of reach

    def _checked_elements(self) -> tuple[Elements, ...]:
        given = self.elements
        if isinstance(given, (tuple, list)) and len(given) == len(self.edges):
            return tuple(checked_elements(self.label, e) for e in given)
        return (checked_elements(self.label, given),) * len(self.edges)

    def _checked_turns(self) -> float | tuple[float, ...]:
        given = self.turns
        if not isinstance(given, Iterable) or isinstance(given, str):
            return checked_turn(self.label, "turns", given)
        turns = checks.sequence(self.label, "turns", given, "angles in rad, one an edge")
        if len(turns) != len(self.edges):
            raise InputError(f"{self.label}: {len(turns)} turns for {len(self.edges)} edges; give one each.")
        return tuple(checked_turn(self.label, f"turns[{i}]", turn) for i, turn in enumerate(turns))

    @classmethod
    def from_mesh(
        cls,
        name: str,
        path: str,
        at: Point = (0.0, 0.0),
        *,
        angle: float = 0.0,
        sections: Mapping[int, Section],
        material: Material,
        mass: float | None = None,
        inertia: float | None = None,
        centre: Point | None = None,
        damping: float = 0.0,
        mass_damping: float = 0.0,
        rotary_inertia: bool | float | None = None,
        shear: bool | float = False,
        stress: bool | None = None,
        velocity: Triple | Field | None = None,
        displacement: Field | None = None,
    ) -> FlexibleFrame:
        """A frame from a mesh of line cells (any format of meshio); corners: beams meet, end or bend there.

        Parameters
        ----------
        name : the frame's name.
        path : mesh file.
        at : point of the mesh's origin in the reference configuration [m].
        angle : rotation of the mesh about its origin [rad].
        sections : cross section by cell tag.
        material, mass, inertia, centre, damping, mass_damping, rotary_inertia, shear, stress, velocity, displacement :
            see the class.

        Raises
        ------
        InputError : a mesh that is no frame of straight beams, tags without a section.
        FileFormatError : a file that is no mesh.
        """
        from flexmb.beams.mesh import members, read_lines  # noqa: PLC0415 - meshio is needed only here

        mesh = read_lines(path)
        corners: dict[int, int] = {}
        edges: list[tuple[int, int]] = []
        elements, chosen = [], []
        for nodes in members(mesh):
            first, last = (corners.setdefault(int(n), len(corners)) for n in (nodes[0], nodes[-1]))
            edges.append((first, last))
            label, tags = f"FlexibleFrame {name!r}", {mesh.tag_of(nodes)}
            beam = beam_of_mesh(label, path, tags, mesh.stations(nodes), sections)
            elements.append(beam[0])
            chosen.append(beam[1])
        points = tuple(
            planar.from_frame(at, angle, (float(mesh.points[n][0]), float(mesh.points[n][1]))) for n in corners
        )
        return cls(
            name, points, tuple(edges), section=tuple(chosen), material=material, elements=tuple(elements), mass=mass,
            inertia=inertia, centre=centre, damping=damping, mass_damping=mass_damping, rotary_inertia=rotary_inertia,
            shear=shear, stress=stress, velocity=velocity, displacement=displacement,
        )  # fmt: skip

    @property
    def corners(self) -> tuple[str, ...]:
        """Names of the corner nodes."""
        return tuple(f"node{i}" for i in range(len(self.points)))

    @property
    def corner_points(self) -> tuple[Point, ...]:
        """The corners [m]."""
        return tuple(self.points)

    def nodes(self) -> tuple[Node, ...]:
        """Corners, then inner nodes edge by edge."""
        found = {f"node{i}": p for i, p in enumerate(self.points)}
        for beam in self.beams:
            for name, point in zip(beam.nodes, beam.points, strict=True):
                found.setdefault(name, point)
        return tuple(Node(name, *point, 0.0) for name, point in found.items())

    @cached_property
    def beams(self) -> tuple[Beam, ...]:
        """One beam an edge."""
        sections = self.section if isinstance(self.section, tuple) else (self.section,) * len(self.edges)
        turns = self.turns if isinstance(self.turns, tuple) else (self.turns,) * len(self.edges)
        beams, count = [], len(self.points)
        for (a, b), section, elements, turn in zip(self.edges, sections, self.elements, turns, strict=True):  # type: ignore[arg-type]
            places = fractions(elements)
            inner = [f"node{count + i}" for i in range(len(places) - 2)]
            count += len(inner)
            ends = (self.points[a], self.points[b])
            beams.append(self._beam((f"node{a}", *inner, f"node{b}"), ends, places, section, turn))
        return tuple(beams)

    def _further_mass(self) -> tuple[float, Point, float]:
        """The mass at the mean of the corners, as a point."""
        mean = np.array(self.points).mean(axis=0)
        return self._bosses.mean_mass, (float(mean[0]), float(mean[1])), 0.0

    def _fit(self, own: RigidProperties, mass: float) -> Bosses:
        """Bosses at the corners and at their mean."""
        inertia = own.inertia if self.inertia is None else self.inertia
        wanted = RigidProperties(mass, self.centre or own.centre, inertia)
        return fit_bosses(self.label, own, wanted, list(self.points))
