"""Base of bodies whose shape is a plane mesh: all nodes of it, or a few modes."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING

from flexmb.model.contributions import Contribution, Coordinate, node_coordinates
from flexmb.model.part import Body

if TYPE_CHECKING:
    from flexmb.model.law import Motion
    from flexmb.planes.nodal_load import NodalLoad
    from flexmb.planes.plane_body import PlaneBody


class MeshBody(Body):
    """A body that can bear loads on its mesh."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of all nodes."""
        return tuple(c for node in self.nodes() for c in node_coordinates(self.name, node.name))

    @property
    @abstractmethod
    def plane(self) -> PlaneBody | None:
        """The body with all nodes of its mesh; None for one of beams."""

    @abstractmethod
    def loaded(self, name: str, load: NodalLoad, history: Motion | None) -> Sequence[Contribution]:
        """Contributions of a load on the mesh.

        Parameters
        ----------
        name : name of the load.
        load : its forces, in the axes of the mesh.
        history : motion whose value multiplies it; None: constant.
        """
