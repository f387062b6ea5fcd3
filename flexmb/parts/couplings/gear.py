"""Gear pair: two toothed wheels, external or internal, on fixed axes or on an arm, with or without backlash."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, replace

import numpy as np

from flexmb import checks, planar
from flexmb.errors import InputError, ModelError
from flexmb.fields import between, count, field, positive, record, two
from flexmb.findings.finding import Finding, found
from flexmb.model.contributions import ContactContribution, Contribution, node_coordinates
from flexmb.model.law import NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, WatchedMotion
from flexmb.model.shape import Shapes
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.couplings.wheels import (
    FITS,
    STANDARD_PRESSURE_ANGLE,
    Wheels,
    involute,
    tooth_gap_kernel,
    tooth_pressure,
)

LARGE_PLAY = 0.2  # error of the distance of the axes in a motion, over the module, above which there is a remark
# Names of the contacts of a pair with backlash; 1 where the first wheel pushes while it turns counter-clockwise.
FLANKS = {"forward": 1.0, "backward": -1.0}


@record
class Gear(Wheels):
    """Gear pair of two wheels, ideal or with backlash; the wheels need joints of their own.

    The pitch circles roll on one another: r1 (theta1 - phi) + r2 (theta2 - phi) is constant, with the direction phi of
    the line of centres, and - r2 for an internal pair.

    Signals: force (tangential, at the pitch circles) [N]; first_torque, second_torque (on the wheels) [N m]; power (of
    second_torque) [W].  The tooth force itself loads the bearings of both wheels.  With backlash: of both contacts,
    forward and backward (`mesh.forward.normal_force`, ...), as of `RevoluteClearance`; the forward one carries where
    the first wheel drives counter-clockwise.

    Raises
    ------
    InputError : numbers of teeth that are not whole or not > 0; an internal pair of equal wheels; backlash without a
        normal law, or more than half a tooth.
    ModelError : a wheel that meshes with itself; a distance of the axes that is 0, or does not fit the module; backlash
        of a wheel whose centre of mass is not on its axis.

    Notes
    -----
    The ratio depends on the teeth alone, exactly and for any distance of the axes, which sets the force at the pitch
    point.  An ideal pair carries on either flank: the tangential force F presses the wheels apart with |F| tan(alpha),
    on both directions of F.  While the axes move this force does work, which is booked with friction in joints: real
    teeth open then; give backlash.  Without an arm the line of centres may turn by less than half a turn.  Wheels drawn
    at another distance than that of their pitch circles load their axes by F (r1 + r2)/D, so moments balance; on one
    axis (shafts in line) they load the arm with a torque.

    With backlash the teeth are rigid involutes with an elastic normal law, which stands for the stiffness of the mesh.
    The force has the direction of the line of action.  Play and pressure angle follow the distance of the axes exactly,
    so bearings may have clearance.  At the start the teeth stand in the middle of their play and move as an ideal pair.
    Sliding along the flanks and a varying number of teeth in mesh are left out.
    Source: J. J. Uicker, G. R. Pennock, J. E. Shigley, Theory of Machines and Mechanisms, 4th ed., Oxford 2011, ch. 7.
    """

    _: KW_ONLY
    teeth: tuple[int, int] = field(
        "numbers of teeth of both wheels", rule=two(count(), "whole numbers", "two whole numbers, e.g. (20, 40)")
    )
    internal: bool = field("whether the wheel with more teeth is a ring with inner teeth", default=False)
    distance: float | None = field("of the axes, for the pitch circles; None: as drawn", "m", positive, default=None)
    module: float | None = field("pitch diameter over teeth; None: by the distance", "m", positive, default=None)
    backlash: float | None = field(
        "play of the teeth along the pitch circles",
        "m",
        positive,
        hint="For an ideal pair leave backlash out.",
        default=None,
    )
    normal: NormalLaw | None = field("law of the flanks along the line of action, with backlash", default=None)
    pressure_angle: float = field(
        "alpha; 0, of an ideal pair: no radial force",
        "rad",
        between(0.0, 0.25 * math.pi),
        default=STANDARD_PRESSURE_ANGLE,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.internal and self.teeth[0] == self.teeth[1]:
            raise InputError(f"{self.label}: both wheels have {self.teeth[0]} teeth; a ring needs more than its wheel.")
        if self.backlash is not None:
            checks.between(self.label, "pressure_angle", self.pressure_angle, 1e-3, 0.25 * math.pi, "rad")
        self._check_backlash()

    def _check_backlash(self) -> None:
        """Check that backlash and normal law are given together."""
        if self.backlash is None:
            if self.normal is not None:
                text = f"{self.label}: normal is given without backlash;"
                raise InputError(f"{text} give backlash=... in m, or leave it.")
            return
        if not isinstance(self.normal, NormalLaw):
            text = f"{self.label}: normal is {self.normal!r};"
            raise InputError(f"{text} a pair with backlash needs a normal law, e.g. KelvinVoigt.")

    def radii(self, mechanism: Mechanism) -> tuple[float, float]:
        """Pitch radii of both wheels in a `mechanism` [m].

        Raises
        ------
        ModelError : a distance of the axes that is 0, unknown, or does not fit the module.
        """
        (z1, z2), distance = self.teeth, self._distance(mechanism)
        sum_of_teeth = abs(z2 - z1) if self.internal else z1 + z2
        if self.module is not None and abs(0.5 * self.module * sum_of_teeth - distance) > FITS * distance:
            raise ModelError(
                f"{self.label}: the axes are {distance:g} m apart, but wheels of {z1} and {z2} teeth with module "
                f"{self.module:g} m need {0.5 * self.module * sum_of_teeth:g} m. Move an axis, or change the wheels."
            )
        return distance * z1 / sum_of_teeth, distance * z2 / sum_of_teeth

    def module_of(self, mechanism: Mechanism) -> float:
        """Module of the teeth in a `mechanism` [m]."""
        return 2.0 * self.radii(mechanism)[0] / self.teeth[0]

    def signed_radii(self, mechanism: Mechanism) -> tuple[float, float]:
        """Pitch radii of both wheels in a `mechanism` [m], that of a ring below 0."""
        r1, r2 = self.radii(mechanism)
        return r1, -r2 if self.internal else r2

    def _distance(self, mechanism: Mechanism) -> float:
        if self.distance is not None:
            return self.distance
        apart = planar.distance(*self._axes(mechanism))
        if apart == 0.0:
            raise ModelError(f"{self.label}: the centres of both wheels coincide. Give distance= of the axes.")
        return apart

    def contact_size(self, mechanism: Mechanism) -> float | None:
        """Module of teeth with backlash in `mechanism` [m]."""
        return None if self.backlash is None else self.module_of(mechanism)

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:
        """Finding on an ideal pair whose axes leave the distance that its wheels are made for."""
        if self.backlash is not None or self.distance is not None:
            return
        apart, drawn = self._distances(mechanism, motion), abs(sum(self.signed_radii(mechanism)))
        off = np.abs(apart - drawn)
        k = int(np.argmax(off))
        if off[k] > LARGE_PLAY * self.module_of(mechanism):
            text = (
                f"At t = {motion.times[k]:.6g} s the centres of the wheels of {self.label} are {apart[k]:.4g} m apart; "
                f"its teeth mesh at {drawn:.4g} m."
            )
            remedy = "An ideal pair holds its ratio at any distance: hold the axes, or give backlash= and normal=."
            yield found("unreal-motion", (self.name,), text, remedy, time=motion.times[k], distance=apart[k])

    def shapes(self, mechanism: Mechanism) -> Shapes:
        return self._circles(mechanism, self.radii(mechanism))

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        r1, r2 = self.signed_radii(mechanism)
        R = math.copysign(r1 + r2, r2) if self.internal else r1 + r2
        base = planar.distance(*self._axes(mechanism)) * math.cos(self.pressure_angle)
        pressure = (tooth_pressure, (R, base)) if self.pressure_angle > 0.0 else None
        ideal = self._rolling(mechanism, (r1, r2), pressure)
        if self.backlash is None or self.normal is None:
            return [ideal]
        contacts = self._contacts(mechanism, r1, r2, self.backlash, self.normal)
        return [*contacts, replace(ideal, holds="closed")]

    def _contacts(
        self, mechanism: Mechanism, r1: float, r2: float, backlash: float, normal: NormalLaw
    ) -> Sequence[Contribution]:
        """Contacts of both flanks."""
        one, two = (mechanism.body(part.name, self.label) for part in (self.first, self.second))
        first, second = one.node(one.main), two.node(two.main)
        apart, wanted = planar.distance((first.x, first.y), (second.x, second.y)), abs(r1 + r2)
        if GROUND.name in (self.first.name, self.second.name) or abs(apart - wanted) > FITS * wanted:
            raise ModelError(
                f"{self.label}: with backlash both wheels must be bodies whose centres of mass lie on their axes, "
                f"{wanted:g} m apart; they are {apart:g} m apart. Use a heavy body on a Fixed joint for a ring at rest."
            )
        pitch = 2.0 * math.pi * abs(r1) / self.teeth[0]
        if backlash >= 0.5 * pitch:
            text = f"{self.label}: backlash is {backlash:g} m, but a tooth and its gap are {pitch:.4g} m long together;"
            raise InputError(f"{text} it must be less than half of that.")
        c = math.cos(self.pressure_angle)
        direction = math.atan2(second.y - first.y, second.x - first.x)
        offset = c * (r1 * (first.theta - direction) + r2 * (second.theta - direction))
        coordinates = (*node_coordinates(one.name, first.name), *node_coordinates(two.name, second.name))
        play = backlash, 0.5 * backlash * c, r1 * c, r2 * c
        rest = involute(self.pressure_angle), offset, pitch * c
        flanks = ((name, (*play, side, *rest)) for name, side in FLANKS.items())
        laws = normal, Frictionless()
        return [ContactContribution(self.name, tooth_gap_kernel, coordinates, p, *laws, name) for name, p in flanks]
