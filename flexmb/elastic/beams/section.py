"""Cross-sections of beams: area, second moment, outer fibre, shear factor, constant or tapered along the beam."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import KW_ONLY, fields

import numpy as np
import numpy.typing as npt

from flexmb import checks
from flexmb.display import Shown
from flexmb.errors import InputError
from flexmb.fields import Input, Rule, field, instance, positive, record
from flexmb.planar import Array

Place = npt.ArrayLike  # place along the beam: s in [0, 1], a number or an array of any shape


class Section(Input, Shown, ABC):
    """Cross-section of a straight beam as a function of s in [0, 1], start to end.

    For a section of your own, derive from this class and write the two methods; both must keep the shape of s.
    """

    @abstractmethod
    def area_at(self, s: Place) -> Array:
        """Area A(s) [m^2], shaped like s."""

    @abstractmethod
    def second_moment_at(self, s: Place) -> Array:
        """Second moment of area I(s) [m^4] about the axis normal to the plane of motion, shaped like s."""

    def outer_fibre_at(self, s: Place) -> Array:  # noqa: ARG002, used where a subclass knows it
        """Distance c(s) [m] of the outermost fibre from the centroid, in the plane of motion; stress = M c / I."""
        raise InputError(f"{type(self).__name__}: the distance of the outer fibre is unknown; no stress can be given.")

    def over_radius_at(self, s: Place, radius: float) -> Array:  # noqa: ARG002, used where a subclass knows it
        """Integral of dA/r [m] over the section at s of an arc, `radius` of its centroid [m]; NaN: no outline."""
        return np.full(np.shape(s), math.nan)

    def shear_factor_at(self, s: Place, poisson: float) -> Array:  # noqa: ARG002, used where a subclass knows it
        """Shear factor ks(s) [1], shaped like s: shear force = ks G A (shear angle); `poisson` is Poisson's ratio.

        Source of the factors of this module: G. R. Cowper, The shear coefficient in Timoshenko's beam theory, Journal
        of Applied Mechanics 33 (1966) 335-340.
        """
        raise InputError(f"{type(self).__name__}: the shear factor is unknown; give it as a number, shear=5/6.")


class Dimensioned(Section):
    """Base of sections that have dimensions everywhere."""

    @abstractmethod
    def _dimensions_at(self, s: Place) -> tuple[type[Prismatic], list[Array]]:
        """Class whose formulas hold, and the dimensions at s."""

    def _numbers_at(self, s: Place) -> tuple[Array, Array, Array]:
        kind, dimensions = self._dimensions_at(s)
        return kind.numbers_of(*dimensions)

    def area_at(self, s: Place) -> Array:
        return self._numbers_at(s)[0]

    def second_moment_at(self, s: Place) -> Array:
        return self._numbers_at(s)[1]

    def outer_fibre_at(self, s: Place) -> Array:
        _, _, c = self._numbers_at(s)
        if np.isnan(c).any():
            raise InputError("GeneralSection: outer_fibre is None; give its distance in m to get stresses.")
        return c

    def over_radius_at(self, s: Place, radius: float) -> Array:
        """Integral of dA/r [m] for the dimensions at s; NaN: no outline, or one that reaches to the centre."""
        kind, dimensions = self._dimensions_at(s)
        *_, c = kind.numbers_of(*dimensions)
        return np.where(radius > c, kind.over_radius_of(radius, *dimensions), math.nan)

    def shear_factor_at(self, s: Place, poisson: float) -> Array:
        kind, dimensions = self._dimensions_at(s)
        return kind.shear_factor_of(poisson, *dimensions)


class Prismatic(Dimensioned):
    """Base of sections that are constant along the beam and described by positive dimensions.

    The fields of a subclass are its dimensions; `numbers_of` and `shear_factor_of` take their values as arrays in the
    order of the fields.  So `Tapered` works with every such class.
    """

    @staticmethod
    @abstractmethod
    def numbers_of(*dimensions: Array) -> tuple[Array, Array, Array]:
        """Area [m^2], second moment of area [m^4] and distance of the outer fibre [m] of dimensions; NaN: unknown."""

    @staticmethod
    def over_radius_of(radius: float, *dimensions: Array) -> Array:
        """Integral of dA/r [m] for a radius of the centroid [m] and these dimensions; NaN: no outline."""
        return np.full_like(dimensions[0], math.nan)

    @classmethod
    def shear_factor_of(cls, poisson: float, *dimensions: Array) -> Array:
        """Shear factor [1] for these dimensions and Poisson's ratio; an error in a class without one."""
        raise InputError(f"{cls.__name__}: the shear factor is unknown; give it as a number, shear=5/6.")

    def dimensions(self) -> tuple[float, ...]:
        """Values of the fields, in order."""
        return tuple(getattr(self, field.name) for field in fields(self))  # type: ignore[arg-type]

    def _dimensions_at(self, s: Place) -> tuple[type[Prismatic], list[Array]]:
        return type(self), [np.full(np.shape(s), value) for value in self.dimensions()]


def checked_factor(owner: str, name: str, value: object, *_: str) -> float:
    """A shear factor given as a number: 0 < ks <= 1."""
    factor = checks.positive(owner, name, value)
    if factor > 1.0:
        text = f"{owner}: {name} is {factor:g}; a shear factor is at most 1."
        checks.refuse(f"{text} Where a book multiplies the shear angle by 6/5, give 5/6.")
    return factor


@record
class Rectangle(Prismatic):
    """Solid rectangle: A = b h, I = b h^3 / 12.

    Raises
    ------
    InputError : a dimension that is not a number > 0.

    Examples
    --------
    >>> Rectangle(width=0.01, height=0.02).area_at([0.0, 1.0])
    array([0.0002, 0.0002])
    """

    width: float = field("b, normal to the plane of motion", "m", positive)
    height: float = field("h, IN the plane of motion, the direction of bending", "m", positive)

    @staticmethod
    def numbers_of(*dimensions: Array) -> tuple[Array, Array, Array]:
        b, h = dimensions
        return b * h, b * h**3 / 12.0, 0.5 * h

    @staticmethod
    def over_radius_of(radius: float, *dimensions: Array) -> Array:
        """Integral of dA/r [m]: b ln((R + h/2)/(R - h/2))."""
        b, h = dimensions
        return np.asarray(2.0 * b * np.arctanh(np.minimum(0.5 * h / radius, 1.0)))

    @classmethod
    def shear_factor_of(cls, poisson: float, *dimensions: Array) -> Array:
        """Shear factor 10 (1 + nu)/(12 + 11 nu) [1] of Cowper, nu = poisson; 5/6 for nu = 0."""
        b, _ = dimensions
        return np.full_like(b, 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson))


@record
class Circle(Prismatic):
    """Solid circle: A = pi d^2 / 4, I = pi d^4 / 64.

    Raises
    ------
    InputError : a diameter that is not a number > 0.
    """

    diameter: float = field("d", "m", positive)

    @staticmethod
    def numbers_of(*dimensions: Array) -> tuple[Array, Array, Array]:
        (d,) = dimensions
        return 0.25 * math.pi * d**2, math.pi * d**4 / 64.0, 0.5 * d

    @staticmethod
    def over_radius_of(radius: float, *dimensions: Array) -> Array:
        """Integral of dA/r [m]: 2 pi (R - (R^2 - d^2/4)^(1/2))."""
        c2 = 0.25 * dimensions[0] ** 2
        return np.asarray(2.0 * math.pi * c2 / (radius + np.sqrt(np.maximum(radius**2 - c2, 0.0))))

    @classmethod
    def shear_factor_of(cls, poisson: float, *dimensions: Array) -> Array:
        """Shear factor 6 (1 + nu)/(7 + 6 nu) [1] of Cowper, nu = poisson."""
        (d,) = dimensions
        return np.full_like(d, 6.0 * (1.0 + poisson) / (7.0 + 6.0 * poisson))


@record
class Tube(Prismatic):
    """Round tube: A = pi (D^2 - d^2) / 4, I = pi (D^4 - d^4) / 64.

    Raises
    ------
    InputError : a diameter that is not a number > 0, inner not smaller than outer.
    """

    outer: float = field("outer diameter D, > inner", "m", positive)
    inner: float = field("inner diameter d", "m", positive, hint="For a solid bar use Circle(diameter=...).")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.inner >= self.outer:
            text = f"Tube: inner is {self.inner:g} m and outer is {self.outer:g} m; inner must be smaller than outer."
            raise InputError(f"{text} Both are diameters.")

    @staticmethod
    def numbers_of(*dimensions: Array) -> tuple[Array, Array, Array]:
        D, d = dimensions
        return 0.25 * math.pi * (D**2 - d**2), math.pi * (D**4 - d**4) / 64.0, 0.5 * D

    @staticmethod
    def over_radius_of(radius: float, *dimensions: Array) -> Array:
        """Integral of dA/r [m], the difference of two circles."""
        D, d = dimensions
        return Circle.over_radius_of(radius, D) - Circle.over_radius_of(radius, d)

    @classmethod
    def shear_factor_of(cls, poisson: float, *dimensions: Array) -> Array:
        """Shear factor [1] of Cowper.

        6 (1 + nu)(1 + m^2)^2/((7 + 6 nu)(1 + m^2)^2 + (20 + 12 nu) m^2) with m = d/D and nu = poisson.
        """
        D, d = dimensions
        m2 = (d / D) ** 2
        both = (1.0 + m2) ** 2
        return 6.0 * (1.0 + poisson) * both / ((7.0 + 6.0 * poisson) * both + (20.0 + 12.0 * poisson) * m2)


@record
class GeneralSection(Prismatic):
    """Any section, given by its area and second moment; symmetric about the plane of motion.

    Without `outer_fibre` there are no stresses, and without `shear_factor` no beams with shear.

    Raises
    ------
    InputError : a value that is not a number > 0; when the outer fibre or the shear factor is asked for and unknown.
    """

    _: KW_ONLY
    area: float = field("A", "m^2", positive)
    second_moment: float = field("I about the axis normal to the plane of motion", "m^4", positive)
    outer_fibre: float | None = field("distance of the outer fibre from the centroid", "m", positive, default=None)
    shear_factor: float | None = field("ks, at most 1", rule=Rule(checked_factor, "> 0"), default=None)

    def dimensions(self) -> tuple[float, ...]:
        """Area, second moment, outer fibre and shear factor; NaN for an unknown one."""
        unsure = (math.nan if value is None else value for value in (self.outer_fibre, self.shear_factor))
        return self.area, self.second_moment, *unsure

    @staticmethod
    def numbers_of(*dimensions: Array) -> tuple[Array, Array, Array]:
        area, second_moment, c, _ = dimensions
        return area, second_moment, c

    @classmethod
    def shear_factor_of(cls, poisson: float, *dimensions: Array) -> Array:
        """Shear factor as given [1], whatever poisson, or `InputError`."""
        *_, factor = dimensions
        if np.any(np.isnan(factor)):
            raise InputError("GeneralSection: shear_factor is None; give it to bend by shear, or a number: shear=5/6.")
        return factor


# Rule of the ends of a tapered section.
PRISMATIC = instance(Prismatic, "a section with constant dimensions, such as Rectangle(width=..., height=...)")


@record
class Tapered(Dimensioned):
    """Linear change of the dimensions between two sections of the same class.

    A tapered rectangle has A of degree two and I of degree four in s; a tapered `GeneralSection` has A and I linear.

    Raises
    ------
    InputError : sections of different classes, or without dimensions.

    Examples
    --------
    >>> taper = Tapered(Rectangle(width=0.01, height=0.03), Rectangle(width=0.01, height=0.01))
    >>> taper.area_at([0.0, 0.5, 1.0])
    array([0.0003, 0.0002, 0.0001])
    """

    start: Prismatic = field("section at s = 0: Rectangle, Circle, Tube or GeneralSection", rule=PRISMATIC)
    end: Prismatic = field("section at s = 1, of the same class", rule=PRISMATIC)

    def __post_init__(self) -> None:
        super().__post_init__()
        if type(self.start) is not type(self.end):
            classes = f"{type(self.start).__name__} and end a {type(self.end).__name__}"
            text = f"Tapered: start is a {classes}; both must be of one class"
            raise InputError(f"{text}. Use GeneralSection for both, or divide the beam.")

    def _dimensions_at(self, s: Place) -> tuple[type[Prismatic], list[Array]]:
        x = np.asarray(s, dtype=float)
        pairs = zip(self.start.dimensions(), self.end.dimensions(), strict=True)
        return type(self.start), [(1.0 - x) * a + x * b for a, b in pairs]


def shear_factors(section: Section, shear: bool | float, poisson: float, s: Array) -> Array:
    """Checked shear factors [1] at s: of the section for True, else the number `shear`."""
    if shear is not True:
        return np.full_like(s, shear)
    values = np.asarray(section.shear_factor_at(s, poisson), dtype=float)
    if values.shape != s.shape or not np.all(np.isfinite(values) & (values > 0.0)):
        owner = f"{type(section).__name__}.shear_factor_at"
        raise InputError(f"{owner}: the result is {values!r}; it must be finite, > 0, and shaped like s.")
    return values
