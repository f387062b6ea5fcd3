"""Flexible bodies of any planar shape by finite elements.

The nodes of the body are its pins (x, y, theta), then the nodes of the mesh that lie on no rigid pin; a constraint
holds theta of each of these at 0, as that of a particle.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, replace
from functools import cached_property, lru_cache
from typing import cast

import numpy as np
from scipy.sparse.linalg import ArpackError

from flexmb import checks, planar
from flexmb.elastic.beams.mass_damping import damping_element
from flexmb.elastic.meshes.mesh import STRAIN, STRESS, PlaneMesh, by_region, cell_values, elasticity, require_material
from flexmb.elastic.planes.cells import Cells, PlaneMatrices, cell_contributions, lowest, matrices, tie_matrix, ties_of
from flexmb.elastic.planes.elements import COROTATED, TOTAL_LAGRANGE
from flexmb.elastic.planes.loads import NodalLoad, load_contributions
from flexmb.elastic.planes.pins import AVERAGED, RIGID, Interface, Tie, averaged_pin, tie
from flexmb.elastic.planes.stress import cell_materials, mesh_shape, peak_stress_signal
from flexmb.errors import InputError, SolveError
from flexmb.fields import field, flag, instance, not_negative, one_of, point, record
from flexmb.findings.finding import Finding, found
from flexmb.model import contributions as pieces
from flexmb.model.law import Material, Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import ElasticBody
from flexmb.model.shape import Shapes
from flexmb.parts.bodies.flexible import Field, RigidProperties, Triple, start_displacement, start_velocity
from flexmb.parts.bodies.rigid import held_rotation_kernel, node_mass
from flexmb.planar import Array


class MeshBody(ElasticBody):
    """A body that can bear loads on its mesh."""

    def left_out(self, load: NodalLoad) -> float:  # noqa: ARG002 - of reduced bodies
        """Share of the strain energy of a `load` on the mesh that the body cannot show, with all pins held."""
        return 0.0

    @property
    def coordinates(self) -> tuple[pieces.Coordinate, ...]:
        """Coordinates of all nodes."""
        return tuple(c for node in self.nodes() for c in pieces.node_coordinates(self.name, node.name))

    @property
    @abstractmethod
    def plane(self) -> PlaneBody | None:
        """The body with all nodes of its mesh; None for one of beams."""

    @abstractmethod
    def loaded(self, name: str, load: NodalLoad, history: Motion | None) -> Sequence[pieces.Contribution]:
        """Contributions of a `load` called `name` on the mesh, in its axes, times `history`; None: constant."""


RIGID_MOTIONS = 3  # motions of a free body without deformation
SHIFT = 1e-6  # shift of the squared angular frequency below 0, over that of a wave along the body's length [1]


def vibrations(
    matrices: PlaneMatrices, count: int = 6, tie: Tie | None = None, held: Sequence[str] = ()
) -> tuple[Array, Array]:
    """Lowest elastic frequencies (count,) [Hz], shapes (2n, count) of phi^T M phi = 1 kg; pins `held` are fixed."""
    label = matrices.mesh.label
    count = checks.count(label, "count", count)
    K, M, T = matrices.stiffness, matrices.mass, None if tie is None else tie.matrix
    if tie is not None and T is not None:
        fixed = [tie.pins.index(checks.one_of(label, "held pin", name, tie.pins)) for name in held]
        kept = np.ones(T.shape[1], dtype=bool)
        kept[(3 * np.array(fixed, dtype=np.int64)[:, None] + np.arange(3)).ravel()] = False
        T = T[:, np.flatnonzero(kept)]
        K, M = T.T @ K @ T, T.T @ M @ T
    rigid = 0 if held else RIGID_MOTIONS
    if K.shape[0] < rigid + 2:
        text = f"{label}: with its pins held it has {K.shape[0]} displacements"
        raise InputError(f"{text}, so it cannot vibrate. Take pins that leave nodes free, or a finer mesh.")
    checks.between(label, "count", count, 1, K.shape[0] - rigid - 1)
    # E/rho and the length of the body give a frequency that no material and no unit changes
    scale = matrices.stiffness.diagonal().max() / matrices.mass.diagonal().max()
    try:
        squared, shapes = lowest(K, M, count + rigid, -SHIFT * scale / len(matrices.mesh.points))
    except ArpackError as error:
        text = f"{label}: {count + rigid} natural frequencies were not found ({error})"
        raise SolveError(f"{text}. Ask for fewer, or look for nearly separate pieces of the mesh.") from None
    frequencies, shapes = np.sqrt(np.maximum(squared[rigid:], 0.0)) / (2.0 * math.pi), shapes[:, rigid:]
    return frequencies, shapes if T is None else T @ shapes


# Mass of an averaged pin over that of its body: it keeps the equations of motion regular.
# Its nodes have as much less, so that no rigid motion of the body has another inertia. Frequencies of motions that
# deform the hole change by less than this share. With a hundredth of it steps find the pins without mass.
PIN_SHARE = 1e-7
Point = tuple[float, float]
FORMULATIONS = {"corotated": COROTATED, "total-lagrange": TOTAL_LAGRANGE}  # formulations of cells by name
TOO_STIFF = 0.1  # share by which a body is too stiff in bending, above which there is a finding
TRIANGLES = {"tri3": ((0, 1, 2),), "quad4": ((0, 1, 2), (0, 2, 3))}  # linear cells as triangles
SAME_LENGTH = 1e-6  # difference of two lengths over the length [1] up to which they are one
REMEMBERED = 4  # number of bodies whose matrices are kept, for bodies that differ in their place or their joints alone


@record
class PlaneBody(MeshBody):
    """A flexible body whose shape is a plane mesh; joints are attached to pins, the centres of its holes.

    Nodes are the pins, with the names of their sets, then the nodes of the mesh that no rigid pin holds: "node0",
    "node1", ... as numbered in the mesh.  theta of a pin is the direction of the mesh's x-axis at the start; nodes of
    the mesh have no rotation.  Signals: `von_mises` [Pa] and `von_mises_node`, the number of its node.

    - state: "stress" for plates, thin against their extent, "strain" for bodies that are held across the plane.
    - interface: "rigid", a pin holds the nodes of its set as a rigid body; "averaged", it moves with their mean; or a
      dictionary by pin.
    - formulation: "corotated", linear elasticity in axes that turn with each cell; "total-lagrange", strains against
      the reference configuration, St. Venant and Kirchhoff's material, at twice the cost.
    - velocity: of the first pin, the body moving as a rigid body, or one (vx, vy, omega) per node; displacement: per
      node [m, rad], added to the reference configuration.

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

    mesh: PlaneMesh = field("its mesh", rule=instance(PlaneMesh, "a PlaneMesh, such as meshes.read(path)"))
    _: KW_ONLY
    start: Point | None = field('point of the pin "start"', "m", point, default=None)
    end: Point | None = field('point of the pin "end", as far from "start" as in the mesh', "m", point, default=None)
    at: Point | None = field("point of the mesh's origin, in place of start and end", "m", point, default=None)
    angle: float = field("direction of the mesh's x-axis, beside `at`", "rad", default=0.0)
    thickness: float | Mapping[str, float] | tuple[tuple[str, float], ...] = field("of the plane, or by region", "m")
    material: Material | Mapping[str, Material] | tuple[tuple[str, Material], ...] = field("material, or by region")
    state: str = field('"stress" or "strain", see above', rule=one_of(STRESS, STRAIN), default=STRESS)
    pins: tuple[str, ...] | None = field("names of sets; None: all sets that are a whole hole", default=None)
    interface: str | Mapping[str, str] | tuple[tuple[str, str], ...] = field("of pins, see above", default=RIGID)
    damping: float = field("stiffness-proportional damping time", "s", not_negative, default=0.0)
    mass_damping: float = field("mass-proportional damping rate zeta1 (Rayleigh)", "1/s", not_negative, default=0.0)
    formulation: str = field("of large rotations, see above", rule=one_of(*FORMULATIONS), default="corotated")
    stress: bool = field("whether every accepted step looks for the largest von Mises stress", rule=flag, default=True)
    velocity: Triple | Field | None = field("(vx, vy, omega) at the start, see above; None: as driven", default=None)
    displacement: Field | None = field("(dx, dy, dtheta) at the start, see above; None: none", default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("thickness", "material", "interface"):
            if isinstance(value := getattr(self, name), Mapping):
                object.__setattr__(self, name, by_region(self.label, name, value))
        if self.pins is None:
            names = self.mesh.holes
            if not names:
                text = f"{self.label}: {self.mesh.label} has no hole with a name, so the body has no pins"
                sets = ", ".join(self.mesh.sets) or "it has none"
                raise InputError(f"{text}. Name sets of it as pins=(...): {sets}.")
        else:
            names = checks.sequence(self.label, "pins", self.pins, "names of sets")
            for name in names:
                self.mesh.set_of(name)
            if not names or len(set(names)) < len(names):
                raise InputError(f"{self.label}: pins are {names!r}; name at least one set, and each one once.")
        object.__setattr__(self, "pins", names)
        checks.no_name_of_nodes(self.label, names, "node", "nodes of the mesh")
        _ = self._place, self.tie  # refuse points and pins that do not fit
        for region, value in by_region(self.label, "thickness", self.thickness):
            checks.positive(self.label, f"thickness of region {region!r}" if region else "thickness", value, "m")
        for region, material in by_region(self.label, "material", self.material):
            require_material(f"{self.label}, region {region!r}" if region else self.label, material)
        cell_values(self.mesh, "thickness", self.thickness)
        elasticity(self.mesh, self.material, self.state)
        count = len(self.interfaces) + len(self.free_nodes)
        for name, checked in (("velocity", start_velocity), ("displacement", start_displacement)):
            object.__setattr__(self, name, checked(self.label, getattr(self, name), count, None))

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
        angle = planar.direction(start, end) - planar.direction(first, last)
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
        usual, mesh = kinds.get("", RIGID), self.mesh
        return tuple(Interface(n, mesh.set_of(n), mesh.centre_of(n), kinds.get(n, usual)) for n in names)

    @cached_property
    def tie(self) -> Tie:
        """Displacements of all nodes by pins and free displacements, in the axes of the mesh."""
        return tie(self.interfaces, self.mesh)

    @cached_property
    def matrices(self) -> PlaneMatrices:
        """Stiffness and mass of all nodes, in the axes of the mesh."""
        return _matrices(self.mesh, self.material, self.thickness, self.state)

    @cached_property
    def on_pins(self) -> dict[int, Interface]:
        """Rigid pins by the numbers of the mesh's nodes that they hold."""
        return {k: pin for pin in self.interfaces if pin.kind == RIGID for k in pin.nodes.tolist()}

    @cached_property
    def free_nodes(self) -> dict[int, str]:
        """Names of the mesh's nodes that no rigid pin holds, by number."""
        return {k: f"node{k}" for k in range(len(self.mesh.points)) if k not in self.on_pins}

    @cached_property
    def _cells(self) -> Cells:
        """Cells with the numbers of their kernels, in the axes of the mesh."""
        return Cells.of(self.mesh, self.material, self.thickness, self.state, FORMULATIONS[self.formulation])

    @cached_property
    def _nodes(self) -> tuple[pieces.Node, ...]:
        points = self.mesh.points.tolist()
        free = (pieces.Node(name, *self._world(points[k]), 0.0, turns=False) for k, name in self.free_nodes.items())
        return (*self.pin_nodes, *free)

    @cached_property
    def pin_nodes(self) -> tuple[pieces.Node, ...]:
        """The pins in the reference configuration."""
        return tuple(pieces.Node(i.name, *self._world(i.point), self.direction) for i in self.interfaces)

    def _world(self, point: Sequence[float]) -> Point:
        """A point of the mesh in the reference configuration [m]."""
        return planar.from_frame(self.origin, self.direction, (point[0], point[1]))

    def nodes(self) -> tuple[pieces.Node, ...]:
        return self._nodes

    def attach(self, owner: str, point: Point) -> pieces.Attachment:
        pins = sorted(self.pin_nodes, key=lambda pin: planar.distance((pin.x, pin.y), point))
        gap = planar.distance((pins[0].x, pins[0].y), point)
        if gap > SAME_LENGTH * self.mesh.size:
            listed = ", ".join(f"{pin.name} at ({pin.x:.6g}, {pin.y:.6g})" for pin in pins[:8])
            text = f"{owner}: the point ({point[0]:g}, {point[1]:g}) is no pin of {self.label};"
            text += f" it lies {gap:.3g} m from the nearest. Pins: {listed}."
            raise InputError(f"{text} Move the point there, or name a set of the mesh there as a pin.")
        return pieces.Attachment(self.name, pins[0].name, (0.0, 0.0))

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        cells, gravity, mesh = self._cells, mechanism.gravity, self.mesh
        found: list[pieces.Contribution] = []
        found += cell_contributions(self.name, cells, self.free_nodes, self.on_pins, self.damping, gravity)
        found += self._damped() if self.mass_damping else ()
        inertia = cells.mass * float(np.ptp(mesh.points, axis=0).max()) ** 2
        for name in self.free_nodes.values():  # any moment of inertia will do
            theta = pieces.node_coordinates(self.name, name)[2:]
            found.append(node_mass(self.name, name, 0.0, inertia / len(self.free_nodes), (0.0, 0.0)))
            found.append(pieces.ConstraintContribution(self.name, held_rotation_kernel, theta, (), 1, is_drive=True))
        for pin in (pin for pin in self.interfaces if pin.kind == AVERAGED):
            # its constraint, and its small mass, which is taken from its nodes
            names = [self.free_nodes[k] for k in pin.nodes.tolist()]
            weights, arms = pin.weights(mesh), pin.arms(mesh)
            coordinates = [*pieces.node_coordinates(self.name, pin.name)]
            coordinates += [c for name in names for c in pieces.node_coordinates(self.name, name)[:2]]
            mass = PIN_SHARE * cells.mass
            found.append(averaged_pin(self.name, tuple(coordinates), arms, weights))
            found.append(node_mass(self.name, pin.name, mass, mass * float(weights @ (arms**2).sum(axis=1)), gravity))
            taken = zip(names, weights.tolist(), strict=True)
            found += [node_mass(self.name, name, -mass * weight, 0.0, gravity) for name, weight in taken]
        if self.stress:
            everywhere = list(range(len(mesh.points)))
            places, ties, _ = ties_of(self.name, everywhere, mesh.points, self.free_nodes, self.on_pins)
            materials = cell_materials(mesh, self.material, self.state)
            found.append(peak_stress_signal(self.name, places, ties, mesh, materials))
        return found

    def _damped(self) -> Iterator[pieces.Contribution]:
        """Mass-proportional damping of all cells; the frame has the first two pins, or one and the farthest node."""
        points, first = self.mesh.points, self.interfaces[0]
        if len(self.interfaces) > 1:
            end, name = self.interfaces[1].point, self.interfaces[1].name
        else:
            far = int(np.linalg.norm(points - np.array(first.point), axis=1).argmax())
            end, name = (float(points[far, 0]), float(points[far, 1])), self.free_nodes[far]
        frame = tuple(c for node in (first.name, name) for c in pieces.node_coordinates(self.name, node)[:2])
        angle = -planar.direction(first.point, end)
        for numbers, mass in zip(self._cells.cells.tolist(), self._cells.masses, strict=True):
            own, ties, held = ties_of(self.name, numbers, points, self.free_nodes, self.on_pins)
            T = tie_matrix(ties, len(own))
            whole = T.T @ np.kron(mass, np.eye(2)) @ T
            yield damping_element(self.name, (*frame, *own), self.mass_damping, held, whole, angle)

    @property
    def plane(self) -> PlaneBody:
        return self

    def loaded(self, name: str, load: NodalLoad, history: Motion | None) -> Sequence[pieces.Contribution]:
        return load_contributions(self, name, load, history)

    def shapes(self, mechanism: Mechanism) -> Shapes:  # noqa: ARG002 - the mesh alone
        names, poses = zip(*((node.name, (node.x, node.y, node.theta)) for node in self.nodes()), strict=True)
        shape = mesh_shape(self.name, self.mesh.placed(self.direction, self.origin), self.material, self.state)
        number, carriers = {name: k for k, name in enumerate(names)}, []
        for k, (x, y) in enumerate(self.mesh.points.tolist()):
            pin = self.on_pins.get(k)
            arm = (0.0, 0.0) if pin is None else (x - pin.point[0], y - pin.point[1])
            carriers.append((number[self.free_nodes[k] if pin is None else pin.name], *arm))
        return (replace(shape, nodes=names, carriers=tuple(carriers), poses=poses),)

    @property
    def seeks_stress(self) -> bool:
        return self.stress

    def reference_points(self) -> np.ndarray:
        return self.mesh.placed(self.direction, self.origin).points

    def odd_sizes(self) -> Iterator[Finding]:
        """Finding on a plate that is thicker than large."""
        thickness = max(value for _, value in by_region(self.label, "thickness", self.thickness))
        if self.state == STRESS and thickness > self.mesh.size:
            text = f"{self.label} is {thickness:.4g} m thick and {self.mesh.size:.4g} m large."
            remedy = "Thickness is in m. Bodies thicker than large are closer to plane strain: state='strain'."
            yield found("odd-units", (self.name,), text, remedy, thickness=thickness)

    def coarse_cells(self, owner: ElasticBody) -> Iterator[Finding]:
        """Finding on linear cells too few to bend, in the name of the `owner` of the body."""
        # The strain energy of u = -x y, v = x^2/2 at the nodes, x along the body, less that of this field itself, is
        # the energy of the strains that linear cells add; over the energy of bending of a bar of the same area whose
        # height is twice the area over the length of the boundary.
        mesh = self.mesh
        if mesh.kind not in TRIANGLES:
            return
        points = mesh.points - mesh.points.mean(axis=0)
        along = np.linalg.eigh(points.T @ points)[1][:, -1]
        across = np.array([-along[1], along[0]])
        x, y = points @ along, points @ across
        field = (-(x * y)[:, None] * along + 0.5 * (x**2)[:, None] * across).ravel()
        stiffness = elasticity(mesh, self.material, self.state)[:, 0]
        for thickness, cells in cell_values(mesh, "thickness", self.thickness):
            stiffness[cells] *= thickness
        square, whole = np.zeros(len(mesh.cells)), np.zeros(len(mesh.cells))
        for corners in TRIANGLES[mesh.kind]:
            (ax, ay), (bx, by), (cx, cy) = (points[mesh.cells[:, k]].T for k in corners)
            area = 0.5 * ((bx - ax) * (cy - ay) - (cx - ax) * (by - ay))
            heights = y[mesh.cells[:, corners]]
            square += area / 12.0 * ((heights**2).sum(axis=1) + heights.sum(axis=1) ** 2)
            whole += area
        rings = [points[np.append(loop, loop[0])] for loop in mesh.loops]
        height = 2.0 * whole.sum() / sum(np.linalg.norm(np.diff(ring, axis=0), axis=1).sum() for ring in rings)
        added = field @ (self.matrices.stiffness @ field) - stiffness @ square
        excess = float(added / (stiffness @ whole * height**2 / 12.0))
        if excess > TOO_STIFF:
            text = f"{owner.label}: its {self.mesh.kind} cells are too few across it: in bending it is some "
            text += f"{100.0 * excess:.2g} % too stiff."
            remedy = "Take quadratic cells, mesh=mesh.to_quadratic(), or several times as many across it."
            yield found("coarse-cells", (owner.name,), text, remedy, excess=excess)

    def properties(self) -> RigidProperties:
        """Mass, centre of mass and moment of inertia as a rigid body in the reference configuration."""
        mass, centre, inertia = self.matrices.rigid_properties
        return RigidProperties(mass, self._world(centre), inertia)

    def frequencies(self, count: int = 6, held: Sequence[str] = ()) -> np.ndarray:
        """Lowest natural frequencies (`count`,) of the whole mesh [Hz]; pins `held` neither move nor turn."""
        return vibrations(self.matrices, count, self.tie, held)[0]

    def total_mass(self) -> float:
        return self.matrices.rigid_properties[0]


_matrices = lru_cache(maxsize=REMEMBERED)(matrices)
