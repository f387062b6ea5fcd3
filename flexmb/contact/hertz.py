"""Stiffness of Hertzian contact between a journal and a bearing."""

import math

from flexmb import checks
from flexmb.errors import InputError
from flexmb.model.material import Material


def hertz_stiffness(first: Material, second: Material, bearing_radius: float, journal_radius: float) -> float:
    """K of N = K depth^1.5 for a ball of `journal_radius` in a hollow of `bearing_radius`, or on a plane [N/m^1.5].

    K = 4 / (3 (s1 + s2)) sqrt(R1 R2 / (R1 - R2)),  s = (1 - nu^2) / E

    Equation (5.6) of docs/theory/contact.md.

    R1 > R2 > 0 are the radii of bearing and journal [m], R1 = math.inf for a plane.  Not for a close fit: the radii
    must differ by more than the contact is wide.

    Source: Chen, Jiang, Deng, Wang, Nonlinear Dynamics (2018), equation (4) with the sign of the hollow radius mended.
    """
    compliance = first.compliance + second.compliance
    if bearing_radius == math.inf:
        return (
            4.0 / (3.0 * compliance) * math.sqrt(checks.positive("hertz_stiffness", "journal_radius", journal_radius))
        )
    R1 = checks.positive("hertz_stiffness", "bearing_radius", bearing_radius, "m")
    R2 = checks.positive("hertz_stiffness", "journal_radius", journal_radius, "m")
    if R2 >= R1:
        raise InputError(
            f"hertz_stiffness: journal_radius is {R2:g} m; it must be smaller than the bearing's {R1:g} m."
        )
    return 4.0 / (3.0 * compliance) * math.sqrt(R1 * R2 / (R1 - R2))
