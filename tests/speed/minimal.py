"""The rigid slider-crank by hand: the equations that somebody would write down for this one mechanism.

Ideal joints, turning freely: one coordinate, the crank's angle; M(theta) theta'' = -M'(theta) theta'^2/2.  The energy
stays what it was, so that the time of an angle is a quadrature: exact.

Play between rod and slider, crank at constant speed: two coordinates, the rod's angle phi and the slider's place x.
With crank pin A = r (cos, sin)(w t), bearing centre B = A + l (cos, sin)(phi), e = (x, 0) - B, n = e/|e|, t across:
depth d = |e| - c, its rate d' = e' . n, slip s = e' . t - R phi' with R = R1 + d/2 the arm of the contact point;
N = K d^1.5 (1 + 3/4 (1 - e^2) d'/d'_0), T = -mu N clip(s/v1, -1, 1);
P = -N n + T t on the slider; -P and the moment T R on the rod.
The right-hand sides are Python; `compiled()` gives the same ones through numba.
"""

import math
from functools import lru_cache

import models as m
import numba
import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

R, L, W = m.CRANK, m.ROD, m.OMEGA
HALF = 0.5 * L
AT_PIN = m.ROD_INERTIA + m.ROD_MASS * HALF**2  # inertia of the rod about the crank pin
CRANK_AT_AXLE = m.CRANK_INERTIA + m.CRANK_MASS * (0.5 * R) ** 2
STIFFNESS = m.hertz()
DAMPING = 0.75 * (1.0 - m.RESTITUTION**2)
BEARING, ZONE = m.BEARING, m.SLIDING_ZONE
ROD_MASS, ROD_INERTIA, SLIDER_MASS = m.ROD_MASS, m.ROD_INERTIA, m.SLIDER_MASS


# Ideal joints, turning freely.


def inertia(theta):
    """M and dM/dtheta [kg m^2] of the ideal slider-crank."""
    sin, cos = math.sin(theta), math.cos(theta)
    s, ds = R * sin / L, R * cos / L
    c = math.sqrt(1.0 - s * s)
    k = R * cos / (L * c)  # rod's rate over the crank's, backwards
    dk = -R * sin / (L * c) + R * cos * s * ds / (L * c * c * c)
    x, dx = -R * sin - L * k * s, -R * cos - L * (dk * s + k * ds)
    along, d_along = 0.5 * (x - R * sin), 0.5 * (dx - R * cos)
    across, d_across = 0.5 * R * cos, -0.5 * R * sin
    M = CRANK_AT_AXLE + ROD_MASS * (along * along + across * across) + ROD_INERTIA * k * k + SLIDER_MASS * x * x
    dM = ROD_MASS * (along * d_along + across * d_across) + ROD_INERTIA * k * dk + SLIDER_MASS * x * dx
    return M, 2.0 * dM


def free_rates(t, y):
    """Rates of (theta, theta')."""
    M, dM = inertia(y[0])
    return np.array([y[1], -0.5 * dM * y[1] * y[1] / M])


def exact_angle(t):
    """The crank's angle at time t of the free slider-crank that starts with W at 0 [rad]."""
    start = inertia(0.0)[0]

    def duration(until):
        return (
            quad(lambda a: math.sqrt(inertia(a)[0] / start), 0.0, until, epsabs=1e-13, epsrel=1e-12, limit=400)[0] / W
        )

    turn = duration(2.0 * math.pi)

    def time_of(theta):
        whole, rest = divmod(theta, 2.0 * math.pi)
        return whole * turn + duration(rest)

    return brentq(lambda a: time_of(a) - t, 0.0, 2.0 * W * t, xtol=1e-15, rtol=1e-15)


# Play between rod and slider.


def contact(t, y, clearance, mu, approach):
    """Depth, its rate, normal force, force on the slider (x, y), moment on the rod."""
    phi, x, spin, speed = y
    sp, cp, st, ct = math.sin(phi), math.cos(phi), math.sin(W * t), math.cos(W * t)
    ex, ey = x - R * ct - L * cp, -R * st - L * sp
    vx, vy = speed + R * W * st + L * spin * sp, -R * W * ct - L * spin * cp
    size = math.sqrt(ex * ex + ey * ey)
    if size == 0.0:
        return -clearance, 0.0, 0.0, 0.0, 0.0, 0.0
    nx, ny = ex / size, ey / size
    depth, rate = size - clearance, vx * nx + vy * ny
    if depth <= 0.0 or approach <= 0.0:
        return depth, rate, 0.0, 0.0, 0.0, 0.0
    N = STIFFNESS * depth * math.sqrt(depth) * (1.0 + DAMPING * rate / approach)
    arm = BEARING + 0.5 * depth
    slip = vy * nx - vx * ny - spin * arm
    T = -mu * N * min(max(slip / ZONE, -1.0), 1.0)
    return depth, rate, N, -N * nx - T * ny, -N * ny + T * nx, -T * arm


def worn_rates(t, y, clearance, mu, approach):
    """Rates of (phi, x, phi', x')."""
    _, _, _, px, py, moment = contact(t, y, clearance, mu, approach)
    phi = y[0]
    sp, cp = math.sin(phi), math.cos(phi)
    ax, ay = -W * W * R * math.cos(W * t), -W * W * R * math.sin(W * t)
    turning = L * (sp * px - cp * py) + moment + ROD_MASS * HALF * (sp * ax - cp * ay)
    return np.array([y[2], y[3], turning / AT_PIN, px / SLIDER_MASS])


def torque(t, y, law):
    """Torque of the drive: what the crank needs to carry the rod's end [N m]."""
    phi, _, spin, _ = y
    _, _, _, px, py, _ = contact(t, y, *law)
    turning = worn_rates(t, y, *law)[2]
    ax = -W * W * R * math.cos(W * t) - HALF * (turning * math.sin(phi) + spin**2 * math.cos(phi))
    ay = -W * W * R * math.sin(W * t) + HALF * (turning * math.cos(phi) - spin**2 * math.sin(phi))
    return R * (math.cos(W * t) * (ROD_MASS * ay + py) - math.sin(W * t) * (ROD_MASS * ax + px))


# After an event the gap is zero but for round-off of either sign: a first step gets away from there, and no step may
# jump over a whole flight or a whole contact, which scipy would not see.
FIRST_STEP, LARGEST_STEP = 1e-7, 1e-5
START = (0.0, m.CRANK + m.ROD, -W * m.CRANK / m.ROD, 0.0)


@lru_cache
def compiled():
    """(free, worn) right-hand sides through numba: the honest best of scipy."""
    fast_inertia, fast_contact = numba.njit(inertia), numba.njit(contact)

    @numba.njit
    def free(t, y):
        M, dM = fast_inertia(y[0])
        return np.array([y[1], -0.5 * dM * y[1] * y[1] / M])

    @numba.njit
    def worn(t, y, clearance, mu, approach):
        _, _, _, px, py, moment = fast_contact(t, y, clearance, mu, approach)
        sp, cp = math.sin(y[0]), math.cos(y[0])
        ax, ay = -W * W * R * math.cos(W * t), -W * W * R * math.sin(W * t)
        turning = L * (sp * px - cp * py) + moment + ROD_MASS * HALF * (sp * ax - cp * ay)
        return np.array([y[2], y[3], turning / AT_PIN, px / SLIDER_MASS])

    return free, worn, fast_contact


def run_free(method, rtol, t_end, *, fast=False):
    """The free slider-crank by scipy: the angle at the end."""
    rates = compiled()[0] if fast else free_rates
    return solve_ivp(rates, (0.0, t_end), (0.0, W), method=method, rtol=rtol, atol=rtol * 1e-3).y[0, -1]


def run_worn(method, rtol, t_end, *, mu=0.0, clearance=m.CLEARANCE, fast=False, look=None, largest=LARGEST_STEP):
    """The worn slider-crank by scipy, stopped by an event where a contact begins or ends: the last state.

    look : function (dense solution, t0, t1, law) called with every stretch.
    largest : step that may not be exceeded [s].
    """
    rates, touch = (compiled()[1:]) if fast else (worn_rates, contact)
    t, y, law = 0.0, np.array(START), (clearance, mu, 0.0)

    def gap(t, y, *law):
        return touch(t, y, *law)[0]

    gap.terminal = True
    atol = rtol * np.array([1e-2, 1e-3, 1e1, 1e0])  # of angle, place and their rates
    while t < t_end:
        gap.direction = -1.0 if law[2] else 1.0
        options = {"method": method, "rtol": rtol, "atol": atol, "events": gap, "dense_output": look is not None}
        first = min(FIRST_STEP, 0.5 * (t_end - t))
        found = solve_ivp(rates, (t, t_end), y, args=law, first_step=first, max_step=largest, **options)
        if look is not None:
            look(found.sol, t, found.t[-1], law)
        t, y = found.t[-1], found.y[:, -1]
        if found.status == 1:  # an event: the contact begins with the rate it has now, or is over
            law = (clearance, mu, 0.0 if law[2] else max(touch(t, y, *law)[1], m.LEAST_APPROACH))
    return y


def worn_reference(mu, t_end):
    """Peak force, first contact, slider at 1 ms, largest torque, from scipy with events and rtol 1e-12."""
    peaks, torques, begins, place = [], [], [], []

    def look(sol, t0, t1, law):
        times = np.linspace(t0, t1, 400)
        states = sol(times).T
        torques.append(max(abs(torque(t, y, law)) for t, y in zip(times, states, strict=True)))
        if law[2]:
            begins.append(t0)
            peaks.append(max(contact(t, y, *law)[2] for t, y in zip(times, states, strict=True)))
        if t0 <= 1e-3 <= t1:
            place.append(sol(1e-3)[1])

    run_worn("DOP853", 1e-12, t_end, mu=mu, fast=True, look=look)
    return {"peak": max(peaks), "first": begins[0], "x1": place[0], "torque": max(torques), "contacts": len(begins)}


def first_peak(clearance, mu=0.0):
    """Peak force of the first contact [N]; the motion before it lasts less than 0.3 ms."""
    peaks = []

    def look(sol, t0, t1, law):
        if law[2]:
            times = np.linspace(t0, t1, 2000)
            peaks.append(max(contact(t, y, *law)[2] for t, y in zip(times, sol(times).T, strict=True)))

    run_worn("DOP853", 1e-11, 3e-4, mu=mu, clearance=clearance, fast=True, look=look)
    return peaks[0]
