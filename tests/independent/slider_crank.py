"""A slider-crank with play in its piston pin, integrated by hand: a second opinion that shares no line with flexmb.

Two minimal coordinates: the angle phi of the rod and the position x of the slider.  The crank turns at the constant
rate omega, theta = omega t.  R, L: lengths of crank and rod; m: mass of the rod, J_A: its moment of inertia about the
crank pin A; M: mass of the slider.  No gravity.

Play: B is the centre of the bearing on the rod, e points from it to the centre of the journal on the slider, d is the
depth of the contact, v the slip at the point of contact (the rod turns, the slider does not), r the arm of that point:

    B = R (cos theta, sin theta) + L (cos phi, sin phi),   e = (x, 0) - B,   n = e/|e|,   t = (-n_y, n_x)
    d = |e| - c,   d' = ((x', 0) - B') . n,   r = R1 + d/2,   v = ((x', 0) - B') . t - r phi'

Contact, from d = 0 to the next d = 0, with the reference speed u (Lankarani and Nikravesh; Hertz; modified Coulomb):

    N = max(0, K d^(3/2) (1 + chi d'/u)),   K = 4/(3 (s1 + s2)) sqrt(R1 R2/(R1 - R2)),   R2 = R1 - c,   s = (1 - nu^2)/E
    T = -mu N sign(v) min(1, max(0, (|v| - v0)/(v1 - v0)))

    PRINTED  u is the closing speed where the contact began, `least` at least, kept until the surfaces part
    LARGEST  u is the largest since the contact began of d' and -d'/e, `least` at least; the present one counts; e is
             the restitution of a free impact
    HELD     u is a given constant

Equations of motion, where P = -N n + T t acts on the slider and a is the acceleration of A:

    M x'' = P_x,   J_A phi'' = L (sin phi P_x - cos phi P_y) - T r - m L/2 (cos phi a_y - sin phi a_x)

Two accounts are integrated beside them: the work W of the drive, which pushes the rod at A by m a_G + P, and what the
contact loses, Q' = (N - K d^(3/2)) d' - T v.  With the energy E of rod and slider and 2/5 K d^(5/2) in the contact,
E - W + Q stays as it was: in free impacts the cut of N at zero takes nothing.

Steps are of one size, four times as long in free flight; they are split where a contact begins or ends (found to
round-off by repeating the step).  Classical Runge-Kutta steps of order 4; where damping in the contact is too stiff for
them, an L-stable diagonally implicit method of order 3 (R. Alexander, SIAM J. Numer. Anal. 14 (1977) 1006), whose
stages are solved for the closing speed by bracketing.  N begins like t^(3/2), so its first step in contact is wrong by
h^(5/2), the order of the whole.  A largest speed that falls between the ends of steps is missed by h^2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
from restitution import delivered

PRINTED, LARGEST, HELD = 0, 1, 2
OPEN_STEPS = 4.0
"""How much longer a step is in free flight."""
STIFF = 0.5
"""Step times rate of damping from which a step is implicit."""
GAMMA = 0.435866521508459
"""Root of g^3 - 3 g^2 + 3/2 g - 1/6: the diagonal of the implicit method."""
SIGNALS = "peak_force peak_acceleration flight onsets depth closing least_force lowest_onset highest_onset cut".split()
"""Of a turn [N, m/s^2, 1, 1, m, m/s, N, m/s, m/s, 1]: largest force, acceleration of the slider, share of free flight,
contacts that began, largest depth and closing speed in contact, least force in contact, slowest and fastest onset,
share of contact without force."""


class Data(NamedTuple):
    """Numbers of the mechanism [SI].

    Parameters
    ----------
    crank, rod : lengths.
    rod_mass, rod_inertia, slider_mass : the inertia is that about the crank pin.
    omega : rate of the crank.
    clearance, bearing_radius : c and R1.
    stiffness, chi, e : K, the factor of damping, restitution of a free impact.
    mu, v0, v1 : friction.
    variant, least, held : which reference speed, its lower bound, the given one.
    """

    crank: float
    rod: float
    rod_mass: float
    rod_inertia: float
    slider_mass: float
    omega: float
    clearance: float
    bearing_radius: float
    stiffness: float
    chi: float
    e: float
    mu: float
    v0: float
    v1: float
    variant: int
    least: float
    held: float


def data_of(numbers, clearance, omega, *, variant=PRINTED, least=1e-3, held=1.0, mu=0.0) -> Data:
    """`Data` from an object with the fields crank, rod, rod_mass, rod_inertia (about the middle), and so on."""
    n = numbers
    about_pin = n.rod_inertia + n.rod_mass * n.rod**2 / 4.0
    journal, compliance = n.bearing_radius - clearance, 2.0 * (1.0 - n.poisson**2) / n.young
    K = 4.0 / (3.0 * compliance) * math.sqrt(n.bearing_radius * journal / clearance)
    chi = 0.75 * (1.0 - n.restitution**2)
    masses = (n.rod_mass, about_pin, n.slider_mass)
    contact = (clearance, n.bearing_radius, K, chi, delivered(chi))
    return Data(n.crank, n.rod, *masses, omega, *contact, mu, n.v0, n.v1, variant, least, held)


def start(p: Data, ex=0.0, ey=0.0) -> np.ndarray:
    """State at theta = 0 with the journal at rest in its bearing at (ex, ey)."""
    sin_phi = -ey / p.rod
    cos_phi = math.sqrt(1.0 - sin_phi**2)
    spin = -p.crank * p.omega / (p.rod * cos_phi)
    speed = -p.rod * spin * sin_phi
    return np.array([math.asin(sin_phi), p.crank + p.rod * cos_phi + ex, spin, speed, 0.0, 0.0])


@numba.njit(cache=True)
def geometry(t, y, p):
    """Depth, its rate, normal (x, y), slip, arm, and how fast the depth grows with phi."""
    theta, phi, spin, speed = p.omega * t, y[0], y[2], y[3]
    sin_phi, cos_phi = math.sin(phi), math.cos(phi)
    sin_theta, cos_theta = math.sin(theta), math.cos(theta)
    ex = y[1] - p.crank * cos_theta - p.rod * cos_phi
    ey = -p.crank * sin_theta - p.rod * sin_phi
    size = math.sqrt(ex * ex + ey * ey)
    nx, ny = (ex / size, ey / size) if size > 0.0 else (1.0, 0.0)
    vx = speed + p.crank * p.omega * sin_theta + p.rod * spin * sin_phi
    vy = -p.crank * p.omega * cos_theta - p.rod * spin * cos_phi
    depth = size - p.clearance
    arm = p.bearing_radius + 0.5 * depth
    slip = vy * nx - vx * ny - arm * spin
    return depth, vx * nx + vy * ny, nx, ny, slip, arm, p.rod * (sin_phi * nx - cos_phi * ny)


@numba.njit(cache=True)
def normal_force(depth, rate, u, p):
    """N, its derivative by the rate while it is not cut, its elastic part."""
    if depth <= 0.0:
        return 0.0, 0.0, 0.0
    if p.variant == LARGEST:
        u = max(u, rate, -rate / p.e)
    elastic = p.stiffness * depth * math.sqrt(depth)
    return elastic * max(0.0, 1.0 + p.chi * rate / u), elastic * p.chi / u, elastic


@numba.njit(cache=True)
def friction_force(N, slip, p):
    """T on the slider."""
    if p.mu == 0.0:
        return 0.0
    share = min(1.0, max(0.0, (abs(slip) - p.v0) / (p.v1 - p.v0)))
    return -math.copysign(p.mu * N * share, slip)


@numba.njit(cache=True)
def derivatives(t, y, N, elastic, placed, p, out):
    """Rates of the state and of both accounts under the normal force N; `placed` is what `geometry` says."""
    depth, rate, nx, ny, slip, arm, growth = placed
    T = friction_force(N, slip, p)
    Px, Py = -N * nx - T * ny, -N * ny + T * nx
    theta = p.omega * t
    sin_phi, cos_phi = math.sin(y[0]), math.cos(y[0])
    sin_theta, cos_theta = math.sin(theta), math.cos(theta)
    ax, ay = -p.crank * p.omega**2 * cos_theta, -p.crank * p.omega**2 * sin_theta
    half = 0.5 * p.rod
    moment = p.rod * (sin_phi * Px - cos_phi * Py) - T * arm
    bend = (moment - p.rod_mass * half * (cos_phi * ay - sin_phi * ax)) / p.rod_inertia
    out[0], out[1], out[2], out[3] = y[2], y[3], bend, Px / p.slider_mass
    push_x = p.rod_mass * (ax - half * (bend * sin_phi + y[2] ** 2 * cos_phi)) + Px
    push_y = p.rod_mass * (ay + half * (bend * cos_phi - y[2] ** 2 * sin_phi)) + Py
    out[4] = p.crank * p.omega * (push_y * cos_theta - push_x * sin_theta)
    out[5] = (N - elastic) * rate - T * slip


@numba.njit(cache=True)
def evaluate(t, y, touching, u, p, out):
    """Rates of the state; N, depth, closing speed, rate of damping [1/s]."""
    placed = geometry(t, y, p)
    N, slope, elastic = normal_force(placed[0], placed[1], u, p) if touching else (0.0, 0.0, 0.0)
    derivatives(t, y, N, elastic, placed, p, out)
    mobility = placed[6] ** 2 / p.rod_inertia + placed[2] ** 2 / p.slider_mass
    return N, placed[0], placed[1], slope * mobility


@numba.njit(cache=True)
def runge_kutta(t, h, y, touching, u, p, k, new):
    """One classical step from y to `new`; k[0] holds the rates at y."""
    for stage, share in ((1, 0.5), (2, 0.5), (3, 1.0)):
        for i in range(6):
            new[i] = y[i] + share * h * k[stage - 1, i]
        evaluate(t + share * h, new, touching, u, p, k[stage])
    for i in range(6):
        new[i] = y[i] + h / 6.0 * (k[0, i] + 2.0 * k[1, i] + 2.0 * k[2, i] + k[3, i])


@numba.njit(cache=True)
def closing_speed(free, mobility, depth, rate, share, u, p):
    """The rate that fits the force it causes: rate = free - share mobility N(depth, rate), depth moving with it.

    depth and rate belong together; the left side less the right one rises with the rate, so the root is bracketed.
    """
    kappa = share * mobility
    high = free
    low = high - kappa * normal_force(depth + share * (high - rate), high, u, p)[0]
    for _ in range(200):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if middle - free + kappa * normal_force(depth + share * (middle - rate), middle, u, p)[0] > 0.0:
            high = middle
        else:
            low = middle
    return high


@numba.njit(cache=True)
def implicit_stage(t, share, base, u, p, y, k):
    """Solve y = base + share k(t, y) for the stage y and its rates k; y comes in as a guess."""
    for _ in range(8):
        before = y[2:4].copy()
        placed = geometry(t, y, p)
        N, _, _ = normal_force(placed[0], placed[1], u, p)
        derivatives(t, y, 0.0, 0.0, placed, p, k)
        spin, speed = base[2] + share * k[2], base[3] + share * k[3]
        free = placed[1] + placed[6] * (spin - y[2]) + placed[2] * (speed - y[3])
        mobility = placed[6] ** 2 / p.rod_inertia + placed[2] ** 2 / p.slider_mass
        rate = closing_speed(free, mobility, placed[0], placed[1], share, u, p)
        N, _, elastic = normal_force(placed[0] + share * (rate - placed[1]), rate, u, p)
        derivatives(t, y, N, elastic, placed, p, k)
        y[2], y[3] = base[2] + share * k[2], base[3] + share * k[3]
        y[0], y[1] = base[0] + share * y[2], base[1] + share * y[3]
        k[0], k[1] = y[2], y[3]
        if abs(y[2] - before[0]) <= 1e-13 * abs(y[2]) and abs(y[3] - before[1]) <= 1e-14 * (1.0 + abs(y[3])):
            break
    for i in (4, 5):
        y[i] = base[i] + share * k[i]


@numba.njit(cache=True)
def implicit(t, h, y, u, p, k, new):
    """One step of Alexander's method from y to `new`, in contact."""
    g, middle = GAMMA, 0.5 * (1.0 + GAMMA)
    b1, b2 = -0.25 * (6.0 * g * g - 16.0 * g + 1.0), 0.25 * (6.0 * g * g - 20.0 * g + 5.0)
    base = y.copy()
    new[:] = y
    implicit_stage(t + g * h, g * h, base, u, p, new, k[1])
    base[:] = y + h * (middle - g) * k[1]
    implicit_stage(t + middle * h, g * h, base, u, p, new, k[2])
    base[:] = y + h * (b1 * k[1] + b2 * k[2])
    implicit_stage(t + h, g * h, base, u, p, new, k[3])


@numba.njit(cache=True)
def take_step(t, h, y, touching, u, stiff, p, k, new):
    """One step of either method; the depth at its end."""
    if stiff:
        implicit(t, h, y, u, p, k, new)
    else:
        runge_kutta(t, h, y, touching, u, p, k, new)
    return geometry(t + h, new, p)[0]


@numba.njit(cache=True)
def split(t, h, y, touching, u, stiff, p, k, new):
    """Repeat a step of h, shorter, so that it ends where the depth changes its sign; its length."""
    low, high = 0.0, h
    for _ in range(60):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if (take_step(t, middle, y, touching, u, stiff, p, k, new) > 0.0) == touching:
            low = middle
        else:
            high = middle
    take_step(t, high, y, touching, u, stiff, p, k, new)
    return high


@numba.njit(cache=True)
def note(signals, N, acceleration, depth, rate, share):
    """Note a state in contact."""
    signals[0], signals[1] = max(signals[0], N), max(signals[1], abs(acceleration))
    signals[4], signals[5] = max(signals[4], depth), max(signals[5], rate)
    signals[6] = min(signals[6], N)
    if N == 0.0 and depth > 0.0:
        signals[9] += share


@numba.njit(cache=True)
def begun(rate, memory, signals, p):
    """Note that a contact begins; its reference speed."""
    memory[0] = 1.0
    memory[1] = p.held if p.variant == HELD else max(rate, p.least)
    signals[3] += 1.0
    signals[7], signals[8] = min(signals[7], rate), max(signals[8], rate)


@numba.njit(cache=True)
def go(begin, end, step, y, memory, signals, p):
    """Carry state y and memory (in contact or not, reference speed) from begin to end; note the signals of a turn."""
    k, new, t = np.zeros((4, 6)), np.zeros(6), begin
    while t < end:
        touching, u = memory[0] > 0.0, memory[1]
        N, depth, rate, damping = evaluate(t, y, touching, u, p, k[0])
        h = min(step if touching else OPEN_STEPS * step, end - t)
        last = h == end - t
        if touching:
            note(signals, N, k[0, 3], depth, rate, h / (end - begin))
        stiff = h * damping > STIFF
        reached = take_step(t, h, y, touching, u, stiff, p, k, new)
        crossed = (reached > 0.0) != touching
        if crossed:
            evaluate(t, y, touching, u, p, k[0])
            whole, h = h, split(t, h, y, touching, u, stiff, p, k, new)
            last = last and h == whole
        y[:] = new
        t = end if last else t + h
        if not touching:
            signals[2] += h
        if crossed and touching:
            memory[0], memory[1] = 0.0, 0.0
        elif crossed:
            begun(geometry(t, y, p)[1], memory, signals, p)
        elif touching and p.variant == LARGEST:
            rate = geometry(t, y, p)[1]
            memory[1] = max(u, rate, -rate / p.e)


@numba.njit(cache=True)
def turns(first, count, step, y, memory, p):
    """Signals of `count` turns after `first` of them, and state and memory at the end of each; y and memory go on."""
    period = 2.0 * math.pi / p.omega
    signals, ends = np.zeros((count, 10)), np.zeros((count, 8))
    for i in range(count):
        signals[i, 6] = signals[i, 7] = np.inf
        signals[i, 8] = -np.inf
        go((first + i) * period, (first + i + 1) * period, step, y, memory, signals[i], p)
        signals[i, 2] /= period
        ends[i, :6], ends[i, 6:] = y, memory
    return signals, ends


@numba.njit(cache=True)
def growth(first, count, step, y, memory, p, apart):
    """Logarithms, one a turn, of how fast a neighbour at the distance `apart` [m] moves away (Benettin).

    Once a turn the neighbour is put back to its distance along the line between the two, its reference speed with it.
    """
    weights = np.array([p.rod, 1.0, p.rod / p.omega, 1.0 / p.omega])
    period, logs, unused = 2.0 * math.pi / p.omega, np.zeros(count), np.zeros(10)
    other, kept = y.copy(), memory.copy()
    other[:4] += apart * np.array([0.5, 0.5, 0.5, 0.5]) / weights
    for i in range(count):
        begin, end = (first + i) * period, (first + i + 1) * period
        go(begin, end, step, y, memory, unused, p)
        go(begin, end, step, other, kept, unused, p)
        away = math.sqrt(np.sum((weights * (other[:4] - y[:4])) ** 2))
        logs[i] = math.log(away / apart)
        other[:] = y + apart / away * (other - y)
        if kept[0] == memory[0]:
            kept[1] = memory[1] + apart / away * (kept[1] - memory[1])
        else:
            kept[:] = memory
    return logs


@numba.njit(cache=True)
def energy(t, y, memory, p):
    """E - W + Q: kinetic energy of rod and slider and energy in the contact, less work of the drive, plus losses."""
    theta, half = p.omega * t, 0.5 * p.rod
    vx = -p.crank * p.omega * math.sin(theta) - half * y[2] * math.sin(y[0])
    vy = p.crank * p.omega * math.cos(theta) + half * y[2] * math.cos(y[0])
    about_centre = p.rod_inertia - p.rod_mass * half**2
    moving = 0.5 * (p.rod_mass * (vx**2 + vy**2) + about_centre * y[2] ** 2 + p.slider_mass * y[3] ** 2)
    depth = geometry(t, y, p)[0] if memory[0] > 0.0 else 0.0
    return moving + 0.4 * p.stiffness * max(depth, 0.0) ** 2.5 - y[4] + y[5]
