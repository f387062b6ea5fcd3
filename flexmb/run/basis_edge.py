"""Remarks of a run on reduced bodies whose highest modes hold much of the strain energy."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.model.mechanism import Mechanism

if TYPE_CHECKING:
    from flexmb.run.watch import Saved

EDGE_SHARE = 0.1
"""Share of the strain energy in the highest modes [1] from which a basis is said to be too small."""


def basis_remarks(mechanism: Mechanism, saved: Saved) -> Iterator[str]:
    """A sentence on each reduced body whose last three modes hold much of its strain energy at a saved instant.

    Parameters
    ----------
    mechanism : the mechanism.
    saved : results of the run.
    """
    module = sys.modules.get("flexmb.reduction.reduced")  # no body is a reduced one before it is imported
    for body in mechanism.bodies if module is not None and len(saved.time) else ():
        if isinstance(body, module.Reduced):  # type: ignore[union-attr]
            yield from _remark(body, saved)


def _remark(body: Any, saved: Saved) -> Iterator[str]:
    """The sentence on one body, if its poses were saved."""
    from flexmb.results.surfaces import deformed

    pins = len(body.basis.model.pins)
    names = [f"{body.name}.{node.name}.{axis}" for node in body.basis.nodes for axis in ("x", "y", "theta")]
    columns = [saved.signals.places.get(name, -1) for name in names]
    if min(columns) < 0 or saved.kept is not None or len(body.basis.nodes) == pins:
        return
    poses = saved.values[:, columns].reshape(len(saved.time), -1, 3)
    e = body.element.strained(deformed(body.moved_by, poses)[0].reshape(len(saved.time), -1))
    stiffness, last = body.element.matrices["K"], slice(len(columns) - 3, None)
    eta = e[:, last] - e[:, : 3 * pins] @ body.basis.followed[-3:].T
    whole = 0.5 * np.einsum("ti,ij,tj->t", e, stiffness, e)
    edge = 0.5 * np.einsum("ti,ij,tj->t", eta, stiffness[last, last], eta)
    when = int(np.argmax(edge))
    share = float(edge[when] / whole.max()) if whole.max() > 0.0 else 0.0
    if share >= EDGE_SHARE:
        frequency, more = body.dropped_frequency, 3 * (len(body.basis.nodes) - pins) + 3
        beyond = f" The lowest one left out has {frequency:.4g} Hz with held pins." if np.isfinite(frequency) else ""
        yield (
            f"{body.label}: at t = {saved.time[when]:.6g} s its three highest modes hold {100.0 * share:.3g} % of its "
            f"largest strain energy, so modes are missing.{beyond} Keep more: modes={more}."
        )
