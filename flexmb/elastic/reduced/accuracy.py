"""Accuracy of reduced bodies, and findings on their deformations in a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy.linalg as la
import scipy.sparse.linalg as sla

from flexmb import checks
from flexmb.elastic.planes.cells import lowest
from flexmb.elastic.planes.stress import von_mises
from flexmb.elastic.reduced.bases import DENSE, RIGID, Basis, inertia_loads
from flexmb.elastic.reduced.kernel import FIRST
from flexmb.elastic.reduced.superelement import Superelement, left_out
from flexmb.errors import InputError
from flexmb.findings.finding import Finding, found
from flexmb.model.part import WatchedMotion
from flexmb.model.shape import MeshShape
from flexmb.parts.loads.mesh_loads import LEFT_OUT
from flexmb.planar import Array

if TYPE_CHECKING:
    from flexmb.elastic.reduced.reduced import Reduced

# Accelerations (S, 2) of gravity [m/s^2] as a function of points (S, 2) [m], or forces (S, 2) at all points [N].
Load = Callable[[Array], Any] | Array
SHIFT = 1e-3  # shift of the squared angular frequencies of a free body below 0, over the lowest one reduced [1]
EXACT = 1e-9  # relative error [1] below which a table shows round-off alone


class LoadAccuracy(NamedTuple):
    """Statics of the full and of the reduced body under one load."""

    deflection: float  # largest displacement of the full body [m]
    deflection_error: float  # largest difference of displacements over that [1]
    stress: float  # largest von Mises stress of the full body [Pa]; nan: unknown
    stress_error: float  # largest von Mises stress of the difference over that [1]; nan: unknown


@dataclass(frozen=True, eq=False, repr=False)
class Accuracy:
    """A reduced body beside the body with all its displacements; both have the same pins."""

    # Displacements of pins are exact under any static load, since the static shapes do no work on motions inside.
    # `repr` is a table.
    label: str  # class and name of the body
    modes: int  # number of kept vibrations
    coordinates: int  # number of coordinates of the reduced body
    displacements: int  # number of displacements of the full one
    holding: str  # how the pins are held, in words
    free: Array  # (k, 2) frequencies without supports of the full and the reduced body, without rigid motions [Hz]
    held: Array  # (k, 2) frequencies with the held pins [Hz]
    # largest difference of the compliances at pins under unit forces and moments there, over the geometric mean of
    # those of both pins [1]; 0 where no pin moves
    compliance_error: float
    # statics by load, with the held pins: "acceleration along x" and "acceleration along y" of 1 m/s^2 in the axes of
    # the body, "angular acceleration" about the first pin of 1 rad/s^2, "rotation" about it at 1 rad/s; given loads
    loads: Mapping[str, LoadAccuracy]
    dropped_frequency: float  # lowest frequency with all pins held that is left out [Hz]; infinite where none is left

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
                error = _shown(own / full - 1.0)
                lines.append(f"{name if k == 0 else '':25}{k + 1:3} Hz{full:12.6g}{own:12.6g}{error}")
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
        self.kept = np.setdiff1d(np.arange(K.shape[0]), held)
        self.own_kept = np.setdiff1d(np.arange(found.shapes.shape[1]), held)
        self.full = K[self.kept][:, self.kept].tocsc(), M[self.kept][:, self.kept].tocsc()
        own = np.ix_(self.own_kept, self.own_kept)
        self.own = element.matrices["K"][own], element.matrices["M"][own]
        self.rigid = 0 if len(held) else RIGID

    def frequencies(self, count: int) -> Array:
        """(k, 2) lowest frequencies of both bodies, without rigid motions [Hz]."""
        own = la.eigh(*self.own, eigvals_only=True)[self.rigid :][:count]
        (K, M), wanted = self.full, len(own) + self.rigid
        if K.shape[0] <= DENSE or wanted >= K.shape[0] - 1:
            full = la.eigh(K.toarray(), M.toarray(), eigvals_only=True)[self.rigid : wanted]
        else:
            shift = -SHIFT * (float(own[0]) if len(own) else 1.0) if self.rigid else 0.0
            full = lowest(K, M, wanted, shift)[0][self.rigid :]
        return np.asarray(np.sqrt(np.stack([full, own], axis=1)) / (2.0 * math.pi))

    def statics(self, forces: Array) -> tuple[Array, Array]:
        """Displacements (N, k) of both bodies under forces (N, k)."""
        full, own = np.zeros_like(forces), np.zeros((self.found.shapes.shape[1], forces.shape[1]))
        full[self.kept] = sla.splu(self.full[0]).solve(np.ascontiguousarray(forces[self.kept]))
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
        moved = (np.asarray(self.model.shape @ found) for found in (full, own - full))
        sizes, errors = (np.hypot(one[0::2], one[1::2]).max(axis=0) for one in moved)  # largest ones of the points
        if self.model.stresses is None:
            stress, wrong = np.full(len(sizes), math.nan), np.full(len(sizes), math.nan)
        else:
            stresses = (np.moveaxis(self.model.stresses(found), 2, 0) for found in (full, own - full))
            stress, wrong = (von_mises(one).max(axis=1) for one in stresses)
        rows = zip(*(found.tolist() for found in (sizes, errors, stress, wrong)), strict=True)
        return [LoadAccuracy(size, _over(error, size), of, _over(off, of)) for size, error, of, off in rows]


def accuracy(
    found: Basis, element: Superelement, count: int, held: Sequence[str] | None, loads: Mapping[str, Load]
) -> Accuracy:
    """A reduced body beside the body with all its displacements, with `count` frequencies at most."""
    # Pins `held` neither move nor turn; None: all pins keep their places and may turn, a single one may not.
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
        fixed, holding = [3 * k + axis for k in places for axis in range(3)], ", ".join(given)
    forces = inertia_loads(model)
    for name, load in loads.items():
        values = np.asarray(load(model.points) if callable(load) else load, dtype=float)
        if values.shape != model.points.shape or not np.isfinite(values).all():
            text = f"{model.label}: load {name!r} has the shape {values.shape}, or values that are not finite; it must"
            raise InputError(f"{text} be {model.points.shape}, one (x, y) for each of the points `model.points`.")
        forces[name] = model.force_of(values) if callable(load) else np.asarray(model.shape.T @ values.ravel())
    supported = Comparison(found, element, fixed)
    free, held_ones = (one.frequencies(count) for one in (Comparison(found, element, []), supported))
    under = dict(zip(forces, supported.under(np.stack(list(forces.values()), axis=1)), strict=True))
    left = float(found.held[found.vibrations]) if len(found.held) > found.vibrations else math.inf
    sizes = found.vibrations, found.shapes.shape[1], model.stiffness.shape[0]
    return Accuracy(model.label, *sizes, holding, free, held_ones, supported.compliance_error(), under, left)


def _shown(error: float) -> str:
    """An error in ten characters."""
    return f"{error:10.1e}" if abs(error) >= EXACT else f"{f'< {EXACT:.0e}':>10}"


def _over(error: float, size: float) -> float:
    """Relative error; 0 of nothing."""
    return error / size if size else 0.0


def deformed(shape: MeshShape, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Deformations (n, nodes, 3) of a reduced body in its frame by poses (n, nodes, 3); angle (n,) of it [rad]."""
    reference = np.array(shape.poses)
    angle = poses[:, 0, 2] - reference[0, 2]
    if shape.weights:
        weights = np.array(shape.weights)
        along = (weights * poses[..., :2]).sum(axis=(1, 2))
        angle = np.arctan2((weights[:, 0] * poses[..., 1] - weights[:, 1] * poses[..., 0]).sum(axis=1), along)
        turns = poses[:, 0, 2] - reference[0, 2] - angle
        angle = angle + 2.0 * np.pi * np.round(turns / (2.0 * np.pi))
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    d = np.empty_like(poses)
    d[..., 0] = c * poses[..., 0] + s * poses[..., 1] - reference[:, 0]
    d[..., 1] = c * poses[..., 1] - s * poses[..., 0] - reference[:, 1]
    d[..., 2] = poses[..., 2] - angle[:, None] - reference[:, 2]
    return d, angle


def shortened(d: np.ndarray, shortening: np.ndarray) -> np.ndarray:
    """Deformation e = d + c(d) (n, coordinates) of a reduced body from d (n, nodes, 3), with shortening by bending."""
    # The translation of the first node is left out, which has no stress but its round-off. `shortening` (k, n + 1, n)
    # has directions, each above its matrix; (k, n, n) in older files: matrices of the coordinates from the fourth on.
    e: np.ndarray = (d - d[:, :1] * np.array([1.0, 1.0, 0.0])).reshape(len(d), -1)
    if not len(shortening):
        return e
    matrices, n = shortening[:, -e.shape[1] :], e.shape[1]
    along = shortening[:, 0] if shortening.shape[1] > n else np.eye(n)[FIRST : FIRST + len(shortening)]
    e += 0.5 * np.einsum("ti,kij,tj->tk", e, matrices, e, optimize=True) @ along
    return e


# Findings on a run: large deformations, strain energy in the highest modes, loads and rotations without shapes

# Displacement in the frame of a reduced body over the size of the body [1], above which there is a finding, and above
# which the run is not ok.
LARGE_SHARE, IMPOSSIBLE_SHARE = 0.1, 0.5
MOST_POINTS = 100  # number of points of a body whose displacements are looked at
EDGE_SHARE = 0.1  # share of the strain energy in the highest modes [1] from which a basis is said to be too small
AT_EDGE = 3  # number of the highest modes that are looked at
# Displacement by the highest modes over the size of a body [1], up to which it is the error of steps.
# Default steps leave some 3e-9 in bodies that are so stiff that their deformation is smaller.
STEP_ERROR = 1e-8


def deformation_findings(body: Reduced, motion: WatchedMotion) -> Iterator[Finding]:
    """Findings on the deformations of a body at the poses of a motion."""
    names = [f"{body.name}.{node.name}.{axis}" for node in body.basis.nodes for axis in ("x", "y", "theta")]
    with np.errstate(all="ignore"):  # a run that blows up ends with numbers that are none
        d = deformed(body.moved_by, motion.rows(*names).reshape(len(motion.times), -1, 3))[0]
        d[..., :2] -= d[:, :1, :2]
    yield from _large(body, d.reshape(len(d), -1), motion)
    if np.isfinite(d).all():
        d = shortened(d, body.element.directions)
        whole = float(0.5 * np.einsum("ti,ij,tj->t", d, body.element.matrices["K"], d).max())
        # Finding on centrifugal forces that the kept shapes leave out, beside the largest strain energy [J]
        model, force = body.model, inertia_loads(body.model)["rotation"]
        speed, when = min(motion.peak(f"{body.name}.{pin.name}.omega") for pin in model.pins)
        moved, size = np.abs(model.shape @ body.basis.static(force)).max(), np.ptp(model.points, axis=0).max()
        left = speed**4 * left_out(body, force)[1]
        share = left / (whole + left) if left > 0.0 else 0.0
        if share > LEFT_OUT and speed**2 * moved > STEP_ERROR * size:
            text = f"{body.label}: at t = {when:.6g} s it turns at {speed:.4g} rad/s, and its kept shapes leave out "
            text += f"{100.0 * share:.3g} % of its strain energy, by centrifugal forces: stress inside is too small."
            remedy = "Keep their shape, Reduced(..., inertia_shapes=True), or more modes."
            yield found("missing-shapes", (body.name,), text, remedy, time=when, share=share, limit=LEFT_OUT)
        if body.basis.vibrations >= AT_EDGE:
            yield from _at_edge(body, d, motion.times, whole)


def _large(body: Reduced, d: np.ndarray, motion: WatchedMotion) -> Iterator[Finding]:
    """Finding on deformations d (t, n) by much of the size of a body."""
    # Largest displacements in the frame of a body over its size
    model = body.model
    points = np.linspace(0, len(model.points) - 1, min(MOST_POINTS, len(model.points))).astype(int)
    with np.errstate(all="ignore"):
        x, y = (d @ np.asarray(model.shape[2 * points + axis] @ body.basis.shapes).T for axis in (0, 1))
        shares = np.hypot(x, y).max(axis=1) / np.ptp(model.points, axis=0).max()
    shares = np.asarray(np.nan_to_num(shares, nan=np.inf))
    large = np.flatnonzero(np.append(shares, np.inf) > LARGE_SHARE)[0] if motion.failed else 0
    lost = next((k for k in range(int(large)) if _inertia_is_lost(body, d[k])), None)
    if lost is not None:
        when, share, wrong = lost, float(shares[lost]), True
        follows = ", and its frame follows the vibrations of one pin" if body.basis.by_pin else ""
        text = f"by {100.0 * share:.3g} % of its size{follows}; stiffening by rotation then takes away more inertia "
        text += "than it has."
        remedy = 'Take a second pin, such as its other end, with frame="chord", or stiffening=False, or the body with '
        remedy += "all its nodes."
    elif shares.max() > LARGE_SHARE:
        wrong = bool(shares.max() > IMPOSSIBLE_SHARE) or motion.failed
        when = int(np.argmax(shares > min(IMPOSSIBLE_SHARE, 0.99 * shares.max())))
        share = float(shares[when])
        moved = f"by {100.0 * share:.3g} % of its size" if share < 1.0 else "by more than its size"
        text = f"{moved}, {'beyond' if wrong else 'at the edge of'} the small deformations that a reduced body is for; "
        text += "its errors grow with the square of that share."
        chord = 'frame="chord", ' if body.basis.by_pin and body.basis.model.count > 3 else ""
        remedy = f"Take {chord}more pins, or the body with all its nodes."
    else:
        return
    time = float(motion.times[when])
    text = f"{body.label}: at t = {time:.6g} s it is deformed {text}"
    yield found("large-deformation", (body.name,), text, remedy, wrong=wrong, time=time, share=share)


def _inertia_is_lost(body: Reduced, d: np.ndarray) -> bool:
    """Whether the mass matrix of a body is not positive, since stiffening by rotation lessens its inertia."""
    matrices, Kc = body.element.matrices, body.element.centrifugal
    turning = np.zeros(len(d))
    turning[2] = 1.0
    if not body.basis.by_pin:
        shape = body.moved_by
        weights, poses = np.array(shape.weights), np.array(shape.poses) + d.reshape(-1, 3)
        size = (weights * poses[:, :2]).sum()
        turning = np.column_stack([-weights[:, 1], weights[:, 0], np.zeros(len(weights))]).ravel() / size
    across = np.outer(matrices["G"] @ d, turning)
    mass = matrices["M"] + across + across.T + np.outer(turning, turning) * (d @ (matrices["H"] - Kc) @ d)
    return bool(np.linalg.eigvalsh(mass)[0] < 0.0)


def _at_edge(body: Reduced, d: np.ndarray, time: np.ndarray, whole: float) -> Iterator[Finding]:
    """Finding on strain energy of the deformations d (t, n) in the highest modes."""
    pins, last = body.basis.model.count, slice(d.shape[1] - AT_EDGE, None)
    eta = d[:, last] - d[:, :pins] @ body.basis.followed[-AT_EDGE:].T
    edge = 0.5 * np.einsum("ti,ij,tj->t", eta, body.element.matrices["K"][last, last], eta)
    when, size = int(np.argmax(edge)), np.ptp(body.model.points, axis=0).max()
    moved = np.abs(eta * (1.0, 1.0, size)).max(axis=1)  # the shape of a rotation of 1 moves by the size
    share = float(edge[when]) / whole if moved[when] > STEP_ERROR * size else 0.0
    if share >= EDGE_SHARE:
        frequency, more = body.dropped_frequency, body.basis.vibrations + AT_EDGE
        text = f"{body.label}: at t = {time[when]:.6g} s its three highest modes hold {100.0 * share:.3g} % of its "
        text += "largest strain energy, so modes are missing."
        text += f" The lowest one left out has {frequency:.4g} Hz with held pins." if np.isfinite(frequency) else ""
        numbers = {"time": time[when], "share": share, "limit": EDGE_SHARE}
        yield found("missing-shapes", (body.name,), text, f"Keep more: modes={more}.", **numbers)
