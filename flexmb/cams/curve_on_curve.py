"""Two bodies that touch along curves: cam and follower, ideal or as a contact that can open."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any

from flexmb import checks
from flexmb.cams.curve_kernels import CURVE
from flexmb.cams.curves.closed_curve import ClosedCurve
from flexmb.cams.curves.line import CircularCurve, Line
from flexmb.cams.line_kernels import face_place
from flexmb.cams.packing import (
    TOLERANCE_LENGTH,
    along,
    carrier,
    curve_numbers,
    distance,
    in_frame,
    pair_shapes,
    side_of,
)
from flexmb.cams.pair_kernels import CURVES, FACE, OPEN, ROLLER, TOUCHING
from flexmb.errors import InputError, ModelError
from flexmb.model.contributions import Contribution, SignalContribution, node_coordinates
from flexmb.model.law import FrictionLaw, NormalLaw
from flexmb.model.part import Part
from flexmb.model.shape import Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism
    from flexmb.model.watched_motion import WatchedMotion

PULL = 1e-3
"""Pull of an ideal pair relative to its largest force, above which there is a remark."""

FAR = 0.25
"""Largest gap in the reference configuration that is closed at the start, over the size of the first curve."""

OVERLAP = 1e-3
"""Largest overlap in the reference configuration with which a contact may start open, over the same."""


@dataclass(frozen=True)
class CurveOnCurve(Part):
    """Two curves of two bodies that touch: cam with flat, roller or curved follower, two cams.

    Signals, ideal: force (contact force, > 0: the bodies press on each other) [N]; normal_speed (velocity along the
    normal there, of the body with the `Line` or `CircularCurve`, else of the second one) [m/s]; power (force times
    normal_speed, given to this body) [W]; with `friction` also friction_force [N].  With `normal`: as of a contact (see
    `RevoluteClearance`; ex, ey from the surface of the first curve to that of the second).  With a `Line` also place
    (of the contact along it from its start) [m].

    Parameters
    ----------
    name : name of the pair.
    first : the first body.
    first_curve : its curve, in the reference configuration.
    second : the second body.
    second_curve : its curve, in the reference configuration: `Line`, `CircularCurve` or `ClosedCurve`.  One
        of both must be a `ClosedCurve`.
    normal : law of the normal force, for a contact that can open; None: ideal, the curves never part.  A law made from
        materials has the stiffness of the places of largest curvature of both curves.
    friction : law of friction; None: none.
    start : of a contact: "touching", the loops are closed and the velocities found as for an ideal pair; "open", the
        bodies stand and move as declared.

    Raises
    ------
    InputError : curves of other kinds, a law of the wrong kind, a concave curve under a `Line`, a roller that is larger
        than a hollow of the curve, or another curve that is (undercut).
    ModelError : a body with itself, a flexible body, curves that are far apart or overlap in the reference
        configuration.

    Notes
    -----
    Bodies lie outside of each other.  The pair is one equation, the distance on the common normal = 0; an ideal pair
    also pulls, so a negative force tells where a real follower lifts off.  The nearest points are searched anew at each
    evaluation; a contact has one point, the nearest.  An ideal `Line` counts as unlimited: `place` outside 0 to its
    length tells that it is too short.  A contact uses the ends of the segment as edges.
    Source: J. J. Uicker, G. R. Pennock, J. E. Shigley, Theory of Machines and Mechanisms, 4th ed., Oxford 2011, ch. 6.
    """

    first: Part
    first_curve: Any
    second: Part
    second_curve: Any
    _: KW_ONLY
    normal: NormalLaw | None = None
    friction: FrictionLaw | None = None
    start: str = TOUCHING

    def __post_init__(self) -> None:
        super().__post_init__()
        check_pair(self)
        curves = self.first_curve, self.second_curve
        if not all(isinstance(c, ClosedCurve | CircularCurve | Line) for c in curves) or not any(
            isinstance(c, ClosedCurve) for c in curves
        ):
            raise InputError(
                f"{self.label}: the curves are {curves[0]!r} and {curves[1]!r}; one must be a ClosedCurve, the other a "
                "Line, cams.CircularCurve or ClosedCurve (fm.Circle is the section of a beam)."
            )
        curve, other = self._ordered()[1::2]
        least, _, (x, y) = curve.extreme_curvature()
        if isinstance(other, Line) and least <= 0.0:
            raise InputError(
                f"{self.label}: the curve is not convex near ({x:.6g}, {y:.6g}) m (curvature {least:.4g} 1/m), so a "
                "straight face bridges that place. Use a roller (CircularCurve), or another profile."
            )
        if isinstance(other, CircularCurve) and least * other.radius <= -1.0:
            raise InputError(
                f"{self.label}: the roller of radius {other.radius:g} m does not fit into the hollow near "
                f"({x:.6g}, {y:.6g}) m, whose radius is {-1.0 / least:.4g} m (undercut). Use a smaller roller."
            )

        if isinstance(other, ClosedCurve):
            self._check_fit(curve, other)
            self._check_fit(other, curve)

    def _check_fit(self, curve: ClosedCurve, other: ClosedCurve) -> None:
        """Refuse a hollow of `curve` that no place of `other` fits into."""
        (least, _, (x, y)), largest = curve.extreme_curvature(), other.extreme_curvature()[1]
        if least <= -largest:
            raise InputError(
                f"{self.label}: the other curve, of radius {1.0 / largest:.4g} m at least, does not fit into the "
                f"hollow near ({x:.6g}, {y:.6g}) m, of radius {-1.0 / least:.4g} m (undercut). Change one of them."
            )

    def _ordered(self) -> tuple[Part, Any, Part, Any]:
        """Bodies and curves with a closed curve first."""
        if isinstance(self.first_curve, ClosedCurve):
            return self.first, self.first_curve, self.second, self.second_curve
        return self.second, self.second_curve, self.first, self.first_curve

    @property
    def pushes(self) -> tuple[str, ...]:
        """The force of an ideal pair."""
        return ("force",) if self.normal is None else ()

    def remarks(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[str]:  # noqa: ARG002 - see `Part`
        """Sentence on a pull, where a real follower would lift off."""
        for name in self.pushes:
            (least, when), (largest, _) = motion.lows[f"{self.name}.{name}"], motion.peak(f"{self.name}.{name}")
            if least < -PULL * largest:
                yield (
                    f"At t = {when:.6g} s {self.label} pulls with {-least:.4g} N, where a follower would lift off. "
                    "Give normal=... for a contact that opens, or a stronger spring."
                )

    @property
    def pin_radius(self) -> float:
        """Least radius of curvature of both curves [m], beside which penetrations are judged."""
        curves = self.first_curve, self.second_curve
        radii = [c.radius for c in curves if isinstance(c, CircularCurve)]
        return min([*radii, *(1.0 / c.extreme_curvature()[1] for c in curves if isinstance(c, ClosedCurve))])

    def contact_law(self) -> NormalLaw | None:
        """Normal law; one made from materials has the stiffness of the places of largest curvature."""
        if self.normal is None:
            return None
        curves = self.first_curve, self.second_curve
        bends = [1.0 / c.radius for c in curves if isinstance(c, CircularCurve)]
        bends += [c.extreme_curvature()[1] for c in curves if isinstance(c, ClosedCurve)]
        return self.normal.for_radii(math.inf, 1.0 / sum(bends))

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse curves that are far apart, overlap, or touch beyond the end of a line."""
        super().validate(mechanism)
        curve, other = self._ordered()[1::2]
        check_distance(self, curve, other)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One constraint equation or one contact."""
        body, curve, second, other = self._ordered()
        nodes = carrier(mechanism, body.name, self.label), carrier(mechanism, second.name, self.label)
        coordinates = (*node_coordinates(body.name, nodes[0].name), *node_coordinates(second.name, nodes[1].name))
        head, closed = (TOLERANCE_LENGTH * curve.size,), curve_numbers(curve, nodes[0])
        if isinstance(other, Line):
            start, end = in_frame(nodes[1], other.start), in_frame(nodes[1], other.end)
            p = (*head, *start, *along(Line(start, end)), side_of(curve, other), other.length, *closed)
            place = SignalContribution(self.name, "place", "m", face_place, coordinates, p)
            return [*FACE.contributions(self, coordinates, p), place]
        if isinstance(other, CircularCurve):
            p = (*head, *in_frame(nodes[1], other.centre), other.radius, *closed)
            return ROLLER.contributions(self, coordinates, p)
        p = (*head, float(CURVE + len(closed)), *closed, *curve_numbers(other, nodes[1]))
        return CURVES.contributions(self, coordinates, p)

    def shapes(self, mechanism: Mechanism) -> Shapes:
        """Both curves."""
        return pair_shapes(mechanism, self, self.first_curve, self.second_curve)


def check_pair(part: Any) -> None:
    """Check bodies, laws and start of a pair of curves."""
    if part.first.name == part.second.name:
        raise ModelError(f"{part.label} joins {part.first.name!r} to itself; give two different bodies.")
    for name, kind, example in (("normal", NormalLaw, "HuntCrossley"), ("friction", FrictionLaw, "ModifiedCoulomb")):
        law = getattr(part, name)
        if law is not None and not isinstance(law, kind):
            raise InputError(f"{part.label}: {name} is {law!r}; it must be a {name} law, e.g. {example}, or None.")
    checks.one_of(part.label, "start", part.start, (TOUCHING, OPEN))
    if part.normal is None and part.start == OPEN:
        raise InputError(f"{part.label}: an ideal pair cannot start open; give normal=..., or leave start.")


def check_distance(part: Any, curve: ClosedCurve, other: Any) -> None:
    """Check gap and place of contact of a pair in the reference configuration."""
    gap, place = distance(curve, other)
    size = curve.size
    if part.start == OPEN:
        if gap < -OVERLAP * size:
            raise ModelError(
                f"{part.label}: the curves overlap by {-gap:.4g} m in the reference configuration. Move one of the "
                'bodies, or give start="touching", which puts the second one onto the curve.'
            )
        return
    if abs(gap) > FAR * size:
        word = "are" if gap > 0.0 else "overlap by"
        raise ModelError(
            f"{part.label}: the curves {word} {abs(gap):.4g} m {'apart ' if gap > 0.0 else ''}in the reference "
            f"configuration, beside a curve of {size:.4g} m. Curves are given in the reference configuration, in the "
            'axes of the frame; move them or the bodies until they touch, or give normal=... and start="open".'
        )
    if isinstance(other, Line) and not -OVERLAP * size <= place <= other.length + OVERLAP * size:
        raise ModelError(
            f"{part.label}: in the reference configuration the curve touches the line {place:.4g} m from its start, "
            f"beyond its ends at 0 and {other.length:.4g} m. Make the line longer."
        )
