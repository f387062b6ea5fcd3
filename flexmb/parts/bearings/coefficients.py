"""Journal at rest in its film under a constant load: place, stiffness, damping, limit of stability."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.optimize

from flexmb import checks
from flexmb.errors import InputError
from flexmb.parts.bearings import kernels
from flexmb.parts.bearings.film import PADS

TRIED = 72  # number of angles of a bearing with grooves between which its place under a load is found
MOST = 2000  # number of iterations in which an eccentricity is found


@dataclass(frozen=True)
class FilmEquilibrium:
    """Journal that a film carries at a constant load and speed; axes along the load, and 90 degrees ahead in the spin.

    Parameters
    ----------
    eccentricity : over the clearance.
    attitude : angle from the load to the line of centres, in the direction of the spin [rad].
    stiffness, damping : coefficients (2, 2) of the film [N/m, N s/m]: minus the derivatives of its force.
    film_thickness, pressure, power, flow : as the signals of the joint [m, Pa, W, m3/s].
    equivalent_stiffness : stiffness of the film against the whirl at the limit of stability [N/m].
    whirl_ratio : whirl over spin there; 0: the journal is stable at every mass.
    critical_mass : mass carried by the film above which a rigid rotor whirls at this speed [kg]; inf: none.
    """

    eccentricity: float
    attitude: float
    stiffness: np.ndarray
    damping: np.ndarray
    film_thickness: float
    pressure: float
    power: float
    flow: float
    equivalent_stiffness: float
    whirl_ratio: float
    critical_mass: float


def equilibrium(
    label: str, p: tuple[float, ...], play: float, load: float, speed: float, direction: float
) -> FilmEquilibrium:
    """Equilibrium of a film of parameters `p` under a `load` [N] at a `speed` [rad/s], at eccentricities up to `play`.

    `direction`: of the load in the bearing [rad].  An `InputError` in the name of `label` tells a load that the film
    cannot carry.
    """
    direction = checks.number(label, "direction", direction, "rad")
    load, speed = checks.positive(label, "load", load, "N"), checks.number(label, "speed", speed, "rad/s")
    if speed == 0.0:
        raise InputError(f"{label}: speed is 0 rad/s; a film carries a constant load at a speed alone.")
    numbers = np.array(p)

    def beyond(e: float, turn: float) -> float:
        return float(np.hypot(*_force(numbers, e, speed, turn)[0])) - load

    def under(turn: float) -> float:
        """Eccentricity at which the film carries the load, or `play`."""
        if beyond(play, turn) < 0.0:
            return play
        return float(
            scipy.optimize.brentq(beyond, 0.0, play, args=(turn,), xtol=sys.float_info.min, rtol=1e-15, maxiter=MOST)
        )

    places = {turn: under(turn) for turn in _turns(numbers, under, speed, direction)}
    short = {turn: beyond(e, turn) for turn, e in places.items() if e == play and beyond(e, turn) < 0.0}
    if len(short) == len(places):
        most = load + max(short.values(), default=-load)
        raise InputError(
            f"{label}: load is {load:g} N; at {speed:g} rad/s the film carries up to {most:.4g} N before the surfaces "
            "touch. Lower the load, or give a higher speed, a thicker oil or less roughness."
        )
    turn, e = next((turn, e) for turn, e in places.items() if turn not in short)
    F, K, B = _force(numbers, e, speed, turn)
    F = -F / np.hypot(*F)
    axes = np.array([F, math.copysign(1.0, speed) * np.array([-F[1], F[0]])])  # rows: load, and ahead of it in the spin
    K, B = axes @ K @ axes.T, axes @ B @ axes.T
    q, v = np.array([0.0, 0.0, turn, e, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 0.0, 0.0, speed])
    told = []
    for k in range(4):
        numbers[kernels.CHOSEN] = k
        told.append(kernels.film_signal.dispatcher(numbers, 0.0, q, v, v))
    attitude = math.atan2(axes[1, 0], axes[0, 0])
    eps, (thickness, pressure, power, flow) = float(e / numbers[kernels.CLEARANCE]), told
    return FilmEquilibrium(eps, attitude, K, B, thickness, pressure, power, flow, *_whirl(K, B, speed))


def _turns(p: np.ndarray, under: Callable[[float], float], speed: float, direction: float) -> list[float]:
    """Angles of a bearing with grooves for which the film carries a load along `direction` with the journal at (e, 0).

    `under`: eccentricity e by angle.  First is the angle to which the load's own direction is nearest, ahead in spin.
    """
    if p[kernels.KIND] != PADS:
        return [0.0]

    def ahead(turn: float) -> float:
        F = _force(p, under(turn), speed, turn)[0]
        return math.remainder(math.atan2(-F[1], -F[0]) - turn - direction, 2.0 * math.pi)

    turns = -direction - math.copysign(1.0, speed) * np.linspace(0.0, 2.0 * math.pi, TRIED + 1)
    found = [ahead(turn) for turn in turns]
    crossed = [k for k in range(TRIED) if found[k] * found[k + 1] <= 0.0 and abs(found[k] - found[k + 1]) < math.pi]
    return [float(scipy.optimize.brentq(ahead, turns[k], turns[k + 1], xtol=1e-13)) for k in crossed]


def _force(p: np.ndarray, e: float, speed: float, turn: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Force (2,) on a journal at (e, 0) in a bearing turned by `turn`, its stiffness and damping (2, 2)."""
    q, v = np.array([0.0, 0.0, turn, e, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 0.0, 0.0, speed])
    r, K, C, M, none = np.zeros(6), np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6)), np.zeros(0)
    kernels.JOURNAL_FILM.element.dispatcher(p, 0.0, 0.0, q, v, np.zeros(6), none, r, K, C, M, none)
    return -r[3:5], K[3:5, 3:5], C[3:5, 3:5]


def _whirl(K: np.ndarray, B: np.ndarray, speed: float) -> tuple[float, float, float]:
    """Equivalent stiffness, whirl ratio and critical mass: where a rigid mass vibrates without growing or dying out."""
    # Equation (15.8) of docs/theory/films.md.
    k = K[0, 0] * B[1, 1] + K[1, 1] * B[0, 0] - K[0, 1] * B[1, 0] - K[1, 0] * B[0, 1]
    k /= B[0, 0] + B[1, 1]
    square = (K[0, 0] - k) * (K[1, 1] - k) - K[0, 1] * K[1, 0]
    square /= speed**2 * (B[0, 0] * B[1, 1] - B[0, 1] * B[1, 0])
    if square <= 0.0:
        return float(k), 0.0, math.inf
    return float(k), math.sqrt(square), float(k / (square * speed**2))
