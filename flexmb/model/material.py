"""Linear elastic, isotropic material."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb import arguments, checks
from flexmb.display.shown import Shown
from flexmb.errors import InputError


@dataclass(frozen=True)
class Material(arguments.Checked, Shown):
    """Linear elastic, isotropic material.

    Parameters
    ----------
    young : Young's modulus E [Pa], > 0.
    density : rho [kg/m^3], > 0.
    poisson : Poisson's ratio nu, -1 < nu < 0.5; contacts use it, and beams with shear.
    yield_stress : uniaxial yield stress Y [Pa], > 0, or None when it is not known; a run then does not say where a
        contact yields.

    Raises
    ------
    InputError : a value out of its range.

    Examples
    --------
    >>> aluminium = Material(young=71.7e9, density=2710.0, poisson=0.333)
    >>> aluminium.young
    71700000000.0
    """

    young: float
    density: float
    poisson: float = 0.3
    yield_stress: float | None = None

    def __post_init__(self) -> None:
        hint = "Young's modulus of steel is 207e9 Pa."
        values = {
            "young": checks.positive("Material", "young", self.young, "Pa", hint),
            "density": checks.positive("Material", "density", self.density, "kg/m^3"),
            "poisson": checks.number("Material", "poisson", self.poisson),
        }
        if self.yield_stress is not None:
            values["yield_stress"] = checks.positive("Material", "yield_stress", self.yield_stress, "Pa")
        if not -1.0 < values["poisson"] < 0.5:
            text = f"Material: poisson is {self.poisson:g}; it must lie between -1 and 0.5, both excluded."
            raise InputError(f"{text} For rubber take 0.499.")
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G = E/(2 (1 + nu)) [Pa]."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa], the share of one body in the compliance of a Hertz contact.

        Source: K. L. Johnson, Contact Mechanics, Cambridge University Press 1985, eq. (4.20): 1/E* is the sum of it
        over both bodies.
        """
        return (1.0 - self.poisson**2) / self.young


STEEL = Material(207e9, 7801.0, 0.29)
"""Carbon steel: 207 GPa, 7801 kg/m^3 (76.5 kN/m^3), 0.29.

Source: J. E. Shigley, C. R. Mischke, Mechanical Engineering Design, appendix A, physical constants of materials.
"""
