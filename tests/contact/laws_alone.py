"""A user's file: laws that return their force alone, each beside the derivatives found by hand."""

import math
from math import exp as exponential

import numba
import numpy as np

import flexmb as fm
from flexmb.parts.contact.onset import approach_speed

OFFSET = 0.25


@fm.normal_law
def hertz(p, h, gap, gap_rate, z, z_new):
    """A ternary and a power."""
    k, n = p
    return k * (-gap) ** n if gap < 0.0 else 0.0


def hertz_by_hand(p, gap, rate):
    k, n = p
    return (k * (-gap) ** n, -n * k * (-gap) ** (n - 1.0), 0.0) if gap < 0.0 else (0.0, 0.0, 0.0)


@fm.normal_law
def hunt_crossley(p, h, gap, gap_rate, z, z_new):
    """Early returns and a variable that changes."""
    k, n, a = p
    factor = 1.0
    factor -= a * gap_rate
    if gap >= 0.0 or factor <= 0.0:
        return 0.0
    return k * (-gap) ** n * factor


@numba.njit
def hunt_crossley_by_hand(p, gap, rate):
    k, n, a = p
    factor = 1.0 - a * rate
    if gap >= 0.0 or factor <= 0.0:
        return 0.0, 0.0, 0.0
    force = k * (-gap) ** n
    return force * factor, n * force / gap * factor, -a * force


@numba.njit
def rising(depth, order):
    """Sum of depth^i / i!, i = 1..order."""
    total, term, i = 0.0, 1.0, 1
    while True:
        term *= depth / i
        total += term
        i += 1
        if i > order:
            break
    return total


@numba.njit
def both(x, y):
    """Two numbers, by way of a third function."""
    return halved(x) * y, x - halved(y)


@numba.njit
def halved(x):
    return 0.5 * x


@fm.normal_law
def loops_and_calls(p, h, gap, gap_rate, z, z_new):
    """A while loop, a for loop, tuples exchanged, functions that call functions, a history."""
    k, a = p
    depth = max(-gap, 0.0)
    z_new[0] = depth
    product, rest = both(depth, gap_rate)
    product, rest = rest, product
    for i in range(2):
        rest = rest * (1.0 + a * depth) + i * a
    return k * rising(depth, 3) + product * 0.0 + k * rest


def loops_and_calls_by_hand(p, gap, rate):
    k, a = p
    d, on = max(-gap, 0.0), 1.0 if gap < 0.0 else 0.0
    sum_, by_d = d + d**2 / 2 + d**3 / 6, 1 + d + d**2 / 2
    w = 1.0 + a * d
    rest, rest_d, rest_r = 0.5 * d * rate * w**2 + a, 0.5 * rate * w**2 + 0.5 * d * rate * 2 * a * w, 0.5 * d * w**2
    return k * (sum_ + rest), -on * k * (by_d + rest_d), k * rest_r


@numba.njit
def compiled_by_the_user(x):
    return x * math.sqrt(x)


@fm.normal_law
def functions(p, h, gap, gap_rate, z, z_new):
    """Elementary functions, from math and numpy, under their own and other names; one that numba has compiled."""
    k, c = p
    x = abs(gap) * 1e3
    bell = exponential(-x * x) + np.tanh(c * gap_rate) * math.log1p(x)
    ratio = np.hypot(x, 1.0) / (OFFSET + np.minimum(np.maximum(x, 0.0), 2.0))
    return k * (bell + ratio + compiled_by_the_user(x) + math.atan2(x, 2.0) + (x if x > 1.0 else np.power(x, 3.0)))


def functions_by_hand(p, gap, rate):
    k, c = p
    x, s = abs(gap) * 1e3, math.copysign(1e3, gap)
    t = math.tanh(c * rate)
    hyp, clip, clip_x = math.hypot(x, 1.0), OFFSET + min(x, 2.0), 1.0 if x < 2.0 else 0.0
    value = math.exp(-x * x) + t * math.log1p(x) + hyp / clip + x**1.5 + math.atan2(x, 2.0) + (x if x > 1.0 else x**3)
    by_x = (
        -2.0 * x * math.exp(-x * x) + t / (1.0 + x) + x / hyp / clip - hyp * clip_x / clip**2
        + 1.5 * math.sqrt(x) + 2.0 / (4.0 + x * x) + (1.0 if x > 1.0 else 3.0 * x * x)
    )  # fmt: skip
    return k * value, k * by_x * s, k * math.log1p(x) * c * (1.0 - t * t)


@fm.normal_law
def lankarani_nikravesh_alone(p, h, gap, gap_rate, z, z_new):
    """The library's law without its derivatives; its helper's are not used either."""
    k, n, e, least = p
    approach, _, _ = approach_speed(h, gap, gap_rate, least, z, z_new)
    if gap >= 0.0:
        return 0.0
    return max(k * (-gap) ** n * (1.0 - 0.75 * (1.0 - e * e) * gap_rate / approach), 0.0)


@fm.normal_law
def hunt_crossley_given(p, h, gap, gap_rate, z, z_new):
    """`hunt_crossley` with its derivatives written by hand."""
    return hunt_crossley_by_hand(p, gap, gap_rate)


@fm.friction_law
def coulomb_alone(p, h, slip, N, z, z_new):
    mu, v0, v1 = p
    speed = abs(slip)
    if speed <= v0:
        return 0.0
    share = min((speed - v0) / (v1 - v0), 1.0)
    return -mu * share * N * math.copysign(1.0, slip)


@fm.friction_law
def smooth_alone(p, h, slip, N, z, z_new):
    mu, v0 = p
    return -mu * N * math.tanh(slip / v0)


BY_HAND = {
    hertz: (hertz_by_hand, (1e9, 1.5)),
    hunt_crossley: (hunt_crossley_by_hand, (1e8, 1.3, 0.4)),
    loops_and_calls: (loops_and_calls_by_hand, (1e3, 0.7)),
    functions: (functions_by_hand, (10.0, 0.6)),
}
