"""Loads on plane bodies: forces per volume, tractions and pressures on edges."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import KW_ONLY, replace
from typing import Any

import numpy as np

from flexmb import planar
from flexmb.elastic.planes import loads
from flexmb.elastic.planes.plane_body import MeshBody, PlaneBody
from flexmb.errors import InputError, ModelError
from flexmb.fields import either, field, flag, number, record, vector
from flexmb.findings.finding import Finding, found
from flexmb.model.contributions import Contribution
from flexmb.model.law import Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part, WatchedMotion
from flexmb.model.shape import ArrowShape, Shapes
from flexmb.parts.loads.force import HISTORY
from flexmb.planar import Array

ARROWS = 5  # largest number of arrows that a drawing shows of a load
# Share of the strain energy of a load that the kept shapes of a reduced body may leave out [1]; stresses are then off
# by some tenth.
LEFT_OUT = 0.01
NO_ARROW = 1e-9  # nodal force over the largest one [1] up to which a drawing shows none
# Rules of a load on all of an edge or body: two numbers or one, or a function of points.
FIELD, STRESS = either(Callable, vector), either(Callable, number)


@record
class MeshLoad(Part):
    """A load on the mesh of a plane body, with all its nodes or reduced."""

    body: Part = field("the loaded body, a `PlaneBody` or a `Reduced` one")
    _: KW_ONLY
    history: Motion | None = field("motion whose value multiplies the load", rule=HISTORY, default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.on(self.plane_of(self.body))

    @abstractmethod
    def nodal(self, plane: PlaneBody) -> loads.NodalLoad:
        """Forces on the nodes of a body `plane` with all its nodes, in the axes of its mesh."""

    def on(self, plane: PlaneBody) -> loads.NodalLoad:
        """Forces on the nodes of a body `plane`, in the axes of its mesh; an `InputError` has the name of the load."""
        try:
            return self.nodal(plane)
        except InputError as error:
            raise InputError(f"{self.label}: {error}") from error

    def plane_of(self, body: Part) -> PlaneBody:
        """The body with all nodes of the mesh of `body`, or `ModelError`."""
        return self._carrier(body)[1]

    def _carrier(self, body: Part) -> tuple[MeshBody, PlaneBody]:
        """The body, which must have a mesh, and the one with all nodes of it."""
        if not isinstance(body, MeshBody) or body.plane is None:
            text = f"{self.label} acts on the nodes of a mesh, and {body.label} has none."
            raise ModelError(f"{text} Give a PlaneBody or its Reduced; a Force acts on any body.")
        return body, body.plane

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:  # noqa: ARG002 - alone
        """Finding on a load whose deflection the kept shapes of a reduced body cannot show."""
        body, plane = self._carrier(mechanism.body(self.body.name, self.label))
        share = body.left_out(self.on(plane))
        if share > LEFT_OUT:
            text = f"{self.label} acts on {body.label}, whose kept shapes leave out {100.0 * share:.3g} % of its"
            text += " strain energy: pins move rightly, but deflection and stress between them are too small."
            remedy = f"Keep its shape: Reduced(..., load_shapes=({self.name},))."
            yield found("missing-shapes", (self.name, body.name), text, remedy, share=share, limit=LEFT_OUT)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        body, plane = self._carrier(mechanism.body(self.body.name, self.label))
        return body.loaded(self.name, self.on(plane), self.history)

    def shapes(self, mechanism: Mechanism) -> Shapes:
        """A few arrows, each carried by the pin that is nearest in the undeformed body."""
        body = mechanism.body(self.body.name, self.label)
        plane, nodes = self.plane_of(body), {node.name for node in body.nodes()}
        pins = [pin for pin in plane.interfaces if pin.name in nodes]
        load, found = self.on(plane), []
        follows = load.follower or load.edges is not None
        sizes = np.hypot(*load.forces.T)
        loaded = np.flatnonzero(sizes > NO_ARROW * sizes.max(initial=0.0))
        for k in loaded[:: max(1, -(-len(loaded) // ARROWS))].tolist():
            force, point = tuple(load.forces[k].tolist()), tuple(plane.mesh.points[k].tolist())
            pin = min(pins, key=lambda pin: planar.distance(pin.point, point))
            offset = (point[0] - pin.point[0], point[1] - pin.point[1])
            direction = force if follows else planar.from_frame((0.0, 0.0), plane.direction, force)
            found.append(ArrowShape(self.name, (self.body.name, pin.name, offset), direction, follows))
        return tuple(found)


def in_mesh_axes(plane: PlaneBody, field: loads.Field) -> loads.Field:
    """A vector (x, y), or function of points (p, 2) of the reference configuration, in the axes of the mesh."""
    if not callable(field):
        return planar.to_frame((0.0, 0.0), plane.direction, (field[0], field[1]))
    turn, given = _turn(plane), at_places(plane, field)

    def turned(points: Array) -> Any:
        values = loads.real_values(given(points))
        return values @ turn.T if values.shape == points.shape else values

    return turned


def at_places(plane: PlaneBody, function: Callable[[Array], Any]) -> Callable[[Array], Any]:
    """A function of points (p, 2) of the reference configuration as one of points in the axes of the mesh."""
    turn, origin = _turn(plane), np.asarray(plane.origin)
    return lambda points: function(points @ turn + origin)


def _turn(plane: PlaneBody) -> Array:
    """Rotation (2, 2) of rows from the axes of the mesh to the world."""
    c, s = np.cos(plane.direction), np.sin(plane.direction)
    return np.array([[c, s], [-s, c]])


@record
class EdgeLoad(MeshLoad):
    """A force per area on an edge of a plane body: dead (of constant direction in the plane), or a follower.

    It acts on all edges of the boundary whose ends lie in a set of the mesh.  `traction` is per area of the undeformed
    edge, in the reference configuration; a function takes points (p, 2) there [m] and returns (p, 2).

    Signals: fx, fy [N], power [W], times the value of `history`.

    Raises
    ------
    ModelError : a body without a mesh.
    InputError : a set that is not there or holds no edge, values of another shape.

    Notes
    -----
    The force is traction times thickness times length.  A reduced body moves at its pins as the full one does, but its
    inside lacks the static shape of the load: `Reduced(..., load_shapes=(load,))` adds it.
    Static equilibrium takes the history at t = 0.  Equation (11.12) of docs/theory/plane_bodies.md.

    Examples
    --------
    >>> import flexmb as fm
    >>> mesh = fm.meshes.rectangle(0.4, 0.02, 20, 1)
    >>> bar = fm.PlaneBody("bar", mesh, at=(0.0, 0.0), thickness=0.01, material=fm.STEEL, pins=("left",))
    >>> wall = fm.Fixed("wall", fm.GROUND, bar, at=(bar.pin_nodes[0].x, bar.pin_nodes[0].y))
    >>> snow = fm.loads.EdgeLoad("snow", bar, "top", (0.0, -1e4))
    >>> found = fm.static_equilibrium(fm.Mechanism("bar", [bar, wall, snow]))
    >>> round(found.force("wall")[1], 6)
    40.0
    """

    edge: str = field("name of a set of the mesh")
    traction: Sequence[float] | Callable[[Array], Any] = field("(tx, ty), or a function, see above", "Pa", FIELD)
    _: KW_ONLY
    follower: bool = field("whether the direction turns with the first pin of the body", rule=flag, default=False)

    def share(self, part: float) -> EdgeLoad:
        return replace(self, traction=scaled(self.traction, part)) if self.follower else self

    def nodal(self, plane: PlaneBody) -> loads.NodalLoad:
        forces = loads.edge_load(plane.mesh, self.edge, in_mesh_axes(plane, self.traction), plane.thickness)
        return loads.NodalLoad(forces.reshape(-1, 2), np.unique(plane.mesh.edges_in(self.edge)), self.follower)


@record
class EdgePressure(MeshLoad):
    """A pressure, and a shear, on an edge of a plane body; both follow the deformed edge.

    They act on all edges of the boundary whose ends lie in a set of the mesh, such as a hole.  A shear > 0 acts with
    the body on its left.  Functions take points (p, 2) of the reference configuration [m] and return (p,).

    Signals: fx, fy [N], power [W], times the value of `history`.

    Raises
    ------
    ModelError : a body without a mesh.
    InputError : a set that is not there or holds no edge, values of another shape.

    Notes
    -----
    Forces are per length of the deformed edge, and the thickness is that of the undeformed body.  A constant pressure
    on a closed edge has a potential, the pressure times the area inside, so its stiffness is symmetric; on an open edge
    whose ends move it has none, and `modes` refuses it as any follower.
    A reduced body moves at its pins as the full one does, but its inside lacks the static shape of the load:
    `Reduced(..., load_shapes=(load,))` adds it.  Static equilibrium takes the history at t = 0.
    Equation (11.13) of docs/theory/plane_bodies.md.
    """

    edge: str = field("name of a set of the mesh")
    pressure: float | Callable[[Array], Any] = field("> 0 into the body, or a function, see above", "Pa", STRESS)
    shear: float | Callable[[Array], Any] = field("along the edge, or a function", "Pa", STRESS, default=0.0)

    def share(self, part: float) -> EdgePressure:
        return replace(self, pressure=scaled(self.pressure, part), shear=scaled(self.shear, part))

    def nodal(self, plane: PlaneBody) -> loads.NodalLoad:
        edges = loads.loaded_edges(plane.mesh, self.edge, plane.thickness)
        stresses = (at_places(plane, s) if callable(s) else s for s in (self.pressure, self.shear))
        normal, along = (loads.edge_products(plane.mesh, edges, stress) for stress in stresses)
        followed = loads.FollowedEdges(edges.nodes, normal, along)
        return loads.NodalLoad(followed.forces(plane.mesh), np.unique(edges.nodes), edges=followed)


def scaled(value: Any, part: float) -> Any:
    """A number, a vector or a function, times a number."""
    if callable(value):
        return lambda points: part * np.asarray(value(points), dtype=float)
    return tuple(part * x for x in value) if isinstance(value, tuple) else part * value


@record
class BodyForce(MeshLoad):
    """A force per volume in a plane body (magnetic, of a field): dead, or a follower.

    It is per volume of the undeformed body, in the reference configuration; a function takes points (p, 2) there [m]
    and returns (p, 2).

    Signals: fx, fy [N], power [W], times the value of `history`.

    Raises
    ------
    ModelError : a body without a mesh.
    InputError : values of another shape.

    Notes
    -----
    Weight is `Mechanism(gravity=...)`.  A force is that of the place in the undeformed body, wherever it moves to.  A
    reduced body moves at its pins as the full one does, but its inside lacks the static shape of the load:
    `Reduced(..., load_shapes=(load,))` adds it.  Static equilibrium takes the history at t = 0.
    Equation (11.12) of docs/theory/plane_bodies.md.
    """

    force: Sequence[float] | Callable[[Array], Any] = field("(fx, fy), or a function, see above", "N/m^3", FIELD)
    _: KW_ONLY
    follower: bool = field("whether the direction turns with the first pin of the body", rule=flag, default=False)

    def share(self, part: float) -> BodyForce:
        return replace(self, force=scaled(self.force, part)) if self.follower else self

    def nodal(self, plane: PlaneBody) -> loads.NodalLoad:
        forces = loads.body_force(plane.mesh, in_mesh_axes(plane, self.force), plane.thickness)
        return loads.NodalLoad(forces.reshape(-1, 2), np.arange(len(plane.mesh.points)), self.follower)
