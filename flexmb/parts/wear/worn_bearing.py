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
from flexmb.kernels import compiled, signal_kernel, summing
from flexmb.model.contributions import Contribution, signal_contributions
from flexmb.model.massless import massless
from flexmb.model.mechanism import Mechanism
from flexmb.parts.bearings import kernels
from flexmb.parts.bearings.journal import FilmEquilibrium, JournalBearing
from flexmb.parts.bearings.laws import ShortBearing
from flexmb.parts.joints.contact_point import arms_of
from flexmb.parts.wear.worn_clearance import WornClearance

# Parameters p: points in the frames of their nodes, whether the journal wears, roughness, scales of force and drag of
# an angle, width, radius; of a signal its number comes last.
OFFSET1_X, OFFSET1_Y, OFFSET2_X, OFFSET2_Y, ON_JOURNAL, HEIGHT, FORCE, DRAG, WIDTH, RADIUS = range(10)
# Place of the first number of the tables by angle: cosine, sine, thickness about the centred journal, its slope.
TABLES = 10


@compiled
def place(p, q, v):
    """Eccentricity and its rate in the axes of the worn body; their derivatives by q; w, w by v, cosine and sine."""
    ax, ay, bx, by, X, Y = arms_of(p[OFFSET1_X], p[OFFSET1_Y], p[OFFSET2_X], p[OFFSET2_Y], q)
    worn, other = (5, 2) if p[ON_JOURNAL] > 0.0 else (2, 5)
    C, S, spin = math.cos(q[worn]), math.sin(q[worn]), v[worn]
    ex, ey = C * X + S * Y, C * Y - S * X
    ax, ay, bx, by = C * ax + S * ay, C * ay - S * ax, C * bx + S * by, C * by - S * bx
    gx = (-C, -S, ay, C, S, -by)
    gy = (S, -C, -ax, -S, C, bx)
    vx, vy = ey * spin, -ex * spin
    for k in range(6):
        vx, vy = vx + gx[k] * v[k], vy + gy[k] * v[k]
    return ex, ey, vx, vy, gx, gy, ax, ay, bx, by, worn, other, v[other] - spin, C, S


@compiled
def tables(p):
    """Cosines and sines of the angles, thickness about the centred journal, its slope."""
    n = (p.shape[0] - TABLES) // 4
    sin, gap, slope = TABLES + n, TABLES + 2 * n, TABLES + 3 * n
    return p[TABLES:sin], p[sin:gap], p[gap:slope], p[slope : slope + n]


@summing
def touches(p, ex, ey):
    """Number of angles at which the film is thinner than the roughness."""
    X, Y, gaps, _ = tables(p)
    found, height = 0, p[HEIGHT]
    for i in range(X.shape[0]):
        found += gaps[i] - ex * X[i] - ey * Y[i] < height
    return found


@summing
def sums(p, ex, ey, vx, vy, w):
    """Sums over the angles of P y; drag; power."""
    X, Y, gaps, slopes = tables(p)
    height, rough = p[HEIGHT], touches(p, ex, ey) > 0
    ax, ay, az = vx + 0.5 * w * ey, vy - 0.5 * w * ex, -0.5 * w  # s by the tables
    m0, m1, m2, drag = 0.0, 0.0, 0.0, 0.0
    for i in range(X.shape[0]):
        h = gaps[i] - ex * X[i] - ey * Y[i]
        if rough and h < height:
            h, _ = kernels.thickness(h, height)
        s, thin = ax * X[i] + ay * Y[i] + az * slopes[i], 1.0 / h
        P = thin * thin * thin * (0.0 if s < 0.0 else s)
        m0, m1, m2, drag = m0 + P * X[i], m1 + P * Y[i], m2 + P * slopes[i], drag + thin
    m0, m1, m2, drag = p[FORCE] * m0, p[FORCE] * m1, p[FORCE] * m2, p[DRAG] * drag
    return m0, m1, m2 + ex * m1 - ey * m0, drag, ax * m0 + ay * m1 + az * m2 + drag * w * w


@compiled
def extremes(p, ex, ey, vx, vy, w):
    """Least gap, largest P, sum of all s > 0."""
    X, Y, gaps, slopes = tables(p)
    least, peak, flow = math.inf, 0.0, 0.0
    for i in range(X.shape[0]):
        gap = gaps[i] - ex * X[i] - ey * Y[i]
        h, _ = kernels.thickness(gap, p[HEIGHT])
        s = max(X[i] * vx + Y[i] * vy - 0.5 * w * (slopes[i] + ex * Y[i] - ey * X[i]), 0.0)
        least, peak, flow = min(least, gap), max(peak, p[FORCE] * s / (h * h * h)), flow + s
    return least, peak, flow


@summing
def stiffness(p, ex, ey, vx, vy, w):
    """Sums of W y y' with P = W s, of dP/dh y u', and derivatives of the drag by e."""
    # A film at rest presses on the side to which the journal goes: of both sides the mean counts.
    X, Y, gaps, slopes = tables(p)
    height, rough = p[HEIGHT], touches(p, ex, ey) > 0
    w00, w01, w11, w02, w12, w22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    q00, q01, q11, q02, q12, by_x, by_y = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(X.shape[0]):
        x, y, fall = X[i], Y[i], 1.0
        h, slope = gaps[i] - ex * x - ey * y, slopes[i] + ex * y - ey * x
        if rough and h < height:
            h, fall = kernels.thickness(h, height)
        s, thin = x * vx + y * vy - 0.5 * w * slope, 1.0 / h
        grows = fall * thin
        shear = thin * grows
        by_x, by_y = by_x + shear * x, by_y + shear * y
        W = thin * thin * thin * (1.0 if s > 0.0 else (0.0 if s < 0.0 else 0.5))
        Q = -3.0 * W * s * grows
        w00, w01, w11 = w00 + W * x * x, w01 + W * x * y, w11 + W * y * y
        w02, w12, w22 = w02 + W * x * slope, w12 + W * y * slope, w22 + W * slope * slope
        q00, q01, q11 = q00 + Q * x * x, q01 + Q * x * y, q11 + Q * y * y
        q02, q12 = q02 + Q * slope * x, q12 + Q * slope * y
    F, D = p[FORCE], p[DRAG]
    W, Q = (F * w00, F * w01, F * w11, F * w02, F * w12, F * w22), (F * q00, F * q01, F * q11, F * q02, F * q12)
    return W, Q, D * by_x, D * by_y


@compiled
def put_force(p, q, v, r):
    """r (6,) alone; energies, of which the film has the power that it takes."""
    ex, ey, vx, vy, gx, gy, _, _, _, _, worn, other, w, _, _ = place(p, q, v)
    m0, m1, m2, drag, taken = sums(p, ex, ey, vx, vy, w)
    turning = drag * w - 0.5 * m2
    for k in range(6):
        r[k] = gx[k] * m0 + gy[k] * m1
    r[worn] += ey * m0 - ex * m1 - turning
    r[other] += turning
    return 0.0, 0.0, taken


@compiled
def bend(k, l, worn, ex, ey, gx, gy, ax, ay, bx, by):
    """Second derivatives of e by coordinates k and l; the axes turn with the worn body."""
    x, y = 0.0, 0.0
    if k == worn:
        x, y = x + gy[l], y - gx[l]
    if l == worn:
        x, y = x + gy[k], y - gx[k]
    if k == worn and l == worn:
        x, y = x - ex, y - ey
    if k == 2 and l == 2:
        x, y = x + ax, y + ay
    elif k == 5 and l == 5:
        x, y = x - bx, y - by
    return x, y


@compiled
def put_tangent(p, q, v, kq, kv, r, A):
    """r (6,), and A += kq dr/dq + kv dr/dv."""
    ex, ey, vx, vy, gx, gy, ax, ay, bx, by, worn, other, w, _, _ = place(p, q, v)
    m0, m1, m2, drag, _ = sums(p, ex, ey, vx, vy, w)
    (w00, w01, w11, w02, w12, w22), (q00, q01, q11, q02, q12), by_x, by_y = stiffness(p, ex, ey, vx, vy, w)
    for l in range(6):
        x, y, z = gx[l], gy[l], 0.0  # de/dq, and ds/dv = x y0 + y y1 + z y2
        if l == worn:
            x, y, z = x + ey, y - ex, 0.5
        elif l == other:
            z = -0.5
        sx, sy = 0.5 * w * y, -0.5 * w * x  # derivative of s
        for k in range(6):
            cx, cy = bend(k, l, worn, ex, ey, gx, gy, ax, ay, bx, by)
            sx, sy = sx + cx * v[k], sy + cy * v[k]
        sx, sy, sz = kq * sx + kv * x, kq * sy + kv * y, kv * z
        px = w00 * sx + w01 * sy + w02 * sz - kq * (q00 * x + q01 * y)  # derivatives of the sums of P y
        py = w01 * sx + w11 * sy + w12 * sz - kq * (q01 * x + q11 * y)
        pz = w02 * sx + w12 * sy + w22 * sz - kq * (q02 * x + q12 * y + m0 * y - m1 * x)
        pz -= 2.0 * kq * (by_x * x + by_y * y) * w - 4.0 * kv * drag * z
        r[l] = x * m0 + y * m1 + z * (m2 - 2.0 * drag * w)
        for k in range(6):
            cx, cy = bend(k, l, worn, ex, ey, gx, gy, ax, ay, bx, by)
            A[k, l] += gx[k] * px + gy[k] * py + kq * (m0 * cx + m1 * cy)
        A[worn, l] += ey * px - ex * py + 0.5 * pz
        A[other, l] -= 0.5 * pz


WORN_FILM = massless("WORN_FILM", globals())


@signal_kernel
def worn_film_signal(p, t, q, v, a):
    """Signals of a film in the order of `SIGNALS`; forces act on the second body."""
    ex, ey, vx, vy, _, _, _, _, _, _, worn, _, w, C, S = place(p, q, v)
    last = p.shape[0] - 1
    which, area = int(p[last]), p[WIDTH] * p[RADIUS] * 8.0 * math.pi / (last - TABLES)
    if which in (kernels.THICKNESS, kernels.PEAK_PRESSURE, kernels.SIDE_FLOW):
        least, peak, flow = extremes(p, ex, ey, vx, vy, w)
        oil = 1.5 * peak / area if which == kernels.PEAK_PRESSURE else flow * area
        return least if which == kernels.THICKNESS else oil
    m0, m1, m2, drag, taken = sums(p, ex, ey, vx, vy, w)
    if which == kernels.POWER:
        return taken
    if which == kernels.FILM_FX:
        return S * m1 - C * m0
    if which == kernels.FILM_FY:
        return -S * m0 - C * m1
    across, along, turning = ey * m0 - ex * m1, ex * m0 + ey * m1, drag * w - 0.5 * m2
    if which == kernels.TORQUE:
        return -turning if worn == 2 else turning - across
    return math.atan2(across, along) if across != 0.0 or along != 0.0 else 0.0


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

    def pressures(
        self, directions: np.ndarray, place: np.ndarray, rate: np.ndarray, turns: np.ndarray, spins: np.ndarray
    ) -> np.ndarray:
        """Pressure of the film (n,) by direction, as of `JournalBearing.pressures`, of (16.11)."""
        worn = int(self.on_journal)
        turn, spin, w = float(turns[worn]), float(spins[worn]), float(spins[1 - worn] - spins[worn])
        axes = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
        x, y = axes @ place
        vx, vy = axes @ (np.asarray(rate) + spin * np.array([place[1], -place[0]]))
        X, Y, gaps, slopes = np.reshape(self.film_numbers((0.0, 0.0), (0.0, 0.0))[TABLES:], (4, self.bins))
        s = X * vx + Y * vy - 0.5 * w * (slopes + x * Y - y * X)
        h = np.array([kernels.thickness(gap, self.roughness)[0] for gap in gaps - x * X - y * Y])
        pressure = 1.5 * self.film.viscosity * self.film.width**2 * np.maximum(s, 0.0) / h**3
        return np.asarray(np.interp(directions - turn, self.places, pressure, period=2.0 * math.pi))

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
        ends = self.ends(mechanism)
        coordinates, p = ends.coordinates, self.film_numbers(ends.first.offset, ends.second.offset)
        film = WORN_FILM.contribution(self.name, coordinates, p)
        signals = signal_contributions(self.name, worn_film_signal, kernels.SIGNALS, coordinates, p)
        return [*super().contributions(mechanism), film, *signals]

    def findings_before(self, mechanism: Mechanism) -> Iterator[Finding]:
        return JournalBearing.findings_before(self, mechanism)
