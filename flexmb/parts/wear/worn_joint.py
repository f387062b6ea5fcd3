"""Wear: its laws, and the base of joints whose surfaces wear, with the wear of a run."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import KW_ONLY, fields, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

import numpy as np

from flexmb import checks
from flexmb.display import Shown
from flexmb.errors import InputError
from flexmb.fields import Input, count, field, instance, not_negative, positive, record, record_with, several
from flexmb.model.law import FrictionLaw
from flexmb.model.part import Joint, Part
from flexmb.parts.contact.friction import Frictionless

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
    bins: int = field("number of angles or places of known depth", rule=count(FEWEST_BINS), default=360)
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
                text = f"{name}: {surface} is {k:g} 1/Pa; such coefficients are below {LARGEST_COEFFICIENT:g}."
                text += " Divide a coefficient without unit by the hardness: 1e-3/2e9 Pa = 5e-13;"
                raise InputError(f"{text} multiply one in mm^3/(N m) by 1e-9.")
        if self.bins > MOST_BINS:
            raise InputError(f"{name}: bins is {self.bins}; give at most {MOST_BINS}, 360 to 720 are usual.")
        if (self.bearing > 0.0) == (self.journal > 0.0):
            both = self.bearing > 0.0
            text = f"{name}: bearing and journal are {'both above' if both else 'both'} 0; one of the two surfaces"
            more = "Give the sum of both to the softer one." if both else "Give bearing=..., e.g. 1e-13 1/Pa."
            raise InputError(f"{text} wears. {more}")

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


Kind = TypeVar("Kind", bound="WornJoint")
FORCES = ("slip", "normal_force", "friction_force")  # signals of each contact whose integral is its wear


@record_with(eq=False)
class Worn:
    """Wear of a joint in a run, see `worn_in` of the joint.

    Notes
    -----
    This work is a part of `energy.dissipated_friction`, by the trapezoidal rule over the steps, times what the impulses
    of contact intervals are more than theirs by that rule.  The material that is lost takes neither energy nor mass out
    of the balance.
    """

    depths: np.ndarray = field("depth that the surfaces lost (n,), in the order of `depths` of the joint", "m")
    volume: float = field("material that they lost", "m^3")
    time: float = field("length of the run", "s")
    work: float = field("work of the friction of the joint", "J")


@record
class WornJoint(Part):
    """Base of joints with clearance whose surfaces wear; studies and pictures ask it by `Part.wearing`."""

    # A profile is the depth of one surface at `bins` places; `depths` holds those of all surfaces that wear.
    _: KW_ONLY
    wear: Wear = field("law of wear", rule=instance(Wear, "a law of wear, e.g. Archard(bearing=1e-13)"))
    profile: tuple[float, ...] = field(
        "depth by place, of several surfaces one behind the other; empty: unworn", "m",
        several(not_negative, "numbers"), default=(),
    )  # fmt: skip

    PLACES: ClassVar[str]  # name of the coordinate of the profiles, and its unit
    PLACE_UNIT: ClassVar[str]
    FACES: ClassVar[tuple[str, ...]]  # names of all surfaces
    SIZES: ClassVar[tuple[str, ...]]  # names of the lengths in `sizes`
    DEEPEST: ClassVar[str]  # words for the length of the joint that no depth may reach
    contacts: ClassVar[tuple[str, ...]]  # prefixes of the signals of all contacts: "" or "upper_front."
    where: ClassVar[tuple[str, ...]]  # signals of the place of each contact
    if TYPE_CHECKING:  # fields of the dry joint
        friction: FrictionLaw
        clearance: float

    def __post_init__(self) -> None:
        super().__post_init__()
        count = self.bins * len(self.wearing_faces)
        if self.profile and len(self.profile) != count:
            text = f"{self.label}: profile has {len(self.profile)} depths;"
            text += f" the law of wear has {self.bins} bins, and {' and '.join(self.wearing_faces)} wear."
            raise InputError(f"{text} Give {count} depths, or none for unworn surfaces.")
        if isinstance(self.friction, Frictionless) and not self.wear.load(np.ones(1), np.zeros(1)).any():
            law = type(self.wear).__name__
            text = f"{self.label}: {law} wears by the work of friction, and the joint has none."
            raise InputError(f"{text} Give it a friction law, or take Archard, which wears by pressure and slip.")
        size = getattr(self, self.DEEPEST.replace(" ", "_"))
        if max(self.profile, default=0.0) >= size:
            text = f"{self.label}: profile is up to {max(self.profile):g} m deep;"
            raise InputError(f"{text} it must stay below the {self.DEEPEST} {size:g} m. Depths are in metres.")

    @property
    @abstractmethod
    def wearing_faces(self) -> tuple[str, ...]:
        """Names of the surfaces that wear."""

    @property
    @abstractmethod
    def places(self) -> np.ndarray:
        """Coordinate of the profiles (bins,)."""

    @property
    @abstractmethod
    def half_play(self) -> float:
        """Half of the widest way across [m]; the clearance where nothing is worn."""

    @property
    def sizes(self) -> dict[str, float]:
        """Lengths that pictures show the profiles beside, by name [m]."""
        return {name: getattr(self, name) for name in self.SIZES}

    @abstractmethod
    def smoothed(self, depths: np.ndarray) -> np.ndarray:
        """The `depths` without ridges between neighbours; their sum stays."""

    @property
    @abstractmethod
    def areas(self) -> np.ndarray:
        """Surface of each place of `depths` [m^2]."""

    @abstractmethod
    def _spread(self, sol: Any, contact: str, rows: np.ndarray, lost: np.ndarray) -> np.ndarray:
        """Volume by place [m^3]; `lost` (rows,): volumes of a contact in some rows of a run [m^3]."""

    @property
    def wearing(self) -> Any:
        return self

    @property
    def bins(self) -> int:
        """Number of places of a profile."""
        return self.wear.bins

    @property
    def wear_signals(self) -> tuple[str, ...]:
        """Names of the signals that `worn_in` reads, without that of the joint."""
        return tuple(contact + name for contact in self.contacts for name in (*self.where, *FORCES))

    @property
    def depths(self) -> np.ndarray:
        """Depth of the worn surfaces by place, one behind the other [m]."""
        return np.array(self.profile or (0.0,) * (self.bins * len(self.wearing_faces)))

    @property
    def volume(self) -> float:
        """Material that the surfaces have lost [m^3]."""
        return float(self.depths @ self.areas)

    def with_depths(self, depths: Sequence[float] | np.ndarray) -> Self:
        """The joint with other depths by place, in the order of `depths` [m]."""
        listed = checks.sequence(self.label, "depths", depths, "depths")
        profile = (checks.not_negative(self.label, f"depths[{k}]", depth, "m") for k, depth in enumerate(listed))
        return replace(self, profile=tuple(profile))

    def worn_in(self, sol: Any) -> Worn:
        """Wear in a run `sol` that saved all steps, `save="steps"`; its profile is that of this joint.

        Raises
        ------
        InputError : no solution; a run that saved other instants than its steps, or fewer than two of them; a contact
            outside of the places whose depths are known.
        """
        try:
            t, whole = sol.time, sol.has_every_step
        except AttributeError:
            text = f"{self.label}: sol is {type(sol).__name__}; it must be the result"
            raise InputError(f"{text} of fm.simulate(mechanism, ..., save='steps').") from None
        if not whole or len(t) < 2:
            text = f"{self.label}: wear needs every step of a run, and this one saved {len(t)} instants"
            raise InputError(f"{text}, not all steps. Run it with save='steps'.")
        weight = 0.5 * (np.diff(t, prepend=t[0]) + np.diff(t, append=t[-1]))
        volume, work = np.zeros(len(self.depths)), 0.0
        for contact in self.contacts:
            slip, normal, friction = (sol.array(f"{self.name}.{contact}{name}") for name in FORCES)
            hits = sol.episodes(f"{self.name}.{contact}".removesuffix("."))
            hits = hits[(hits.start > t[0]) & ~np.isnan(hits.end)]
            within = np.searchsorted(hits.start, t) > np.searchsorted(hits.end, t)
            impulse = float(weight[within] @ normal[within])  # by the steps: of a few in an impact 1 to 2 % are missing
            exact = weight * (hits.impulse.sum() / impulse if impulse > 0.0 else 1.0)
            lost = self.wear.coefficient * exact * self.wear.load(normal, friction) * np.abs(slip)
            rows = np.flatnonzero(lost)
            volume += self._spread(sol, contact, rows, lost[rows])
            work -= float(exact @ (friction * slip))
        return Worn(volume / self.areas, float(volume.sum()), float(t[-1] - t[0]), work)

    def worn_by(self, wear: Wear) -> Self:
        """The joint with another law of wear; its depths stay, and must be as many.

        Raises
        ------
        InputError : a law by which other surfaces wear, where these have lost material; another number of bins.
        """
        if isinstance(wear, Wear) and any(self.profile):
            worn, others = self.wearing_faces, replace(self, wear=wear, profile=()).wearing_faces
            if worn != others:
                text = f"{self.label}:"
                text += f" its {' and '.join(worn)} is worn, and the law of wear is one of {' and '.join(others)}."
                raise InputError(f"{text} Give wear to the joint without a profile, or a law of the same surfaces.")
        return replace(self, wear=wear)


def worn(joint: Joint, dry: type[Joint], kind: type[Kind], **more: Any) -> Kind:
    """The joint as one of a `kind` that wears, with `more` fields; of `dry` only the class itself wears."""
    if type(joint) is not dry:
        text = f"{joint.label} is a {type(joint).__name__}; only the dry joint {dry.__name__} wears."
        raise InputError(f"{text} Give wear to the joint without a film.")
    return kind(**{one.name: getattr(joint, one.name) for one in fields(joint)}, **more)
