"""Flexible body of any planar shape: a mesh of plane stress or plane strain with pins in its holes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, cast

import numpy as np

from flexmb import checks, planar
from flexmb.bodies.bosses import RigidProperties
from flexmb.bodies.fields import Field, Triple, start_displacement, start_velocity
from flexmb.errors import InputError
from flexmb.model.contributions import Attachment, Contribution, Node
from flexmb.model.material import Material
from flexmb.model.shape import Shapes
from flexmb.planes.cell_numbers import COROTATED, TOTAL_LAGRANGE
from flexmb.planes.forms import PlaneMatrices, matrices
from flexmb.planes.interfaces import AVERAGED, RIGID, Interface, Tie, tie
from flexmb.planes.mesh import PlaneMesh
from flexmb.planes.mesh_body import MeshBody
from flexmb.planes.regions import STRAIN, STRESS, by_region, cell_values, elasticity, require_material
from flexmb.planes.vibrations import vibrations

if TYPE_CHECKING:
    from flexmb.model.law import Motion
    from flexmb.model.mechanism import Mechanism
    from flexmb.planes.full_body import FullBody
    from flexmb.planes.nodal_load import NodalLoad

Point = tuple[float, float]

FORMULATIONS = {"corotated": COROTATED, "total-lagrange": TOTAL_LAGRANGE}
"""Formulations of cells by name."""

SAME_LENGTH = 1e-6
"""Difference of two lengths over the length [1] up to which they are one."""

REMEMBERED = 4
"""Number of bodies whose matrices are kept, for bodies that differ in their place or their joints alone."""


@dataclass(frozen=True)
class PlaneBody(MeshBody):
    """A flexible body whose shape is a plane mesh; joints are attached to pins, the centres of its holes.

    Nodes are the pins, with the names of their sets, then the nodes of the mesh that no rigid pin holds: "node0",
    "node1", ... as numbered in the mesh.  theta of a pin is the direction of the mesh's x-axis at the start; nodes of
    the mesh have no rotation.

    Parameters
    ----------
    name : the body's name.
    mesh : its mesh, see `meshes`.
    start, end : points of the pins "start" and "end" in the reference configuration [m]; their distance must be that in
        the mesh.
    at : point of the mesh's origin in the reference configuration [m], in place of start and end.
    angle : direction of the mesh's x-axis [rad], beside `at`.
    thickness : across the plane [m], or thicknesses by region of the mesh.
    material : material, or materials by region of the mesh.
    state : "stress" for plates, thin against their extent, "strain" for bodies that are held across the plane.
    pins : names of the sets that are pins; None: all sets that are a whole hole.
    interface : "rigid": a pin holds the nodes of its set as a rigid body; "averaged": it moves with their mean; or a
        dictionary by pin.
    damping : stiffness-proportional damping time [s], >= 0.
    mass_damping : mass-proportional damping rate zeta1 [1/s] (Rayleigh), >= 0; see the notes.
    formulation : "corotated": linear elasticity in axes that turn with each cell; "total-lagrange": strains
        against the reference configuration, St. Venant and Kirchhoff's material, at twice the cost.
    stress : whether every accepted step looks for the largest von Mises stress: signals `von_mises` [Pa] and
        `von_mises_node`, the number of its node.
    velocity : (vx, vy, omega) of the first pin at the start, the body moving as a rigid body, or one (vx, vy, omega)
        per node; None: as driven.
    displacement : (dx, dy, dtheta) per node at the start [m, rad], added to the reference configuration; None: no
        displacement.

    Raises
    ------
    InputError : no pins, points whose distance is not that in the mesh, regions without a value, values out of range.

    Notes
    -----
    Small strains and any rotation.  A rigid pin is too stiff, since the hole cannot become oval; an averaged one is too
    soft, since nothing keeps the hole round.  A pin that fills its hole lies between both.

    `mass_damping` acts on the velocity against a frame that has its origin at the first pin and points to the second
    one (with one pin: to the node farthest from it).  No rigid motion is damped.  Where both pins stand still, each
    vibration of the angular frequency omega has the damping ratio (zeta1/omega + zeta2 omega)/2, zeta2 being `damping`.
    """

    mesh: PlaneMesh
    _: KW_ONLY
    start: Point | None = None
    end: Point | None = None
    at: Point | None = None
    angle: float = 0.0
    thickness: float | Mapping[str, float] | tuple[tuple[str, float], ...]
    material: Material | Mapping[str, Material] | tuple[tuple[str, Material], ...]
    state: str = STRESS
    pins: tuple[str, ...] | None = None
    interface: str | Mapping[str, str] | tuple[tuple[str, str], ...] = RIGID
    damping: float = 0.0
    mass_damping: float = 0.0
    formulation: str = "corotated"
    stress: bool = True
    velocity: Triple | Field | None = None
    displacement: Field | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.mesh, PlaneMesh):
            raise InputError(f"{self.label}: mesh is {self.mesh!r}; it must be a PlaneMesh, such as meshes.read(path).")
        checks.one_of(self.label, "state", self.state, (STRESS, STRAIN))
        checks.one_of(self.label, "formulation", self.formulation, FORMULATIONS)
        checks.not_negative(self.label, "damping", self.damping, "s")
        checks.not_negative(self.label, "mass_damping", self.mass_damping, "1/s")
        checks.flag(self.label, "stress", self.stress)
        for field in ("thickness", "material", "interface"):
            if isinstance(value := getattr(self, field), Mapping):
                object.__setattr__(self, field, by_region(self.label, field, value))
        for field in ("start", "end", "at"):
            if (point := getattr(self, field)) is not None:
                object.__setattr__(self, field, checks.point(self.label, field, point))
        object.__setattr__(self, "pins", self._checked_pins())
        checks.no_name_of_nodes(self.label, cast("tuple[str, ...]", self.pins), "node", "nodes of the mesh")
        _ = self._place, self.tie  # refuse points and pins that do not fit
        for region, value in by_region(self.label, "thickness", self.thickness):
            checks.positive(self.label, f"thickness of region {region!r}" if region else "thickness", value, "m")
        for region, material in by_region(self.label, "material", self.material):
            require_material(f"{self.label}, region {region!r}" if region else self.label, material)
        cell_values(self.mesh, "thickness", self.thickness)
        elasticity(self.mesh, self.material, self.state)
        count = len(self.interfaces) + len(self.mesh.points) - len(self._held)
        for field, checked in (("velocity", start_velocity), ("displacement", start_displacement)):
            object.__setattr__(self, field, checked(self.label, getattr(self, field), count, None))

    def _checked_pins(self) -> tuple[str, ...]:
        """Names of the sets that are pins."""
        if self.pins is None:
            names = self.mesh.holes
            if not names:
                text = f"{self.label}: {self.mesh.label} has no hole with a name, so the body has no pins"
                sets = ", ".join(self.mesh.sets) or "it has none"
                raise InputError(f"{text}. Name sets of it as pins=(...): {sets}.")
            return names
        names = checks.sequence(self.label, "pins", self.pins, "names of sets")
        for name in names:
            self.mesh.set_of(name)
        if not names or len(set(names)) < len(names):
            raise InputError(f"{self.label}: pins are {names!r}; name at least one set, and each one once.")
        return names

    @cached_property
    def _place(self) -> tuple[Point, float]:
        """Point of the mesh's origin [m] and direction of its x-axis [rad]."""
        given = [field for field in ("start", "end", "at") if getattr(self, field) is not None]
        if given in ([], ["at"]):
            return self.at or (0.0, 0.0), float(self.angle)
        if given != ["start", "end"] or self.angle != 0.0:
            now = ", ".join(given) + (" and angle" if self.angle != 0.0 else "")
            raise InputError(f"{self.label}: give either start and end, or at and angle; given are {now}.")
        first, last = (self.mesh.centre_of(name) for name in ("start", "end"))
        start, end = cast("Point", self.start), cast("Point", self.end)
        wanted, own = planar.distance(start, end), planar.distance(first, last)
        if abs(wanted - own) > SAME_LENGTH * own:
            text = f"{self.label}: start and end are {wanted:.9g} m apart, but {own:.9g} m in {self.mesh.label}"
            remedy = "Move the points, or mesh the right length"
            if not 0.01 < wanted / own < 100.0:
                remedy += f"; for a mesh in other units take mesh.scaled({wanted / own:.4g})"
            raise InputError(f"{text}. {remedy}.")
        angle = _direction(start, end) - _direction(first, last)
        return planar.from_frame(start, angle, (-first[0], -first[1])), angle

    @property
    def origin(self) -> Point:
        """Point of the mesh's origin in the reference configuration [m]."""
        return self._place[0]

    @property
    def direction(self) -> float:
        """Direction of the mesh's x-axis in the reference configuration [rad]."""
        return self._place[1]

    @cached_property
    def interfaces(self) -> tuple[Interface, ...]:
        """Pins with their nodes, in the axes of the mesh."""
        kinds = dict(by_region(self.label, "interface", self.interface))
        names = cast("tuple[str, ...]", self.pins)
        for name in kinds.keys() - {""}:
            checks.one_of(f"{self.label}, interface", "pin", name, names)
        for kind in kinds.values():
            checks.one_of(self.label, "interface", kind, (RIGID, AVERAGED))
        usual = kinds.get("", RIGID)
        return tuple(
            Interface(name, self.mesh.set_of(name), self.mesh.centre_of(name), kinds.get(name, usual)) for name in names
        )

    @cached_property
    def tie(self) -> Tie:
        """Displacements of all nodes by pins and free displacements, in the axes of the mesh."""
        return tie(self.interfaces, self.mesh)

    @cached_property
    def matrices(self) -> PlaneMatrices:
        """Stiffness and mass of all nodes, in the axes of the mesh."""
        return _matrices(self.mesh, self.material, self.thickness, self.state)

    @cached_property
    def _held(self) -> frozenset[int]:
        """Nodes of the mesh that rigid pins hold."""
        return frozenset(node for i in self.interfaces if i.kind == RIGID for node in i.nodes.tolist())

    @cached_property
    def _nodes(self) -> tuple[Node, ...]:
        free = [(f"node{k}", point) for k, point in enumerate(self.mesh.points.tolist()) if k not in self._held]
        return (*self.pin_nodes, *(Node(name, *self._world((x, y)), 0.0, turns=False) for name, (x, y) in free))

    @cached_property
    def pin_nodes(self) -> tuple[Node, ...]:
        """The pins in the reference configuration."""
        return tuple(Node(i.name, *self._world(i.point), self.direction) for i in self.interfaces)

    def _world(self, point: Point) -> Point:
        """A point of the mesh in the reference configuration [m]."""
        return planar.from_frame(self.origin, self.direction, point)

    def nodes(self) -> tuple[Node, ...]:
        """The pins, then the nodes of the mesh that no rigid pin holds."""
        return self._nodes

    def attach(self, owner: str, point: Point) -> Attachment:
        """The pin at `point`; `owner` names who asks, for messages."""
        pins = sorted(self.pin_nodes, key=lambda pin: planar.distance((pin.x, pin.y), point))
        gap = planar.distance((pins[0].x, pins[0].y), point)
        if gap > SAME_LENGTH * self.mesh.size:
            listed = ", ".join(f"{pin.name} at ({pin.x:.6g}, {pin.y:.6g})" for pin in pins[:8])
            raise InputError(
                f"{owner}: the point ({point[0]:g}, {point[1]:g}) is no pin of {self.label}; it lies {gap:.3g} m from "
                f"the nearest. Pins: {listed}. Move the point there, or name a set of the mesh there as a pin."
            )
        return Attachment(self.name, pins[0].name, (0.0, 0.0))

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """Cells, averaged pins, held rotations of the mesh's nodes; the largest stress."""
        from flexmb.planes.mesh_shape import cell_materials  # noqa: PLC0415

        found = self._full.contributions(mechanism.gravity)
        if self.stress:
            found.append(self._full.stress_signal(self.mesh, cell_materials(self.mesh, self.material, self.state)))
        return found

    @property
    def plane(self) -> PlaneBody:
        """The body itself, with all nodes of its mesh."""
        return self

    def loaded(self, name: str, load: NodalLoad, history: Motion | None) -> Sequence[Contribution]:
        """Contributions of a load `name` on the nodes, times the value of `history`."""
        from flexmb.planes.nodal_load import LoadedMesh  # noqa: PLC0415

        full, main = self._full, self.interfaces[0].name
        mesh = LoadedMesh(self.name, full.cells.points, full.names, full.on_pins, main, self.direction)
        return mesh.contributions(name, load, history)

    @cached_property
    def _full(self) -> FullBody:
        """The body with all nodes of its mesh."""
        from flexmb.planes.cells import Cells  # noqa: PLC0415
        from flexmb.planes.full_body import FullBody, MeshPin  # noqa: PLC0415

        cells = Cells.of(self.mesh, self.material, self.thickness, self.state, FORMULATIONS[self.formulation])
        weights = [None if i.kind == RIGID else i.weights(self.mesh) for i in self.interfaces]
        pins = [MeshPin(i.name, i.point, i.nodes, w) for i, w in zip(self.interfaces, weights, strict=True)]
        return FullBody(self.name, cells, pins, self.origin, self.direction, self.damping, self.mass_damping)

    def shapes(self, mechanism: Mechanism) -> Shapes:  # noqa: ARG002 - the mesh alone
        """The mesh."""
        from flexmb.planes.mesh_shape import mesh_shape  # noqa: PLC0415

        names, poses = zip(*((node.name, (node.x, node.y, node.theta)) for node in self.nodes()), strict=True)
        shape = mesh_shape(self.name, self.mesh.placed(self.direction, self.origin), self.material, self.state)
        return (replace(shape, nodes=names, carriers=self._full.carriers(), poses=poses),)

    @property
    def seeks_stress(self) -> bool:
        """Whether every accepted step looks for the largest stress."""
        return self.stress

    def properties(self) -> RigidProperties:
        """Mass, centre of mass and moment of inertia as a rigid body in the reference configuration."""
        mass, centre, inertia = self.matrices.rigid_properties
        return RigidProperties(mass, self._world(centre), inertia)

    def frequencies(self, count: int = 6, held: Sequence[str] = ()) -> np.ndarray:
        """Lowest natural frequencies (count,) of the whole mesh [Hz], without motions as a rigid body.

        Parameters
        ----------
        count : number of frequencies.
        held : names of pins that neither move nor turn; without them the body is free.
        """
        return vibrations(self.matrices, count, self.tie, held)[0]

    def total_mass(self) -> float:
        """The mass [kg]."""
        return self.matrices.rigid_properties[0]

    def start_velocity(self) -> Triple | Field | None:
        """The declared start velocity."""
        return self.velocity

    def start_displacement(self) -> Field | None:
        """The declared start displacement."""
        return self.displacement


_matrices = lru_cache(maxsize=REMEMBERED)(matrices)


def _direction(start: Point, end: Point) -> float:
    """Direction from one point to another one [rad]."""
    return math.atan2(end[1] - start[1], end[0] - start[0])
