"""Base of the families of normal laws that multiply an elastic force by a hysteresis factor."""

from __future__ import annotations

from abc import abstractmethod

from flexmb import checks
from flexmb.contact import validity
from flexmb.contact.onset import LARGEST, LEAST_APPROACH, ONSET
from flexmb.contact.restitution import delivered_restitution
from flexmb.errors import InputError
from flexmb.kernels import compiled
from flexmb.model.law import NormalLaw
from flexmb.model.material import Material


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
    """Base of laws that multiply an elastic force by (1 + chi depth_rate/w) and cut the product at zero.

    w is the reference speed: by default the approach speed, which is located inside the step.

    Parameters
    ----------
    restitution : coefficient of restitution e asked for, in (0, 1].
    least_approach : least approach speed [m/s]; a contact that begins slower, at rest or grazing, refers to the
        largest speed since its onset instead.
    reference_speed : "onset": the approach speed, as published; "largest": the largest speed since the onset, for
        contacts that are pressed together or released faster than they met (docs/contact.md).
    """

    restitution: float
    least_approach: float
    reference_speed: str

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

    def _check_damping(self) -> None:
        """Refuse restitution, least approach and reference speed out of their ranges."""
        name = type(self).__name__
        checks.positive(name, "restitution", self.restitution)
        checks.between(name, "restitution", self.restitution, 0.0, 1.0)
        checks.not_negative(name, "least_approach", self.least_approach, "m/s")
        checks.one_of(name, "reference_speed", self.reference_speed, (ONSET, LARGEST))

    def _no_radii(self) -> InputError:
        """Error of a law that has no stiffness yet, since its radii are unknown."""
        return InputError(f"{type(self).__name__}: the stiffness depends on radii; use it in a clearance joint.")


def two_materials(name: str, materials: object) -> None:
    """Refuse anything but two materials."""
    pair = checks.sequence(name, "materials", materials, "two materials")
    if len(pair) != 2 or not all(isinstance(m, Material) for m in pair):
        raise InputError(f"{name}: materials are {pair!r}; they must be two Material(...), bearing first.")
