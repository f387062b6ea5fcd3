"""Guide and slot whose sides wear: a slider or a pin with clearance between two worn sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, replace
from typing import Any, Self

import numpy as np

from flexmb.errors import InputError
from flexmb.fields import field, positive, record
from flexmb.model.contributions import ContactContribution, Contribution, SignalContribution
from flexmb.model.mechanism import Mechanism
from flexmb.parts.joints.pin_slot import PinSlotClearance
from flexmb.parts.joints.prismatic_clearance import CORNERS, PrismaticClearance
from flexmb.parts.wear import guide_kernels as kernels
from flexmb.parts.wear.laws import Wear
from flexmb.parts.wear.worn_joint import WornJoint

# Names of the sides: upper is left of `along`.
UPPER, LOWER = "upper", "lower"
# Number of places to which the wear goes from each half of a step.
WAYS = 4


@record
class WornSides(WornJoint):
    """Base of guides and slots with two sides that wear along a length."""

    _: KW_ONLY
    worn_length: float = field("length of the sides whose depth is known, about the joint's point", "m", positive)

    PLACES = "place"
    PLACE_UNIT = "1"
    FACES = (UPPER, LOWER)
    wearing_faces = FACES
    rounding = 0.0
    """Radius of what slides on the sides [m]."""

    def __post_init__(self) -> None:
        super().__post_init__()
        law = type(self.wear).__name__
        if self.wear.journal > 0.0:
            text = f"{self.label}: {law} has a coefficient of the journal; only the sides of the first body wear here"
            raise InputError(f"{text}. Give {law}(bearing=...), the coefficient of guide or slot.")
        if self.wear.width is None:
            text = f"{self.label}: {law} has no width, with which depths go"
            raise InputError(f"{text}. Give the width of the sides, e.g. {law}(..., width=0.02).")
        if self.wear.foundation is not None:
            text = f"{self.label}: {law} has a foundation, and contact with a side is at one place"
            raise InputError(f"{text}. Leave foundation out; it is for bearings.")

    @property
    def step(self) -> float:
        """Distance of two places [m]."""
        return self.worn_length / self.bins

    @property
    def places(self) -> np.ndarray:
        """Places of the profile over its length, from its middle [1]."""
        return (np.arange(self.bins) + 0.5) / self.bins - 0.5

    @property
    def areas(self) -> np.ndarray:
        return np.full(2 * self.bins, self.step * (self.wear.width or 0.0))

    @property
    def sizes(self) -> dict[str, float]:
        return {"clearance": self.clearance, "worn_length": self.worn_length}

    @property
    def sides(self) -> np.ndarray:
        """Depths that the moving surface can reach (2, bins) [m]: a round pin does not come to the ground of a valley.

        Equation (16.7) of docs/theory/wear.md.
        """
        depths, radius = self.depths.reshape(2, self.bins), self.rounding
        reached = depths.copy()
        for k in range(1, self.bins):
            if k * self.step >= radius:
                break
            lift = radius - np.sqrt(radius * radius - (k * self.step) ** 2)
            for beside in (slice(k, None), slice(None, -k)):
                other = slice(None, -k) if beside.start else slice(k, None)
                np.minimum(reached[:, other], depths[:, beside] + lift, out=reached[:, other])
            reached[:, :k], reached[:, -k:] = np.minimum(reached[:, :k], lift), np.minimum(reached[:, -k:], lift)
        return reached

    @property
    def half_play(self) -> float:
        return self.clearance + 0.5 * float(self.sides.sum(axis=0).max())

    def smoothed(self, depths: np.ndarray) -> np.ndarray:
        """Means of the depths of neighbours, weights 1/4, 1/2, 1/4; an end is its own neighbour."""
        padded = np.pad(depths.reshape(2, self.bins), ((0, 0), (1, 1)), mode="edge")
        return np.asarray(0.5 * padded[:, 1:-1] + 0.25 * (padded[:, :-2] + padded[:, 2:])).ravel()

    def _spread(self, sol: Any, contact: str, rows: np.ndarray, lost: np.ndarray) -> np.ndarray:
        """Volume by place, over the way of each step."""
        place = sol.array(f"{self.name}.{contact}{self.where[0]}")
        where = place[rows]
        limit = 0.5 * (self.worn_length - self.step)
        if len(where) and np.abs(where).max() > limit:
            text = f"{self.label}: it rubs from {where.min():.4g} to {where.max():.4g} m from the middle of its sides"
            raise InputError(f"{text}, whose depth is known up to {limit:.4g} m. Give worn_by(..., length=...) more.")
        begin = np.where(self._on_upper(sol, contact, rows), 0, self.bins)
        before, behind = (place[np.clip(rows + k, 0, len(place) - 1)] - where for k in (-1, 1))
        found = np.zeros(2 * self.bins)
        for part in (np.arange(WAYS) + 0.5) / (2.0 * WAYS):
            for way in (before, behind):
                u = (np.clip(where + part * way, -limit, limit) + limit) / self.step
                left = np.minimum(u.astype(int), self.bins - 2)
                for k, share in ((left, 1.0 - (u - left)), (left + 1, u - left)):
                    found += np.bincount(begin + k, lost * share, minlength=2 * self.bins)
        return np.asarray(found / (2.0 * WAYS))

    def _on_upper(self, sol: Any, contact: str, rows: np.ndarray) -> np.ndarray:  # noqa: ARG002 - of pins
        """Whether a contact is on the upper side in some rows."""
        return np.full(len(rows), contact.startswith(UPPER))

    def _numbers(self, size: Sequence[float], tables: np.ndarray) -> tuple[float, ...]:
        """Numbers of the kernels, depths of the sides last."""
        steepest = float(np.abs(np.diff(np.pad(np.atleast_2d(tables), ((0, 0), (1, 1))))).max()) / self.step
        return (*size, self.step, steepest, float(tables.max()), 0.0, *tables.ravel().tolist())

    def _worn_contact(self, contact: ContactContribution, p: tuple[float, ...], signals: int) -> list[Contribution]:
        """A contact of the dry joint on the worn sides, and its first signals."""
        found: list[Contribution] = [replace(contact, gap=kernels.worn_side_gap_kernel, p=p)]
        for k, (name, unit) in enumerate(kernels.SIGNALS[:signals]):
            own = (*p[: kernels.CHOSEN], float(k), *p[kernels.DEPTHS :])
            named = f"{contact.name}.{name}" if contact.name else name
            found.append(SignalContribution(self.name, named, unit, kernels.worn_side_signal, contact.coordinates, own))
        return found

    def worn_by(self, wear: Wear, length: float | None = None) -> Self:
        """The joint with another law of wear, and another `length` if it is unworn; its depths stay.

        Raises
        ------
        InputError : another number of bins, or another length, of a joint that has lost material.
        """
        if length is not None and length != self.worn_length and any(self.profile):
            text = f"{self.label}: its depths are those of a length of {self.worn_length:g} m"
            raise InputError(f"{text}. Leave length out, or give wear to the joint without a profile.")
        made = super().worn_by(wear)
        return made if length is None else replace(made, worn_length=length)


@record
class WornGuide(WornSides, PrismaticClearance):
    """Prismatic joint with clearance and worn sides of the guide, made by `PrismaticClearance.worn_by`.

    Each side has a depth for each of `wear.bins` places along `worn_length`, whose middle is at the joint's point.  A
    corner touches the worn side at the place where it is.  Beyond this length the sides are unworn.

    Signals: those of `PrismaticClearance`; for each corner `upper_front.place` (along the guide from its middle) [m],
    `upper_front.slip` [m/s], ...

    Raises
    ------
    InputError : a law of wear of the slider (journal), one without width, a profile of another length than both sides
        together, depths out of range, `EnergyWear` without friction, further ones of `PrismaticClearance`.

    Notes
    -----
    `depths` holds the upper side, then the lower one.  The profile stays as it is within a run: `worn_in(sol)` gives
    the wear of a run, `with_depths(depths)` the joint with other depths, `wear_out` goes on over many turns.  Corners
    themselves do not wear, and a face between them does not touch, also where the guide is hollow.
    Impacts that recur at one place make pits as narrow as two places of the profile: give places as wide as a contact.
    """

    contacts = tuple(f"{name}." for name, *_ in CORNERS)
    where = ("place",)

    @property
    def deepest(self) -> tuple[str, float]:
        return "half_height", self.half_height

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        found: list[Contribution] = []
        corners: tuple[float, ...] = ()
        for one in super().contributions(mechanism):
            if isinstance(one, ContactContribution):
                play, half, across, *geometry = one.p
                p = self._numbers((play, half, 0.0, across, *geometry), self.sides[0 if across > 0.0 else 1])
                corners += p
                found += self._worn_contact(one, p, 2)
            elif isinstance(one, SignalContribution) and one.is_mode:
                found.append(replace(one, kernel=kernels.worn_guide_mode, p=corners))
            else:
                found.append(one)
        return found


@record
class WornSlot(WornSides, PinSlotClearance):
    """Pin with clearance in a slot with worn sides, made by `PinSlotClearance.worn_by`.

    Each side has a depth for each of `wear.bins` places along `worn_length`, whose middle is at the joint's point.  The
    contact acts on the distance of the pin's centre from the places that the worn sides leave free to it.  Beyond this
    length the sides are unworn.

    Signals: those of `PinSlotClearance`; place (of the contact along the slot, from its middle) [m], slip [m/s], offset
    (of the pin across the slot, from its middle line) [m].

    Raises
    ------
    InputError : a slot with ends, a law of wear of the pin (journal), one without width, a profile of another length
        than both sides together, depths out of range, `EnergyWear` without friction, further ones of
        `PinSlotClearance`.

    Notes
    -----
    `depths` holds the upper side, left of `along`, then the lower one.  The profile stays as it is within a run:
    `worn_in(sol)` gives the wear of a run, `with_depths(depths)` the joint with other depths, `wear_out` goes on over
    many turns.  The pin does not wear.
    """

    contacts = ("",)
    where = ("place", "offset")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.length is not None:
            text = f"{self.label}: length is {self.length:g} m, so the slot has round ends, whose wear is not known"
            raise InputError(f"{text}. Give length=None, and a Stop where the travel has ends.")

    @property
    def rounding(self) -> float:  # type: ignore[override]
        return self.pin_radius

    @property
    def deepest(self) -> tuple[str, float]:
        return "pin_radius", self.pin_radius

    def _on_upper(self, sol: Any, contact: str, rows: np.ndarray) -> np.ndarray:
        """Whether the pin is above the middle line of the slot."""
        return np.asarray(sol.array(f"{self.name}.{contact}offset")[rows] >= 0.0)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        found: list[Contribution] = []
        for one in super().contributions(mechanism):
            if isinstance(one, ContactContribution):
                play, _, radius, *geometry = one.p
                p = self._numbers((play, 0.0, radius, 0.0, *geometry), self.sides)
                found += self._worn_contact(one, p, 3)
            else:
                found.append(one)
        return found
