"""Normal laws of a cylinder in a cylindrical hollow: base, kernel and published laws.

f = N/L is the force a length, sigma = (1 - nu1^2)/(pi E1) + (1 - nu2^2)/(pi E2).  The laws differ in A alone.
Equation (5.12) of docs/theory/contact.md.

A further law is a further class: its formula in the first line, its source in the notes, and A of
depth = sigma f ln(A/f).
"""

import copy
import math
from abc import abstractmethod
from collections.abc import Iterator
from typing import Self

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import Rule, field, not_negative, one_of, positive, variant
from flexmb.kernels import compiled, normal_law
from flexmb.model.law import Material
from flexmb.parts.contact import validity
from flexmb.parts.contact.hysteresis import RESTITUTION, DampedElasticLaw, damped_contact, exact_chi, two_materials
from flexmb.parts.contact.onset import LARGEST, LEAST_APPROACH, ONSET

# ln(A/f) at the end of use. The printed laws end at ln(A/f) = 1, where their stiffness is infinite; here it has reached
# 1/sigma a length, and from here on the force follows its tangent.
END = 2.0
END_DEPTH = END * math.exp(-END)  # depth/(sigma A) at the end of use


@compiled
def line_load(sigma, A, depth):
    """f of depth = sigma f ln(A/f), and its derivative; beyond the end of use along the tangent."""
    # With y = ln(A/f) it is y - ln(y) = -ln(depth/(sigma A)): convex, slope at least 1/2 where y >= 2, so Newton's
    # method cannot fail; it needs three to six steps.
    s = depth / (sigma * A)
    if s <= 0.0:
        return 0.0, 0.0
    if s >= END_DEPTH:
        return A * math.exp(-END) + (depth / sigma - A * END_DEPTH) / (END - 1.0), 1.0 / (sigma * (END - 1.0))
    c = -math.log(s)
    y = c + math.log(c)
    for _ in range(20):
        step = (y - math.log(y) - c) * y / (y - 1.0)
        y -= step
        if abs(step) <= 1e-15 * y:
            break
    return depth / (sigma * y), 1.0 / (sigma * (y - 1.0))


@normal_law
def cylinder_kernel(p, h, gap, gap_rate, z, z_new):
    """N = L f(depth) (1 + chi depth_rate / w), never pulling."""
    sigma, A, L, chi, least, largest, e = p
    f, stiffness = line_load(sigma, A, -gap)
    return damped_contact(L * f, -L * stiffness, chi, least, largest, e, h, gap, gap_rate, z, z_new)


@variant
class CylinderLaw(DampedElasticLaw):
    """Base of the laws depth = sigma f ln(A/f) of a cylinder in a hollow; a subclass gives A.

    R1 and R2 are the radii of bearing and journal, f = N/L, sigma = (1 - nu1^2)/(pi E1) + (1 - nu2^2)/(pi E2).  The
    elastic force follows its tangent beyond ln(A/f) = 2.  It is multiplied by (1 + chi depth_rate/w) with the chi whose
    free impacts return exactly e.

    Raises
    ------
    InputError : values out of range.

    Notes
    -----
    For long parallel cylinders with a contact much narrower than the radii.
    """

    length: float = field("length L of the contact, out of the plane", "m", positive)
    materials: tuple[Material, Material] = field("materials of bearing and journal", rule=Rule(two_materials))
    restitution: float = field("coefficient of restitution e asked for", rule=RESTITUTION, default=0.9)
    least_approach: float = field("least approach speed", "m/s", not_negative, default=LEAST_APPROACH)
    reference_speed: str = field('"onset" or "largest"', rule=one_of(ONSET, LARGEST), default=ONSET)
    radii: tuple[float, float] | None = field(default=None, init=False, repr=False, compare=False)

    kernel = cylinder_kernel

    @staticmethod
    def chi(restitution: float) -> float:
        return exact_chi(restitution)

    @abstractmethod
    def load_scale(self, sigma: float, bearing_radius: float, journal_radius: float) -> float:
        """A of depth = `sigma` f ln(A/f) [N/m], for the radii R1 = `bearing_radius` and R2 = `journal_radius` [m]."""

    @property
    def sigma(self) -> float:
        """(1 - nu1^2)/(pi E1) + (1 - nu2^2)/(pi E2) [1/Pa]."""
        return sum(m.compliance for m in self.materials) / math.pi

    def for_radii(self, bearing_radius: float, journal_radius: float) -> Self:
        name = type(self).__name__
        R1 = checks.positive(name, "bearing_radius", bearing_radius, "m")
        R2 = checks.positive(name, "journal_radius", journal_radius, "m")
        if R2 >= R1:
            raise InputError(f"{name}: journal_radius is {R2:g} m; it must be smaller than the bearing's {R1:g} m.")
        law = copy.copy(self)
        object.__setattr__(law, "radii", (R1, R2))
        return law

    def depth(self, force: float) -> float:
        """Depth [m] under a steady `force` [N], for the radii of `for_radii`; beyond the end of use on the tangent."""
        f = checks.not_negative(type(self).__name__, "force", force, "N") / self.length
        sigma, A = self._scales()
        if f == 0.0:
            return 0.0
        return sigma * f * math.log(A / f) if f <= A * math.exp(-END) else self._end(sigma, A, f)

    def parameters(self) -> tuple[float, ...]:
        """sigma, A, L, chi, least approach speed, whether the reference speed is the largest one, restitution."""
        largest, e = float(self.reference_speed == LARGEST), self.restitution
        return *self._scales(), self.length, self.chi(e), self.least_approach, largest, e

    def passed_limits(self, depth: float, force: float) -> Iterator[str]:
        """Remarks on the end of the logarithm, width and yield."""
        sigma, A = self._scales()
        if self.radii is None:
            return
        end = sigma * A * END_DEPTH
        if depth > end:
            text = f"the depth reached {depth:.3g} m; the formula of this law holds up to {end:.3g} m"
            yield f"{text}, and its force was continued as a straight line beyond"
        R, E, f = validity.relative_radius(*self.radii), validity.effective_modulus(self.materials), force / self.length
        yield from validity.too_wide(math.sqrt(4.0 * f * R / (math.pi * E)), self.radii[1])  # Johnson 1985, eq. (4.43)
        pressure = math.sqrt(f * E / (math.pi * R))  # eq. (4.45)
        yield from validity.yielded(pressure, validity.YIELD_OF_LINE, self.materials)

    def _scales(self) -> tuple[float, float]:
        """Both numbers of the logarithm: sigma and A."""
        if self.radii is None:
            raise self._no_radii()
        return self.sigma, self.load_scale(self.sigma, *self.radii)

    @staticmethod
    def _end(sigma: float, A: float, f: float) -> float:
        return sigma * (A * END_DEPTH + (f - A * math.exp(-END)) * (END - 1.0))


@variant
class Johnson(CylinderLaw):
    """Cylinder in a cylindrical hollow, depth = sigma f [ln(4 (R1 - R2)/(sigma f)) - 1].

    Notes
    -----
    For long parallel cylinders with a contact much narrower than the radii.
    Source: K. L. Johnson, Contact Mechanics, Cambridge University Press 1985, eq. (5.57) for both bodies, with one
    radius difference in place of the radii as in C. M. Pereira, A. L. Ramalho, J. A. Ambrosio, A critical overview of
    internal and external cylinder contact force models, Nonlinear Dynamics 63 (2011) 681-697 (there with pi E* for
    1/sigma; the overview was not read for it).
    """

    def load_scale(self, sigma: float, bearing_radius: float, journal_radius: float) -> float:
        return 4.0 * (bearing_radius - journal_radius) / (sigma * math.e)


@variant
class Radzimovsky(CylinderLaw):
    """Cylinder in a cylindrical hollow, depth = sigma f [ln(4 R1/b) + ln(4 R2/b) + 2/3].

    b = 1.60 sqrt(f D1 D2/((D1 - D2) E*)) is the width of the contact, with the diameters D and 1/E* = pi sigma.

    Notes
    -----
    For long parallel cylinders with a contact much narrower than the radii.  Some reviews print radii in place of the
    diameters, which makes the depth larger by sigma f ln 2.
    Source: E. I. Radzimovsky, Stress distribution and strength conditions of two rolling cylinders pressed together,
    University of Illinois Engineering Experiment Station Bulletin 408 (1953), in the form of W. C. Young, Roark's
    Formulas for Stress and Strain, table of contact stress, cylinder in a cylindrical socket; taken up by C. M.
    Pereira, A. L. Ramalho, J. A. Ambrosio, A critical overview of internal and external cylinder contact force
    models, Nonlinear Dynamics 63 (2011) 681-697.  Bulletin and overview were not read for it.
    """

    def load_scale(self, sigma: float, bearing_radius: float, journal_radius: float) -> float:
        b2_over_f = 1.60**2 * 2.0 * validity.relative_radius(bearing_radius, journal_radius) * math.pi * sigma
        return math.exp(2.0 / 3.0) * 16.0 * bearing_radius * journal_radius / b2_over_f


@variant
class Goldsmith(CylinderLaw):
    """Cylinder in a cylindrical hollow, depth = sigma f [ln(1 m^2/(R sigma f)) + 1],  R = R1 R2/(R1 - R2).

    Notes
    -----
    For long parallel cylinders with a contact much narrower than the radii.
    Reviews print ln(L^m/(N R sigma)) with m = 1, a formula whose units do not cancel; in SI units, as here, the
    logarithm is that of 1 m^2/(R sigma f).  `DubowskyFreudenstein`, the same law with m = 3, has consistent units.
    Both laws agree for L = 1 m; for shorter contacts `Goldsmith` is softer.
    Source: W. Goldsmith, Impact: The Theory and Physical Behaviour of Colliding Solids, Edward Arnold 1960, in the
    form of reviews such as P. Flores, J. Ambrosio, J. C. P. Claro, H. M. Lankarani, Kinematics and Dynamics of
    Multibody Systems with Imperfect Joints, Springer 2008, chapter 3.  The formula is that of the reviews; the
    book of Goldsmith was not read for it.
    """

    def load_scale(self, sigma: float, bearing_radius: float, journal_radius: float) -> float:
        return math.e * (bearing_radius - journal_radius) / (bearing_radius * journal_radius * sigma)


@variant
class DubowskyFreudenstein(CylinderLaw):
    """Cylinder in a cylindrical hollow, depth = sigma f [ln(L^2 (R1 - R2)/(R1 R2 sigma f)) + 1].

    Notes
    -----
    For long parallel cylinders with a contact much narrower than the radii.
    Reviews print ln(L^m (R1 - R2)/(N R1 R2 sigma)) with m = 3.
    Source: S. Dubowsky, F. Freudenstein, Dynamic analysis of mechanical systems with clearances, part 1: formation of
    dynamic model, Journal of Engineering for Industry 93 (1971) 305-309, in the form of reviews such as P. Flores, J.
    Ambrosio, J. C. P. Claro, H. M. Lankarani, Kinematics and Dynamics of Multibody Systems with Imperfect Joints,
    Springer 2008, chapter 3.  The formula is that of the reviews; the article was not read for it.
    """

    def load_scale(self, sigma: float, bearing_radius: float, journal_radius: float) -> float:
        return math.e * self.length**2 * (bearing_radius - journal_radius) / (bearing_radius * journal_radius * sigma)


@variant
class ESDU78035(CylinderLaw):
    """Cylinder in a cylindrical hollow, depth = sigma f [ln(4 (R1 - R2)/(sigma f)) + 1].

    Notes
    -----
    For long parallel cylinders with a contact much narrower than the radii.  The law of Johnson with +1 for -1.
    Source: Engineering Sciences Data Unit, Item 78035, Contact phenomena I: stresses, deflections and contact
    dimensions for normally-loaded unlubricated elastic components (1978), in the form of reviews for a pin in a
    hollow such as P. Flores, J. Ambrosio, J. C. P. Claro, H. M. Lankarani, Kinematics and Dynamics of Multibody
    Systems with Imperfect Joints, Springer 2008, chapter 3.  The formula is that of the reviews; the item
    was not read for it.  Another program multiplies sigma by pi, a law three times as soft as all others.
    """

    def load_scale(self, sigma: float, bearing_radius: float, journal_radius: float) -> float:
        return 4.0 * math.e * (bearing_radius - journal_radius) / sigma
