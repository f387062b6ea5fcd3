"""Journal bearing with a short film whose bearing or journal wears: the film has the worn thickness at each angle.

In the axes of the worn body, at the angles of the profile: h = c + depth - e . u, its slope h', w the spin of the
other body against it.  With y = (u, h') and the rates of thinning s = u . e_dot - w h'/2, the film presses with
P = C s/h^3 where s > 0, and its power is the sum of P s, so r = sum of P ds/dv.

Equations (16.10) and (16.11) of docs/theory/wear.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import fields

import numpy as np

from flexmb.errors import InputError
from flexmb.fields import record
from flexmb.findings.finding import Finding
from flexmb.kernels import (
    account_kernel,
    compiled,
    element_kernel,
    energy_kernel,
    force_kernel,
    signal_kernel,
    tangent_kernel,
)
from flexmb.model.contributions import Contribution, ElementContribution, signal_contributions
from flexmb.model.mechanism import Mechanism
from flexmb.parts.bearings.coefficients import FilmEquilibrium
from flexmb.parts.bearings.journal import JournalBearing
from flexmb.parts.bearings.kernels import SIGNALS, thickness
from flexmb.parts.bearings.laws import ShortBearing
from flexmb.parts.wear.worn_clearance import WornClearance

OFFSET1_X, OFFSET1_Y, OFFSET2_X, OFFSET2_Y, ON_JOURNAL, HEIGHT, FORCE, DRAG, WIDTH, RADIUS = range(10)
"""Parameters p: points in the frames of their nodes, whether the journal wears, roughness, scales of force and drag of
an angle, width, radius; of a signal its number comes last."""

TABLES = 10
"""Place of the first number of the tables by angle: cosine, sine, thickness about the centred journal, its slope."""


@compiled
def place(p, q, v):
    """Eccentricity and its rate in the axes of the worn body; their derivatives by q; w, w by v, cosine and sine."""
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ax, ay = c1 * p[OFFSET1_X] - d1 * p[OFFSET1_Y], d1 * p[OFFSET1_X] + c1 * p[OFFSET1_Y]
    bx, by = c2 * p[OFFSET2_X] - d2 * p[OFFSET2_Y], d2 * p[OFFSET2_X] + c2 * p[OFFSET2_Y]
    X, Y = q[3] + bx - q[0] - ax, q[4] + by - q[1] - ay
    worn, other = (5, 2) if p[ON_JOURNAL] > 0.0 else (2, 5)
    C, S, spin = math.cos(q[worn]), math.sin(q[worn]), v[worn]
    ex, ey = C * X + S * Y, C * Y - S * X
    A, B = (C * ax + S * ay, C * ay - S * ax), (C * bx + S * by, C * by - S * bx)
    gx = (-C, -S, A[1], C, S, -B[1])
    gy = (S, -C, -A[0], -S, C, B[0])
    vx, vy = ey * spin, -ex * spin
    for k in range(6):
        vx, vy = vx + gx[k] * v[k], vy + gy[k] * v[k]
    return ex, ey, vx, vy, gx, gy, A, B, worn, other, spin, v[other] - spin, C, S


@compiled
def sums(p, ex, ey, vx, vy, w):
    """Sums over the angles with P = W s and Q = dP/dh: P y; W y y'; Q y u'; drag and its derivative by e; the rest.

    The rest is power, least gap, largest P, and the sum of all s > 0.
    """
    n = (p.shape[0] - TABLES) // 4
    m0, m1, m2, w00, w01, w11, w02, w12, w22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    q00, q01, q11, q02, q12, drag, by_x, by_y = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    power, least, peak, flow = 0.0, math.inf, 0.0, 0.0
    for i in range(n):
        x, y = p[TABLES + i], p[TABLES + n + i]
        gap = p[TABLES + 2 * n + i] - ex * x - ey * y
        slope = p[TABLES + 3 * n + i] + ex * y - ey * x
        h, fall = thickness(gap, p[HEIGHT])
        shear = p[DRAG] / h
        least, drag = min(least, gap), drag + shear
        by_x, by_y = by_x + shear * fall / h * x, by_y + shear * fall / h * y
        s = x * vx + y * vy - 0.5 * w * slope
        if s < 0.0:
            continue
        W = (
            p[FORCE] / (h * h * h) * (1.0 if s > 0.0 else 0.5)
        )  # at rest it presses on the side to which the journal goes
        P, Q = W * s, -3.0 * W * s * fall / h
        power, flow, peak = power + P * s, flow + s, max(peak, P)
        m0, m1, m2 = m0 + P * x, m1 + P * y, m2 + P * slope
        w00, w01, w11 = w00 + W * x * x, w01 + W * x * y, w11 + W * y * y
        w02, w12, w22 = w02 + W * x * slope, w12 + W * y * slope, w22 + W * slope * slope
        q00, q01, q11 = q00 + Q * x * x, q01 + Q * x * y, q11 + Q * y * y
        q02, q12 = q02 + Q * slope * x, q12 + Q * slope * y
    rest = power + drag * w * w, least, peak, flow
    return (m0, m1, m2), (w00, w01, w11, w02, w12, w22), (q00, q01, q11, q02, q12), (drag, by_x, by_y), rest


@compiled
def put_force(p, q, v, r):
    """r (6,) alone; returns the power that the film takes."""
    ex, ey, vx, vy, gx, gy, _, _, worn, other, _, w, _, _ = place(p, q, v)
    m, _, _, drag, rest = sums(p, ex, ey, vx, vy, w)
    turning = drag[0] * w - 0.5 * m[2]
    for k in range(6):
        r[k] += gx[k] * m[0] + gy[k] * m[1]
    r[worn] += ey * m[0] - ex * m[1] - turning
    r[other] += turning
    return rest[0]


@compiled
def bend(k, l, worn, ex, ey, gx, gy, a, b):
    """Second derivatives of e by coordinates k and l; the axes turn with the worn body."""
    x, y = 0.0, 0.0
    if k == worn:
        x, y = x + gy[l], y - gx[l]
    if l == worn:
        x, y = x + gy[k], y - gx[k]
    if k == worn and l == worn:
        x, y = x - ex, y - ey
    if k == 2 and l == 2:
        x, y = x + a[0], y + a[1]
    elif k == 5 and l == 5:
        x, y = x - b[0], y - b[1]
    return x, y


@compiled
def put_tangent(p, q, v, kq, kv, r, A):
    """r (6,), and A += kq dr/dq + kv dr/dv."""
    ex, ey, vx, vy, gx, gy, a, b, worn, _, _, w, _, _ = place(p, q, v)
    m, W, Q, drag, _ = sums(p, ex, ey, vx, vy, w)
    on = 1.0 if worn == 2 else 0.0
    off = 1.0 - on
    fx = (gx[0], gx[1], gx[2] + on * ey, gx[3], gx[4], gx[5] + off * ey)  # de/dq
    fy = (gy[0], gy[1], gy[2] - on * ex, gy[3], gy[4], gy[5] - off * ex)
    fz = (0.0, 0.0, on - 0.5, 0.0, 0.0, off - 0.5)  # ds/dv = fx y0 + fy y1 + fz y2
    for l in range(6):
        x, y = fx[l], fy[l]
        sx, sy = 0.5 * w * y, -0.5 * w * x  # derivative of s
        for k in range(6):
            ax, ay = bend(k, l, worn, ex, ey, gx, gy, a, b)
            sx, sy = sx + ax * v[k], sy + ay * v[k]
        sx, sy, sz = kq * sx + kv * x, kq * sy + kv * y, kv * fz[l]
        px = W[0] * sx + W[1] * sy + W[3] * sz - kq * (Q[0] * x + Q[1] * y)  # derivatives of P y
        py = W[1] * sx + W[2] * sy + W[4] * sz - kq * (Q[1] * x + Q[2] * y)
        pz = W[3] * sx + W[4] * sy + W[5] * sz - kq * (Q[3] * x + Q[4] * y + m[0] * y - m[1] * x)
        turning = kq * (drag[1] * x + drag[2] * y) * w - 2.0 * kv * drag[0] * fz[l]
        r[l] += x * m[0] + y * m[1] + fz[l] * (m[2] - 2.0 * drag[0] * w)
        for k in range(6):
            ax, ay = bend(k, l, worn, ex, ey, gx, gy, a, b)
            A[k, l] += fx[k] * px + fy[k] * py + fz[k] * (pz - 2.0 * turning) + kq * (m[0] * ax + m[1] * ay)


@element_kernel
def worn_film_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Forces of the film on both bodies, and their tangents."""
    put_tangent(p, q, v, 1.0, 0.0, r, K)
    r[:] = 0.0
    put_tangent(p, q, v, 0.0, 1.0, r, C)


@force_kernel
def worn_film_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (6,) alone."""
    put_force(p, q, v, r)


@tangent_kernel
def worn_film_tangent(p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new):
    """Residual r (6,), and A = kq K + kv C."""
    put_tangent(p, q, v, kq, kv, r, A)


@energy_kernel
def worn_film_energy(p, t, q, v):
    """No strain energy, no weight, power that the film turns into heat."""
    ex, ey, vx, vy, _, _, _, _, _, _, _, w, _, _ = place(p, q, v)
    return 0.0, 0.0, sums(p, ex, ey, vx, vy, w)[4][0]


@account_kernel
def worn_film_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """Residual r (6,); no mass; energies as `worn_film_energy` gives them."""
    return 0.0, 0.0, put_force(p, q, v, r)


@signal_kernel
def worn_film_signal(p, t, q, v, a):
    """Signals of a film in the order of `SIGNALS`; forces act on the second body."""
    ex, ey, vx, vy, _, _, _, _, worn, _, _, w, C, S = place(p, q, v)
    m, _, _, drag, (power, least, peak, flow) = sums(p, ex, ey, vx, vy, w)
    area = p[WIDTH] * p[RADIUS] * 8.0 * math.pi / (p.shape[0] - TABLES - 1)
    across, along, turning = ey * m[0] - ex * m[1], ex * m[0] + ey * m[1], drag[0] * w - 0.5 * m[2]
    attitude = math.atan2(across, along) if across != 0.0 or along != 0.0 else 0.0
    torque = -turning if worn == 2 else turning - across
    found = (least, 1.5 * peak / area, power, flow * area, attitude, S * m[1] - C * m[0], -S * m[0] - C * m[1], torque)
    return found[int(p[p.shape[0] - 1])]


@record
class WornBearing(WornClearance, JournalBearing):
    """Journal bearing with a short film and a worn surface, made by `JournalBearing.worn_by`.

    The film has the worn thickness at each angle.  Where it falls below the roughness the surfaces touch through it,
    as those of `WornClearance` do, and this contact alone wears.

    Signals: those of `JournalBearing` and of `WornClearance`; film_thickness is the least one, at the angles of the
    profile.

    Raises
    ------
    InputError : a film that is not a `ShortBearing` with positive pressure, further ones of `JournalBearing` and
        `WornClearance`.

    Notes
    -----
    The film is Ocvirk's with any thickness around, by the sum over the angles of the profile; 360 of them give its
    force to 1e-3 up to an eccentricity of 0.95.  Equilibria and coefficients are those of the unworn bearing alone.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        short = self.film if isinstance(self.film, ShortBearing) else None
        if short is None or short.cavitation != "positive":
            text = f"{self.label}: film is {self.film!r}; with a worn surface it must be"
            raise InputError(f'{text} ShortBearing(..., cavitation="positive"), known for any thickness around.')

    @property
    def width(self) -> float:
        """Width of the surfaces [m]; that of the film where the law of wear has none."""
        return self.film.width if self.wear.width is None else self.wear.width

    def equilibrium(self, load: float, speed: float, direction: float = -0.5 * math.pi) -> FilmEquilibrium:
        """As of `JournalBearing`, of an unworn bearing.

        Raises
        ------
        InputError : a worn surface, further ones of `JournalBearing.equilibrium`.
        """
        if any(self.profile):
            text = f"{self.label}: its equilibrium is not known in closed form, since it is worn"
            raise InputError(f"{text}. Let a run come to rest, or ask the unworn JournalBearing.")
        own = {one.name: getattr(self, one.name) for one in fields(JournalBearing)}
        return JournalBearing(**own).equilibrium(load, speed, direction)

    def film_numbers(self, first: tuple[float, float], second: tuple[float, float]) -> tuple[float, ...]:
        """Parameters of the kernels of the film; `first`, `second`: offsets of both points [m]."""
        oil, depths, step = self.film, self.depths, 2.0 * math.pi / self.bins
        slope = (np.roll(depths, -1) - np.roll(depths, 1)) / (2.0 * step)
        force = oil.viscosity * oil.width**3 * self.bearing_radius * step
        drag = oil.viscosity * oil.width * self.bearing_radius**3 * step
        own = (*first, *second, float(self.on_journal), self.roughness, force, drag, oil.width, self.bearing_radius)
        tables = (np.cos(self.places), np.sin(self.places), self.clearance + depths, slope)
        return (*own, *np.concatenate(tables).tolist())

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """Contact, angle and start of the worn joint, and the film with its signals."""
        first, second = self.ends(mechanism)
        coordinates, p = (*first.coordinates, *second.coordinates), self.film_numbers(first.offset, second.offset)
        film = ElementContribution(
            self.name, worn_film_kernel, coordinates, p, energy=worn_film_energy, force=worn_film_force,
            tangent=worn_film_tangent, account=worn_film_account,
        )  # fmt: skip
        signals = signal_contributions(self.name, worn_film_signal, SIGNALS, coordinates, p)
        return [*super().contributions(mechanism), film, *signals]

    def findings_before(self, mechanism: Mechanism) -> Iterator[Finding]:
        """Finding on a gap that is not thin."""
        return JournalBearing.findings_before(self, mechanism)
