"""Base of loads on plane bodies."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from flexmb import planar
from flexmb.errors import InputError, ModelError
from flexmb.loads.force import check_history
from flexmb.model.contributions import Contribution
from flexmb.model.law import Motion
from flexmb.model.part import Part
from flexmb.model.shape import ArrowShape, Shapes
from flexmb.planes.loads import Array, Field, real_values
from flexmb.planes.mesh_body import MeshBody
from flexmb.planes.nodal_load import NodalLoad
from flexmb.planes.plane_body import PlaneBody

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

ARROWS = 5
"""Largest number of arrows that a drawing shows of a load."""

NO_ARROW = 1e-9
"""Nodal force over the largest one [1] up to which a drawing shows none."""


@dataclass(frozen=True)
class MeshLoad(Part):
    """A load on the mesh of a plane body, with all its nodes or reduced.

    Parameters
    ----------
    name : the load's name.
    body : the loaded body.
    history : a motion whose value at the time t multiplies the load; None: constant.
    """

    body: Part
    _: KW_ONLY
    history: Motion | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check_history(self, self.history)
        _ = self.on(self.plane_of(self.body))

    @abstractmethod
    def nodal(self, plane: PlaneBody) -> NodalLoad:
        """Forces on the nodes of a body, in the axes of its mesh.

        Parameters
        ----------
        plane : the body with all nodes.
        """

    def on(self, plane: PlaneBody) -> NodalLoad:
        """Forces on the nodes of a body, in the axes of its mesh.

        Parameters
        ----------
        plane : the body with all nodes.

        Raises
        ------
        InputError : a set that the mesh has not, values of another shape; with the name of the load.
        """
        try:
            return self.nodal(plane)
        except InputError as error:
            raise InputError(f"{self.label}: {error}") from error

    def plane_of(self, body: Part) -> PlaneBody:
        """The body with all nodes of its mesh.

        Raises
        ------
        ModelError : a body without a mesh.
        """
        plane = self._carrier(body).plane
        return plane if plane is not None else self._refuse(body)

    def _carrier(self, body: Part) -> MeshBody:
        """The body, if it has a mesh."""
        return body if isinstance(body, MeshBody) else self._refuse(body)

    def _refuse(self, body: Part) -> NoReturn:
        """Refuse a body without a mesh."""
        raise ModelError(
            f"{self.label} acts on the nodes of a mesh, and {body.label} has none. Give a PlaneBody or its Reduced; a "
            "Force acts on any body."
        )

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """Elements on the nodes of the body, and three signals."""
        body = self._carrier(mechanism.body(self.body.name, self.label))
        return body.loaded(self.name, self.on(self.plane_of(body)), self.history)

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


def in_mesh_axes(plane: PlaneBody, field: Field) -> Field:
    """A field of vectors of the reference configuration, in the axes of the mesh.

    The field is (x, y), or a function of points (p, 2) of the reference configuration that returns (p, 2).
    """
    if not callable(field):
        return planar.to_frame((0.0, 0.0), plane.direction, (field[0], field[1]))
    turn, given = _turn(plane), at_places(plane, field)

    def turned(points: Array) -> Any:
        values = real_values(given(points))
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
