"""Laws of wear: depth that a surface loses, by pressure and slip."""

from __future__ import annotations

from dataclasses import KW_ONLY

import numpy as np

from flexmb.display import Shown
from flexmb.errors import InputError
from flexmb.fields import Input, count, field, not_negative, positive, record

# Coefficient of wear [1/Pa] above which a number cannot be one: dry steel has 1e-15 to 1e-11.
LARGEST_COEFFICIENT = 1e-9
# Least and largest number of angles: below, a bin is wider than a contact; each step passes all of them.
FEWEST_BINS, MOST_BINS = 60, 7200


@record
class Wear(Input, Shown):
    """Base of the laws of wear: coefficients of both surfaces, number of places at which depths are known.

    A `foundation` spreads the wear as the pressure of an elastic layer does that carries the normal force.  Of a layer
    of the thickness t, Young's modulus E and Poisson's ratio nu on a rigid ground it is (1 - nu) E/((1 + nu) (1 - 2 nu)
    t): a Winkler foundation.  The force of the contact stays that of the joint's laws.  Equation (16.12) of
    docs/theory/wear.md.

    Raises
    ------
    InputError : coefficients out of range, none or both above 0, too few bins.
    """

    _: KW_ONLY
    bearing: float = field("coefficient of the bearing, guide or slot", "1/Pa", not_negative, default=0.0)
    journal: float = field("coefficient of the journal", "1/Pa", not_negative, default=0.0)
    bins: int = field(
        "number of angles or places at which the depth of a surface is known", rule=count(FEWEST_BINS), default=360
    )
    width: float | None = field(
        "width of both surfaces; None: that of the film, or the diameter of the bearing", "m", positive, default=None
    )

    foundation: float | None = field(
        "pressure over depth on the surface of a bearing; None: so that it carries the force at the depth of contact",
        "Pa/m", positive, default=None,
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        name = type(self).__name__
        for surface in ("bearing", "journal"):
            k = getattr(self, surface)
            if k > LARGEST_COEFFICIENT:
                raise InputError(
                    f"{name}: {surface} is {k:g} 1/Pa; such coefficients are below {LARGEST_COEFFICIENT:g}. Divide a "
                    "coefficient without unit by the hardness: 1e-3/2e9 Pa = 5e-13; multiply one in mm^3/(N m) by 1e-9."
                )
        if self.bins > MOST_BINS:
            raise InputError(f"{name}: bins is {self.bins}; give at most {MOST_BINS}, 360 to 720 are usual.")
        if (self.bearing > 0.0) == (self.journal > 0.0):
            both = self.bearing > 0.0
            raise InputError(
                f"{name}: bearing and journal are {'both above' if both else 'both'} 0; one of the two surfaces wears. "
                + ("Give the sum of both to the softer one." if both else "Give bearing=..., e.g. 1e-13 1/Pa.")
            )

    @property
    def coefficient(self) -> float:
        """Coefficient of the surface that wears [1/Pa]."""
        return self.bearing + self.journal

    def load(self, normal: np.ndarray, friction: np.ndarray) -> np.ndarray:  # noqa: ARG002 - of other laws
        """Force whose work against the slip, times the coefficient, is the worn volume [N].

        Parameters
        ----------
        normal, friction : normal force, and friction force of either sign [N].
        """
        return normal


@record
class Archard(Wear):
    """Wear by pressure and slip: a surface that slides by ds under the pressure p loses the depth k p ds.

    The coefficient is k = K/H, of Archard's number K without unit and the hardness H.  The worn volume is k times the
    integral of the normal force over the slip.  Equation (16.4) of docs/theory/wear.md.

    Raises
    ------
    InputError : coefficients out of range, none or both above 0, too few bins.

    Notes
    -----
    For wear that is mild and steady; running-in, fragments and heat are left out.
    Source: J. F. Archard, Contact and rubbing of flat surfaces, Journal of Applied Physics 24 (1953) 981-988.

    Examples
    --------
    >>> Archard(bearing=1e-13).coefficient
    1e-13
    """


@record
class EnergyWear(Wear):
    """Wear by the work of friction: the worn volume is the coefficient times that work, spread as the pressure is.

    With a coefficient of friction mu it is `Archard` with mu times this coefficient.  Equation (16.4) of
    docs/theory/wear.md.

    Raises
    ------
    InputError : coefficients out of range, none or both above 0, too few bins.

    Notes
    -----
    Source: S. Fouvry, P. Kapsa, L. Vincent, Quantification of fretting damage, Wear 200 (1996) 186-205.
    """

    def load(self, normal: np.ndarray, friction: np.ndarray) -> np.ndarray:  # noqa: ARG002 - of other laws
        """Friction force [N], positive."""
        return np.asarray(np.abs(friction))
