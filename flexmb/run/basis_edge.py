"""Remarks of a run on reduced bodies: much strain energy in the highest modes, loads and rotations without shapes."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from flexmb.model.mechanism import Mechanism
from flexmb.run.deformations import deformations

if TYPE_CHECKING:
    from flexmb.reduction.reduced import Reduced
    from flexmb.run.watch import Seen

EDGE_SHARE = 0.1
"""Share of the strain energy in the highest modes [1] from which a basis is said to be too small."""

AT_EDGE = 3
"""Number of the highest modes that are looked at."""

LEFT_OUT = 0.01
"""Share of the strain energy of a load, with all pins held, that the kept shapes may leave out [1]; stresses are then
off by some tenth."""

STEP_ERROR = 1e-8
"""Displacement by the highest modes over the size of a body [1], up to which it is the error of steps.

Default steps leave some 3e-9 in bodies that are so stiff that their deformation is smaller."""


def basis_remarks(mechanism: Mechanism, seen: Seen) -> Iterator[str]:
    """Sentences on each reduced body whose highest modes hold much of its strain energy, or that lacks that of a turn.

    Parameters
    ----------
    mechanism : the mechanism.
    seen : what is seen of the run.
    """
    for body, time, d in deformations(mechanism, seen):
        if np.isfinite(d).all():
            yield from _remark(body, d, time, seen)


def load_remarks(mechanism: Mechanism) -> Iterator[str]:
    """A sentence on each load whose deflection the kept shapes of a reduced body cannot show.

    Parameters
    ----------
    mechanism : the mechanism.
    """
    if "flexmb.reduction.reduced" not in sys.modules:  # no body is reduced, and the import takes long
        return
    from flexmb.loads.mesh_load import MeshLoad
    from flexmb.reduction.loads import left_out
    from flexmb.reduction.reduced import Reduced

    for load in mechanism.parts:
        body = mechanism.find(load.body.name) if isinstance(load, MeshLoad) else None
        if not isinstance(load, MeshLoad) or not isinstance(body, Reduced):
            continue
        whole, left = left_out(body, body.model.shape.T @ load.on(load.plane_of(body)).forces.ravel())
        if left > LEFT_OUT * whole:
            yield (
                f"{load.label} acts on {body.label}, whose kept shapes leave out {100.0 * left / whole:.3g} % of its "
                "strain energy: pins move rightly, but deflection and stress between them are too small. Keep its "
                f"shape: Reduced(..., load_shapes=({load.name},))."
            )


def _remark(body: Reduced, d: np.ndarray, time: np.ndarray, seen: Seen) -> Iterator[str]:
    """The sentences on one body with the deformations d (t, n)."""
    from flexmb.results.surfaces import shortened

    d = shortened(d.reshape(len(d), -1, 3), body.element.directions)
    whole = 0.5 * np.einsum("ti,ij,tj->t", d, body.element.matrices["K"], d).max()
    yield from _of_rotation(body, float(whole), seen)
    if body.basis.vibrations >= AT_EDGE:
        yield from _at_edge(body, d, time, float(whole))


def _at_edge(body: Reduced, d: np.ndarray, time: np.ndarray, whole: float) -> Iterator[str]:
    """The sentence on strain energy in the highest modes."""
    pins, last = body.basis.model.count, slice(d.shape[1] - AT_EDGE, None)
    eta = d[:, last] - d[:, :pins] @ body.basis.followed[-AT_EDGE:].T
    edge = 0.5 * np.einsum("ti,ij,tj->t", eta, body.element.matrices["K"][last, last], eta)
    when = int(np.argmax(edge))
    size = np.ptp(body.model.points, axis=0).max()
    moved = np.abs(eta * (1.0, 1.0, size)).max(axis=1)  # the shape of a rotation of 1 moves by the size
    share = float(edge[when]) / whole if moved[when] > STEP_ERROR * size else 0.0
    if share >= EDGE_SHARE:
        frequency, more = body.dropped_frequency, body.basis.vibrations + AT_EDGE
        beyond = f" The lowest one left out has {frequency:.4g} Hz with held pins." if np.isfinite(frequency) else ""
        yield (
            f"{body.label}: at t = {time[when]:.6g} s its three highest modes hold {100.0 * share:.3g} % of its "
            f"largest strain energy, so modes are missing.{beyond} Keep more: modes={more}."
        )


def _of_rotation(body: Reduced, whole: float, seen: Seen) -> Iterator[str]:
    """The sentence on centrifugal forces that the kept shapes leave out, beside the largest strain energy."""
    from flexmb.reduction.craig_bampton import inertia_loads
    from flexmb.reduction.loads import left_out

    model, force = body.model, inertia_loads(body.model)["rotation"]
    speed, when = min(seen.motion.peak(f"{body.name}.{pin.name}.omega") for pin in model.pins)
    moved, size = np.abs(model.shape @ body.basis.static(force)).max(), np.ptp(model.points, axis=0).max()
    left = speed**4 * left_out(body, force)[1]
    if left > LEFT_OUT * (whole + left) and speed**2 * moved > STEP_ERROR * size:
        yield (
            f"{body.label}: at t = {when:.6g} s it turns at {speed:.4g} rad/s, and its kept shapes leave out "
            f"{100.0 * left / (whole + left):.3g} % of its strain energy, by centrifugal forces: stress inside is too "
            "small. Keep their shape, Reduced(..., inertia_shapes=True), or more modes."
        )
