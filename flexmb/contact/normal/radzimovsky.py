"""Normal law of Radzimovsky for a cylinder in a hollow."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexmb.contact import validity
from flexmb.contact.normal.cylinder import CylinderLaw


@dataclass(frozen=True)
class Radzimovsky(CylinderLaw):
    """Cylinder in a cylindrical hollow, depth = sigma f [ln(4 R1/b) + ln(4 R2/b) + 2/3].

    R1 and R2 are the radii of bearing and journal, f = N/L, sigma = (1 - nu1^2)/(pi E1) + (1 - nu2^2)/(pi E2).  The
    hysteresis factor (1 + chi depth_rate/approach) has the exact chi.

    Parameters
    ----------
    length : length L of the contact, out of the plane [m], > 0.
    materials : materials of bearing and journal.
    restitution : e, in (0, 1]; free impacts return exactly this.
    least_approach : approach speed [m/s] below which a contact has none to speak of; one that begins slower, at rest
        or grazing, takes the largest speed since its onset instead.
    reference_speed : "onset": the approach speed, as published; "largest": the largest speed since the onset, for
        contacts that are pressed together or released faster than they met (docs/contact.md).

    Raises
    ------
    InputError : values out of range.

    Notes
    -----
    For long parallel cylinders with a contact much narrower than the radii; the force follows the tangent beyond
    ln(A/f) = 2, where A is the scale in depth = sigma f ln(A/f).
    b = 1.60 sqrt(f D1 D2/((D1 - D2) E*)) with the diameters D is the width of the contact, 1/E* = pi sigma.  Some
    reviews print radii in place of the diameters, which makes the depth larger by sigma f ln 2.
    Source: E. I. Radzimovsky, Stress distribution and strength conditions of two rolling cylinders pressed together,
    University of Illinois Engineering Experiment Station Bulletin 408 (1953), in the form of W. C. Young, Roark's
    Formulas for Stress and Strain, table of contact stress, cylinder in a cylindrical socket; taken up by C. M.
    Pereira, A. L. Ramalho, J. A. Ambrosio, A critical overview of internal and external cylinder contact force
    models, Nonlinear Dynamics 63 (2011) 681-697.  Bulletin and overview were not at hand.
    """

    def load_scale(self, sigma: float, bearing_radius: float, journal_radius: float) -> float:
        """A of depth = sigma f ln(A/f) [N/m]."""
        b2_over_f = 1.60**2 * 2.0 * validity.relative_radius(bearing_radius, journal_radius) * math.pi * sigma
        return math.exp(2.0 / 3.0) * 16.0 * bearing_radius * journal_radius / b2_over_f
