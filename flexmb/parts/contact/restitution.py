"""Coefficient of restitution, and stiffness by Hertz.

For N = F(depth) (1 + chi depth_rate/approach), with any elastic force F, the equation of motion separates:
m v dv / (1 + chi v/approach) = -F d(depth).  The right side is the same in compression and in restitution, so that

    phi(chi) = phi(-chi e),   phi(x) = x - ln(1 + x),   or   chi (1 + e) = ln[(1 + chi)/(1 - chi e)]

for any F, mass and speed.  Source: the integral is that of K. H. Hunt, F. R. E. Crossley, Coefficient of restitution
interpreted as damping in vibroimpact, Journal of Applied Mechanics 42 (1975) 440-445, who expand it for e near 1.
Equation (5.8) of docs/theory/contact.md.
"""

import math
import sys
from collections.abc import Callable
from functools import lru_cache

from flexmb import checks
from flexmb.errors import InputError
from flexmb.model.law import Material

SMALL_CHI = 0.5  # damping factor chi [1] below which phi is summed as a series, since x - ln(1 + x) cancels
TERMS = 90
SERIES_FROM = 0.75  # coefficient of restitution [1] from which the exact chi is small enough for the series


@lru_cache(256)  # a sweep asks for the same one again and again
def delivered_restitution(chi: float) -> float:
    """Coefficient of restitution e of a free impact with the factor (1 + `chi` depth_rate/approach); to round-off.

    Notes
    -----
    chi >= 0.  chi = 0 gives 1; e falls with chi and stays above 0 and below 1/chi.
    """
    if chi < SMALL_CHI:
        return _newton(lambda e: _series(chi, e), 1.0 - 2.0 * chi / 3.0)
    want = chi - math.log1p(chi)  # phi(chi) = u + exp(-u) - 1 with u = -ln(1 - chi e)
    u = _bisect(lambda u: u + math.expm1(-u) - want, 0.0, want + 1.0)
    return -math.expm1(-u) / chi


def exact_chi(restitution: float) -> float:
    """Damping factor chi with which a free impact returns exactly e = `restitution`, in (0, 1]; to round-off.

    Notes
    -----
    The root chi > 0 of chi (1 + e) = ln[(1 + chi)/(1 - chi e)] lies between (1 - e)/e, the least difference of both
    sides, and 1/e, the end of the logarithm.
    """
    e = restitution
    if e == 1.0:
        return 0.0
    if e >= SERIES_FROM:
        return _newton(lambda chi: _series(chi, e), 1.5 * (1.0 - e) / (1.0 - e + e * e))

    def difference(u: float) -> float:  # u = -ln(1 - chi e): chi comes as near to 1/e as it likes
        chi = -math.expm1(-u) / e
        return math.log1p(chi) + u - chi * (1.0 + e)

    return -math.expm1(-_bisect(difference, -math.log(e), (1.0 + e) / e)) / e


def _series(chi: float, e: float) -> float:
    """[phi(-chi e) - phi(chi)] / (chi^2 (1 + e)), whose root is sought; the factor 1 - e is not multiplied out."""
    # Summed from (e^k - (-1)^k)/(1 + e) = -(1 - e)(1 + e^2 + ... + e^(k-2)) for even k, 1 - e + e^2 - ... + e^(k-1) for
    # odd k.
    total, power = 0.0, 1.0
    even, odd = 1.0, 1.0 - e + e * e  # the sums for k = 2 and k = 3
    high = e * e  # e^k of the next even k
    for k in range(2, TERMS, 2):
        total += power * (chi * odd / (k + 1.0) - (1.0 - e) * even / k)
        power *= chi * chi
        even += high
        odd += -high * e + high * e * e
        high *= e * e
    return total


def _newton(function: Callable[[float], float], x: float) -> float:
    """Root of a smooth, almost straight function near x, by secants."""
    before, value = x * (1.0 - 1e-3) - 1e-9, function(x)
    previous = function(before)
    for _ in range(30):
        if value == previous or x == before:
            break
        step = value * (x - before) / (value - previous)
        before, previous = x, value
        x -= step
        value = function(x)
        if abs(step) <= sys.float_info.epsilon * abs(x):
            break
    return x


def _bisect(function: Callable[[float], float], low: float, high: float) -> float:
    """Root between low (function < 0) and high, halved until neighbouring numbers are reached."""
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        if function(middle) < 0.0:
            low = middle
        else:
            high = middle


# Stiffness of Hertzian contact between a journal and a bearing
def hertz_stiffness(first: Material, second: Material, bearing_radius: float, journal_radius: float) -> float:
    """K of N = K depth^1.5 for a ball of `journal_radius` in a hollow of `bearing_radius`, or on a plane [N/m^1.5]."""
    # K = 4 / (3 (s1 + s2)) sqrt(R1 R2 / (R1 - R2)),  s = (1 - nu^2) / E
    # Equation (5.6) of docs/theory/contact.md.
    # R1 > R2 > 0 are the radii of bearing and journal [m], R1 = math.inf for a plane. Not for a close fit: the radii
    # must differ by more than the contact is wide.
    # Source: Chen, Jiang, Deng, Wang, Nonlinear Dynamics (2018), equation (4) with the sign of the hollow radius
    # mended.
    compliance = first.compliance + second.compliance
    if bearing_radius == math.inf:
        root = math.sqrt(checks.positive("hertz_stiffness", "journal_radius", journal_radius))
        return 4.0 / (3.0 * compliance) * root
    R1 = checks.positive("hertz_stiffness", "bearing_radius", bearing_radius, "m")
    R2 = checks.positive("hertz_stiffness", "journal_radius", journal_radius, "m")
    if R2 >= R1:
        text = f"hertz_stiffness: journal_radius is {R2:g} m;"
        raise InputError(f"{text} it must be smaller than the bearing's {R1:g} m.")
    return 4.0 / (3.0 * compliance) * math.sqrt(R1 * R2 / (R1 - R2))
