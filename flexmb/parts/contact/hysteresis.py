"""Bases of normal laws that multiply an elastic force by a factor of the rate, and Hertz's elastic law."""

from __future__ import annotations

import copy
import math
import sys
import warnings
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.errors import InputError, RestitutionWarning
from flexmb.fields import Rule, between, both, field, not_negative, one_of, positive, record, variant
from flexmb.kernels import compiled, normal_law
from flexmb.model.law import Material, NormalLaw
from flexmb.parts.contact import validity
from flexmb.parts.contact.onset import APPROACH, LARGEST, LEAST_APPROACH, ONSET, reference_speed
from flexmb.parts.contact.restitution import delivered_restitution, hertz_stiffness

SMALL_SHARE = 0.01  # share of impulses or losses in contacts slower than `least_approach`, up to which all is well


@compiled
def damped(elastic, slope, chi, e, gap_rate, speed, by_gap, by_rate):
    """Elastic force times (1 + chi depth_rate/w), its derivatives by gap and gap rate, the tension cut off, the excess.

    slope : derivative of the elastic force by the gap; by_gap, by_rate : derivatives of the reference speed w, `speed`.
    The excess is the damping force beyond that of a free impact, whose depth_rate/w is between -e and 1.  A contact at
    rest (w = 0) is not damped.
    """
    if speed <= 0.0:
        return elastic, slope, 0.0, 0.0, 0.0
    ratio = -gap_rate / speed
    factor, excess = 1.0 + chi * ratio, elastic * chi * max(ratio - 1.0, -e - ratio, 0.0)
    if factor <= 0.0:
        return 0.0, 0.0, 0.0, -elastic * factor, excess
    by_speed = -elastic * chi * ratio / speed
    by_rate = -elastic * chi / speed + by_speed * by_rate
    return elastic * factor, slope * factor + by_speed * by_gap, by_rate, 0.0, excess


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
        asked = self.restitution if e is None else checks.between(name, "e", checks.positive(name, "e", e), 0.0, 1.0)
        return delivered_restitution(self.chi(asked))

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
                "met. "
                "reference_speed='largest' treats all alike",
            )
        lasting = np.isnan(intervals["end"]) & (intervals["peak_force"] > 0.0) & ~(intervals["start"] > since)
        for start in intervals["start"][lasting]:
            begun = "the start" if np.isnan(start) else f"t = {start:.6g} s"
            text = f"the surfaces have touched without a break since {begun}; {self.damped_since_onset(history)}"
            yield "lasting-contact", text

    def damped_since_onset(self, history: Sequence[float]) -> str:
        """Sentence on the speed that scales the damping of a lasting contact of that `history`; "" without damping."""
        approach = history[APPROACH]
        if self.restitution == 1.0:
            return ""
        if self.reference_speed == LARGEST or approach < self.least_approach or approach <= 0.0:
            return "its damping follows the largest speed since then"
        return f"its damping still follows the speed at which its surfaces met, {approach:.3g} m/s (docs/contact.md)"

    def _no_radii(self) -> InputError:
        """Error of a law that has no stiffness yet, since its radii are unknown."""
        return InputError(f"{type(self).__name__}: the stiffness depends on radii; use it in a clearance joint.")


RESTITUTION = both(positive, between(0.0, 1.0))  # rule of a coefficient of restitution e


def two_materials(name: str, field_name: str, materials: object, *_: str) -> Any:
    """Two materials, or `InputError`."""
    pair = checks.sequence(name, field_name, materials, "two materials")
    if len(pair) != 2 or not all(isinstance(m, Material) for m in pair):
        raise InputError(f"{name}: materials are {pair!r}; they must be two Material(...), bearing first.")
    return materials


MISS = 0.05  # fraction of the coefficient of restitution asked for by which a law may miss it without a warning


@normal_law
def hysteresis_kernel(p, h, gap, gap_rate, z, z_new):
    """N = K depth^n (1 + chi depth_rate / w), never pulling."""
    K, n, chi, least, largest, e = p
    speed, by_gap, by_rate = reference_speed(h, gap, gap_rate, least, largest > 0.0, e, z, z_new)
    if gap >= 0.0:
        validity.keep_extremes(0.0, 0.0, 0.0, 0.0, z, z_new)
        return 0.0, 0.0, 0.0
    elastic = K * (-gap) ** n
    N, dN_dgap, dN_drate, tension, excess = damped(elastic, n * elastic / gap, chi, e, gap_rate, speed, by_gap, by_rate)
    validity.keep_extremes(-gap, N, tension, excess, z, z_new)
    return N, dN_dgap, dN_drate


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
    exponent: float = field("n", rule=positive, default=1.5)
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
        self._warn_of_a_miss()

    @classmethod
    def from_materials(
        cls,
        bearing: Material,
        journal: Material,
        *,
        restitution: float = 0.9,
        least_approach: float = LEAST_APPROACH,
        reference_speed: str = ONSET,
    ) -> Self:
        """The law with Hertz's stiffness for n = 3/2, from two materials and the radii of the joint.

        Parameters
        ----------
        bearing, journal : materials.
        restitution, least_approach, reference_speed : see the class.
        """
        return cls(
            materials=(bearing, journal),
            restitution=restitution,
            least_approach=least_approach,
            reference_speed=reference_speed,
        )

    def for_radii(self, bearing_radius: float, journal_radius: float) -> Self:
        """The law with its stiffness for these radii [m]."""
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
        if self.materials is not None and self.radii is not None and self.exponent == 1.5:
            R, E = validity.relative_radius(*self.radii), validity.effective_modulus(self.materials)
            yield from validity.too_wide(math.sqrt(R * depth), self.radii[1])  # Johnson 1985, eq. (4.23)
            pressure = (6.0 * force * E * E / (math.pi**3 * R * R)) ** (1.0 / 3.0)  # eq. (4.24)
            yield from validity.yielded(pressure, validity.YIELD_OF_POINT, self.materials)

    def _warn_of_a_miss(self) -> None:
        """Warn at the line outside flexmb that makes a law whose free impacts miss the given coefficient."""
        asked, found = self.restitution, self.delivered_restitution()
        if abs(found - asked) <= MISS * asked:
            return
        text = f"{type(self).__name__}(restitution={asked:g}) delivers {found:.3f}"
        text = f"{text}; ExactRestitution(restitution={asked:g}) delivers {asked:g}."
        warnings.warn(text, RestitutionWarning, stacklevel=_levels_inside())


def _levels_inside() -> int:
    """The stack level, seen from the caller of this function, of the first caller that is not flexmb."""
    frame, levels = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").split(".")[0] in ("flexmb", "dataclasses"):
        frame, levels = frame.f_back, levels + 1
    return levels


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
