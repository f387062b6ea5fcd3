"""Base of joints whose surfaces wear: law of wear, profile, and the wear of a run."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, fields, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import field, instance, not_negative, record, several
from flexmb.model.part import Joint, Part
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.wear.laws import Wear

if TYPE_CHECKING:
    from flexmb.model.law import FrictionLaw

# Signals of each contact whose integral is its wear.
FORCES = ("slip", "normal_force", "friction_force")


@dataclass(frozen=True)
class Worn:
    """Wear of a joint in a run, see `worn_in` of the joint.

    Parameters
    ----------
    depths : depth that the surfaces lost (n,), in the order of `depths` of the joint [m].
    volume : material that they lost [m^3].
    time : length of the run [s].
    work : work of the friction of the joint [J].

    Notes
    -----
    This work is a part of `energy.dissipated_friction`, the same integral by the trapezoidal rule over the steps.  The
    material that is lost takes neither energy nor mass out of the balance.
    """

    depths: np.ndarray
    volume: float
    time: float
    work: float


@record
class WornJoint(Part):
    """Base of joints with clearance whose surfaces wear; studies and pictures ask it by `Part.wearing`."""

    # A profile is the depth of one surface at `bins` places; `depths` holds those of all surfaces that wear.
    _: KW_ONLY
    wear: Wear = field("law of wear", rule=instance(Wear, "a law of wear, e.g. Archard(bearing=1e-13)"))
    profile: tuple[float, ...] = field(
        "depth by place, of several surfaces one behind the other; empty: unworn",
        "m",
        several(not_negative, "numbers"),
        default=(),
    )

    PLACES: ClassVar[str]  # name of the coordinate of the profiles, and its unit
    PLACE_UNIT: ClassVar[str]
    FACES: ClassVar[tuple[str, ...]]  # names of all surfaces
    contacts: ClassVar[tuple[str, ...]]  # prefixes of the signals of all contacts: "" or "upper_front."
    where: ClassVar[tuple[str, ...]]  # signals of the place of each contact
    if TYPE_CHECKING:  # fields of the dry joint
        friction: FrictionLaw
        clearance: float

    def __post_init__(self) -> None:
        super().__post_init__()
        count = self.bins * len(self.wearing_faces)
        if self.profile and len(self.profile) != count:
            raise InputError(
                f"{self.label}: profile has {len(self.profile)} depths; the law of wear has {self.bins} bins, and "
                f"{' and '.join(self.wearing_faces)} wear. Give {count} depths, or none for unworn surfaces."
            )
        if isinstance(self.friction, Frictionless) and not self.wear.load(np.ones(1), np.zeros(1)).any():
            law = type(self.wear).__name__
            text = f"{self.label}: {law} wears by the work of friction, and the joint has none."
            raise InputError(f"{text} Give it a friction law, or take Archard, which wears by pressure and slip.")
        name, size = self.deepest
        if max(self.profile, default=0.0) >= size:
            text = f"{self.label}: profile is up to {max(self.profile):g} m deep;"
            raise InputError(f"{text} it must stay below the {name} {size:g} m. Depths are in metres.")

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
    @abstractmethod
    def sizes(self) -> dict[str, float]:
        """Lengths that pictures show the profiles beside, by name [m]."""

    @abstractmethod
    def smoothed(self, depths: np.ndarray) -> np.ndarray:
        """Depths without ridges between neighbours; their sum stays."""

    @property
    @abstractmethod
    def deepest(self) -> tuple[str, float]:
        """Length of the joint that no depth may reach, and its name [m]."""

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
            lost = self.wear.coefficient * weight * self.wear.load(normal, friction) * np.abs(slip)
            rows = np.flatnonzero(lost)
            volume += self._spread(sol, contact, rows, lost[rows])
            work -= float(weight @ (friction * slip))
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
                raise InputError(
                    f"{self.label}: its {' and '.join(worn)} is worn, and the law of wear is one of "
                    f"{' and '.join(others)}. Give wear to the joint without a profile, or a law of the same surfaces."
                )
        return replace(self, wear=wear)


def worn(joint: Joint, dry: type[Joint], kind: type[WornJoint], **more: Any) -> Any:
    """The joint as one of a `kind` that wears, with `more` fields; of `dry` only the class itself wears."""
    if type(joint) is not dry:
        text = f"{joint.label} is a {type(joint).__name__}; only the dry joint {dry.__name__} wears."
        raise InputError(f"{text} Give wear to the joint without a film.")
    return kind(**{one.name: getattr(joint, one.name) for one in fields(joint)}, **more)
