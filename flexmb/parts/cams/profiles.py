"""Profiles of cams, from lift laws of their followers.

A jet is an array (orders, n) of derivatives 0, 1, 2, ... at n places, each divided by the factorial of its order.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.display import Shown
from flexmb.errors import InputError
from flexmb.fields import Input, field, one_of, record, several, vector
from flexmb.parts.cams.curves import ClosedCurve, hermite_spans, sampled

# Truncated Taylor series in one variable: functions with their derivatives, multiplied and composed

Jet = np.ndarray


def constant(value: float, like: Jet) -> Jet:
    """Jet of a constant, of the shape of another jet."""
    jet = np.zeros_like(like)
    jet[0] = value
    return jet


def slope(jet: Jet) -> Jet:
    """Jet of the derivative, one order shorter."""
    return np.array([(k + 1) * jet[k + 1] for k in range(len(jet) - 1)])


def times(a: Jet, b: Jet) -> Jet:
    """Product, of the shorter order."""
    orders = min(len(a), len(b))
    return np.array([sum(a[i] * b[k - i] for i in range(k + 1)) for k in range(orders)])


def cos_sin(jet: Jet) -> tuple[Jet, Jet]:
    """Cosine and sine of a jet, by their differential equations."""
    c, s = np.zeros_like(jet), np.zeros_like(jet)
    c[0], s[0] = np.cos(jet[0]), np.sin(jet[0])
    for k in range(1, len(jet)):
        c[k] = -sum(i * jet[i] * s[k - i] for i in range(1, k + 1)) / k
        s[k] = sum(i * jet[i] * c[k - i] for i in range(1, k + 1)) / k
    return c, s


def over(a: Jet, b: Jet) -> Jet:
    """Quotient, of the shorter order."""
    orders = min(len(a), len(b))
    found = np.zeros((orders, *np.shape(a)[1:]))
    for k in range(orders):
        found[k] = (a[k] - sum(found[i] * b[k - i] for i in range(k))) / b[0]
    return found


ORDERS = 5  # number of derivatives of a lift, from the lift itself on
# Coefficients of the normalised laws x(u), from the constant on.
POLYNOMIALS = {"3-4-5": (0.0, 0.0, 0.0, 10.0, -15.0, 6.0), "4-5-6-7": (0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0)}
LAWS = ("cycloidal", *POLYNOMIALS, "harmonic")  # names of the laws


@record
class Lift(Input, Shown):
    """Lift of a follower over the cam angle: stations, joined by a law of rise and fall.

    Cam angles increase within a turn; lifts are in m, of an oscillating follower in rad.  Equal lifts of neighbours are
    a dwell.  The last station is followed by the first one, a turn later.

    Laws: "cycloidal", u - sin(2 pi u)/(2 pi); "3-4-5" or "4-5-6-7", polynomials with these powers; "harmonic",
    (1 - cos(pi u))/2, whose acceleration jumps at dwells.

    Raises
    ------
    InputError : fewer than two stations, angles that do not increase or span a turn, an unknown law.

    Notes
    -----
    Source: R. L. Norton, Cam Design and Manufacturing Handbook, 2nd ed., Industrial Press 2009, ch. 2 and 3.

    Examples
    --------
    >>> lift = Lift(((0.0, 0.0), (1.0, 0.01), (2.0, 0.01), (3.0, 0.0)), law="cycloidal")
    >>> lift.at(0.5)[0]
    0.005
    """

    stations: tuple[tuple[float, float], ...] = field(
        "pairs (angle, lift)", "rad and m", several(vector, "pairs (angle, lift)")
    )
    law: str = field("law of the rises and falls", rule=one_of(*LAWS), default="cycloidal")

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.stations) < 2:
            raise InputError(f"Lift: {len(self.stations)} stations; give at least two, e.g. ((0.0, 0.0), (1.0, 0.01)).")
        angles = [angle for angle, _ in self.stations]
        for k, (before, after) in enumerate(pairwise([*angles, angles[0] + 2.0 * math.pi])):
            if after <= before:
                text = f"Lift: the angle of station {k} is {before:g} rad and that of the next one {after:g} rad;"
                raise InputError(f"{text} angles must increase and span less than a turn (2 pi) in all.")

    def intervals(self) -> list[tuple[float, float, float, float]]:
        """Angles at both ends [rad] and lifts at both ends of each interval."""
        (first, lift), turn = self.stations[0], 2.0 * math.pi
        return [(a, b, s, e) for (a, s), (b, e) in pairwise([*self.stations, (first + turn, lift)])]

    def at(self, angle: float) -> tuple[float, float, float]:
        """Lift and two derivatives by the cam angle [m, m/rad, m/rad^2]."""
        first = self.stations[0][0]
        inside = first + (checks.number("Lift", "angle", angle, "rad") - first) % (2.0 * math.pi)
        piece = next((p for p in self.intervals() if inside <= p[1]), self.intervals()[-1])
        values = self.derivatives(piece, np.array([inside]))
        return float(values[0, 0]), float(values[1, 0]), float(values[2, 0])

    def derivatives(self, piece: Any, angles: np.ndarray) -> np.ndarray:
        """Lift and derivatives (ORDERS, n) at `angles` (n,) [rad] in a `piece`: angles and lifts at both ends."""
        begin, end, low, high = piece
        span = end - begin
        found: np.ndarray = (high - low) * normalised(self.law, (angles - begin) / span)
        found /= span ** np.arange(ORDERS)[:, None]
        found[0] += low
        return found


def normalised(law: str, u: np.ndarray) -> np.ndarray:
    """A law from 0 to 1 over u from 0 to 1, and its derivatives (ORDERS, n)."""
    if law in POLYNOMIALS:
        terms = list(enumerate(POLYNOMIALS[law]))
        rows = [[c * math.perm(k, order) * u ** (k - order) for k, c in terms if k >= order] for order in range(ORDERS)]
        return np.array([sum(row) for row in rows])
    turn = math.pi if law == "harmonic" else 2.0 * math.pi
    waves = [turn**order * np.sin(turn * u + 0.5 * math.pi * order) for order in range(ORDERS)]
    if law == "harmonic":
        cosines = [-0.5 * turn**order * np.sin(turn * u + 0.5 * math.pi * (order + 1)) for order in range(ORDERS)]
        cosines[0] = cosines[0] + 0.5
        return np.array(cosines)
    found = [-wave / turn for wave in waves]
    found[0] = found[0] + u
    found[1] = found[1] + 1.0
    return np.array(found)


ACCURACY = 1e-9  # largest error of the second derivative of a profile by the cam angle, over its largest value
FEWEST_SPANS, MOST_SPANS = 4, 256  # numbers of spans of an interval of the lift law
Pair = tuple[Jet, Jet]


def flat_profile(
    lift: Lift, base_radius: float, *, along: tuple[float, float] = (0.0, 1.0), at: tuple[float, float] = (0.0, 0.0)
) -> ClosedCurve:
    """Profile of a cam for a translating follower with a flat face across its motion.

    Parameters
    ----------
    lift : lift over the angle by which the cam has turned counter-clockwise from the reference configuration [m].
    base_radius : distance of the face from the axis at lift 0 [m], > 0.
    along : direction of the motion of the follower.
    at : axis of the cam in the reference configuration [m].

    Returns
    -------
    ClosedCurve : the profile in the reference configuration; the second derivative of the lift is exact to 1e-9.

    Raises
    ------
    InputError : undercut, named with its cam angle: base radius + lift + its second derivative must be > 0.

    Notes
    -----
    With the distance h = base radius + lift of the face and its direction phi in the cam, the profile is h n + h' t.
    Source: R. L. Norton, Cam Design and Manufacturing Handbook, 2nd ed., Industrial Press 2009, ch. 7.
    """
    base = checks.positive("flat_profile", "base_radius", base_radius, "m")
    direction = math.atan2(*checks.direction("flat_profile", "along", along)[::-1])

    def face(angle: Jet, s: Jet) -> tuple[Jet, Jet]:
        return s + constant(base, s), constant(direction, angle) - angle

    return _profile("flat_profile", lift, _envelope(face), at)


def oscillating_flat_profile(
    lift: Lift, pivot: tuple[float, float], *, angle: float, offset: float = 0.0, at: tuple[float, float] = (0.0, 0.0)
) -> ClosedCurve:
    """Profile of a cam for a flat face that swings about a pivot.

    Parameters
    ----------
    lift : swing of the face counter-clockwise [rad] over the angle by which the cam has turned counter-clockwise.
    pivot : pivot in the reference configuration [m].
    angle : direction of the outward normal of the cam at the face at lift 0 [rad].
    offset : distance of the face from the pivot along this normal [m].
    at : axis of the cam in the reference configuration [m].

    Raises
    ------
    InputError : undercut, named with its cam angle.
    """
    name = "oscillating_flat_profile"
    axis, centre = checks.point(name, "pivot", pivot), checks.point(name, "at", at)
    first, away = checks.number(name, "angle", angle, "rad"), checks.number(name, "offset", offset, "m")
    x, y = axis[0] - centre[0], axis[1] - centre[1]

    def face(turn: Jet, s: Jet) -> tuple[Jet, Jet]:
        swung = s + constant(first, s)
        c, d = cos_sin(swung)
        return x * c + y * d + constant(away, s), swung - turn

    return _profile(name, lift, _envelope(face), at)


def roller_profile(
    lift: Lift, base_radius: float, *, roller: float, along: tuple[float, float] = (0.0, 1.0), offset: float = 0.0,
    at: tuple[float, float] = (0.0, 0.0),
) -> ClosedCurve:  # fmt: skip
    """Profile of a cam for a translating roller follower, or a knife edge.

    Parameters
    ----------
    lift : lift over the angle by which the cam has turned counter-clockwise from the reference configuration [m].
    base_radius : radius of the cam at lift 0 [m], > 0.
    roller : radius of the roller [m]; 0: a knife edge.
    along : direction of the motion of the follower.
    offset : distance of the path of the roller's centre from the axis, to the right of the motion [m].
    at : axis of the cam in the reference configuration [m].

    Raises
    ------
    InputError : undercut, named with its cam angle; an offset that is not less than base radius + roller.

    Notes
    -----
    The roller's centre moves on the pitch curve; the profile is its parallel at the distance of the roller's radius.
    Source: R. L. Norton, Cam Design and Manufacturing Handbook, 2nd ed., Industrial Press 2009, ch. 7.
    """
    base = checks.positive("roller_profile", "base_radius", base_radius, "m")
    radius = checks.not_negative("roller_profile", "roller", roller, "m")
    side = checks.number("roller_profile", "offset", offset, "m")
    if abs(side) >= base + radius:
        text = f"roller_profile: offset is {side:g} m;"
        raise InputError(f"{text} it must be less than base radius + roller, {base + radius:g} m.")
    dx, dy = checks.direction("roller_profile", "along", along)
    ux, uy = dx / math.hypot(dx, dy), dy / math.hypot(dx, dy)
    low = math.sqrt((base + radius) ** 2 - side**2)

    def centre(angle: Jet, s: Jet) -> Pair:
        far = s + constant(low, s)
        return ux * far + constant(side * uy, s), uy * far - constant(side * ux, s)

    return _profile("roller_profile", lift, _parallel(centre, radius), at)


def oscillating_roller_profile(
    lift: Lift, pivot: tuple[float, float], *, arm: float, angle: float, roller: float,
    at: tuple[float, float] = (0.0, 0.0),
) -> ClosedCurve:  # fmt: skip
    """Profile of a cam for a roller on an arm that swings about a pivot.

    Parameters
    ----------
    lift : swing of the arm counter-clockwise [rad] over the angle by which the cam has turned counter-clockwise.
    pivot : pivot in the reference configuration [m].
    arm : distance of the roller's centre from the pivot [m], > 0.
    angle : direction from the pivot to the roller at lift 0 [rad].
    roller : radius of the roller [m]; 0: a knife edge.
    at : axis of the cam in the reference configuration [m].

    Raises
    ------
    InputError : undercut, named with its cam angle.
    """
    name = "oscillating_roller_profile"
    axis, origin = checks.point(name, "pivot", pivot), checks.point(name, "at", at)
    length, first = checks.positive(name, "arm", arm, "m"), checks.number(name, "angle", angle, "rad")
    radius = checks.not_negative(name, "roller", roller, "m")

    def centre(turn: Jet, s: Jet) -> Pair:
        c, d = cos_sin(s + constant(first, s))
        return length * c + constant(axis[0] - origin[0], s), length * d + constant(axis[1] - origin[1], s)

    return _profile(name, lift, _parallel(centre, radius), at)


def _envelope(face: Callable[[Jet, Jet], Pair]) -> Callable[[Jet, Jet], tuple[Jet, Jet, np.ndarray]]:
    """Envelope h n + (dh/dphi) t of faces at distance h and direction phi in the cam, and its radius of curvature."""

    def curve(angle: Jet, s: Jet) -> tuple[Jet, Jet, np.ndarray]:
        h, phi = face(angle, s)
        c, d = cos_sin(phi)
        across = over(slope(h), slope(phi))
        bend = h[:-2] + over(slope(across), slope(phi))[: len(h) - 2]
        return times(h, c)[:-1] - times(across, d), times(h, d)[:-1] + times(across, c), bend[0]

    return curve


def _parallel(centre: Callable[[Jet, Jet], Pair], radius: float) -> Callable[[Jet, Jet], tuple[Jet, Jet, np.ndarray]]:
    """Parallel of the pitch curve at `radius` towards the axis; and how fast it goes, over the pitch curve."""

    def curve(angle: Jet, s: Jet) -> tuple[Jet, Jet, np.ndarray]:
        X, Y = centre(angle, s)
        c, d = cos_sin(angle)
        x, y = times(X, c) + times(Y, d), times(Y, c) - times(X, d)
        dx, dy = slope(x), slope(y)  # clockwise, so the outward normal stands on the left
        # Square root of a jet > 0
        jet = times(dx, dx) + times(dy, dy)
        speed = np.zeros_like(jet)
        speed[0] = np.sqrt(jet[0])
        for k in range(1, len(jet)):
            speed[k] = (jet[k] - sum(speed[i] * speed[k - i] for i in range(1, k))) / (2.0 * speed[0])
        px, py = x[:-1] + radius * over(dy, speed), y[:-1] - radius * over(dx, speed)
        return px, py, (slope(px)[0] * dx[0] + slope(py)[0] * dy[0]) / speed[0] ** 2

    return curve


def _profile(name: str, lift: Lift, curve: Any, at: tuple[float, float]) -> ClosedCurve:
    """The profile with as many spans as ACCURACY needs, or `InputError` for undercut."""
    # The curve gives x, y and a number > 0 by the jets of cam angle and lift; `at` is the axis of the cam [m].
    checks.instance(name, "lift", lift, Lift, "a Lift")
    x, y = checks.point(name, "at", at)

    def derivatives(piece: Any, angles: np.ndarray) -> np.ndarray:
        turn = np.zeros((5, len(angles)))
        turn[0], turn[1] = angles, 1.0
        jet = np.array([row / math.factorial(k) for k, row in enumerate(lift.derivatives(piece, angles))])
        px, py, sound = curve(turn, jet)
        if not np.all(sound > 0.0):
            k = int(np.argmin(np.where(np.isnan(sound), -np.inf, sound)))
            text = f"{name}: undercut at the cam angle {angles[k]:.4f} rad ({math.degrees(angles[k]):.1f} degrees):"
            text += " the profile would cross itself there."
            raise InputError(f"{text} Make the base radius larger, the rise slower, or the roller smaller.")
        return np.array([row * math.factorial(k) for k, row in enumerate(np.stack([px, py], axis=1))])

    found = []  # spans (n, 2, 8) of the profile over each interval of the lift law
    for piece in lift.intervals():
        count, error = FEWEST_SPANS, math.inf
        while not error <= ACCURACY and count <= MOST_SPANS:
            angles = np.linspace(piece[0], piece[1], count + 1)
            steps, ends = np.diff(angles), derivatives(piece, angles)
            own = hermite_spans(ends[..., :-1], ends[..., 1:], steps)
            middle = derivatives(piece, angles[:-1] + 0.5 * steps)[2].T
            bend = sampled(own, 2, 2)[1::2] / steps[:, None] ** 2
            error, count = np.abs(bend - middle).max() / np.abs(middle).max(), 2 * count
        found.append(own)
    spans = np.concatenate(found)
    spans[:, :, 0] += (x, y)
    return ClosedCurve(spans[:, :, 0], spans)
