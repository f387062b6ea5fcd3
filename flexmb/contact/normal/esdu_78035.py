"""Normal law of ESDU 78035 for a cylinder in a hollow."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexmb.contact.normal.cylinder import CylinderLaw


@dataclass(frozen=True)
class ESDU78035(CylinderLaw):
    """Cylinder in a cylindrical hollow, depth = sigma f [ln(4 (R1 - R2)/(sigma f)) + 1].

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
    The law of Johnson with +1 for -1.
    Source: Engineering Sciences Data Unit, Item 78035, Contact phenomena I: stresses, deflections and contact
    dimensions for normally-loaded unlubricated elastic components (1978), in the form of reviews for a pin in a
    hollow such as P. Flores, J. Ambrosio, J. C. P. Claro, H. M. Lankarani, Kinematics and Dynamics of Multibody
    Systems with Imperfect Joints, Springer 2008, chapter 3.  The form is second-hand: neither of both was at hand,
    and an implementation elsewhere has a further factor pi, which would make it three times as soft as all other
    laws.
    """

    def load_scale(self, sigma: float, bearing_radius: float, journal_radius: float) -> float:
        """A of depth = sigma f ln(A/f) [N/m]."""
        return 4.0 * math.e * (bearing_radius - journal_radius) / sigma
