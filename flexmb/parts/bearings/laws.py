"""Films of oil by their viscosity and width, and oil whose viscosity falls with its temperature."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY
from itertools import pairwise
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import scipy.optimize

from flexmb import checks
from flexmb.display import Shown
from flexmb.errors import InputError
from flexmb.fields import Input, between, field, number, one_of, positive, record, several, two
from flexmb.model.part import Part
from flexmb.parts.bearings import film
from flexmb.parts.bearings.kernels import CLEARANCE, DRAG, EXTENT, FLOW, FORCE, KIND, PRESSURE

# Kinds of cavitation, with the extents that they leave of a film.
EXTENTS = {"positive": film.POSITIVE, "half": film.HALF, "none": film.WHOLE}


@record
class Film(Input, Shown, ABC):
    """Base of films of oil of constant viscosity between a journal and its bearing."""

    _: KW_ONLY
    viscosity: float = field(
        "dynamic viscosity mu of the oil", "Pa s", positive, hint="Oils have 0.005 to 0.5 Pa s; 1 cP is 0.001 Pa s."
    )
    width: float = field("axial width L of the bearing", "m", positive)
    density: float = field("density of the oil, for the Reynolds number", "kg/m^3", positive, default=870.0)
    kind: ClassVar[float]

    @property
    def extent(self) -> float:
        """Extent of the film, as a parameter of the kernels."""
        return film.POSITIVE

    @abstractmethod
    def scales(self, radius: float, clearance: float) -> dict[int, float]:
        """Scales of force, pressure and flow by their places, for `radius` and `clearance` of a bearing [m]."""

    def numbers(self, radius: float, clearance: float) -> dict[int, float]:
        """Parameters of a film in a bearing of this `radius` and `clearance` [m], by their places."""
        drag = 2.0 * math.pi * self.viscosity * radius**3 * self.width / clearance
        return {KIND: self.kind, EXTENT: self.extent, CLEARANCE: clearance, DRAG: drag} | self.scales(radius, clearance)

    @abstractmethod
    def pressures(
        self, radius: float, clearance: float, motion: tuple[float, float, float], theta: np.ndarray, widest: float
    ) -> np.ndarray:
        """Pressure (n,) in the middle of the width [Pa] at angles `theta` (n,) from the widest gap [rad].

        `radius` and `clearance` of the bearing [m]; `motion`: eccentricity over the clearance, rates a and b [1/s] of
        (15.1); `widest`: direction of the widest gap in the frame of the bearing's body [rad].
        """

    def table(self, label: str, radius: float, thinnest: float) -> tuple[float, ...]:  # noqa: ARG002 - asked by some
        """Further parameters, of a film whose force is a table, for a bearing of this `radius` [m].

        `label`: of the joint, for messages; `thinnest`: least film over the clearance.
        """
        return ()


@record
class ClosedFilm(Film):
    """Base of films whose forces are closed forms."""

    _: KW_ONLY
    cavitation: str = field(
        '"positive": the film is where its pressure is positive; "half": from the widest to the narrowest gap, also '
        'with squeeze, as often published; "none": all round', rule=one_of(*EXTENTS), default="positive",
    )  # fmt: skip

    @property
    def extent(self) -> float:
        return EXTENTS[self.cavitation]

    def pressures(
        self, radius: float, clearance: float, motion: tuple[float, float, float], theta: np.ndarray,
        widest: float,  # noqa: ARG002 - asked by others
    ) -> np.ndarray:  # fmt: skip
        return self.scales(radius, clearance)[PRESSURE] * film.pressures(self.kind, self.extent, *motion, theta)


@record
class ShortBearing(ClosedFilm):
    """Film of a bearing that is short beside its diameter (Ocvirk): the oil flows to the sides alone.

    Squeeze and spin may have any size and sign.

    Equation (15.3) of docs/theory/films.md.

    Raises
    ------
    InputError : values out of range.

    Notes
    -----
    For widths up to half the diameter, and eccentricities up to 0.8 of the clearance: beyond, it is too stiff.
    The shear stress acts all round the bearing, in the cavitated part as well.
    Source: G. B. DuBois, F. W. Ocvirk, Analytical derivation and experimental evaluation of short-bearing approximation
    for full journal bearings, NACA Report 1157, 1953.
    """

    kind = film.SHORT

    def scales(self, radius: float, clearance: float) -> dict[int, float]:
        mu, L, c = self.viscosity, self.width, clearance
        return {FORCE: mu * radius * L**3 / c**2, PRESSURE: 1.5 * mu * (L / c) ** 2, FLOW: 2.0 * radius * L * c}


@record
class LongBearing(ClosedFilm):
    """Film of a bearing that is long beside its diameter (Sommerfeld): the oil flows around the journal alone.

    Squeeze and spin may have any size and sign.

    Equation (15.4) of docs/theory/films.md.

    Raises
    ------
    InputError : values out of range.

    Notes
    -----
    For widths of more than four times the diameter; at a width of one diameter its force is five times that of a finite
    film.  Nothing flows out at the sides, so `flow` is 0.
    The shear stress acts all round the bearing, in the cavitated part as well.
    With squeeze the pressure is zero at both ends of half a turn, too.
    Source: O. Pinkus, B. Sternlicht, Theory of Hydrodynamic Lubrication, McGraw-Hill 1961, for the film without it.
    """

    kind = film.LONG

    def scales(self, radius: float, clearance: float) -> dict[int, float]:
        slender = (radius / clearance) ** 2
        return {
            FORCE: self.viscosity * radius * slender * self.width, PRESSURE: 6.0 * self.viscosity * slender, FLOW: 0.0,
        }  # fmt: skip


WIDEST, EVERYWHERE = "widest", "everywhere"
NARROWEST = math.pi / 18.0  # least angle of film between two grooves [rad]


@record
class FiniteBearing(Film):
    """Film of a bearing of any width, by the Reynolds equation with p >= 0 and Reynolds' condition at its border.

    Its forces stand in a table of eccentricity and direction of the motion, which is made once for each ratio of width
    to diameter, before the first run.  Squeeze and spin may have any size and sign.

    Equations (15.1) and (15.6) of docs/theory/films.md.

    Raises
    ------
    InputError : values out of range; with the joint: a roughness below 0.002 of the clearance, where the table ends;
        grooves that leave no film between them, or beside another `supply`.

    Notes
    -----
    Finite volumes, 96 around and 12 on half of the width; errors of forces are below 0.1 % up to an eccentricity of
    0.9 and a width of two diameters, 0.3 % up to 0.97 and ten diameters (docs/decisions/074-films-of-oil.md), but 1 to
    5 % of the small forces of a journal that leaves its bearing's wall; `flow` is 0.5 to 2 % too small.  Published
    tables of steady loads begin the film at the widest gap.  Under a load that turns or reverses, oil from everywhere
    is the better guess.  Mass of oil in cavities is left out.
    With `grooves` the oil comes from them alone, and what lies between is a film of its own; a table then takes half a
    minute for each angle between grooves, and adds 1 % at most (1e-4 in the median) to the error.
    The shear stress acts all round the bearing, in the cavitated part as well.
    """

    supply: str = field(
        'where oil is supplied without pressure: "widest", along the widest gap; "everywhere" where the film is torn',
        rule=one_of(WIDEST, EVERYWHERE), default=WIDEST,
    )  # fmt: skip
    grooves: Sequence[float] = field(
        "directions of axial grooves in the frame of the bearing's body, which supply the oil in place of `supply`",
        "rad", several(number, "angles"), default=(),
    )  # fmt: skip
    groove_width: float = field("angle that a groove takes", "rad", between(0.0, math.pi), default=math.pi / 9.0)

    kind = film.TABLE

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.grooves and self.supply != WIDEST:
            raise InputError('FiniteBearing: the oil comes from grooves or from "everywhere"; leave one of them out.')
        apart = (second - first for first, second in pairwise(self.turned))
        narrow = min(apart, default=math.inf) - self.groove_width
        if narrow < NARROWEST:
            text = f"FiniteBearing: grooves leave {narrow:.3g} rad of film between them;"
            raise InputError(f"{text} give directions that leave {NARROWEST:.3g} rad, or a smaller groove_width.")

    @property
    def turned(self) -> tuple[float, ...]:
        """Directions of the grooves, in turn from 0 to 2 pi, the first one once more at the end [rad]."""
        turned = sorted(angle % (2.0 * math.pi) for angle in self.grooves)
        return (*turned, *(angle + 2.0 * math.pi for angle in turned[:1]))

    def numbers(self, radius: float, clearance: float) -> dict[int, float]:
        return super().numbers(radius, clearance) | ({KIND: film.PADS} if self.grooves else {})

    def scales(self, radius: float, clearance: float) -> dict[int, float]:
        pressure = self.viscosity * (radius / clearance) ** 2
        return {FORCE: pressure * radius * self.width, PRESSURE: pressure, FLOW: radius**2 * clearance / 6.0}

    def pressures(
        self, radius: float, clearance: float, motion: tuple[float, float, float], theta: np.ndarray, widest: float
    ) -> np.ndarray:
        found, half = np.zeros(len(theta)), 0.5 * self.groove_width
        ends = pairwise(self.turned)
        pads: list[tuple[float, float] | None] = [(one + half - widest, end - one - 2.0 * half) for one, end in ends]
        for pad in pads or [None]:
            solved = film.solve_film(*motion, self.width / (2.0 * radius), from_widest=self.supply == WIDEST, pad=pad)
            own = np.interp(theta, solved.angle, solved.pressure[:, 0], period=2.0 * math.pi)
            found += own if pad is None else np.where((theta - pad[0]) % (2.0 * math.pi) < pad[1], own, 0.0)
        return self.scales(radius, clearance)[PRESSURE] * found

    def table(self, label: str, radius: float, thinnest: float) -> tuple[float, ...]:
        if thinnest < film.THINNEST:
            text = f"{label}: the film may become as thin as {thinnest:.3g} of the clearance, half of the roughness;"
            text += f" the table of a FiniteBearing ends at {film.THINNEST:g}."
            raise InputError(f"{text} Give a roughness of 0.002 of the clearance.")
        ratio = self.width / (2.0 * radius)
        if self.grooves:
            return film.pads_table(ratio, self.turned, self.groove_width)
        return film.film_table(ratio, self.supply == WIDEST)


@record
class Oiled(Part):
    """Base of joints with clearance, a film of oil, and rough surfaces that touch through it."""

    _: KW_ONLY
    roughness: float = field(
        "height of the roughness of both surfaces together, from which they touch", "m", positive, default=1e-6
    )
    if TYPE_CHECKING:  # field of the dry joint
        clearance: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.roughness >= 0.5 * self.clearance:
            text = f"{self.label}: roughness is {self.roughness:g} m; it must be smaller than half of the clearance"
            raise InputError(f"{text} {self.clearance:g} m. Ground steel has 1e-7 to 1e-6 m.")

    @property
    def play(self) -> float:
        """Eccentricity at which the surfaces touch [m]."""
        return self.clearance - self.roughness


COLDEST, HOTTEST = -60.0, 250.0  # temperatures between which Walther's law is asked [degC]
THINNEST_OIL = 0.3  # kinematic viscosity [mm^2/s] from which Walther's double logarithm exists
ABSOLUTE = 273.15  # temperature of 0 degC [K]


@record
class Oil(Input, Shown):
    """Oil by its viscosity at two temperatures, between and beyond them by Walther's law.

    Equation (15.11) of docs/theory/films.md.

    Raises
    ------
    InputError : values out of range; a viscosity that does not fall with the temperature.

    Notes
    -----
    Temperatures are in degC.  Of 13 oils with viscosities measured at 30, 60 and 100 degC the law gives that at 60 degC
    with an error of 2 % in the median from the other two.
    Source: ASTM D341, after C. Walther 1931.
    """

    viscosities: Sequence[Sequence[float]] = field(
        "two pairs (temperature [degC], dynamic viscosity [Pa s])",
        rule=several(two(number, "numbers", "a temperature [degC] and a viscosity [Pa s]"), "pairs"),
    )
    density: float = field("density, constant", "kg/m^3", positive, default=870.0)
    heat_capacity: float = field("heat capacity of a mass", "J/(kg K)", positive, default=2000.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.viscosities) != 2:
            text = f"Oil: viscosities has {len(self.viscosities)} pairs;"
            raise InputError(f"{text} give two, e.g. ((40, .04), (100, .006)).")
        (_, thick), (_, thin) = pairs = sorted((float(t), float(mu)) for t, mu in self.viscosities)
        for temperature, viscosity in pairs:
            checks.between("Oil", "temperature", temperature, COLDEST, HOTTEST, "degC", "")
            checks.positive("Oil", "viscosity", viscosity, "Pa s", "Oils have 0.005 to 0.5 Pa s; 1 cP is 0.001 Pa s.")
        if pairs[0][0] == pairs[1][0] or not thick > thin:
            raise InputError("Oil: the viscosity must fall from the lower to the higher of two temperatures.")
        if thin <= 1e-6 * THINNEST_OIL * self.density:
            text = f"Oil: a viscosity is {thin:g} Pa s; Walther's law holds above {THINNEST_OIL:g} mm^2/s,"
            text += f" here {1e-6 * THINNEST_OIL * self.density:.3g} Pa s."
            raise InputError(f"{text} Oils have 0.005 to 0.5 Pa s; 1 cP is 0.001 Pa s.")

    def viscosity(self, temperature: float) -> float:
        """Dynamic viscosity [Pa s] at a `temperature` [degC].

        Raises
        ------
        InputError : a temperature outside -60 to 250 degC.
        """
        checks.between("Oil", "temperature", temperature, COLDEST, HOTTEST, "degC", "")
        pairs = ((t + ABSOLUTE, 1e6 * mu / self.density + 0.7) for t, mu in self.viscosities)
        (t1, first), (t2, second) = ((math.log(t), math.log(math.log(nu))) for t, nu in pairs)  # Walther's law
        now = first + (second - first) * (math.log(temperature + ABSOLUTE) - t1) / (t2 - t1)
        return 1e-6 * self.density * (math.exp(math.exp(now)) - 0.7)

    def film_temperature(self, power: float, flow: float, inlet: float) -> float:
        """Mean temperature [degC] of a film that turns `power` [W] into heat, which its `flow` [m3/s] carries away.

        `inlet`: temperature of the oil that is supplied [degC].  The mean of inlet and outlet counts; nothing is
        carried away by the surfaces, so the true film is cooler.

        Equation (15.12) of docs/theory/films.md.
        """
        checks.not_negative("Oil", "power", power, "W")
        if checks.number("Oil", "flow", flow, "m^3/s") <= 0.0:
            raise InputError("Oil: no oil flows out of the film, which carries no heat away; take a FiniteBearing.")
        return inlet + 0.5 * power / (self.density * self.heat_capacity * flow)

    def balanced(self, inlet: float, of_film: Callable[[float], tuple[float, float]]) -> float:
        """Temperature [degC] at which a film is as warm as its heat makes it.

        `inlet`: temperature of the oil that is supplied [degC]; `of_film`: power [W] and flow [m3/s] of the film at a
        viscosity [Pa s]; an `InputError` of it says that oil as thin carries no load.
        """

        def missing(temperature: float) -> float:
            try:
                return self.film_temperature(*of_film(self.viscosity(temperature)), inlet) - temperature
            except InputError:
                if temperature == inlet:
                    raise
                return -1.0

        end = min(inlet + missing(inlet), HOTTEST)  # thinner oil turns less power into heat, and more of it flows
        if end == HOTTEST and missing(end) > 0.0:
            text = f"Oil: the film gets warmer than {HOTTEST:g} degC, where Walther's law ends. Lower the speed,"
            raise InputError(f"{text} take a thinner oil, or a larger clearance, through which more oil flows.")
        found = scipy.optimize.brentq(missing, inlet, end, xtol=1e-9)
        of_film(self.viscosity(found))
        return float(found)
