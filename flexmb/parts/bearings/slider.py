"""Plane slider bearing: a slider in an oiled guide, and dry contact of its corners where the faces meet.

With the offset y of the slider across its guide, its tilt tau and the speed U along it, oil is squeezed or dragged into
the gap of one face at each place s along the slider, where g = y' - U tau/2 + s tau' says which; see (15.9).

Equations (15.9) and (15.10) of docs/theory/films.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY
from typing import ClassVar

import numpy as np

from flexmb.errors import InputError
from flexmb.fields import field, instance, record
from flexmb.kernels import compiled, signal_kernel
from flexmb.model.contributions import Contribution, signal_contributions
from flexmb.model.massless import massless
from flexmb.model.mechanism import Mechanism
from flexmb.parts.bearings.kernels import thickness
from flexmb.parts.bearings.laws import Oiled, ShortBearing
from flexmb.parts.joints.prismatic import PrismaticClearance
from flexmb.places import packed

# Parameters p: direction of the guide, points in the frames of their nodes, angle of the slider; gap on either side,
# height of the roughness, half of the length [m]; viscosity [Pa s], width [m]; number of the signal.
(UX, UY, S1X, S1Y, S2X, S2Y, ANGLE, GAP, HEIGHT, HALF, VISCOSITY, WIDTH, CHOSEN) = range(13)
NODES = 34
# Number of places along the slider, places from -1 to 1, weights: Gauss' rule, and the ends for the largest pressure.
PLACES, SHARES = ((-e, *own, e) for e, own in zip((1.0, 0.0), np.polynomial.legendre.leggauss(NODES - 2), strict=True))


@compiled
def pose(p, q):
    """Offset and tilt, direction of the guide, arm of the slider's point, D to it; derivatives of travel and offset."""
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ux, uy = c1 * p[UX] - d1 * p[UY], d1 * p[UX] + c1 * p[UY]
    bx, by = c2 * p[S2X] - d2 * p[S2Y], d2 * p[S2X] + c2 * p[S2Y]
    Dx, Dy = q[3] + bx - q[0], q[4] + by - q[1]
    offset = ux * Dy - uy * Dx - p[UX] * p[S1Y] + p[UY] * p[S1X]
    along = -ux, -uy, ux * Dy - uy * Dx, ux, uy, uy * bx - ux * by
    across = uy, -ux, -ux * Dx - uy * Dy, -uy, ux, ux * bx + uy * by
    return offset, q[5] - q[2] - p[ANGLE], ux, uy, bx, by, Dx, Dy, along, across


@compiled
def rates(travel, offset, v):
    """Speed along the guide, rates of offset and tilt; `travel`, `offset`: derivatives of both by q."""
    along, across = 0.0, 0.0
    for j in range(6):
        along, across = along + travel[j] * v[j], across + offset[j] * v[j]
    return along, across, v[5] - v[2]


@compiled
def pressed(p, y, tau, U, rate, turning):
    """Integrals of the pressure along the slider, and the largest |f|, f = g/H^3."""
    # They are those of f and f s, of the derivative of f by the offset times 1, s and s^2, of H^-3 times 1, s and s^2;
    # H is that of the face on which the oil presses at each place.
    g0, half, largest = rate - 0.5 * U * tau, p[HALF], 0.0
    f, fs, fy, fys, fyss, i0, i1, i2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(NODES):
        s, weight = half * PLACES[k], half * SHARES[k]
        g = g0 + turning * s
        side = 1.0 if g > 0.0 else -1.0
        H, H_h = thickness(p[GAP] - side * (y + s * tau), p[HEIGHT])
        inverse = 1.0 / (H * H * H)
        now = g * inverse
        largest, slope = max(largest, abs(now)), 3.0 * side * now * H_h / H * weight
        now, inverse = now * weight, inverse * weight
        f, fs = f + now, fs + now * s
        fy, fys, fyss = fy + slope, fys + slope * s, fyss + slope * s * s
        i0, i1, i2 = i0 + inverse, i1 + inverse * s, i2 + inverse * s * s
    return f, fs, fy, fys, fyss, i0, i1, i2, largest


@compiled
def sheared(p, y, tau):
    """Integral of 1/H over both faces, and its derivatives by offset and tilt."""
    whole, by_y, by_tau = 0.0, 0.0, 0.0
    for k in range(NODES):
        s, weight = p[HALF] * PLACES[k], p[HALF] * SHARES[k]
        for side in (-1.0, 1.0):
            H, H_h = thickness(p[GAP] - side * (y + s * tau), p[HEIGHT])
            slope = side * H_h / (H * H) * weight
            whole, by_y, by_tau = whole + weight / H, by_y + slope, by_tau + slope * s
    return whole, by_y, by_tau


@compiled
def force(p, y, tau, U, rate, turning):
    """Forces on the slider along travel, offset and tilt; rows of their derivatives by y, tau and the three rates."""
    k, drag, half = p[VISCOSITY] * p[WIDTH] ** 3, p[VISCOSITY] * p[WIDTH], 0.5 * tau
    f, fs, fy, fys, fyss, i0, i1, i2, _ = pressed(p, y, tau, U, rate, turning)
    shear, shear_y, shear_tau = sheared(p, y, tau)
    f_tau, fs_tau = fys - 0.5 * U * i0, fyss - 0.5 * U * i1
    return (
        (k * half * f - drag * U * shear, -k * f, -k * fs),
        (
            k * half * fy - drag * U * shear_y, k * (half * f_tau + 0.5 * f) - drag * U * shear_tau,
            -k * half * half * i0 - drag * shear, k * half * i0, k * half * i1,
        ),
        (-k * fy, -k * f_tau, k * half * i0, -k * i0, -k * i1),
        (-k * fys, -k * fs_tau, k * half * i1, -k * i1, -k * i2),
    )  # fmt: skip


@compiled
def put_residual(travel, offset, Fx, Fy, T, r):
    """r (6,) of the forces on the slider along travel and offset, and of their moment."""
    for j in range(6):
        r[j] = -Fx * travel[j] - Fy * offset[j]
    r[2] += T
    r[5] -= T


@compiled
def change(slopes, y, tau, U, rate, turning):
    """Change of a force by its derivatives."""
    by_y, by_tau, by_U, by_rate, by_turning = slopes
    return by_y * y + by_tau * tau + by_U * U + by_rate * rate + by_turning * turning


@compiled
def put_force(p, q, v, r):
    """r (6,) alone; energies, of which the film has the power that it takes."""
    y, tau, _, _, _, _, _, _, travel, offset = pose(p, q)
    U, rate, turning = rates(travel, offset, v)
    (Fx, Fy, T), _, _, _ = force(p, y, tau, U, rate, turning)
    put_residual(travel, offset, Fx, Fy, T, r)
    return 0.0, 0.0, -Fx * U - Fy * rate - T * turning


@compiled
def put_tangent(p, q, v, kq, kv, r, A):
    """r (6,), and A += kq dr/dq + kv dr/dv."""
    y, tau, ux, uy, bx, by, Dx, Dy, travel, offset = pose(p, q)
    U, rate, turning = rates(travel, offset, v)
    (Fx, Fy, T), of_Fx, of_Fy, of_T = force(p, y, tau, U, rate, turning)
    put_residual(travel, offset, Fx, Fy, T, r)
    gx, gy, own = (-1.0, 0.0, 0.0, 1.0, 0.0, -by), (0.0, -1.0, 0.0, 0.0, 1.0, bx), (0.0, 0.0, -1.0, 0.0, 0.0, 1.0)
    across, along = ux * Dy - uy * Dx, ux * Dx + uy * Dy
    vx, vy = 0.0, 0.0  # rate of D
    for j in range(6):
        vx, vy = vx + gx[j] * v[j], vy + gy[j] * v[j]
    for k in range(6):
        X_k, Y_k = (ux * gy[k] - uy * gx[k]) * v[2], -(ux * gx[k] + uy * gy[k]) * v[2]  # rates of both by q
        if k == 2:
            X_k, Y_k = -along * v[2] + ux * vy - uy * vx, -across * v[2] - ux * vx - uy * vy
        elif k == 5:
            X_k, Y_k = X_k - (ux * bx + uy * by) * v[5], Y_k + (uy * bx - ux * by) * v[5]
        a, b, c = kq * X_k + kv * travel[k], kq * Y_k + kv * offset[k], kv * own[k]
        if U == 0.0 and rate == 0.0 and turning == 0.0:  # at rest, where the film presses on the face that comes nearer
            (Fx_k, Fy_k, T_k), _, _, _ = force(p, y, tau, 0.5 * a, 0.5 * b, 0.5 * c)
            (Fx_m, Fy_m, T_m), _, _, _ = force(p, y, tau, -0.5 * a, -0.5 * b, -0.5 * c)
            Fx_k, Fy_k, T_k = Fx_k - Fx_m, Fy_k - Fy_m, T_k - T_m
        else:
            y_k, tau_k = kq * offset[k], kq * own[k]
            Fx_k, Fy_k = change(of_Fx, y_k, tau_k, a, b, c), change(of_Fy, y_k, tau_k, a, b, c)
            T_k = change(of_T, y_k, tau_k, a, b, c)
        for j in range(6):
            A[j, k] -= travel[j] * Fx_k + offset[j] * Fy_k + own[j] * T_k
        turned = kq * (Fx * (ux * gy[k] - uy * gx[k]) - Fy * (ux * gx[k] + uy * gy[k]))  # of the guide's direction
        A[2, k] -= turned
        if k != 2:
            A[k, 2] -= turned
    A[2, 2] += kq * (Fx * along + Fy * across)
    A[5, 5] += kq * (Fx * (ux * bx + uy * by) + Fy * (ux * by - uy * bx))


GUIDE_FILM = massless("GUIDE_FILM", globals())

THICKNESS, PRESSURE, POWER, NORMAL, DRAG, MOMENT = range(6)
# Signals with their units, in the order of `guide_film_signal`.
SIGNALS = (
    ("film_thickness", "m"), ("pressure", "Pa"), ("power", "W"), ("film_force", "N"), ("film_drag", "N"),
    ("film_moment", "N m"),
)  # fmt: skip


@signal_kernel
def guide_film_signal(p, t, q, v, a):
    """`CHOSEN`: place in `SIGNALS`; forces act on the slider."""
    which = int(p[CHOSEN])
    y, tau, _, _, _, _, _, _, travel, offset = pose(p, q)
    if which == THICKNESS:
        return p[GAP] - abs(y) - p[HALF] * abs(tau)
    U, rate, turning = rates(travel, offset, v)
    if which == PRESSURE:
        _, _, _, _, _, _, _, _, largest = pressed(p, y, tau, U, rate, turning)
        return 1.5 * p[VISCOSITY] * p[WIDTH] ** 2 * largest
    (Fx, Fy, T), _, _, _ = force(p, y, tau, U, rate, turning)
    if which == POWER:
        return -Fx * U - Fy * rate - T * turning
    return Fy if which == NORMAL else (Fx if which == DRAG else T)


@record
class SliderBearing(Oiled, PrismaticClearance):
    """Slider in an oiled guide: a film on both faces, and dry contact of the four corners through it.

    The film acts everywhere.  Where it is thinner than `roughness`, the corners touch through it with the given laws.

    Signals: those of `PrismaticClearance` for the dry contact, from the height of the roughness on; film_thickness
    (least of both faces) [m], pressure (largest of the film) [Pa], power (that the film turns into heat) [W];
    film_force (across the guide, positive to the left of `along`), film_drag (along it) [N], film_moment [N m], of the
    film on the slider about its centre.

    Raises
    ------
    InputError : a value out of range, a film of another kind, further ones of `PrismaticClearance`.

    Notes
    -----
    The faces are plane and the oil flows to the sides of the slider alone, so its width must be small beside its
    length: at a width of a tenth of the length a film of Reynolds' equation carries 10 % less, at a half 40 %.
    Gauss' rule of 32 places along the slider has errors of 0.2 % up to gaps of 1 to 40, and 2 % up to 1 to 200.
    Oil bears no tension: at each place it presses on one face.  The shear stress acts on both faces, all along.
    What the film takes is dissipated_damping in the balance of energies.
    """

    _: KW_ONLY
    film: ShortBearing = field(
        "film of oil", rule=instance(ShortBearing, "a film, e.g. ShortBearing(viscosity=0.02, width=0.012)")
    )

    lost_when: ClassVar[str] = "the slider passes through its guide"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.film.cavitation != "positive":
            text = f'{self.label}: the film of a guide has cavitation="positive";'
            raise InputError(f'{text} it is "{self.film.cavitation}".')

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        ideal = self.ideal(mechanism)
        numbers = dict(enumerate(ideal.p)) | {
            GAP: self.clearance, HEIGHT: self.roughness, HALF: self.half_length,
            VISCOSITY: self.film.viscosity, WIDTH: self.film.width, CHOSEN: 0.0,
        }  # fmt: skip
        p = packed(numbers)
        signals = signal_contributions(self.name, guide_film_signal, SIGNALS, ideal.coordinates, p[:CHOSEN])
        return [*super().contributions(mechanism), GUIDE_FILM.contribution(self.name, ideal.coordinates, p), *signals]
