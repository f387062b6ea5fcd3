"""Loads on edges of plane bodies: a traction of given direction, and stresses that follow the edge."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.loads.mesh_load import MeshLoad, at_places, in_mesh_axes
from flexmb.planes.loads import Array, Field, Stress, edge_load, edge_products, loaded_edges, on_edges
from flexmb.planes.nodal_load import FollowedEdges, NodalLoad
from flexmb.planes.plane_body import PlaneBody


@dataclass(frozen=True)
class EdgeLoad(MeshLoad):
    """A force per area on an edge of a plane body: dead (of constant direction in the plane), or a follower.

    Signals: fx, fy [N], power [W], times the value of `history`.

    Parameters
    ----------
    name : the load's name.
    body : the loaded body, a `PlaneBody` or a `Reduced` one.
    edge : name of a set of its mesh; the load acts on all edges of the boundary whose ends lie in the set.
    traction : (tx, ty) in the reference configuration [Pa], per area of the undeformed edge; or a function of points
        (p, 2) of the reference configuration [m] that returns (p, 2).
    history : a motion whose value at the time t multiplies the load, e.g. `Pulse(end=0.1)`; None: constant.
    follower : whether the direction turns with the first pin of the body.

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

    edge: str
    traction: Sequence[float] | Callable[[Array], Any]
    _: KW_ONLY
    follower: bool = False

    def __post_init__(self) -> None:
        checks.flag(f"{type(self).__name__} {self.name!r}", "follower", self.follower)
        object.__setattr__(self, "traction", checked_field(self, "traction", self.traction, "Pa"))
        super().__post_init__()

    def share(self, part: float) -> EdgeLoad:
        """The load with the fraction `part` of its traction, if it is a follower."""
        return replace(self, traction=scaled(self.traction, part)) if self.follower else self

    def nodal(self, plane: PlaneBody) -> NodalLoad:
        """Forces on the nodes of a body, in the axes of its mesh.

        Parameters
        ----------
        plane : the body with all nodes.
        """
        forces = edge_load(plane.mesh, self.edge, in_mesh_axes(plane, self.traction), plane.thickness)
        nodes = np.unique(plane.mesh.edges_in(self.edge))
        return NodalLoad(forces.reshape(-1, 2), nodes, self.follower)


@dataclass(frozen=True)
class EdgePressure(MeshLoad):
    """A pressure, and a shear, on an edge of a plane body; both follow the deformed edge.

    Signals: fx, fy [N], power [W], times the value of `history`.

    Parameters
    ----------
    name : the load's name.
    body : the loaded body, a `PlaneBody` or a `Reduced` one.
    edge : name of a set of its mesh, such as a hole; the load acts on all edges of the boundary whose ends lie in the
        set.
    pressure : force per area [Pa], > 0 pushes into the body; or a function of points (p, 2) of the reference
        configuration [m] that returns (p,).
    shear : force per area [Pa] along the edge, > 0 with the body on the left; or such a function.
    history : a motion whose value at the time t multiplies the load, e.g. `Pulse(end=0.1)`; None: constant.

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

    edge: str
    pressure: float | Callable[[Array], Any]
    shear: float | Callable[[Array], Any] = 0.0

    def __post_init__(self) -> None:
        for name in ("pressure", "shear"):
            if not callable(value := getattr(self, name)):
                object.__setattr__(self, name, checks.number(f"EdgePressure {self.name!r}", name, value, "Pa"))
        super().__post_init__()

    def share(self, part: float) -> EdgePressure:
        """The load with the fraction `part` of its stresses."""
        return replace(self, pressure=scaled(self.pressure, part), shear=scaled(self.shear, part))

    def nodal(self, plane: PlaneBody) -> NodalLoad:
        """Forces on the nodes of a body, in the axes of its mesh.

        Parameters
        ----------
        plane : the body with all nodes.
        """
        edges = loaded_edges(plane.mesh, self.edge, plane.thickness)
        normal, along = (edge_products(plane.mesh, edges, _placed(plane, s)) for s in (self.pressure, self.shear))
        forces = on_edges(plane.mesh, edges.nodes, normal, along)
        return NodalLoad(forces, np.unique(edges.nodes), edges=FollowedEdges(edges.nodes, normal, along))


def checked_field(load: MeshLoad, name: str, value: Any, unit: str) -> Field:
    """A field of vectors: a function, or two numbers."""
    if callable(value):
        return value  # type: ignore[no-any-return]
    return checks.point(f"{type(load).__name__} {load.name!r}", name, value, unit)


def scaled(value: Any, part: float) -> Any:
    """A number, a vector or a function, times a number."""
    if callable(value):
        return lambda points: part * np.asarray(value(points), dtype=float)
    return tuple(part * x for x in value) if isinstance(value, tuple) else part * value


def _placed(plane: PlaneBody, stress: Stress) -> Stress:
    return at_places(plane, stress) if callable(stress) else stress
