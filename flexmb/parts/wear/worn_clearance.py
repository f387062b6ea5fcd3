"""Revolute joint with clearance whose bearing or journal wears."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from flexmb.fields import record
from flexmb.findings.finding import Finding, found
from flexmb.model.contributions import ContactContribution, Contribution, SignalContribution
from flexmb.model.mechanism import Mechanism
from flexmb.parts.joints.revolute import angle_contribution
from flexmb.parts.joints.revolute_clearance import RevoluteClearance
from flexmb.parts.wear import kernels
from flexmb.parts.wear.profile import Surface, settled, shares, smoothed, surface
from flexmb.parts.wear.worn_joint import WornJoint


@record
class WornClearance(WornJoint, RevoluteClearance):
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
    The profile stays as it is within a run: `worn_in(sol)` gives the wear of a run, `with_depths(depths)` the joint
    with another profile, and `wear_out` goes on over many turns.  `depths`, `volume` and `half_play` say how far it is
    worn.

    Examples
    --------
    >>> import flexmb as fm
    >>> new = fm.mechanisms.slider_crank(clearance=5e-5)["B"].worn_by(fm.Archard(bearing=1e-13, width=0.02))
    >>> worn = new.with_depths(new.depths + 1e-5)
    >>> f"{1e9 * worn.volume:.1f} mm^3, {1e6 * worn.half_play:.0f} um"
    '12.6 mm^3, 60 um'
    """

    PLACES = "angle"
    PLACE_UNIT = "rad"
    FACES = ("bearing", "journal")
    contacts = ("",)
    where = ("x", "y", "contact_angle", "penetration")

    @property
    def wearing_faces(self) -> tuple[str, ...]:
        return ("journal",) if self.on_journal else ("bearing",)

    @property
    def deepest(self) -> tuple[str, float]:
        return "bearing radius", self.bearing_radius

    @property
    def on_journal(self) -> bool:
        """Whether the journal wears, and not the bearing."""
        return self.wear.journal > 0.0

    @property
    def width(self) -> float:
        """Width of the surfaces [m]."""
        return 2.0 * self.bearing_radius if self.wear.width is None else self.wear.width

    @property
    def areas(self) -> np.ndarray:
        radius = self.journal_radius if self.on_journal else self.bearing_radius
        return np.full(self.bins, 2.0 * np.pi / self.bins * radius * self.width)

    @property
    def places(self) -> np.ndarray:
        return 2.0 * np.pi * np.arange(self.bins) / self.bins

    @property
    def sizes(self) -> dict[str, float]:
        return {"clearance": self.clearance, "bearing_radius": self.bearing_radius}

    @property
    def half_play(self) -> float:
        support = self.surface.support
        return self.clearance - self.play + float(0.5 * (support + np.roll(support, len(support) // 2)).max())

    @cached_property
    def surface(self) -> Surface:
        """Tables of the worn surface."""
        return surface(self.play, self.depths)

    def smoothed(self, depths: np.ndarray) -> np.ndarray:
        return smoothed(depths)

    def _spread(self, sol: Any, contact: str, rows: np.ndarray, lost: np.ndarray) -> np.ndarray:
        """Volume by angle, spread as the pressure is."""
        x, y, angle, depth = (sol.array(f"{self.name}.{contact}{name}")[rows] for name in self.where)
        if self.wear.foundation is not None:
            force = sol.array(f"{self.name}.{contact}normal_force")[rows]
            x, y = settled(self.surface, x, y, angle, depth, force / (self.wear.foundation * self.areas[0]))
        return np.asarray(lost @ shares(self.surface, x, y, angle))

    def numbers(self, first: tuple[float, float], second: tuple[float, float]) -> tuple[float, ...]:
        """Parameters of the kernels; `first`, `second`: offsets of both points in the frames of their nodes [m]."""
        own = (self.play, self.bearing_radius, *first, *second, float(self.on_journal), 0.0)
        return (*own, *np.concatenate(self.surface).tolist())

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
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
