"""Accuracy of reduced bodies: frequencies, deflections and stresses beside the ones of all displacements."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la
import scipy.sparse.linalg as sla

from flexmb import checks
from flexmb.errors import InputError
from flexmb.planes.recovery import von_mises
from flexmb.reduction.craig_bampton import DENSE, RIGID, Basis, inertia_loads
from flexmb.reduction.elastic_model import ElasticModel, Sparse
from flexmb.reduction.superelement import Superelement

Array = npt.NDArray[np.float64]
Load = Callable[[Array], Any] | Array
"""Accelerations (S, 2) of gravity [m/s^2] as a function of points (S, 2) [m], or forces (S, 2) at all points [N]."""

SHIFT = 1e-3
"""Shift of the squared angular frequencies of a free body below 0, over the lowest one of its reduced body [1]."""

EXACT = 1e-9
"""Relative error [1] below which a table shows round-off alone."""


class LoadAccuracy(NamedTuple):
    """Statics of the full and of the reduced body under one load.

    Parameters
    ----------
    deflection : largest displacement of the full body [m].
    deflection_error : largest difference of displacements over that [1].
    stress : largest von Mises stress of the full body [Pa]; nan: unknown.
    stress_error : largest von Mises stress of the difference over that [1]; nan: unknown.
    """

    deflection: float
    deflection_error: float
    stress: float
    stress_error: float


@dataclass(frozen=True, eq=False, repr=False)
class Accuracy:
    """A reduced body beside the body with all its displacements; both have the same pins.

    Attributes
    ----------
    label : class and name of the body.
    modes : number of kept vibrations.
    coordinates : number of coordinates of the reduced body.
    displacements : number of displacements of the full one.
    holding : how the pins are held, in words.
    free : (k, 2) frequencies without supports of the full and of the reduced body, without rigid motions [Hz].
    held : (k, 2) frequencies with the held pins [Hz].
    compliance_error : largest difference of the compliances at pins under unit forces and moments there, over the
        geometric mean of those of both pins [1]; 0 where no pin moves.
    loads : statics by load, with the held pins: "acceleration along x" and "acceleration along y" of 1 m/s^2 in the
        axes of the body, "angular acceleration" about the first pin of 1 rad/s^2, "rotation" about it at 1 rad/s, then
        given loads.
    dropped_frequency : lowest frequency with all pins held that is left out [Hz]; infinite where none is left.

    Notes
    -----
    Displacements of pins are exact under any static load, since the static shapes do no work on motions inside.
    `repr` is a table.
    """

    label: str
    modes: int
    coordinates: int
    displacements: int
    holding: str
    free: Array
    held: Array
    compliance_error: float
    loads: Mapping[str, LoadAccuracy]
    dropped_frequency: float

    @property
    def free_errors(self) -> Array:
        """(k,) errors of the frequencies without supports, relative [1]."""
        return np.asarray(self.free[:, 1] / self.free[:, 0] - 1.0)

    @property
    def held_errors(self) -> Array:
        """(k,) errors of the frequencies with the held pins, relative [1]."""
        return np.asarray(self.held[:, 1] / self.held[:, 0] - 1.0)

    def __repr__(self) -> str:
        dropped = f"{self.dropped_frequency:.6g} Hz" if math.isfinite(self.dropped_frequency) else "none"
        lines = [
            f"{self.label}: {self.modes} vibrations, {self.coordinates} coordinates for {self.displacements}",
            f"lowest frequency left out, all pins held: {dropped}",
            f"{'':31}{'full':>12}{'reduced':>12}{'error':>10}",
        ]
        for name, pairs in (("free", self.free), (f"held ({self.holding})", self.held)):
            for k, (full, own) in enumerate(pairs.tolist()):
                lines.append(
                    f"{name if k == 0 else '':25}{k + 1:3} Hz{full:12.6g}{own:12.6g}{_shown(own / full - 1.0)}"
                )
        lines.append(f"{'compliance of the pins':55}{_shown(self.compliance_error)}")
        lines.append(f"{'held, under':31}{'deflection':>12}{'error':>10}{'stress':>12}{'error':>10}")
        for name, load in self.loads.items():
            shown = f"{name:31}{load.deflection:10.3g} m{_shown(load.deflection_error)}"
            stress = "" if math.isnan(load.stress) else f"{load.stress:9.3g} Pa{_shown(load.stress_error)}"
            lines.append(shown + stress)
        return "\n".join(lines)


class Comparison:
    """The full and the reduced body with some displacements of pins held at 0."""

    def __init__(self, found: Basis, element: Superelement, held: Sequence[int]) -> None:
        self.model, self.found = found.model, found
        K, M = self.model.stiffness.tocsc(), self.model.mass_matrix()
        n = found.shapes.shape[1]
        self.kept = np.setdiff1d(np.arange(K.shape[0]), held)
        self.own_kept = np.setdiff1d(np.arange(n), held)
        self.full = K[self.kept][:, self.kept].tocsc(), M[self.kept][:, self.kept].tocsc()
        own = np.ix_(self.own_kept, self.own_kept)
        self.own = element.matrices["K"][own], element.matrices["M"][own]
        self.rigid = 0 if len(held) else RIGID

    def frequencies(self, count: int) -> Array:
        """(k, 2) lowest frequencies of both bodies, without rigid motions [Hz]."""
        own = la.eigh(*self.own, eigvals_only=True)[self.rigid :][:count]
        full = _lowest(*self.full, len(own), self.rigid, float(own[0]) if len(own) else 1.0)
        return np.asarray(np.sqrt(np.stack([full, own], axis=1)) / (2.0 * math.pi))

    def statics(self, forces: Array) -> tuple[Array, Array]:
        """Displacements (N, k) of both bodies under forces (N, k)."""
        K = self.full[0]
        full, own = np.zeros_like(forces), np.zeros((self.found.shapes.shape[1], forces.shape[1]))
        full[self.kept] = sla.splu(K).solve(np.ascontiguousarray(forces[self.kept]))
        own[self.own_kept] = np.linalg.solve(self.own[0], (self.found.shapes.T @ forces)[self.own_kept])
        return full, np.asarray(self.found.shapes @ own)

    def compliance_error(self) -> float:
        """Largest difference of the compliances at the pins over the geometric mean of their own ones."""
        moved = self.kept[self.kept < self.model.count]
        if not len(moved):
            return 0.0
        unit = np.zeros((self.model.stiffness.shape[0], len(moved)))
        unit[moved, np.arange(len(moved))] = 1.0
        full, own = (found[moved] for found in self.statics(unit))
        scale = np.sqrt(np.diag(full))
        return float(np.abs((own - full) / np.outer(scale, scale)).max())

    def under(self, forces: Array) -> list[LoadAccuracy]:
        """Statics under forces (N, k)."""
        full, own = self.statics(forces)
        sizes, errors = (_lengths(self.model, found) for found in (full, own - full))
        if self.model.stresses is None:
            stress, wrong = np.full(len(sizes), math.nan), np.full(len(sizes), math.nan)
        else:
            stress, wrong = (_largest(self.model.stresses(found)) for found in (full, own - full))
        columns = (found.tolist() for found in (sizes, errors, stress, wrong))
        return [
            LoadAccuracy(size, _over(error, size), of, _over(off, of))
            for size, error, of, off in zip(*columns, strict=True)
        ]


def accuracy(
    found: Basis,
    element: Superelement,
    *,
    count: int = 3,
    held: Sequence[str] | None = None,
    loads: Mapping[str, Load] | None = None,
) -> Accuracy:
    """A reduced body beside the body with all its displacements, with `count` frequencies at most.

    Pins `held` neither move nor turn; None: all pins keep their places and may turn, a single one may not.
    """
    model = found.model
    count = checks.count(model.label, "count", count)
    names = [pin.name for pin in model.pins]
    if held is None:
        alone = len(names) == 1
        fixed = list(range(RIGID)) if alone else [3 * k + axis for k in range(len(names)) for axis in range(2)]
        holding = "the pin" if alone else "pins may turn"
    else:
        given = checks.sequence(model.label, "held", held, "names of pins")
        places = [names.index(checks.one_of(model.label, "held pin", name, names)) for name in given]
        if not places:
            raise InputError(f"{model.label}: held is empty, and a free body has no statics. Name a pin.")
        fixed = [3 * k + axis for k in places for axis in range(3)]
        holding = ", ".join(given)
    forces = inertia_loads(model) | {name: _forces(model, name, load) for name, load in (loads or {}).items()}
    supported = Comparison(found, element, fixed)
    return Accuracy(
        model.label,
        found.vibrations,
        found.shapes.shape[1],
        model.stiffness.shape[0],
        holding,
        Comparison(found, element, []).frequencies(count),
        supported.frequencies(count),
        supported.compliance_error(),
        dict(zip(forces, supported.under(np.stack(list(forces.values()), axis=1)), strict=True)),
        float(found.held[found.vibrations]) if len(found.held) > found.vibrations else math.inf,
    )


def _forces(model: ElasticModel, name: str, load: Load) -> Array:
    """Forces (N,) of a given load."""
    values = np.asarray(load(model.points) if callable(load) else load, dtype=float)
    if values.shape != model.points.shape or not np.isfinite(values).all():
        raise InputError(
            f"{model.label}: load {name!r} has the shape {values.shape}, or values that are not finite; it must be "
            f"{model.points.shape}, one (x, y) for each of the points `model.points`."
        )
    if callable(load):
        return model.force_of(values)
    return np.asarray(model.shape.T @ values.ravel())


def _lowest(K: Sparse, M: Sparse, count: int, rigid: int, scale: float) -> Array:
    """Lowest squared angular frequencies (count,), without rigid motions; `scale` is about the first of them."""
    n, wanted = K.shape[0], count + rigid
    if n <= DENSE or wanted >= n - 1:
        return np.asarray(la.eigh(K.toarray(), M.toarray(), eigvals_only=True)[rigid:wanted])
    shift = -SHIFT * scale if rigid else 0.0
    factors = sla.splu(K - shift * M, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
                       options={"SymmetricMode": True})  # fmt: skip
    inverse = sla.LinearOperator((n, n), matvec=factors.solve, dtype=float)
    start = np.sin(1.0 + 7.3 * np.arange(n))  # the same in every run
    squares = sla.eigsh(K, wanted, M, sigma=shift, OPinv=inverse, v0=start, return_eigenvectors=False)
    return np.asarray(np.sort(squares)[rigid:])


def _lengths(model: ElasticModel, displacements: Array) -> Array:
    """(k,) largest displacements of the points."""
    moved = np.asarray(model.shape @ displacements)
    return np.asarray(np.hypot(moved[0::2], moved[1::2]).max(axis=0))


def _largest(stresses: Array) -> Array:
    """(k,) largest von Mises stresses of stresses (nodes, 4, k)."""
    return np.asarray(von_mises(np.moveaxis(stresses, 2, 0)).max(axis=1))


def _shown(error: float) -> str:
    """An error in ten characters."""
    return f"{error:10.1e}" if abs(error) >= EXACT else f"{f'< {EXACT:.0e}':>10}"


def _over(error: float, size: float) -> float:
    """Relative error; 0 of nothing."""
    return error / size if size else 0.0
