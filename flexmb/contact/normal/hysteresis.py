"""Base of the normal laws N = K depth^n (1 + chi depth_rate/w), and their kernel."""

from __future__ import annotations

import copy
import math
import sys
import warnings
from collections.abc import Sequence
from dataclasses import field
from typing import Self

from flexmb import checks
from flexmb.contact import validity
from flexmb.contact.hertz import hertz_stiffness
from flexmb.contact.normal.damped_elastic import DampedElasticLaw, damped, two_materials
from flexmb.contact.onset import LARGEST, LEAST_APPROACH, ONSET, reference_speed
from flexmb.docstrings import documented
from flexmb.errors import InputError, RestitutionWarning
from flexmb.kernels import normal_law
from flexmb.model.material import Material

MISS = 0.05
"""Fraction of the coefficient of restitution asked for by which a law may miss it without a warning."""


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


@documented
class HysteresisLaw(DampedElasticLaw):
    """Base of the laws of hysteresis damping; a subclass gives the damping factor chi(e).

    N = K depth^n (1 + chi depth_rate/w), cut at zero, so the surfaces never pull.

    Equation (5.5) of docs/theory/contact.md.

    Parameters
    ----------
    stiffness : K [N/m^n], > 0; None with `materials`: Hertz, from the radii of the joint.
    exponent : n, > 0.
    materials : materials of bearing and journal, when `stiffness` is None.

    Raises
    ------
    InputError : values out of range; neither stiffness nor materials.

    Notes
    -----
    The coefficient of restitution of a free impact depends on chi alone, not on K, n, mass or speed:
    `delivered_restitution`.  A law that misses the coefficient asked for by more than 5 % gives a `RestitutionWarning`
    when it is made.
    """

    stiffness: float | None = None
    exponent: float = 1.5
    restitution: float = 0.9
    least_approach: float = LEAST_APPROACH
    materials: tuple[Material, Material] | None = None
    reference_speed: str = ONSET
    radii: tuple[float, float] | None = field(default=None, init=False, repr=False, compare=False)

    kernel = hysteresis_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        name = type(self).__name__
        if self.stiffness is None and self.materials is None:
            raise InputError(f"{name}: stiffness is missing; give stiffness=..., or use {name}.from_materials(...).")
        if self.materials is not None:
            two_materials(name, self.materials)
        if self.stiffness is not None:
            checks.positive(name, "stiffness", self.stiffness, "N/m^n")
        checks.positive(name, "exponent", self.exponent)
        self._check_damping()
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

    def remarks(self, history: Sequence[float]) -> tuple[str, ...]:
        """Limits that the run passed: tension, excess, speed; with Hertz's stiffness also width and yield."""
        approach, depth, force, tension, excess = validity.Extremes.of(history)
        found = [*validity.pressed(excess, force)] or [*validity.pulled(tension, force)]
        if self.materials is not None:
            found += validity.too_fast(approach, self.materials)
            if self.radii is not None and self.exponent == 1.5:
                R, E = validity.relative_radius(*self.radii), validity.effective_modulus(self.materials)
                found += validity.too_wide(math.sqrt(R * depth), self.radii[1])  # Johnson 1985, eq. (4.23)
                pressure = (6.0 * force * E * E / (math.pi**3 * R * R)) ** (1.0 / 3.0)  # eq. (4.24)
                found += validity.yielded(pressure, validity.YIELD_OF_POINT, self.materials)
        return tuple(found)

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
