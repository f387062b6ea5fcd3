"""Journal and slider bearings: joints with clearance and a film of oil, dry contact where their surfaces meet."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import KW_ONLY, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
import scipy.optimize

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import field, instance, record, record_with
from flexmb.findings.finding import Finding, found
from flexmb.kernels import compiled, signal_kernel
from flexmb.model.contributions import Contribution, signal_contributions
from flexmb.model.massless import massless
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import WatchedMotion
from flexmb.parts.bearings import kernels
from flexmb.parts.bearings.film import PADS
from flexmb.parts.bearings.kernels import thickness
from flexmb.parts.bearings.laws import Film, Oil, Oiled, ShortBearing
from flexmb.parts.joints.prismatic import PrismaticClearance
from flexmb.parts.joints.revolute import RevoluteClearance
from flexmb.places import packed

if TYPE_CHECKING:
    from flexmb.parts.wear.worn_bearing import WornBearing
    from flexmb.parts.wear.worn_joint import Wear


TRIED = 72  # number of angles of a bearing with grooves between which its place under a load is found
MOST = 2000  # number of iterations in which an eccentricity is found


@record_with(eq=False)
class FilmEquilibrium:
    """Journal that a film carries at constant load and speed; axes along the load, and 90 degrees ahead in the spin."""

    eccentricity: float = field("over the clearance")
    attitude: float = field("angle from the load to the line of centres, in the direction of the spin", "rad")
    stiffness: np.ndarray = field("coefficients (2, 2) of the film: minus the derivatives of its force", "N/m")
    damping: np.ndarray = field("the same by the velocity", "N s/m")
    film_thickness: float = field("as the signal of the joint", "m")
    pressure: float = field("as the signal of the joint", "Pa")
    power: float = field("as the signal of the joint", "W")
    flow: float = field("as the signal of the joint", "m3/s")
    equivalent_stiffness: float = field("of the film against the whirl at the limit of stability", "N/m")
    whirl_ratio: float = field("whirl over spin there; 0: the journal is stable at every mass")
    critical_mass: float = field("mass carried by the film above which a rigid rotor whirls; inf: none", "kg")


def equilibrium(
    label: str, p: tuple[float, ...], play: float, load: float, speed: float, direction: float
) -> FilmEquilibrium:
    """Equilibrium of a film of parameters `p` at eccentricities up to `play`, see `JournalBearing.equilibrium`."""
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
        finest = {"xtol": sys.float_info.min, "rtol": 1e-15, "maxiter": MOST}
        return float(scipy.optimize.brentq(beyond, 0.0, play, (turn,), **finest))

    places = {turn: under(turn) for turn in _turns(numbers, under, speed, direction)}
    short = {turn: beyond(e, turn) for turn, e in places.items() if e == play and beyond(e, turn) < 0.0}
    if len(short) == len(places):
        most = load + max(short.values(), default=-load)
        text = f"{label}: load is {load:g} N;"
        text += f" at {speed:g} rad/s the film carries up to {most:.4g} N before the surfaces touch."
        raise InputError(f"{text} Lower the load, or give a higher speed, a thicker oil or less roughness.")
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
    (thickness, pressure, power, flow), attitude = told, math.atan2(axes[1, 0], axes[0, 0])
    place = float(e / numbers[kernels.CLEARANCE]), attitude, K, B
    return FilmEquilibrium(*place, thickness, pressure, power, flow, *_whirl(K, B, speed))


def _turns(p: np.ndarray, under: Callable[[float], float], speed: float, direction: float) -> list[float]:
    """Angles of a bearing with grooves for which the film carries a load along a direction, its journal at (e, 0)."""
    # `under`: eccentricity e by angle. First is the angle to which the load's own direction is nearest, ahead in spin.
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


# Clearance over radius up to which the gap counts as thin: the theory of thin films neglects terms of this size.
THIN = 0.01
# Reynolds number of the film times sqrt(clearance/radius) from which vortices stand in it (G. I. Taylor 1923).
TAYLOR = 41.2


@record
class JournalBearing(Oiled, RevoluteClearance):
    """Revolute joint with an oil film: the first body carries the bearing, the second one the journal.

    The film acts everywhere.  Where its least thickness falls below `roughness`, the surfaces touch through it, with
    the given laws of normal force and friction: both act together, and either alone is the limit of the other.

    Signals: those of `RevoluteClearance` for the dry contact, where penetration counts from the height of the roughness
    and normal_force, friction_force, fx, fy, force are of the contact alone; film_thickness (clearance less
    eccentricity) [m], pressure (largest of the film) [Pa], power (that the film turns into heat) [W], flow (of oil, out
    at both sides) [m3/s], attitude (from the load on the film to the eccentricity, positive in the direction of
    positive spin) [rad]; film_fx, film_fy [N], film_torque (on the second body, about the journal's centre) [N m].

    Raises
    ------
    InputError : a value out of range, a roughness that is not small beside the clearance, further ones of
        `RevoluteClearance`.

    Notes
    -----
    Both bodies may turn: squeeze and wedge count beside the mean of both spins, so results are free of the frame.
    Between surfaces that are pressed into each other the film stays as thick as half of the roughness.
    What the film takes is dissipated_damping in the balance of energies.
    Analyses that replace the joint by an ideal one (modes, inverse dynamics) have the film about the centred journal.
    """

    _: KW_ONLY
    film: Film = field("film of oil", rule=instance(Film, "a film, e.g. ShortBearing(viscosity=0.02, width=0.012)"))

    lost_when: ClassVar[str] = "the journal passes through its bearing"

    @property
    def oiled(self) -> Any:
        return self

    def pressures(
        self, directions: np.ndarray, place: np.ndarray, rate: np.ndarray, turns: np.ndarray, spins: np.ndarray
    ) -> np.ndarray:
        """Pressure of the film (n,) in the middle of its width [Pa] by direction (n,) [rad], in world axes.

        Parameters
        ----------
        directions : from the centre of the bearing [rad].
        place, rate : centre of the journal less that of the bearing (2,), and its rate (2,) [m, m/s].
        turns, spins : angles and angular velocities of bearing and journal (2,) [rad, rad/s].
        """
        (x, y), (vx, vy), spin = place, rate, 0.5 * float(np.sum(spins))
        size, along = math.hypot(x, y), math.atan2(y, x)
        cos, sin, ux, uy, c = math.cos(along), math.sin(along), vx + spin * y, vy - spin * x, self.clearance
        h, _ = kernels.thickness(c - size, self.roughness)
        motion = 1.0 - h / c, (cos * ux + sin * uy) / c, (sin * ux - cos * uy) / c
        widest = along + math.pi
        return self.film.pressures(self.bearing_radius, c, motion, directions - widest, widest - float(turns[0]))

    def worn_by(self, wear: Wear) -> WornBearing:
        """The joint with a surface that wears where the surfaces touch through the film, unworn so far.

        Parameters
        ----------
        wear : law of wear, e.g. Archard(bearing=1e-13).

        Raises
        ------
        InputError : a film that is not a `ShortBearing` with positive pressure.
        """
        from flexmb.parts.wear.worn_bearing import WornBearing  # noqa: PLC0415 - it is a journal bearing itself
        from flexmb.parts.wear.worn_joint import worn  # noqa: PLC0415

        return worn(self, JournalBearing, WornBearing, wear=wear)

    def equilibrium(self, load: float, speed: float, direction: float = -0.5 * math.pi) -> FilmEquilibrium:
        """Place of the journal, stiffness and damping of the film, under a constant `load` [N] at a `speed` [rad/s].

        The bearing stands still and the dry contact is left out.  `direction`: of the load, in the frame of the
        bearing's body [rad]; it counts where the oil comes from grooves.

        Raises
        ------
        InputError : a load that the film cannot carry before the surfaces touch, a speed of 0.
        """
        return equilibrium(self.label, self.numbers((0.0, 0.0), (0.0, 0.0)), self.play, load, speed, direction)

    def warmed(self, oil: Oil, inlet: float, load: float, speed: float, direction: float = -0.5 * math.pi) -> Self:
        """Same joint, with the viscosity of `oil` at the temperature to which a constant `load` and `speed` heat it.

        `inlet`: temperature of the oil that is supplied [degC]; `load` [N], `speed` [rad/s] and `direction` [rad] as of
        `equilibrium`.

        Raises
        ------
        InputError : a load that the warm film cannot carry, a film from which no oil flows or that gets warmer than 250
            degC, a speed of 0.
        """

        def of_film(viscosity: float) -> tuple[float, float]:
            found = self._thickened(viscosity).equilibrium(load, speed, direction)
            return found.power, found.flow

        return self._thickened(self._warm(oil, inlet, of_film))

    def warmed_by(self, oil: Oil, inlet: float, power: float, flow: float) -> Self:
        """Same joint, with the viscosity of `oil` at the temperature to which the means of a run heat its film.

        A few runs settle, each with the joint of the one before; the film is uniformly warm and stores no heat.
        `inlet`: temperature of the oil that is supplied [degC]; `power` [W] and `flow` [m3/s]: means of these signals
        over whole periods.

        Raises
        ------
        InputError : a film from which no oil flows or that gets warmer than 250 degC, a power below 0.
        """
        power = checks.not_negative(self.label, "power", power, "W")
        of_film = lambda viscosity: (power * viscosity / self.film.viscosity, flow)  # noqa: E731 - at the same motion
        return self._thickened(self._warm(oil, inlet, of_film))

    def _warm(self, oil: Oil, inlet: float, of_film: Callable[[float], tuple[float, float]]) -> float:
        """Viscosity of `oil` where its heat keeps it."""
        if not isinstance(oil, Oil):
            text = f"{self.label}: oil is {type(oil).__name__}; it must be an oil"
            raise InputError(f"{text}, e.g. Oil(viscosities=((40.0, 0.04), (100.0, 0.006))).")
        return oil.viscosity(oil.balanced(inlet, of_film))

    def _thickened(self, viscosity: float) -> Self:
        return replace(self, film=replace(self.film, viscosity=viscosity))

    def numbers(self, first: tuple[float, float], second: tuple[float, float]) -> tuple[float, ...]:
        """Parameters of the kernels; `first`, `second`: offsets of both points in the frames of their nodes [m]."""
        own = self.film.numbers(self.bearing_radius, self.clearance)
        own |= {kernels.HEIGHT: self.roughness, kernels.CHOSEN: 0.0}
        own |= dict(enumerate((*first, *second), kernels.OFFSET1_X))
        thinnest = kernels.KEPT * self.roughness / self.clearance
        return (*packed(own), *self.film.table(self.label, self.bearing_radius, thinnest))

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        ends = self.ends(mechanism)
        coordinates, p = ends.coordinates, self.numbers(ends.first.offset, ends.second.offset)
        told, before, behind = (kernels.film_signal, kernels.SIGNALS), p[: kernels.CHOSEN], p[kernels.CHOSEN + 1 :]
        signals = signal_contributions(self.name, *told, coordinates, before, behind=behind)
        film = kernels.JOURNAL_FILM.contribution(self.name, coordinates, p)
        return [*super().contributions(mechanism), film, *signals]

    def findings_before(self, mechanism: Mechanism) -> Iterator[Finding]:  # noqa: ARG002
        """Finding on a gap that is not thin."""
        ratio = self.clearance / self.bearing_radius
        if ratio > THIN:
            text = f"{self.label} has a clearance of {ratio:.3g} of its radius; films are thin up to {THIN:g}."
            remedy = "Errors are of that size: take a smaller clearance, or take the result as an estimate."
            yield found("thick-film", (self.name,), text, remedy, ratio=ratio, limit=THIN)

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:  # noqa: ARG002
        """Finding on a film that is not laminar."""
        speed, when = motion.peak(f"{self.name}.omega")
        oil, radius = self.film, self.bearing_radius
        reynolds = oil.density * speed * radius * self.clearance / oil.viscosity
        limit = TAYLOR * (radius / self.clearance) ** 0.5
        if reynolds > limit:
            text = f"At t = {when:.6g} s the Reynolds number of the film of {self.label} is {reynolds:.4g}; "
            text += f"it is laminar up to {limit:.4g}."
            remedy = "Forces and losses are larger than computed: take a smaller clearance or a thicker oil."
            yield found("turbulent-film", (self.name,), text, remedy, time=when, reynolds=reynolds, limit=limit)


# Plane slider bearing: with the offset y of the slider across its guide, its tilt tau and the speed U along it, oil is
# squeezed or dragged into the gap of one face at each place s along the slider, where g = y' - U tau/2 + s tau' says
# which.  Equations (15.9) and (15.10) of docs/theory/films.md.

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
