"""End bosses: point masses that give a beam model a prescribed mass, centre of mass and moment of inertia exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.errors import InputError

Point = tuple[float, float]


@dataclass(frozen=True)
class RigidProperties:
    """Mass [kg], centre of mass [m] and moment of inertia about the centre [kg m^2] of a body as declared."""

    mass: float
    centre: Point
    inertia: float

    @staticmethod
    def of(parts: list[tuple[float, Point, float]]) -> RigidProperties:
        """Sum of rigid parts given as (mass, centre, inertia about the centre)."""
        masses = np.array([m for m, _, _ in parts])
        centres = np.array([c for _, c, _ in parts])
        inertias = np.array([j for _, _, j in parts])
        mass = float(masses.sum())
        centre = masses @ centres / mass
        inertia = inertias.sum() + masses @ ((centres - centre) ** 2).sum(axis=1)
        return RigidProperties(mass, (float(centre[0]), float(centre[1])), float(inertia))


@dataclass(frozen=True)
class Bosses:
    """Masses at the corners [kg], moment of inertia of each boss [kg m^2], mass at the mean of the corners [kg]."""

    masses: tuple[float, ...]
    inertia: float
    mean_mass: float

    @property
    def empty(self) -> bool:
        """Whether nothing is added."""
        return not any(self.masses) and self.inertia == 0.0 and self.mean_mass == 0.0


def fit_bosses(label: str, beam: RigidProperties, wanted: RigidProperties, corners: list[Point]) -> Bosses:
    """Bosses that turn the mass properties of the bare `beam` into the `wanted` ones.

    Unknowns are one mass a corner, one moment of inertia common to all corners and, with three corners or more, a mass
    at their mean; none may be negative.  Among several solutions the one of least norm is taken.  Wanted values that
    cannot be reached by adding mass at these places are refused with the difference.
    """
    points = np.array(corners)
    places = [*points, points.mean(axis=0)] if len(corners) > 2 else list(points)
    centre = np.array(wanted.centre)
    radius = max(float(np.abs(points - centre).max()), 1e-12)
    mass = wanted.mass - beam.mass
    if mass < -1e-9 * wanted.mass:
        raise InputError(
            f"{label}: mass is {wanted.mass:g} kg, but the beams alone weigh {beam.mass:g} kg. "
            "Give a larger mass, a smaller section or density, or leave mass out."
        )
    moment = wanted.mass * centre - beam.mass * np.array(beam.centre)
    shift = np.array(beam.centre) - centre
    inertia = wanted.inertia - beam.inertia - beam.mass * float(shift @ shift)
    columns = [[1.0, *((p - centre) / radius), float((p - centre) @ (p - centre)) / radius**2] for p in places]
    columns.append([0.0, 0.0, 0.0, 1.0])  # the common moment of inertia, in units of mass radius^2
    A = np.array(columns).T
    b = np.array([mass, *((moment - mass * centre) / radius), inertia / radius**2])
    x = _least_norm_not_negative(A, b, wanted.mass)
    if x is None:
        raise InputError(
            f"{label}: mass {wanted.mass:g} kg, inertia {wanted.inertia:g} kg m^2 with the centre of mass at "
            f"({wanted.centre[0]:.4g}, {wanted.centre[1]:.4g}) m cannot be reached by bosses at the corners: "
            f"they have {mass:.4g} kg and {inertia:.4g} kg m^2 to add. "
            f"{_advice(mass, inertia, places, centre)}"
        )
    n = len(corners)
    return Bosses(tuple(float(v) for v in x[:n]), float(x[-1]) * radius**2 / n, float(x[n]) if n > 2 else 0.0)


def _least_norm_not_negative(A: np.ndarray, b: np.ndarray, scale: float) -> np.ndarray | None:
    """The x >= 0 of least norm with A x = b, or None."""
    from scipy.optimize import nnls  # noqa: PLC0415 - takes long to import, and only bosses need it

    small = 1e-7
    n = A.shape[1]
    rough, _ = nnls(np.vstack([A, small * np.eye(n)]), np.concatenate([b, np.zeros(n)]))
    active = rough > 1e-6 * scale
    x = np.zeros(n)
    x[active] = np.linalg.lstsq(A[:, active], b, rcond=None)[0]
    good = np.abs(A @ x - b).max() <= 1e-9 * scale and x.min() >= 0.0
    if not good:
        x, _ = nnls(A, b)
        good = np.abs(A @ x - b).max() <= 1e-9 * scale
    return x if good else None


def _advice(mass: float, inertia: float, places: list[np.ndarray], centre: np.ndarray) -> str:
    """Advice for values that bosses cannot give."""
    reach = [float((p - centre) @ (p - centre)) for p in places]
    low, high = mass * min(reach), mass * max(reach)
    if inertia < low:
        return f"Masses there add at least {low:.4g} kg m^2: give a larger inertia or a lighter beam."
    if inertia > high:
        return f"Masses there add about {high:.4g} kg m^2: check the inertia and the centre of mass."
    return "Check the centre of mass: it must lie between the places where mass can be added."
