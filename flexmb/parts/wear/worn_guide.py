"""Guide and slot whose sides wear: a slider or a pin with clearance between two worn sides.

The free places of a corner, or of the centre of a pin, end at y = g + f(x) beside the side, f the cubic B-spline of the
depths that can be reached (`WornSides.sides`): f'' is continuous, f is 0 beyond the known places.  The depth is the
distance from the border, along its normal, which turns by its curvature.

Equations (16.7) to (16.9) of docs/theory/wear.md.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import KW_ONLY, replace
from typing import Any, Self

import numpy as np

from flexmb.errors import InputError
from flexmb.fields import field, positive, record
from flexmb.kernels import compiled, gap_kernel, signal_kernel
from flexmb.model.contributions import ContactContribution, Contribution, SignalContribution, signal_contributions
from flexmb.model.mechanism import Mechanism
from flexmb.parts.joints.contact_point import arms_of, put_column, put_eccentricity, put_point
from flexmb.parts.joints.prismatic import CORNERS, PinSlotClearance, PrismaticClearance
from flexmb.parts.wear.worn_joint import Wear, WornJoint

(PLAY, HALF, RADIUS, SIDE, ALONG_X, ALONG_Y, OFFSET1_X, OFFSET1_Y, OFFSET2_X, OFFSET2_Y, STEP, STEEPEST, DEEPEST,
 CHOSEN) = range(14)  # fmt: skip
DEPTHS = 14  # place of the first depth; of a pin the left side of the slot comes first
MOST_TRIALS = 60  # number of trials at most for the foot; bisection alone has found it to round-off by then
CLOSE = 1e-13  # error of the foot over the distance of two places [1] that ends the search


@compiled
def nearest_border(p, first, n, x, y):
    """Depth D of the point (x, y), normal along and across the guide, 1/(rho + D), foot on the border."""
    s, reach = x, 2.0 * p[STEEPEST] * (abs(y) + p[DEEPEST])
    low, high = x - reach, x + reach
    f, f1, f2 = 0.0, 0.0, 0.0
    for _ in range(MOST_TRIALS):
        # f, f', f'' of the border at s
        step = p[STEP]
        place = s / step + 0.5 * n - 0.5
        k = math.floor(place)
        u = place - k
        w = 1.0 - u
        left, right = 2.0 / 3.0 - u * u * (1.0 - 0.5 * u), 2.0 / 3.0 - w * w * (1.0 - 0.5 * w)
        weights = (w * w * w / 6.0, left, right, u * u * u / 6.0)
        slopes = (-0.5 * w * w, u * (1.5 * u - 2.0), -w * (1.5 * w - 2.0), 0.5 * u * u)
        bends = (w, 3.0 * u - 2.0, 3.0 * w - 2.0, u)
        f, f1, f2 = 0.0, 0.0, 0.0
        for j in range(4):
            i = int(k) - 1 + j
            if 0 <= i < n:
                h = p[first + i]
                f, f1, f2 = f + weights[j] * h, f1 + slopes[j] * h, f2 + bends[j] * h
        f1, f2 = f1 / step, f2 / (step * step)
        F, F_s = x - s + (y - f) * f1, -1.0 - f1 * f1 + (y - f) * f2
        if F_s < 0.0 and abs(F) <= -CLOSE * p[STEP] * F_s:
            break
        if F >= 0.0:
            low = s
        else:
            high = s
        s = s - F / F_s if F_s < 0.0 else low
        if not low < s < high:
            s = 0.5 * (low + high)
    size = math.sqrt(1.0 + f1 * f1)
    depth, bend = (y - f) * size, -f2 / (size * size * size)
    turns = 1.0 + bend * depth
    return depth, -f1 / size, 1.0 / size, bend / turns if turns != 0.0 else 0.0, s


@compiled
def touch(p, q):
    """Arms, point in the axes of the guide, its directions, depth, normal, curvature, point of contact, side, place."""
    ax, ay, bx, by, ex, ey = arms_of(p[OFFSET1_X], p[OFFSET1_Y], p[OFFSET2_X], p[OFFSET2_Y], q)
    c1, d1 = math.cos(q[2]), math.sin(q[2])
    ux, uy = c1 * p[ALONG_X] - d1 * p[ALONG_Y], d1 * p[ALONG_X] + c1 * p[ALONG_Y]
    along, across = ux * ex + uy * ey, ux * ey - uy * ex
    far, side, n = p[PLAY] + p[HALF], p[SIDE], p.shape[0] - DEPTHS
    if side == 0.0:
        n, side = n // 2, 1.0
        depth, mx, my, inverse, foot = nearest_border(p, DEPTHS, n, along, across - far)
        deeper, ox, oy, turns, place = nearest_border(p, DEPTHS + n, n, along, -across - far)
        if deeper > depth:
            side, depth, mx, my, inverse, foot = -1.0, deeper, ox, oy, turns, place
    else:
        depth, mx, my, inverse, foot = nearest_border(p, DEPTHS, n, along, side * across - far)
    nx, ny = mx * ux - side * my * uy, mx * uy + side * my * ux
    radius = p[RADIUS]
    ahead, grows = (radius - 0.5 * depth, -0.5) if radius > 0.0 else (0.0, 0.0)
    return ax, ay, bx, by, ex, ey, ux, uy, across, depth, nx, ny, inverse, ahead, grows, foot + radius * mx


@gap_kernel
def worn_side_gap_kernel(p, q, v, out):
    """Corner or pin against the worn sides of a guide or slot."""
    ax, ay, bx, by, ex, ey, ux, uy, across, depth, nx, ny, inverse, ahead, grows, _ = touch(p, q)
    put_point(out, q, v, -depth, nx, ny, q[3] + bx + ahead * nx, q[4] + by + ahead * ny)
    vx, vy = v[3] - v[5] * by - v[0] + v[2] * ay, v[4] + v[5] * bx - v[1] - v[2] * ax
    wx, wy = (ex, ey) if p[SIDE] != 0.0 else (-across * uy, across * ux)
    if p[SIDE] == 0.0:  # the middle line turns; the way along it does not count
        rate = ux * vy - uy * vx - v[2] * (ux * ex + uy * ey)
        vx, vy = -rate * uy - v[2] * wy, rate * ux + v[2] * wx
    put_eccentricity(out, wx, wy, vx, vy)
    gx, gy = (-1.0, 0.0, ay, 1.0, 0.0, -by), (0.0, -1.0, -ax, 0.0, 1.0, bx)  # de/dq
    for j in range(6):
        x, y, turn, px, py = gx[j], gy[j], 0.0, 0.0, 0.0
        if j > 2:
            px, py = x, y
        if j == 2:  # the guide turns
            x, y, turn = x + ey, y - ex, 1.0
        turn += inverse * (nx * y - ny * x)
        r = grows * (nx * x + ny * y)
        put_column(out, j, -ny * turn, nx * turn, px - ahead * ny * turn + r * nx, py + ahead * nx * turn + r * ny)


PLACE, SLIDING = range(2)
# Signals with their units, in the order of `worn_side_signal`; the last one of a pin alone.
SIGNALS = (("place", "m"), ("slip", "m/s"), ("offset", "m"))


@signal_kernel
def worn_side_signal(p, t, q, v, a):
    """`CHOSEN`: place of the contact along the guide from its middle, slip, place of the pin across the slot."""
    _, _, bx, by, _, _, _, _, across, _, nx, ny, _, ahead, _, place = touch(p, q)
    which = int(p[CHOSEN])
    if which == PLACE:
        return place
    if which != SLIDING:
        return across
    r2x, r2y = bx + ahead * nx, by + ahead * ny
    r1x, r1y = r2x + q[3] - q[0], r2y + q[4] - q[1]
    x, y = v[3] - v[5] * r2y - v[0] + v[2] * r1y, v[4] + v[5] * r2x - v[1] - v[2] * r1x
    return nx * y - ny * x


@signal_kernel
def worn_guide_mode(p, t, q, v, a):
    """Mode of a slider by its corners: 0 free, 1 one, 2 two across, 3 face, 4 more; p: of each, upper ones first."""
    size, upper, lower = p.shape[0] // 4, 0, 0
    for k in range(4):
        _, _, _, _, _, _, _, _, _, depth, _, _, _, _, _, _ = touch(p[k * size : (k + 1) * size], q)
        touching = depth >= 0.0
        if k < 2:
            upper += touching
        else:
            lower += touching
    return 4.0 if upper + lower > 2 else (3.0 if upper == 2 or lower == 2 else float(upper + lower))


UPPER, LOWER = "upper", "lower"  # names of the sides: upper is left of `along`
WAYS = 4  # number of places to which the wear goes from each half of a step


@record
class WornSides(WornJoint):
    """Base of guides and slots with two sides that wear along a length."""

    _: KW_ONLY
    worn_length: float = field("length of the sides whose depth is known, about the joint's point", "m", positive)

    PLACES = "place"
    PLACE_UNIT = "1"
    FACES = (UPPER, LOWER)
    SIZES = ("clearance", "worn_length")
    wearing_faces = FACES
    rounding = 0.0
    """Radius of what slides on the sides [m]."""

    def __post_init__(self) -> None:
        super().__post_init__()
        law = type(self.wear).__name__
        if self.wear.journal > 0.0:
            text = f"{self.label}: {law} has a coefficient of the journal; only the sides of the first body wear here"
            raise InputError(f"{text}. Give {law}(bearing=...), the coefficient of guide or slot.")
        if self.wear.width is None:
            text = f"{self.label}: {law} has no width, with which depths go"
            raise InputError(f"{text}. Give the width of the sides, e.g. {law}(..., width=0.02).")
        if self.wear.foundation is not None:
            text = f"{self.label}: {law} has a foundation, and contact with a side is at one place"
            raise InputError(f"{text}. Leave foundation out; it is for bearings.")

    @property
    def step(self) -> float:
        """Distance of two places [m]."""
        return self.worn_length / self.bins

    @property
    def places(self) -> np.ndarray:
        """Places of the profile over its length, from its middle [1]."""
        return (np.arange(self.bins) + 0.5) / self.bins - 0.5

    @property
    def areas(self) -> np.ndarray:
        return np.full(2 * self.bins, self.step * (self.wear.width or 0.0))

    @property
    def sides(self) -> np.ndarray:
        """Depths that the moving surface can reach (2, bins) [m]: a round pin does not come to the ground of a valley.

        Equation (16.7) of docs/theory/wear.md.
        """
        depths, radius = self.depths.reshape(2, self.bins), self.rounding
        reached = depths.copy()
        for k in range(1, self.bins):
            if k * self.step >= radius:
                break
            lift = radius - np.sqrt(radius * radius - (k * self.step) ** 2)
            np.minimum(reached[:, :-k], depths[:, k:] + lift, out=reached[:, :-k])
            np.minimum(reached[:, k:], depths[:, :-k] + lift, out=reached[:, k:])
            reached[:, :k], reached[:, -k:] = np.minimum(reached[:, :k], lift), np.minimum(reached[:, -k:], lift)
        return reached

    @property
    def half_play(self) -> float:
        return self.clearance + 0.5 * float(self.sides.sum(axis=0).max())

    def smoothed(self, depths: np.ndarray) -> np.ndarray:
        """Means of the depths of neighbours, weights 1/4, 1/2, 1/4; an end is its own neighbour."""
        padded = np.pad(depths.reshape(2, self.bins), ((0, 0), (1, 1)), mode="edge")
        return np.asarray(0.5 * padded[:, 1:-1] + 0.25 * (padded[:, :-2] + padded[:, 2:])).ravel()

    def _spread(self, sol: Any, contact: str, rows: np.ndarray, lost: np.ndarray) -> np.ndarray:
        """Volume by place, over the way of each step."""
        place = sol.array(f"{self.name}.{contact}{self.where[0]}")
        where, limit = place[rows], 0.5 * (self.worn_length - self.step)
        if len(where) and np.abs(where).max() > limit:
            text = f"{self.label}: it rubs from {where.min():.4g} to {where.max():.4g} m from the middle of its sides"
            raise InputError(f"{text}, whose depth is known up to {limit:.4g} m. Give worn_by(..., length=...) more.")
        begin = np.where(self._on_upper(sol, contact, rows), 0, self.bins)
        before, behind = (place[np.clip(rows + k, 0, len(place) - 1)] - where for k in (-1, 1))
        found = np.zeros(2 * self.bins)
        for part in (np.arange(WAYS) + 0.5) / (2.0 * WAYS):
            for way in (before, behind):
                u = (np.clip(where + part * way, -limit, limit) + limit) / self.step
                left = np.minimum(u.astype(int), self.bins - 2)
                for k, share in ((left, 1.0 - (u - left)), (left + 1, u - left)):
                    found += np.bincount(begin + k, lost * share, minlength=2 * self.bins)
        return np.asarray(found / (2.0 * WAYS))

    def _on_upper(self, sol: Any, contact: str, rows: np.ndarray) -> np.ndarray:  # noqa: ARG002 - of pins
        """Whether a contact is on the upper side in some rows."""
        return np.full(len(rows), contact.startswith(UPPER))

    def _numbers(self, size: Sequence[float], tables: np.ndarray) -> tuple[float, ...]:
        """Numbers of the kernels, depths of the sides last."""
        steepest = float(np.abs(np.diff(np.pad(np.atleast_2d(tables), ((0, 0), (1, 1))))).max()) / self.step
        return (*size, self.step, steepest, float(tables.max()), 0.0, *tables.ravel().tolist())

    @abstractmethod
    def _on_sides(self, *p: float) -> tuple[float, ...]:
        """Numbers of a contact on the worn sides; `p`: of the dry contact."""

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """Contributions of the dry joint, contacts on the worn sides."""
        found: list[Contribution] = []
        corners: tuple[float, ...] = ()
        for one in super().contributions(mechanism):  # type: ignore[safe-super]
            if isinstance(one, ContactContribution):
                p, prefix = self._on_sides(*one.p), f"{one.name}." if one.name else ""
                corners += p
                found.append(replace(one, gap=worn_side_gap_kernel, p=p))
                told = [(prefix + name, unit) for name, unit in SIGNALS[: 1 + len(self.where)]]
                own = self.name, worn_side_signal, told, one.coordinates, p[:CHOSEN]
                found += signal_contributions(*own, behind=p[DEPTHS:])
            elif isinstance(one, SignalContribution) and one.is_mode:
                found.append(replace(one, kernel=worn_guide_mode, p=corners))
            else:
                found.append(one)
        return found

    def worn_by(self, wear: Wear, length: float | None = None) -> Self:
        """The joint with another law of wear, and another `length` if it is unworn; its depths stay.

        Raises
        ------
        InputError : another number of bins, or another length, of a joint that has lost material.
        """
        if length is not None and length != self.worn_length and any(self.profile):
            text = f"{self.label}: its depths are those of a length of {self.worn_length:g} m"
            raise InputError(f"{text}. Leave length out, or give wear to the joint without a profile.")
        made = super().worn_by(wear)
        return made if length is None else replace(made, worn_length=length)


@record
class WornGuide(WornSides, PrismaticClearance):
    """Prismatic joint with clearance and worn sides of the guide, made by `PrismaticClearance.worn_by`.

    Each side has a depth for each of `wear.bins` places along `worn_length`, whose middle is at the joint's point.  A
    corner touches the worn side at the place where it is.  Beyond this length the sides are unworn.

    Signals: those of `PrismaticClearance`; for each corner `upper_front.place` (along the guide from its middle) [m],
    `upper_front.slip` [m/s], ...

    Raises
    ------
    InputError : a law of wear of the slider (journal), one without width, a profile of another length than both sides
        together, depths out of range, `EnergyWear` without friction, further ones of `PrismaticClearance`.

    Notes
    -----
    `depths` holds the upper side, then the lower one.  The profile stays as it is within a run: `worn_in(sol)` gives
    the wear of a run, `with_depths(depths)` the joint with other depths, `wear_out` goes on over many turns.  Corners
    themselves do not wear, and a face between them does not touch, also where the guide is hollow.
    Impacts that recur at one place make pits as narrow as two places of the profile: give places as wide as a contact.
    """

    contacts = tuple(f"{name}." for name, *_ in CORNERS)
    where = ("place",)
    DEEPEST = "half_height"

    def _on_sides(self, *p: float) -> tuple[float, ...]:
        play, half, across, *geometry = p
        return self._numbers((play, half, 0.0, across, *geometry), self.sides[0 if across > 0.0 else 1])


@record
class WornSlot(WornSides, PinSlotClearance):
    """Pin with clearance in a slot with worn sides, made by `PinSlotClearance.worn_by`.

    Each side has a depth for each of `wear.bins` places along `worn_length`, whose middle is at the joint's point.  The
    contact acts on the distance of the pin's centre from the places that the worn sides leave free to it.  Beyond this
    length the sides are unworn.

    Signals: those of `PinSlotClearance`; place (of the contact along the slot, from its middle) [m], slip [m/s], offset
    (of the pin across the slot, from its middle line) [m].

    Raises
    ------
    InputError : a slot with ends, a law of wear of the pin (journal), one without width, a profile of another length
        than both sides together, depths out of range, `EnergyWear` without friction, further ones of
        `PinSlotClearance`.

    Notes
    -----
    `depths` holds the upper side, left of `along`, then the lower one.  The profile stays as it is within a run:
    `worn_in(sol)` gives the wear of a run, `with_depths(depths)` the joint with other depths, `wear_out` goes on over
    many turns.  The pin does not wear.
    """

    contacts = ("",)
    where = ("place", "offset")
    DEEPEST = "pin_radius"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.length is not None:
            text = f"{self.label}: length is {self.length:g} m, so the slot has round ends, whose wear is not known"
            raise InputError(f"{text}. Give length=None, and a Stop where the travel has ends.")

    @property
    def rounding(self) -> float:  # type: ignore[override]
        return self.pin_radius

    def _on_upper(self, sol: Any, contact: str, rows: np.ndarray) -> np.ndarray:
        """Whether the pin is above the middle line of the slot."""
        return np.asarray(sol.array(f"{self.name}.{contact}offset")[rows] >= 0.0)

    def _on_sides(self, *p: float) -> tuple[float, ...]:
        play, _, radius, *geometry = p
        return self._numbers((play, 0.0, radius, 0.0, *geometry), self.sides)
