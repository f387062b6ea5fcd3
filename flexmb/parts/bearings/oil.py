"""Oil whose viscosity falls with its temperature, and the heat that it carries out of a bearing."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import scipy.optimize

from flexmb import checks
from flexmb.display import Shown
from flexmb.errors import InputError
from flexmb.fields import Input, field, number, positive, record, several, two

COLDEST, HOTTEST = -60.0, 250.0
"""Temperatures between which Walther's law is asked [degC]."""

ABSOLUTE = 273.15  # temperature of 0 degC [K]


@record
class Oil(Input, Shown):
    """Oil by its viscosity at two temperatures, between and beyond them by Walther's law.

    Equation (15.9) of docs/theory/films.md.

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
            raise InputError(
                f"Oil: viscosities has {len(self.viscosities)} pairs; give two, e.g. ((40, .04), (100, .006))."
            )
        (_, thick), (_, thin) = pairs = sorted((float(t), float(mu)) for t, mu in self.viscosities)
        for temperature, viscosity in pairs:
            checks.between("Oil", "temperature", temperature, COLDEST, HOTTEST, "degC", "")
            checks.positive("Oil", "viscosity", viscosity, "Pa s", "Oils have 0.005 to 0.5 Pa s; 1 cP is 0.001 Pa s.")
        if pairs[0][0] == pairs[1][0] or not thick > thin:
            raise InputError("Oil: the viscosity must fall from the lower to the higher of two temperatures.")

    def viscosity(self, temperature: float) -> float:
        """Dynamic viscosity [Pa s] at a `temperature` [degC].

        Raises
        ------
        InputError : a temperature outside -60 to 250 degC.
        """
        checks.between("Oil", "temperature", temperature, COLDEST, HOTTEST, "degC", "")
        (t1, first), (t2, second) = ((math.log(t + ABSOLUTE), self._double_log(mu)) for t, mu in self.viscosities)
        now = first + (second - first) * (math.log(temperature + ABSOLUTE) - t1) / (t2 - t1)
        return 1e-6 * self.density * (math.exp(math.exp(now)) - 0.7)

    def _double_log(self, viscosity: float) -> float:
        """Left side of Walther's law."""
        return math.log(math.log(1e6 * viscosity / self.density + 0.7))

    def film_temperature(self, power: float, flow: float, inlet: float) -> float:
        """Mean temperature [degC] of a film that turns `power` [W] into heat, which its `flow` [m3/s] carries away.

        `inlet`: temperature of the oil that is supplied [degC].  The mean of inlet and outlet counts; nothing is
        carried away by the surfaces, so the true film is cooler.

        Equation (15.10) of docs/theory/films.md.
        """
        if flow <= 0.0:
            raise InputError("Oil: no oil flows out of the film, which carries no heat away; take a FiniteBearing.")
        return inlet + 0.5 * power / (self.density * self.heat_capacity * flow)

    def balanced(self, inlet: float, of_film: Callable[[float], tuple[float, float]]) -> float:
        """Temperature [degC] at which a film is as warm as its heat makes it.

        `of_film`: power [W] and flow [m3/s] of the film at a viscosity [Pa s]; an `InputError` of it says that oil as
        thin carries no load.
        """

        def missing(temperature: float) -> float:
            try:
                return self.film_temperature(*of_film(self.viscosity(temperature)), inlet) - temperature
            except InputError:
                if temperature == inlet:
                    raise
                return -1.0

        end = min(inlet + missing(inlet), HOTTEST)  # thinner oil turns less power into heat, and more of it flows
        found = scipy.optimize.brentq(missing, inlet, end, xtol=1e-9)
        of_film(self.viscosity(found))
        return float(found)
