"""Normal laws N = K depth^n (1 + chi depth_rate/w): restitution, stiffness by Hertz, bases, and the published laws.

For N = F(depth) (1 + chi depth_rate/approach), with any elastic force F, the equation of motion separates:
m v dv / (1 + chi v/approach) = -F d(depth).  The right side is the same in compression and in restitution, so that

    phi(chi) = phi(-chi e),   phi(x) = x - ln(1 + x),   or   chi (1 + e) = ln[(1 + chi)/(1 - chi e)]

for any F, mass and speed.  Source: the integral is that of K. H. Hunt, F. R. E. Crossley, Coefficient of restitution
interpreted as damping in vibroimpact, Journal of Applied Mechanics 42 (1975) 440-445, who expand it for e near 1.
Equation (5.8) of docs/theory/contact.md.

A further law is a further class: its formula in the first line, its range and source in the notes, and chi(e).
"""

from __future__ import annotations

import copy
import math
import sys
import warnings
from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.errors import InputError, RestitutionWarning
from flexmb.fields import Rule, field, not_negative, one_of, positive, record, variant
from flexmb.kernels import compiled, normal_law
from flexmb.model.law import Material, NormalLaw
from flexmb.namespace import level_of_user
from flexmb.parts.contact import validity
from flexmb.parts.contact.onset import APPROACH, LARGEST, LEAST_APPROACH, ONSET, reference_speed

SMALL_CHI = 0.5  # damping factor chi [1] below which phi is summed as a series, since x - ln(1 + x) cancels
TERMS = 90
SERIES_FROM = 0.75  # coefficient of restitution [1] from which the exact chi is small enough for the series


@lru_cache(256)  # a sweep asks for the same one again and again
def delivered_restitution(chi: float) -> float:
    """Coefficient of restitution e of a free impact with the factor (1 + `chi` depth_rate/approach); to round-off."""
    # chi >= 0: chi = 0 gives 1; e falls with chi and stays above 0 and below 1/chi.
    if chi < SMALL_CHI:
        return _newton(lambda e: _series(chi, e), 1.0 - 2.0 * chi / 3.0)
    want = chi - math.log1p(chi)  # phi(chi) = u + exp(-u) - 1 with u = -ln(1 - chi e)
    u = _bisect(lambda u: u + math.expm1(-u) - want, 0.0, want + 1.0)
    return -math.expm1(-u) / chi


def exact_chi(restitution: float) -> float:
    """Damping factor chi with which a free impact returns exactly e = `restitution`, in (0, 1]; to round-off."""
    # The root chi > 0 of chi (1 + e) = ln[(1 + chi)/(1 - chi e)] lies between (1 - e)/e, the least difference of both
    # sides, and 1/e, the end of the logarithm.
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


SMALL_SHARE = 0.01  # share of impulses or losses in contacts slower than `least_approach`, up to which all is well


@compiled
def damped_contact(elastic, slope, chi, least, largest, e, h, gap, gap_rate, z, z_new):
    """Elastic force times (1 + chi depth_rate/w), and its derivatives by gap and gap rate, of a normal law; history."""
    # `slope` : derivative of the elastic force by the gap; nothing acts while the gap is open.
    speed, by_gap, by_rate = reference_speed(h, gap, gap_rate, least, largest > 0.0, e, z, z_new)
    if gap >= 0.0:
        validity.keep_extremes(0.0, 0.0, 0.0, 0.0, z, z_new)
        return 0.0, 0.0, 0.0
    if speed <= 0.0:  # a contact at rest is not damped
        validity.keep_extremes(-gap, elastic, 0.0, 0.0, z, z_new)
        return elastic, slope, 0.0
    # the excess is the damping beyond that of a free impact, whose depth_rate/w is between -e and 1
    ratio = -gap_rate / speed
    factor, excess = 1.0 + chi * ratio, elastic * chi * max(ratio - 1.0, -e - ratio, 0.0)
    if factor <= 0.0:
        validity.keep_extremes(-gap, 0.0, -elastic * factor, excess, z, z_new)
        return 0.0, 0.0, 0.0
    validity.keep_extremes(-gap, elastic * factor, 0.0, excess, z, z_new)
    by_speed = -elastic * chi * ratio / speed
    return elastic * factor, slope * factor + by_speed * by_gap, -elastic * chi / speed + by_speed * by_rate


class DampedElasticLaw(NormalLaw):
    """Base of laws that multiply an elastic force by (1 + chi depth_rate/w) and cut the product at zero."""

    # w is the reference speed: by default the approach speed, which is located inside the step.
    # A contact that begins slower than `least_approach`, at rest or grazing, refers to the largest speed since its
    # onset instead. `reference_speed` "onset": the approach speed, as published; "largest": the largest speed since the
    # onset, for contacts that are pressed together or released faster than they met (docs/contact.md).
    restitution: float
    least_approach: float
    reference_speed: str
    materials: tuple[Material, Material] | None

    @staticmethod
    @abstractmethod
    def chi(restitution: float) -> float:
        """Damping factor that gives the coefficient of restitution e = `restitution`."""

    def delivered_restitution(self, e: float | None = None) -> float:
        """Coefficient of restitution of a free impact with the factor for `e` (None: the law's own); exact.

        Contacts that begin slower than `least_approach` return more.
        """
        name = type(self).__name__
        return delivered_restitution(self.chi(self.restitution if e is None else checked_restitution(name, "e", e)))

    def history(self) -> tuple[float, ...]:
        """Reference speed, gap, gap rate, approach speed; largest approach speed, depth, force, cut tension, excess."""
        return validity.HISTORY_WITH_EXTREMES

    def lasting_history(self) -> tuple[float, ...]:
        """The history with the least approach speed, so that round-off of a rate at rest is none of the force."""
        return (max(self.least_approach, LEAST_APPROACH), 0.0, 0.0, *self.history()[3:])

    @abstractmethod
    def passed_limits(self, depth: float, force: float) -> Iterator[str]:
        """Remarks on the limits of the elastic force that the largest `depth` [m] and `force` [N] of a run passed."""

    def remarks(self, history: Sequence[float]) -> tuple[str, ...]:
        """Limits that the run passed: tension or excess, speed, limits of the elastic force."""
        approach, depth, force, tension, excess = history[validity.MOST_APPROACH : validity.EXCESS + 1]
        found = [*validity.cut_or_pressed(tension, excess, force), *validity.too_fast(approach, self.materials or ())]
        return (*found, *self.passed_limits(depth, force))

    def remarks_on(
        self, intervals: Mapping[str, np.ndarray], history: Sequence[float], since: float
    ) -> Iterator[tuple[str, str]]:
        """Remarks on slow and on lasting contacts; see `NormalLaw.remarks_on`."""
        if self.restitution == 1.0:
            return
        slow, shares = intervals["approach_speed"] < self.least_approach, []
        for name in ("impulse", "dissipated_contact"):
            whole = float(intervals[name].sum())
            shares.append(float(intervals[name][slow].sum()) / whole if whole > 0.0 else 0.0)
        if self.reference_speed != LARGEST and max(shares) > SMALL_SHARE:
            yield (
                "slow-onset",
                f"{int(slow.sum())} of {len(slow)} contacts began below least_approach = {self.least_approach:g} m/s, "
                f"and have {100.0 * shares[0]:.3g} % of the impulse and {100.0 * shares[1]:.3g} % of the loss; their "
                "damping follows the largest speed while they last, that of the others the speed at which the surfaces "
                "met. reference_speed='largest' treats all alike",
            )
        lasting = np.isnan(intervals["end"]) & (intervals["peak_force"] > 0.0) & ~(intervals["start"] > since)
        for start in intervals["start"][lasting]:
            begun = "the start" if np.isnan(start) else f"t = {start:.6g} s"
            text = f"the surfaces have touched without a break since {begun}; {self.damped_since_onset(history)}"
            yield "lasting-contact", text

    def damped_since_onset(self, history: Sequence[float]) -> str:
        approach = history[APPROACH]
        if self.restitution == 1.0:
            return ""
        if self.reference_speed == LARGEST or approach < self.least_approach or approach <= 0.0:
            return "its damping follows the largest speed since then"
        return f"its damping still follows the speed at which its surfaces met, {approach:.3g} m/s (docs/contact.md)"

    def _no_radii(self) -> InputError:
        """Error of a law that has no stiffness yet, since its radii are unknown."""
        return InputError(f"{type(self).__name__}: the stiffness depends on radii; use it in a clearance joint.")


def checked_restitution(owner: str, name: str, value: object, *_: str) -> float:
    """A coefficient of restitution e in (0, 1], or `InputError`."""
    return checks.between(owner, name, checks.positive(owner, name, value), 0.0, 1.0)


RESTITUTION = Rule(checked_restitution, "> 0, between 0 and 1")


def two_materials(name: str, field_name: str, materials: object, *_: str) -> Any:
    """Two materials, or `InputError`."""
    pair = checks.sequence(name, field_name, materials, "two materials")
    if len(pair) != 2 or not all(isinstance(m, Material) for m in pair):
        raise InputError(f"{name}: materials are {pair!r}; they must be two Material(...), bearing first.")
    return materials


HERTZ = 1.5  # exponent of the contact of curved surfaces
MISS = 0.05  # fraction of the coefficient of restitution asked for by which a law may miss it without a warning


@normal_law
def hysteresis_kernel(p, h, gap, gap_rate, z, z_new):
    """N = K depth^n (1 + chi depth_rate / w), never pulling."""
    K, n, chi, least, largest, e = p
    elastic, slope = 0.0, 0.0
    if gap < 0.0:
        elastic = K * (-gap * math.sqrt(-gap) if n == HERTZ else (-gap) ** n)  # a root takes a third of a power's time
        slope = n * elastic / gap
    return damped_contact(elastic, slope, chi, least, largest, e, h, gap, gap_rate, z, z_new)


@variant
class HysteresisLaw(DampedElasticLaw):
    """Base of the laws of hysteresis damping; a subclass gives the damping factor chi(e).

    N = K depth^n (1 + chi depth_rate/w), cut at zero, so the surfaces never pull.

    Equation (5.5) of docs/theory/contact.md.

    Raises
    ------
    InputError : values out of range; neither stiffness nor materials.

    Notes
    -----
    The coefficient of restitution of a free impact depends on chi alone, not on K, n, mass or speed:
    `delivered_restitution`.  A law that misses the coefficient asked for by more than 5 % gives a `RestitutionWarning`
    when it is made.
    """

    stiffness: float | None = field("K; None: Hertz's, from `materials` and the radii", "N/m^n", positive, default=None)
    exponent: float = field("n", rule=positive, default=HERTZ)
    restitution: float = field("coefficient of restitution e asked for", rule=RESTITUTION, default=0.9)
    least_approach: float = field("least approach speed", "m/s", not_negative, default=LEAST_APPROACH)
    materials: tuple[Material, Material] | None = field(
        "materials of bearing and journal, when `stiffness` is None", rule=Rule(two_materials), default=None
    )
    reference_speed: str = field('"onset" or "largest"', rule=one_of(ONSET, LARGEST), default=ONSET)
    radii: tuple[float, float] | None = field(default=None, init=False, repr=False, compare=False)

    kernel = hysteresis_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        name = type(self).__name__
        if self.stiffness is None and self.materials is None:
            raise InputError(f"{name}: stiffness is missing; give stiffness=..., or use {name}.from_materials(...).")
        asked, found = self.restitution, self.delivered_restitution()
        if abs(found - asked) > MISS * asked:
            text = f"{name}(restitution={asked:g}) delivers {found:.3f}"
            text = f"{text}; ExactRestitution(restitution={asked:g}) delivers {asked:g}."
            warnings.warn(text, RestitutionWarning, stacklevel=level_of_user())

    @classmethod
    def from_materials(
        cls, bearing: Material, journal: Material, *, restitution: float = 0.9,
        least_approach: float = LEAST_APPROACH, reference_speed: str = ONSET,
    ) -> Self:  # fmt: skip
        """The law with Hertz's stiffness for n = 3/2, from two materials and the radii of the joint.

        Parameters
        ----------
        bearing, journal : materials.
        restitution, least_approach, reference_speed : see the class.
        """
        return cls(
            materials=(bearing, journal), restitution=restitution, least_approach=least_approach,
            reference_speed=reference_speed,
        )  # fmt: skip

    def for_radii(self, bearing_radius: float, journal_radius: float) -> Self:
        law = copy.copy(self)  # not made anew: a warning was given where the user made it
        object.__setattr__(law, "radii", (bearing_radius, journal_radius))
        if self.stiffness is None and self.materials is not None:
            object.__setattr__(law, "stiffness", hertz_stiffness(*self.materials, bearing_radius, journal_radius))
        return law

    def parameters(self) -> tuple[float, ...]:
        """K, n, chi, least approach speed, whether the reference speed is the largest one, restitution delivered."""
        if self.stiffness is None:
            raise self._no_radii()
        largest = float(self.reference_speed == LARGEST)
        chi, e = self.chi(self.restitution), self.delivered_restitution()
        return self.stiffness, self.exponent, chi, self.least_approach, largest, e

    def passed_limits(self, depth: float, force: float) -> Iterator[str]:
        """Remarks on width and yield, with Hertz's stiffness."""
        if self.materials is not None and self.radii is not None and self.exponent == HERTZ:
            R, E = validity.relative_radius(*self.radii), validity.effective_modulus(self.materials)
            yield from validity.too_wide(math.sqrt(R * depth), self.radii[1])  # Johnson 1985, eq. (4.23)
            pressure = (6.0 * force * E * E / (math.pi**3 * R * R)) ** (1.0 / 3.0)  # eq. (4.24)
            yield from validity.yielded(pressure, validity.YIELD_OF_POINT, self.materials)


@record
class Hertz(HysteresisLaw):
    """Elastic contact, N = K depth^n, without losses: the coefficient of restitution is 1.

    Raises
    ------
    InputError : values out of range; neither stiffness nor materials.

    Notes
    -----
    For contacts much smaller than the radii, and impacts slow enough to leave neither marks nor waves.
    Source: K. L. Johnson, Contact Mechanics, Cambridge University Press 1985, eq. (4.23), for n = 3/2.
    """

    restitution: float = field(default=1.0, init=False, repr=False)
    least_approach: float = field(default=0.0, init=False, repr=False)
    reference_speed: str = field(default=ONSET, init=False, repr=False)

    @classmethod
    def from_materials(cls, bearing: Material, journal: Material) -> Self:  # type: ignore[override]
        """The law with Hertz's stiffness for n = 3/2, from the materials of `bearing` and `journal` and the radii."""
        return cls(materials=(bearing, journal))

    @staticmethod
    def chi(restitution: float) -> float:
        return 0.0


@variant
class ExactRestitution(HysteresisLaw):
    """Hysteresis damping whose free impacts return exactly e: chi (1 + e) = ln[(1 + chi)/(1 - chi e)], chi > 0.

    Notes
    -----
    For every K, n, mass and speed of a free impact between two bodies.  Further forces during the impact change the
    coefficient of restitution.
    Source: the integral of K. H. Hunt, F. R. E. Crossley, Journal of Applied Mechanics 42 (1975) 440-445, solved
    without their expansion; the same root is given by A. S. Carvalho, J. M. Martins, Mechanism and Machine Theory 139
    (2019) 174-194.

    Examples
    --------
    >>> law = ExactRestitution(stiffness=1e9, restitution=0.5)
    >>> f"{law.delivered_restitution():.12f}"
    '0.500000000000'
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return exact_chi(restitution)


@variant
class HuntCrossley(HysteresisLaw):
    """Hysteresis damping, chi = 3 (1 - e)/2.

    Notes
    -----
    For e near 1: free impacts return e within 5 % from e = 0.79 on, and more than e everywhere.
    Source: K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact, Journal
    of Applied Mechanics 42 (1975) 440-445, whose lambda = 3 alpha K/2 with e = 1 - alpha v is this chi.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 1.5 * (1.0 - restitution)


@variant
class HerbertMcWhannell(HysteresisLaw):
    """Hysteresis damping, chi = 6 (1 - e)/[(2 e - 1)^2 + 3].

    Notes
    -----
    Free impacts return e within 5 % from e = 0.66 on, and more than e everywhere.
    Source: R. G. Herbert, D. C. McWhannell, Shape and frequency composition of pulses from an impact pair, Journal of
    Engineering for Industry 99 (1977) 513-518.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 6.0 * (1.0 - restitution) / ((2.0 * restitution - 1.0) ** 2 + 3.0)


@variant
class LeeWang(HysteresisLaw):
    """Hysteresis damping, chi = 3 (1 - e)/4.

    Notes
    -----
    Half the damping of Hunt and Crossley: free impacts return more than e also near e = 1; within 5 % from e = 0.92 on.
    Source: T. W. Lee, A. C. Wang, On the dynamics of intermittent-motion mechanisms, part 1, Journal of Mechanisms,
    Transmissions, and Automation in Design 105 (1983) 534-540.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 0.75 * (1.0 - restitution)


@variant
class LankaraniNikravesh(HysteresisLaw):
    """Hysteresis damping, chi = 3 (1 - e^2)/4.

    Notes
    -----
    For e near 1: free impacts return e within 5 % from e = 0.82 on, and far more than e at low e.
    Source: H. M. Lankarani, P. E. Nikravesh, A contact force model with hysteresis damping for impact analysis of
    multibody systems, Journal of Mechanical Design 112 (1990) 369-376.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 0.75 * (1.0 - restitution * restitution)


@variant
class Gonthier(HysteresisLaw):
    """Hysteresis damping, chi = (1 - e^2)/e.

    Notes
    -----
    For any e above 0: free impacts return e within 0.032, and exactly to first order near e = 0.
    Source: Y. Gonthier, J. McPhee, C. Lange, J.-C. Piedboeuf, A regularized contact model with asymmetric damping and
    dwell-time dependent friction, Multibody System Dynamics 11 (2004) 209-233.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return (1.0 - restitution * restitution) / restitution


@variant
class ZhiyingQishao(HysteresisLaw):
    """Hysteresis damping, chi = 3 (1 - e^2)/4 exp[2 (1 - e)].

    Notes
    -----
    For middle and high e: free impacts return e within 5 % from e = 0.34 on.
    Source: Q. Zhiying, L. Qishao, Analysis of impact process based on restitution coefficient, Journal of Dynamics
    and Control 4 (2006) 294-298.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 0.75 * (1.0 - restitution * restitution) * math.exp(2.0 * (1.0 - restitution))


@variant
class Flores(HysteresisLaw):
    """Hysteresis damping, chi = 8 (1 - e)/(5 e).

    Notes
    -----
    For any e above 0: free impacts return somewhat less than e, within 5 % from e = 0.54 on.
    Source: P. Flores, M. Machado, M. T. Silva, J. M. Martins, On the continuous contact force models for soft
    materials in multibody dynamics, Multibody System Dynamics 25 (2011) 357-375.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 8.0 * (1.0 - restitution) / (5.0 * restitution)


@variant
class HuGuo(HysteresisLaw):
    """Hysteresis damping, chi = 3 (1 - e)/(2 e).

    Notes
    -----
    For any e above 0: free impacts return e within 5 % from e = 0.41 on.
    Source: S. Hu, X. Guo, A dissipative contact force model for impact analysis in multibody dynamics, Multibody
    System Dynamics 35 (2015) 131-151.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 1.5 * (1.0 - restitution) / restitution


@variant
class CarvalhoMartins(HysteresisLaw):
    """Hysteresis damping, chi = (3/2) (1 - e) (11 - e)/(1 + 9 e).

    Notes
    -----
    A fit of the exact factor: free impacts return e within 5 % from e = 0.21 on.
    Source: A. S. Carvalho, J. M. Martins, Exact restitution and generalizations for the Hunt-Crossley contact model,
    Mechanism and Machine Theory 139 (2019) 174-194.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 1.5 * (1.0 - restitution) * (11.0 - restitution) / (1.0 + 9.0 * restitution)


@normal_law
def kelvin_voigt_kernel(p, h, gap, gap_rate, z, z_new):
    """N = K depth + C s depth_rate, never pulling; s grows from 0 to 1 over the depth `ramp`."""
    K, C, ramp = p
    reference_speed(h, gap, gap_rate, 0.0, False, 1.0, z, z_new)
    if gap >= 0.0:
        validity.keep_extremes(0.0, 0.0, 0.0, 0.0, z, z_new)
        return 0.0, 0.0, 0.0
    s, s_depth = 1.0, 0.0
    if -gap < ramp:
        x = -gap / ramp
        s, s_depth = x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x) / ramp
    N = -K * gap - C * s * gap_rate
    if N <= 0.0:
        validity.keep_extremes(-gap, 0.0, -N, 0.0, z, z_new)
        return 0.0, 0.0, 0.0
    validity.keep_extremes(-gap, N, 0.0, 0.0, z, z_new)
    return N, -K + C * s_depth * gap_rate, -C * s


@record
class KelvinVoigt(NormalLaw):
    """Linear spring beside a linear damper, N = K depth + C depth_rate, cut at zero so that it never pulls.

    Equation (5.10) of docs/theory/contact.md.

    Raises
    ------
    InputError : values out of range.

    Notes
    -----
    The force jumps by C times the approach speed at the onset.  Newton's method does not converge on a jump, so fixed
    steps can end a run there.  Error-controlled steps pass the jump; a `ramp` of several steps removes it: up to that
    depth the damper force grows as 3 x^2 - 2 x^3 of x = depth/ramp.
    The restitution depends on the mass: `for_restitution` and `delivered_restitution` hold for a free impact of a
    reduced mass, without ramp.
    Source: W. Goldsmith, Impact: The Theory and Physical Behaviour of Colliding Solids, Edward Arnold 1960, for the
    law; the cut at zero is that of any contact without adhesion.
    """

    stiffness: float = field("K", "N/m", positive)
    damping: float = field("C", "N s/m", not_negative)
    ramp: float = field("depth over which the damper force grows; 0: it acts at once", "m", not_negative, default=0.0)

    kernel = kelvin_voigt_kernel

    @classmethod
    def for_restitution(cls, stiffness: float, restitution: float, mass: float) -> Self:
        """The law, without ramp, whose free impacts return `restitution`.

        Parameters
        ----------
        stiffness : K [N/m], > 0.
        restitution : e, in (0, 1].
        mass : reduced mass m1 m2/(m1 + m2) of the two bodies [kg], > 0.
        """
        name = "KelvinVoigt.for_restitution"
        K, m = checks.positive(name, "stiffness", stiffness, "N/m"), checks.positive(name, "mass", mass, "kg")
        e = checks.between(name, "restitution", checks.positive(name, "restitution", restitution), 0.0, 1.0)
        low, high = 0.0, 1.0
        while _restitution(high) > e:
            low, high = high, 2.0 * high
        while low < 0.5 * (low + high) < high:
            zeta = 0.5 * (low + high)
            low, high = (zeta, high) if _restitution(zeta) > e else (low, zeta)
        return cls(K, 2.0 * low * math.sqrt(K * m))

    def delivered_restitution(self, mass: float) -> float:
        """The restitution of a free impact of the reduced `mass` [kg]; exact, for a law without ramp.

        With zeta = C/(2 sqrt(K m)) = cos(theta), the force falls to zero at the angle 2 theta and from there on the
        bodies fly apart: e = exp(-2 theta cot(theta)); for zeta = cosh(theta) > 1, e = exp(-2 theta coth(theta)).

        Equation (5.11) of docs/theory/contact.md.
        """
        m = checks.positive("KelvinVoigt", "mass", mass, "kg")
        if self.ramp > 0.0:
            text = f"KelvinVoigt: ramp is {self.ramp:g} m; with a ramp the restitution depends on the speed"
            raise InputError(f"{text}. Ask the law with ramp=0, and simulate for the difference.")
        return _restitution(self.damping / (2.0 * math.sqrt(self.stiffness * m)))

    def history(self) -> tuple[float, ...]:
        return validity.HISTORY_WITH_EXTREMES


def _restitution(zeta: float) -> float:
    """e for the damping ratio zeta >= 0, with the force cut at zero."""
    if zeta == 1.0:
        return math.exp(-2.0)
    if zeta < 1.0:
        theta = math.acos(zeta)
        return math.exp(-2.0 * theta / math.tan(theta))
    theta = math.acosh(zeta)
    return math.exp(-2.0 * theta / math.tanh(theta))
