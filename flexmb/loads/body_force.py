"""Force per volume in plane bodies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.loads.edge_load import checked_field, scaled
from flexmb.loads.mesh_load import MeshLoad, in_mesh_axes
from flexmb.planes.loads import Array, body_force
from flexmb.planes.nodal_load import NodalLoad
from flexmb.planes.plane_body import PlaneBody


@dataclass(frozen=True)
class BodyForce(MeshLoad):
    """A force per volume in a plane body (magnetic, of a field): dead, or a follower.

    Signals: fx, fy [N], power [W], times the value of `history`.

    Parameters
    ----------
    name : the load's name.
    body : the loaded body, a `PlaneBody` or a `Reduced` one.
    force : (fx, fy) in the reference configuration [N/m^3], per volume of the undeformed body; or a function of points
        (p, 2) of the reference configuration [m] that returns (p, 2).
    history : a motion whose value at the time t multiplies the load, e.g. `Pulse(end=0.1)`; None: constant.
    follower : whether the direction turns with the first pin of the body.

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

    force: Sequence[float] | Callable[[Array], Any]
    _: KW_ONLY
    follower: bool = False

    def __post_init__(self) -> None:
        checks.flag(f"{type(self).__name__} {self.name!r}", "follower", self.follower)
        object.__setattr__(self, "force", checked_field(self, "force", self.force, "N/m^3"))
        super().__post_init__()

    def share(self, part: float) -> BodyForce:
        """The load with the fraction `part` of its force, if it is a follower."""
        return replace(self, force=scaled(self.force, part)) if self.follower else self

    def nodal(self, plane: PlaneBody) -> NodalLoad:
        """Forces on the nodes of a body, in the axes of its mesh.

        Parameters
        ----------
        plane : the body with all nodes.
        """
        forces = body_force(plane.mesh, in_mesh_axes(plane, self.force), plane.thickness)
        return NodalLoad(forces.reshape(-1, 2), np.arange(len(plane.mesh.points)), self.follower)
