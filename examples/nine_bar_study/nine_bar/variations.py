"""Variations of the page "sensitivity": changes of unpublished parameters, one at a time."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from nine_bar_study.case import Case
from nine_bar_study.nine_bar.staggered.method import Staggered

from flexmb.errors import FlexmbError, RestitutionWarning
from flexmb.mechanisms.nine_bar import NineBarData
from flexmb.parts.contact.onset import LARGEST

DATA = NineBarData()
QUARTER = 0.5 * math.pi


@dataclass(frozen=True)
class Variation:
    """Change of the reconstructed mechanism or of its steps.

    Parameters
    ----------
    letter : lower-case letters of the variation in tables and names of runs; "" for no change.
    what : text of the change.
    data : changed fields of the data of the mechanism.
    case : changed fields of a case: start, elements, steps, method.
    convex : whether the contact stiffness is the stiffness of two convex surfaces.
    beams_only : whether the change applies to the flexible mechanism only.
    play_only : whether the change applies to mechanisms with clearance only.
    """

    letter: str
    what: str
    data: Mapping[str, Any] = field(default_factory=dict)
    case: Mapping[str, Any] = field(default_factory=dict)
    convex: bool = False
    beams_only: bool = False
    play_only: bool = False

    @property
    def staggered(self) -> bool:
        """Whether the variation is the integration method of the paper."""
        return "method" in self.case

    def touches(self, model: str) -> bool:
        """Whether the change applies to a model, "ideal", "rigid" or "flexible"."""
        if (self.beams_only and model != "flexible") or (self.play_only and model == "ideal"):
            return False
        return bool(self.letter)

    def numbers(self, clearance: float) -> NineBarData:
        """Data of the mechanism with this change at a clearance [m]."""
        found = dataclasses.replace(DATA, **self.data)
        if not self.convex:
            return found
        # eq. (4) prints sqrt(R1 R2 / (R1 + R2)) instead of sqrt(R1 R2 / (R1 - R2)); K is proportional to E
        factor = math.sqrt(clearance / (2.0 * found.bearing_radius - clearance))
        return dataclasses.replace(found, contact_young=factor * found.contact_young)

    def of(self, case: Case) -> Case:
        """Case with this change."""
        if not self.touches(case.model):
            return dataclasses.replace(case, label=_label("", case.label))
        kept = {name: value for name, value in self.case.items() if name != "elements" or case.model == "flexible"}
        label = _label(self.letter, case.label)
        return dataclasses.replace(case, data=self.numbers(case.clearance), label=label, **kept)

    def why_not(self, case: Case) -> str:
        """Message of the error of a case with this change; "" without an error."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RestitutionWarning)  # `what` gives the resulting restitution
            try:
                self.of(case).mechanism()
            except FlexmbError as error:
                return str(error)
        return ""


def _label(letter: str, label: str) -> str:
    return "-".join(text for text in ("varied", letter, label) if text)


def _pivot(dx: float, dy: float) -> dict[str, Any]:
    return {"pivot6": (round(DATA.pivot6[0] + dx, 6), round(DATA.pivot6[1] + dy, 6))}


SWAPPED = {"side_ab": DATA.side_ac, "side_ac": DATA.side_ab}
SLENDER = {"depth": 0.020, "thickness": 0.0150, "thickness3": 0.0075}
"""Bars of 20 mm depth and unchanged area, hence unchanged mass."""

STAGGERED = {"method": Staggered(), "step": 4e-5}

USUAL = Variation("", "as reconstructed")

VARIATIONS = (
    Variation("a", "sides AB and AC of the panel swapped: .304, .229 m", SWAPPED),
    Variation("b", "J7 = 3.802e-3 kg m^2, as printed", {"inertia7": 3.802e-3}),
    Variation("c", "J7 = 2.3e-2 kg m^2, a uniform triangle", {"inertia7": 2.3e-2}),
    Variation("d", "no friction, cf = 0", {"friction_coefficient": 0.0}, play_only=True),
    Variation("e", "cf = 0.03", {"friction_coefficient": 0.03}, play_only=True),
    Variation("f", "cf = 0.1", {"friction_coefficient": 0.1}, play_only=True),
    Variation("g", "R1 = 5 mm", {"bearing_radius": 0.005}, play_only=True),
    Variation("h", "R1 = 20 mm", {"bearing_radius": 0.020}, play_only=True),
    Variation("i", "zeta2 = 0", {"damping": 0.0}, beams_only=True),
    Variation("j", "zeta2 = 1e-6 s, light steel structures", {"damping": DATA.LIGHT_DAMPING}, beams_only=True),
    Variation("k", "zeta2 = 1e-5 s", {"damping": 1e-5}, beams_only=True),
    Variation("l", "zeta2 = 1e-4 s", {"damping": 1e-4}, beams_only=True),
    Variation("m", "zeta1 = 10 1/s, on rates of deformation", {"mass_damping": 10.0}, beams_only=True),
    Variation("n", "start at 90, 0 degrees", case={"start": (QUARTER, 0.0)}),
    Variation("o", "start at 180, 0 degrees", case={"start": (2.0 * QUARTER, 0.0)}),
    Variation("p", "start at 270, 0 degrees", case={"start": (3.0 * QUARTER, 0.0)}),
    Variation("q", "O6 10 mm towards +X", _pivot(0.01, 0.0)),
    Variation("r", "O6 10 mm towards -X", _pivot(-0.01, 0.0)),
    Variation("s", "O6 10 mm towards +Y", _pivot(0.0, 0.01)),
    Variation("t", "O6 10 mm towards -Y", _pivot(0.0, -0.01)),
    Variation("u", "bars 20 mm deep, 15 mm thick (link 3: 7.5 mm)", SLENDER, beams_only=True),
    Variation("v", "K of convex surfaces, R1 R2 / (R1 + R2), as eq. (4) is printed", convex=True, play_only=True),
    Variation("w", "restitution 0.7 (this law then gives 0.80)", {"restitution": 0.7}, play_only=True),
    Variation("x", "restitution 0.5 (this law then gives 0.73)", {"restitution": 0.5}, play_only=True),
    Variation("y", "2 elements a link", case={"elements": 2}, beams_only=True),
    Variation("z", "8 elements a link", case={"elements": 8}, beams_only=True),
    Variation("aa", "coarser steps, rtol = 1e-3", case={"rtol": 1e-3}),
    Variation("bb", "finer steps, rtol = 1e-5", case={"rtol": 1e-5}),
    Variation(
        "cc",
        "the paper's own scheme (staggered), steps of 4e-5 s, zeta2 = 1e-6 s, 2 pi rad/s only",
        {"damping": DATA.LIGHT_DAMPING},  # with 2e-5 s its energies do not add up: 0.355 of 1.44 J are missing
        case=STAGGERED,
        beams_only=True,
    ),
    Variation("dd", "the largest speed of a contact scales its damping", {"reference_speed": LARGEST}, play_only=True),
    Variation(
        "ee", "the same of contacts that begin slower than 1e-5 m/s (1e-6)", {"least_approach": 1e-5}, play_only=True
    ),
    Variation("ff", "the same of contacts that begin slower than 1e-7 m/s", {"least_approach": 1e-7}, play_only=True),
    Variation("gg", "the same of contacts that begin slower than 1e-3 m/s", {"least_approach": 1e-3}, play_only=True),
    Variation("hh", "steps of 0.05 ms at most (0.2 ms)", case={"longest": 5e-5}, play_only=True),
    Variation("ii", "128 steps at least in an impact (32)", case={"impact_steps": 128}, play_only=True),
    Variation("kk", "thinner panel of the same mass, J7 and centre", {"side_ab": 0.248, "side_ac": 0.290}),
    Variation("ll", "thicker panel of the same", {"side_ab": 0.208, "side_ac": 0.317, "side_bc": 0.314}),
    Variation("mm", "L8 = .335 m, which fits mass and J8 better", {"length8": 0.335}),
    Variation("jj", "friction rises from 1e-5 to 1e-4 m/s (1e-4 to 1e-3)", {"v0": 1e-5, "v1": 1e-4}, play_only=True),
)

LETTERS = {1e-7: "zeta1e-07", 1e-6: "j", 5e-6: "zeta5e-06", 1e-5: "k", 2e-5: "y"}
LETTERS |= {3e-5: "zeta3e-05", 5e-5: "zeta5e-05", 1e-4: "l", 1e-3: "zeta0.001"}
"""Letters of the rows of the page "damping" by zeta2 [s]; rows that the sensitivity has, too, have its letters, so that
both pages share their runs."""

ZETAS = tuple(LETTERS)
"""Values of zeta2 on the page "damping" [s]."""


def _damped(letter: str, what: str, beams_only: bool = True, elements: int = 2, **data: float) -> Variation:
    return Variation(letter, what, {"damping": DATA.damping, **data}, {"elements": elements}, beams_only=beams_only)


def _beside(what: str) -> str:
    """Words of a row in which another number changes, too."""
    return f"{DATA.damping:g} s, {what}"


DAMPED = (
    *(_damped(letter, f"zeta2 = {z:g} s", damping=z) for z, letter in LETTERS.items()),
    *(_damped(letter, _beside(f"{n} elements a link"), elements=n) for letter, n in (("elements4", 4), ("z", 8))),
    *(
        _damped(letter, _beside(f"zeta1 = {z:g} 1/s"), mass_damping=z)
        for letter, z in (("m", 10.0), ("mass100", 100.0))
    ),
    *(
        _damped(letter, _beside(f"cf = {c:g}"), False, friction_coefficient=c)
        for letter, c in (("d", 0.0), ("e", 0.03))
    ),
)
"""Variations of the page "damping"."""
