"""Revolute joint with clearance whose bearing or journal wears: contact, profile, and the places left to the journal.

The angles are phi_i = 2 pi i/n in the axes of the worn body, u the directions there, h_i the depths.  The places that a
worn joint leaves free are e . u_i <= c + h_i for all i: a convex set.  What no journal can reach is a valley.  The set
is known by its support sigma and the radius of curvature rho = sigma + sigma'', which is linear between the angles.
With the eccentricity e in these axes, the depth is its distance from the free places, D = max (e . u - sigma), along
the normal n at the largest value; n turns by t/(rho + D) with e.

Equations (16.1), (16.2), (16.3) and (16.5) of docs/theory/wear.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from flexmb.fields import record
from flexmb.findings.finding import Finding, found
from flexmb.kernels import compiled, gap_kernel, signal_kernel
from flexmb.model.contributions import ContactContribution, Contribution, signal_contributions
from flexmb.model.mechanism import Mechanism
from flexmb.parts.joints.contact_point import arms_of, put_column, put_eccentricity, put_point
from flexmb.parts.joints.revolute import RevoluteClearance, angle_contribution
from flexmb.parts.wear.worn_joint import WornJoint

CLEARANCE, BEARING_RADIUS, OFFSET1_X, OFFSET1_Y, OFFSET2_X, OFFSET2_Y, ON_JOURNAL, CHOSEN = range(8)
TABLES = 8  # place of the first number of the tables of a `Surface`, one behind the other


@compiled
def nearest(p, n, ex, ey):
    """Depth D, normal, and 1/(rho + D), by which the normal turns; (ex, ey) in the axes of the worn body."""
    # Between two angles sigma is rho_0 + r x + a cos x + b sin x, so the largest value has a closed form.
    cos, sin, support, slope, radius = TABLES, TABLES + n, TABLES + 2 * n, TABLES + 3 * n, TABLES + 4 * n
    k, best = 0, -math.inf
    for i in range(n):
        now = ex * p[cos + i] + ey * p[sin + i] - p[support + i]
        if now > best:
            k, best = i, now
    if ey * p[cos + k] - ex * p[sin + k] < p[slope + k]:
        k = k - 1 if k > 0 else n - 1
    step, ux, uy, rho = 2.0 * math.pi / n, p[cos + k], p[sin + k], p[radius + k]
    following = k + 1 if k < n - 1 else 0
    r = (p[radius + following] - rho) / step
    along, across = ex * ux + ey * uy - p[support + k] + rho, ey * ux - ex * uy - p[slope + k] + r
    size, x = math.sqrt(along * along + across * across), 0.0
    if size > 0.0:
        x = math.atan2(across, along) - math.asin(min(max(r / size, -1.0), 1.0))
        x = min(max(x, 0.0), step)
    c, s = math.cos(x), math.sin(x)
    depth = along * c + across * s - rho - r * x
    turns = rho + r * x + depth
    return depth, ux * c - uy * s, uy * c + ux * s, 1.0 / turns if turns > 0.0 and size > 0.0 else 0.0


@compiled
def arm(p, n, ex, ey, depth, nx, ny, inverse):
    """Factor of the arm of friction, and its derivatives by e."""
    # It is the sum of the pressures over the size of their resultant, beside the same of an unworn bearing at this
    # depth.
    c, tx, ty = p[CLEARANCE], -ny, nx
    A, B, A0, B0 = 0.0, 0.0, 0.0, 0.0
    Ax, Ay, Bx, By, turn = 0.0, 0.0, 0.0, 0.0, 0.0
    A0n, A0t, B0n, B0t = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        ux, uy = p[TABLES + i], p[TABLES + n + i]
        near, aside = ux * nx + uy * ny, ux * tx + uy * ty
        d = ex * ux + ey * uy - p[TABLES + 5 * n + i]
        if d > 0.0:
            A, B, turn = A + d, B + d * near, turn + d * aside
            Ax, Ay, Bx, By = Ax + ux, Ay + uy, Bx + near * ux, By + near * uy
        d = (c + depth) * near - c
        if d > 0.0:
            along, across = near, (c + depth) * aside * inverse
            A0, B0 = A0 + d, B0 + d * near
            A0n, A0t = A0n + along, A0t + across
            B0n, B0t = B0n + near * along, B0t + near * across + d * aside * inverse
    x, y, factor = 0.0, 0.0, 1.0
    if B > 0.0 and A > 0.0:
        factor = A / B
        Bx, By = Bx + turn * inverse * tx, By + turn * inverse * ty
        x, y = Ax / A - Bx / B, Ay / A - By / B
    if B0 > 0.0:
        factor *= B0 / A0
        along, across = B0n / B0 - A0n / A0, B0t / B0 - A0t / A0
        x, y = x + along * nx + across * tx, y + along * ny + across * ty
    return factor, factor * x, factor * y


@compiled
def relative(p, q, v):
    """Arms from the nodes to both centres, eccentricity and its rate."""
    ax, ay, bx, by, ex, ey = arms_of(p[OFFSET1_X], p[OFFSET1_Y], p[OFFSET2_X], p[OFFSET2_Y], q)
    vex, vey = v[3] - by * v[5] - v[0] + ay * v[2], v[4] + bx * v[5] - v[1] - ax * v[2]
    worn = 5 if p[ON_JOURNAL] > 0.0 else 2  # rotation of the worn body
    return ax, ay, bx, by, ex, ey, vex, vey, worn, math.cos(q[worn]), math.sin(q[worn])


@gap_kernel
def worn_gap_kernel(p, q, v, out):
    """Journal in a worn bearing, or worn journal: the normal passes through the centre of the surface that is round."""
    n, c, R1 = (p.shape[0] - TABLES) // 6, p[CLEARANCE], p[BEARING_RADIUS]
    ax, ay, bx, by, ex, ey, vex, vey, worn, C, S = relative(p, q, v)
    X, Y, radius, grows = q[3] + bx, q[4] + by, R1 - c, -0.5
    if worn == 5:
        X, Y, radius, grows = q[0] + ax, q[1] + ay, R1, 0.5
    lx, ly = C * ex + S * ey, C * ey - S * ex
    depth, mx, my, inverse = nearest(p, n, lx, ly)
    factor, fx, fy = 1.0, 0.0, 0.0
    if depth > 0.0:
        factor, fx, fy = arm(p, n, lx, ly, depth, mx, my, inverse)
    nx, ny, fx, fy = C * mx - S * my, S * mx + C * my, C * fx - S * fy, S * fx + C * fy
    radius += grows * depth
    put_point(out, q, v, -depth, nx, ny, X + factor * radius * nx, Y + factor * radius * ny)
    put_eccentricity(out, ex, ey, vex, vey)
    gx, gy = (-1.0, 0.0, ay, 1.0, 0.0, -by), (0.0, -1.0, -ax, 0.0, 1.0, bx)  # de/dq
    for j in range(6):
        x, y, turn, px, py = gx[j], gy[j], 0.0, 0.0, 0.0
        if j == worn:
            x, y, turn = x + ey, y - ex, 1.0
        if j < 3 and worn == 5:
            px, py = -x, -y
        elif j > 2 and worn == 2:
            px, py = x, y
        turn += inverse * (nx * y - ny * x)
        r = (fx * x + fy * y) * radius + factor * grows * (nx * x + ny * y)
        put_column(out, j, -ny * turn, nx * turn, px + r * nx - factor * radius * ny * turn,
                   py + r * ny + factor * radius * nx * turn)  # fmt: skip


PLACE_X, PLACE_Y, ANGLE, SLIDING = range(4)
# Signals with their units, in the order of `worn_signal`.
SIGNALS = (("x", "m"), ("y", "m"), ("contact_angle", "rad"), ("slip", "m/s"))


@signal_kernel
def worn_signal(p, t, q, v, a):
    """`CHOSEN`: place in `SIGNALS`; the first three in the axes of the worn body."""
    which, n = int(p[CHOSEN]), (p.shape[0] - TABLES) // 6
    _, _, _, _, ex, ey, vex, vey, worn, C, S = relative(p, q, v)
    lx, ly = C * ex + S * ey, C * ey - S * ex
    if which == PLACE_X:
        return lx
    if which == PLACE_Y:
        return ly
    depth, mx, my, inverse = nearest(p, n, lx, ly)
    if which == ANGLE:
        return math.atan2(my, mx)
    factor = 1.0
    if depth > 0.0:
        factor, _, _ = arm(p, n, lx, ly, depth, mx, my, inverse)
    nx, ny, spin = C * mx - S * my, S * mx + C * my, v[worn]
    radius = p[BEARING_RADIUS] + 0.5 * depth if worn == 5 else p[BEARING_RADIUS] - p[CLEARANCE] - 0.5 * depth
    return nx * (vey - ex * spin) - ny * (vex + ey * spin) + factor * radius * (v[5] - v[2])


CARRIED = 1e-12  # error of a force that a foundation carries over this force, which counts as none [1]
LEAST_COSINE = 1e-9  # least cosine of an angle from the normal at which a foundation carries something [1]


class Surface(NamedTuple):
    """Tables by angle of the free places; each (n,)."""

    cos: np.ndarray  # directions u
    sin: np.ndarray
    support: np.ndarray  # sigma [m]
    slope: np.ndarray  # sigma' [m]
    radius: np.ndarray  # rho >= 0 [m]
    wall: np.ndarray  # place of the surface, sigma or beyond in valleys [m]


def surface(clearance: float, depths: Sequence[float] | np.ndarray) -> Surface:
    """Tables of a surface with the `depths` h (n,) [m]."""
    h = np.array(depths, dtype=float)
    n, step = len(h), 2.0 * np.pi / len(h)
    phi, cos, sin = step * np.arange(n), np.cos(step), np.sin(step)
    x, y = np.cos(phi), np.sin(phi)
    reached = _reached(clearance, h, x, y)
    bend = np.roll(reached, 1) - 2.0 * cos * reached + np.roll(reached, -1)
    rho = np.maximum(clearance + bend / (2.0 * (1.0 - cos)), 0.0)
    waves = np.cos(step * np.arange(n // 2 + 1))
    factor = (waves - cos + (1.0 - waves) * sin / step) / (1.0 - cos)
    sigma = clearance + np.fft.irfft(np.fft.rfft(reached) * factor, n)
    rest = sigma - rho
    slope = (np.roll(rho, -1) - rho) / step + (np.roll(rest, -1) - rest * cos) / sin
    return Surface(x, y, sigma, slope, rho, np.minimum(sigma, clearance + reached) + h - reached)


def _reached(clearance: float, h: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Depths that a journal can reach (n,): the largest support of a convex set below c + h, less c."""
    # The lines that bound the set are the corners of the convex hull of the points u/(c + h), polar to it.
    n, scale = len(h), 1.0 / (clearance + h)
    first = int(np.argmin(h))
    order = [*range(first, n), *range(first), first]
    dual = list(zip((x * scale).tolist(), (y * scale).tolist(), strict=True))
    kept: list[int] = []
    for i in order:
        while len(kept) > 1:
            (x1, y1), (x2, y2), (x3, y3) = dual[kept[-2]], dual[kept[-1]], dual[i]
            if (x2 - x1) * (y3 - y2) > (y2 - y1) * (x3 - x2):  # the way turns to the left
                break
            kept.pop()
        kept.append(i)
    reached = h.copy()
    for a, b in pairwise(kept):
        skipped = np.arange(a + 1, b if b > a else b + n) % n
        if len(skipped):
            across, one, two = x[a] * y[b] - y[a] * x[b], clearance + h[a], clearance + h[b]
            X, Y = (one * y[b] - two * y[a]) / across, (two * x[a] - one * x[b]) / across  # the corner
            reached[skipped] = np.minimum(h[skipped], X * x[skipped] + Y * y[skipped] - clearance)
    return reached


def shares(tables: Surface, x: np.ndarray, y: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Shares of the angles in the pressure (rows, n), each row with the sum 1."""
    # x, y : centre of the journal in the axes of the worn body (rows,) [m]; angle : of the normal there (rows,) [rad].
    depth = np.outer(x, tables.cos) + np.outer(y, tables.sin) - tables.wall
    np.maximum(depth, 0.0, out=depth)
    total, n = depth.sum(axis=1), len(tables.cos)
    narrow = np.flatnonzero(total <= 0.0)  # narrower than the distance of two angles
    place = angle[narrow] / (2.0 * np.pi) * n
    left = np.floor(place)
    depth[narrow, left.astype(int) % n] = 1.0 - (place - left)
    depth[narrow, (left.astype(int) + 1) % n] += place - left
    total[narrow] = 1.0
    return np.asarray(depth / total[:, None])


def settled(
    tables: Surface, x: np.ndarray, y: np.ndarray, angle: np.ndarray, depth: np.ndarray, force: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Places of the journal's centre, moved along the normal until the pressure carries a force; each (rows,) [m]."""
    # depth : of the contact at the places x, y; force : over the stiffness of an angle [m]. The force that the pressure
    # carries is a convex function of the depth, so Newton's method from above ends with the angles that are pressed.
    nx, ny = np.cos(angle), np.sin(angle)
    free = np.outer(x - depth * nx, tables.cos) + np.outer(y - depth * ny, tables.sin) - tables.wall
    near = np.maximum(np.outer(nx, tables.cos) + np.outer(ny, tables.sin), LEAST_COSINE)
    d = ((force[:, None] / near - free) / near).min(axis=1)
    while True:
        pressed = np.maximum(free + d[:, None] * near, 0.0)
        excess = (pressed * near).sum(axis=1) - force
        if not (excess > CARRIED * force).any():
            return x + (d - depth) * nx, y + (d - depth) * ny
        d -= excess / (near**2 * (pressed > 0.0)).sum(axis=1)


@record
class WornClearance(WornJoint, RevoluteClearance):
    """Revolute joint with clearance and a worn surface, made by `RevoluteClearance.worn_by`.

    The surface has a depth for each of `wear.bins` angles, which are counted in the axes of the body that carries it:
    of a link from its start to its end.  The contact acts on the distance of the journal's centre from the places that
    the worn surface leaves free, with the given laws, and presses on all angles within this distance.

    Signals: those of `RevoluteClearance`; x, y (journal's centre less the bearing's, in the axes of the worn body)
    [m], contact_angle (of the normal in these axes) [rad], slip (of the surfaces) [m/s].

    Raises
    ------
    InputError : a profile of another length than `wear.bins` or deeper than the bearing's radius, `EnergyWear` without
        friction, further ones of `RevoluteClearance`.

    Notes
    -----
    The profile stays as it is within a run: `worn_in(sol)` gives the wear of a run, `with_depths(depths)` the joint
    with another profile, and `wear_out` goes on over many turns.  `depths`, `volume` and `half_play` say how far it is
    worn.

    Examples
    --------
    >>> import flexmb as fm
    >>> new = fm.mechanisms.slider_crank(clearance=5e-5)["B"].worn_by(fm.Archard(bearing=1e-13, width=0.02))
    >>> worn = new.with_depths(new.depths + 1e-5)
    >>> f"{1e9 * worn.volume:.1f} mm^3, {1e6 * worn.half_play:.0f} um"
    '12.6 mm^3, 60 um'
    """

    PLACES = "angle"
    PLACE_UNIT = "rad"
    FACES = ("bearing", "journal")
    SIZES = ("clearance", "bearing_radius")
    DEEPEST = "bearing radius"
    contacts = ("",)
    where = ("x", "y", "contact_angle", "penetration")

    @property
    def wearing_faces(self) -> tuple[str, ...]:
        return ("journal",) if self.on_journal else ("bearing",)

    @property
    def on_journal(self) -> bool:
        """Whether the journal wears, and not the bearing."""
        return self.wear.journal > 0.0

    @property
    def width(self) -> float:
        """Width of the surfaces [m]."""
        return 2.0 * self.bearing_radius if self.wear.width is None else self.wear.width

    @property
    def areas(self) -> np.ndarray:
        radius = self.journal_radius if self.on_journal else self.bearing_radius
        return np.full(self.bins, 2.0 * np.pi / self.bins * radius * self.width)

    @property
    def places(self) -> np.ndarray:
        return 2.0 * np.pi * np.arange(self.bins) / self.bins

    @property
    def half_play(self) -> float:
        support = self.surface.support
        return self.clearance - self.play + float(0.5 * (support + np.roll(support, len(support) // 2)).max())

    @cached_property
    def surface(self) -> Surface:
        """Tables of the worn surface."""
        return surface(self.play, self.depths)

    def smoothed(self, depths: np.ndarray) -> np.ndarray:
        """Means of the depths of neighbours, weights 1/4, 1/2, 1/4; their sum stays the same."""
        return np.asarray(0.5 * depths + 0.25 * (np.roll(depths, 1) + np.roll(depths, -1)))

    def _spread(self, sol: Any, contact: str, rows: np.ndarray, lost: np.ndarray) -> np.ndarray:
        """Volume by angle, spread as the pressure is."""
        x, y, angle, depth = (sol.array(f"{self.name}.{contact}{name}")[rows] for name in self.where)
        if self.wear.foundation is not None:
            force = sol.array(f"{self.name}.{contact}normal_force")[rows]
            x, y = settled(self.surface, x, y, angle, depth, force / (self.wear.foundation * self.areas[0]))
        return np.asarray(lost @ shares(self.surface, x, y, angle))

    def numbers(self, first: tuple[float, float], second: tuple[float, float]) -> tuple[float, ...]:
        """Parameters of the kernels; `first`, `second`: offsets of both points in the frames of their nodes [m]."""
        own = (self.play, self.bearing_radius, *first, *second, float(self.on_journal), 0.0)
        return (*own, *np.concatenate(self.surface).tolist())

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        ends = self.ends(mechanism)
        coordinates, p = ends.coordinates, self.numbers(ends.first.offset, ends.second.offset)
        normal = self.normal.for_radii(self.bearing_radius, self.journal_radius)
        contact = ContactContribution(self.name, worn_gap_kernel, coordinates, p, normal, self.friction)
        signals = signal_contributions(self.name, worn_signal, SIGNALS, coordinates, p[:CHOSEN], behind=p[TABLES:])
        return [contact, angle_contribution(self.name, mechanism, ends), self._held(mechanism, ends), *signals]

    def findings_before(self, mechanism: Mechanism) -> Iterator[Finding]:  # noqa: ARG002
        """Finding on a width that is not given."""
        if self.wear.width is None:
            text = f"{self.label} wears and has no width; it is taken as the diameter of the bearing, {self.width:g} m."
            remedy = f"Depths go with 1/width: give it, e.g. {type(self.wear).__name__}(..., width=0.02)."
            yield found("width-of-wear", (self.name,), text, remedy, width=self.width)
