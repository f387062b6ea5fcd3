"""Revolute joint with clearance whose bearing or journal wears."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from flexmb.errors import InputError
from flexmb.fields import field, instance, not_negative, record, several
from flexmb.findings.finding import Finding, found
from flexmb.model.contributions import ContactContribution, Contribution, SignalContribution
from flexmb.model.mechanism import Mechanism
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.joints.revolute import angle_contribution
from flexmb.parts.joints.revolute_clearance import RevoluteClearance
from flexmb.parts.wear import kernels
from flexmb.parts.wear.laws import Wear
from flexmb.parts.wear.profile import Surface, shares, surface


@dataclass(frozen=True)
class Worn:
    """Wear of a joint in a time.

    Parameters
    ----------
    depths : depth that the surface lost by angle (n,) [m].
    volume : material that it lost [m^3].
    time : length of the time [s].
    """

    depths: np.ndarray
    volume: float
    time: float


@record
class WornClearance(RevoluteClearance):
    """Revolute joint with clearance and a worn surface, made by `RevoluteClearance.worn_by`.

    The surface has a depth for each of `wear.bins` angles, which are counted in the axes of the body that carries it:
    of a link from its start to its end.  The contact acts on the distance of the journal's centre from the places that
    the worn surface leaves free, with the given laws, and presses on all angles within this distance.

    Signals: those of `RevoluteClearance`; x, y (journal's centre less the bearing's, in the axes of the worn body)
    [m], contact_angle (of the normal in these axes) [rad], slip (of the surfaces) [m/s].

    Raises
    ------
    InputError : a profile of another length than `wear.bins` or deeper than the bearing's radius, `EnergyWear` without
        friction, further ones of `RevoluteClearance`.

    Notes
    -----
    The profile stays as it is within a run.  `worn_in` gives the wear of a run, `wear_out` goes on over many turns.
    """

    _: KW_ONLY
    wear: Wear = field("law of wear", rule=instance(Wear, "a law of wear, e.g. Archard(bearing=1e-13)"))
    profile: tuple[float, ...] = field(
        "depth by angle; empty: unworn", "m", several(not_negative, "numbers"), default=()
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.profile and len(self.profile) != self.wear.bins:
            raise InputError(
                f"{self.label}: profile has {len(self.profile)} depths, and the law of wear {self.wear.bins} bins. "
                "Give both the same number, or no profile for an unworn surface."
            )
        if isinstance(self.friction, Frictionless) and not self.wear.load(np.ones(1), np.zeros(1)).any():
            law = type(self.wear).__name__
            raise InputError(
                f"{self.label}: {law} wears by the work of friction, and the joint has none. Give it a friction law, "
                "or take Archard, which wears by pressure and slip."
            )

        if max(self.profile, default=0.0) >= self.bearing_radius:
            raise InputError(
                f"{self.label}: profile is up to {max(self.profile):g} m deep; it must stay below the bearing radius "
                f"{self.bearing_radius:g} m. Depths are in metres."
            )

    @property
    def on_journal(self) -> bool:
        """Whether the journal wears, and not the bearing."""
        return self.wear.journal > 0.0

    @property
    def width(self) -> float:
        """Width of the surfaces [m]."""
        return 2.0 * self.bearing_radius if self.wear.width is None else self.wear.width

    @property
    def depths(self) -> np.ndarray:
        """Depth of the worn surface by angle (bins,) [m]."""
        return np.array(self.profile or (0.0,) * self.wear.bins)

    @property
    def area(self) -> float:
        """Surface between two angles [m^2]."""
        radius = self.journal_radius if self.on_journal else self.bearing_radius
        return 2.0 * np.pi / self.wear.bins * radius * self.width

    @property
    def volume(self) -> float:
        """Material that the surface has lost [m^3]."""
        return float(self.depths.sum()) * self.area

    @property
    def travel(self) -> float:
        """Half of the widest way of the journal's centre [m]; the clearance where nothing is worn."""
        support = self.surface.support
        return float(0.5 * (support + np.roll(support, len(support) // 2)).max())

    @cached_property
    def surface(self) -> Surface:
        """Tables of the worn surface."""
        return surface(self.clearance, self.depths)

    def with_depths(self, depths: Sequence[float] | np.ndarray) -> Self:
        """The joint with another profile (bins,) [m]."""
        return replace(self, profile=tuple(np.asarray(depths, dtype=float).tolist()))

    def worn_in(self, sol: Any) -> Worn:
        """Wear in a run whose signals are saved at all steps (`save="steps"`); its profile is that of this joint.

        Raises
        ------
        InputError : fewer than two saved instants.
        """
        t = sol.time
        if len(t) < 2:
            raise InputError(f"{self.label}: the run has {len(t)} saved instants. Save all steps: save='steps'.")
        names = ("x", "y", "contact_angle", "slip", "normal_force", "friction_force")
        x, y, angle, slip, normal, friction = (sol.array(f"{self.name}.{name}") for name in names)
        weight = 0.5 * (np.diff(t, prepend=t[0]) + np.diff(t, append=t[-1]))
        lost = self.wear.coefficient * weight * self.wear.load(normal, friction) * np.abs(slip)  # [m^3]
        rows = np.flatnonzero(lost)
        spread = shares(self.surface, x[rows], y[rows], angle[rows])
        return Worn(lost[rows] @ spread / self.area, float(lost.sum()), float(t[-1] - t[0]))

    def worn_by(self, wear: Wear) -> WornClearance:
        """The joint with another law of wear; its profile stays, and must have as many angles.

        Raises
        ------
        InputError : a law by which the other surface wears, where this one has lost material; another number of angles.
        """
        if isinstance(wear, Wear) and self.on_journal != (wear.journal > 0.0) and any(self.profile):
            worn, other = ("journal", "bearing") if self.on_journal else ("bearing", "journal")
            raise InputError(
                f"{self.label}: its {worn} is worn, and the law of wear is one of the {other}. Give wear to the joint "
                f"without a profile, or {type(wear).__name__}({worn}=...)."
            )
        return replace(self, wear=wear)

    def numbers(self, first: tuple[float, float], second: tuple[float, float]) -> tuple[float, ...]:
        """Parameters of the kernels; `first`, `second`: offsets of both points in the frames of their nodes [m]."""
        own = (self.clearance, self.bearing_radius, *first, *second, float(self.on_journal), 0.0)
        return (*own, *np.concatenate(self.surface).tolist())

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """Contact of the worn surface, angle, start of the joint, and signals."""
        first, second = ends = self.ends(mechanism)
        coordinates, p = (*first.coordinates, *second.coordinates), self.numbers(first.offset, second.offset)
        normal = self.normal.for_radii(self.bearing_radius, self.journal_radius)
        before, behind = p[: kernels.CHOSEN], p[kernels.TABLES :]
        return [
            ContactContribution(self.name, kernels.worn_gap_kernel, coordinates, p, normal, self.friction),
            angle_contribution(self.name, mechanism, ends),
            self._held(mechanism, coordinates, p[kernels.OFFSET1_X : kernels.ON_JOURNAL]),
            *[
                SignalContribution(
                    self.name, name, unit, kernels.worn_signal, coordinates, (*before, float(k), *behind)
                )
                for k, (name, unit) in enumerate(kernels.SIGNALS)
            ],
        ]

    def findings_before(self, mechanism: Mechanism) -> Iterator[Finding]:  # noqa: ARG002
        """Finding on a width that is not given."""
        if self.wear.width is None:
            text = f"{self.label} wears and has no width; it is taken as the diameter of the bearing, {self.width:g} m."
            remedy = f"Depths go with 1/width: give it, e.g. {type(self.wear).__name__}(..., width=0.02)."
            yield found("width-of-wear", (self.name,), text, remedy, width=self.width)
