"""Normal law with hysteresis damping that returns exactly what it is asked for."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.contact.normal.hysteresis import HysteresisLaw
from flexmb.contact.restitution import exact_chi


@dataclass(frozen=True)
class ExactRestitution(HysteresisLaw):
    """Elastic contact with hysteresis damping whose free impacts return exactly the restitution asked for.

    N = K depth^n (1 + chi depth_rate/approach),  chi the root of chi (1 + e) = ln[(1 + chi)/(1 - chi e)] other than 0.
    `approach` is the closing speed where the contact began, located inside the step.

    Parameters
    ----------
    stiffness : K [N/m^n], > 0; None with `materials`: Hertz, from the radii of the joint.
    exponent : n, > 0.
    restitution : e asked for, in (0, 1].
    least_approach : approach speed [m/s] below which a contact has none to speak of; one that begins slower, at rest
        or grazing, takes the largest speed since its onset instead.
    materials : materials of bearing and journal, when `stiffness` is None.
    reference_speed : "onset": the approach speed, as published; "largest": the largest speed since the onset, for
        contacts that are pressed together or released faster than they met (docs/contact.md).

    Raises
    ------
    InputError : values out of range; neither stiffness nor materials.

    Notes
    -----
    Exact for every K, n, mass and speed of a free impact between two bodies; with further forces acting during the
    impact more or less is returned.
    Source: the integral of K. H. Hunt, F. R. E. Crossley, Journal of Applied Mechanics 42 (1975) 440-445, solved
    without their expansion; the same root is given by A. S. Carvalho, J. M. Martins, Mechanism and Machine Theory 139
    (2019) 174-194.

    Examples
    --------
    >>> law = ExactRestitution(stiffness=1e9, restitution=0.5)
    >>> f"{law.delivered_restitution():.12f}"
    '0.500000000000'
    """

    @staticmethod
    def chi(restitution: float) -> float:
        """The exact factor for e = `restitution`."""
        return exact_chi(restitution)
