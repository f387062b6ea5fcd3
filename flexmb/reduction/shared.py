"""Models, bases and matrices of reduced bodies that are kept for equal bodies, by the values that they depend on."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from threading import Lock
from typing import Generic, TypeVar

import numpy as np

from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.planes.plane_body import PlaneBody
from flexmb.reduction.craig_bampton import Basis, basis
from flexmb.reduction.elastic_model import ElasticModel
from flexmb.reduction.of_beams import model_of_beams
from flexmb.reduction.of_planes import model_of_plane
from flexmb.reduction.peak_stress import group_parameters
from flexmb.reduction.superelement import Superelement, superelement

Value = TypeVar("Value")

REMEMBERED = 8
"""Number of models, of bases and of matrices of reduced bodies that are kept."""


class Kept(Generic[Value]):
    """Values by key; the oldest give way.

    Attributes
    ----------
    made : number of values that were computed.
    """

    def __init__(self) -> None:
        self.made = 0
        self._values: OrderedDict[Hashable, Value] = OrderedDict()
        self._lock = Lock()  # sweeps may run in threads

    def of(self, key: Hashable, make: Callable[[], Value]) -> Value:
        """Value of a key, which is all that the value depends on; computed by `make` when it is not kept."""
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
                return self._values[key]
        value = make()
        with self._lock:
            self.made += 1
            self._values[key] = value
            while len(self._values) > REMEMBERED:
                self._values.popitem(last=False)
        return value


MODELS: Kept[ElasticModel] = Kept()
BASES: Kept[Basis] = Kept()
ELEMENTS: Kept[Superelement] = Kept()
GROUPS: Kept[tuple[float, ...]] = Kept()


def key_of(body: FlexibleBody | PlaneBody, pins: Sequence[str]) -> Hashable:
    """All that the elastic model of a body with pins depends on, but its label, damping and place."""
    if isinstance(body, PlaneBody):
        kinds = tuple((interface.name, interface.kind) for interface in body.interfaces if interface.name in pins)
        return body.mesh, body.thickness, body.material, body.state, kinds
    pivot = float(getattr(body, "pivot_inertia", 0.0))
    corners = body.corners, body.corner_points
    return tuple(pins), body.nodes(), body.beams, corners, body._bosses, pivot


def shared_model(body: FlexibleBody | PlaneBody, pins: Sequence[str], key: Hashable) -> ElasticModel:
    """Elastic model of a body, with pins where parts are attached and its `key_of`."""
    if isinstance(body, PlaneBody):
        found = MODELS.of(key, lambda: model_of_plane(body, pins))
        found = replace(found, origin=body.origin, direction=body.direction)
    else:
        found = MODELS.of(key, lambda: model_of_beams(body, pins))
    return replace(found, label=body.label, damping=body.damping, mass_damping=body.mass_damping)


def shared_basis(
    model: ElasticModel,
    key: Hashable,
    modes: int,
    up_to: float | None,
    *,
    by_pin: bool,
    inertia: bool,
    forces: tuple[bytes, ...] = (),
) -> Basis:
    """Craig-Bampton basis of a body with its `key_of`; modes as of `craig_bampton.basis`.

    `forces` are the forces (2 S) on the points of the model of each load whose static shape is kept, as bytes [N].
    """
    options = (modes, up_to, by_pin, inertia, forces)

    def make() -> Basis:
        loads = [model.shape.T @ np.frombuffer(force) for force in forces]
        columns = np.stack(loads, axis=1) if loads else None
        return basis(model, modes, up_to, by_pin=by_pin, inertia=inertia, loads=columns)

    found = BASES.of((key, options), make)
    return replace(found, model=model)


def shared_element(
    found: Basis,
    key: Hashable,
    damping: float,
    *,
    stiffening: bool,
    ratios: float | tuple[float, ...],
    mass_damping: float,
) -> Superelement:
    """Matrices of a reduced body, as of `superelement.superelement`; the key is all that the basis depends on."""
    options = (damping, stiffening, ratios, mass_damping)

    def make() -> Superelement:
        return superelement(found, damping, stiffening=stiffening, ratios=ratios, mass_damping=mass_damping)

    return ELEMENTS.of((key, options), make)


def shared_groups(found: Basis, key: Hashable) -> tuple[float, ...]:
    """Parameters of the search for the largest stress of a body; the key is all that the basis depends on."""
    stresses = found.model.stresses
    if stresses is None:
        raise ValueError(f"{found.model.label} has no stresses")
    return GROUPS.of(key, lambda: group_parameters(stresses(found.shapes)))
