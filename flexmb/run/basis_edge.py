"""Remarks of a run on reduced bodies: much strain energy in the highest modes, loads without their static shapes."""

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
    """A sentence on each reduced body whose last three modes hold much of its strain energy at a pose that is kept.

    Parameters
    ----------
    mechanism : the mechanism.
    seen : what is seen of the run.
    """
    for body, time, d in deformations(mechanism, seen):
        if body.basis.vibrations >= AT_EDGE and np.isfinite(d).all():
            yield from _remark(body, d, time)


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
        share = left_out(load, body) if isinstance(load, MeshLoad) and isinstance(body, Reduced) else 0.0
        if body is not None and share > LEFT_OUT:
            yield (
                f"{load.label} acts on {body.label}, whose kept shapes leave out {100.0 * share:.3g} % of its strain "
                "energy: pins move rightly, but deflection and stress between them are too small. Keep its shape: "
                f"Reduced(..., load_shapes=({load.name},))."
            )


def _remark(body: Reduced, d: np.ndarray, time: np.ndarray) -> Iterator[str]:
    """The sentence on one body with the deformations d (t, n)."""
    from flexmb.results.surfaces import shortened

    pins, d = body.basis.model.count, shortened(d.reshape(len(d), -1, 3), body.element.directions)
    stiffness, last = body.element.matrices["K"], slice(d.shape[1] - AT_EDGE, None)
    eta = d[:, last] - d[:, :pins] @ body.basis.followed[-AT_EDGE:].T
    whole = 0.5 * np.einsum("ti,ij,tj->t", d, stiffness, d)
    edge = 0.5 * np.einsum("ti,ij,tj->t", eta, stiffness[last, last], eta)
    when = int(np.argmax(edge))
    size = np.ptp(body.model.points, axis=0).max()
    moved = np.abs(eta * (1.0, 1.0, size)).max(axis=1)  # the shape of a rotation of 1 moves by the size
    share = float(edge[when] / whole.max()) if moved[when] > STEP_ERROR * size else 0.0
    if share >= EDGE_SHARE:
        frequency, more = body.dropped_frequency, body.basis.vibrations + AT_EDGE
        beyond = f" The lowest one left out has {frequency:.4g} Hz with held pins." if np.isfinite(frequency) else ""
        yield (
            f"{body.label}: at t = {time[when]:.6g} s its three highest modes hold {100.0 * share:.3g} % of its "
            f"largest strain energy, so modes are missing.{beyond} Keep more: modes={more}."
        )
