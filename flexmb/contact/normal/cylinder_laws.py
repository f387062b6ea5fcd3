"""Published normal laws of a cylinder in a hollow: a class for each, with its formula, range and source.

A further law is a further class: its formula in the first line, its source in the notes, and A of
depth = sigma f ln(A/f).
"""

from __future__ import annotations

import math

from flexmb.contact import validity
from flexmb.contact.normal.cylinder import CylinderLaw
from flexmb.docstrings import documented


@documented
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


@documented
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


@documented
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


@documented
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


@documented
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
