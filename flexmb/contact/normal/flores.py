"""Normal law of Flores, Machado, Silva and Martins."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.contact.normal.hysteresis import HysteresisLaw


@dataclass(frozen=True)
class Flores(HysteresisLaw):
    """Elastic contact with hysteresis damping, chi = 8 (1 - e)/(5 e).

    N = K depth^n (1 + chi depth_rate/approach), cut at zero.
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
    For any restitution above 0; returns somewhat less than it is asked for; within 5 % from e = 0.54 on.
    Source: P. Flores, M. Machado, M. T. Silva, J. M. Martins, On the continuous contact force models for soft
    materials in multibody dynamics, Multibody System Dynamics 25 (2011) 357-375.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        """8 (1 - e)/(5 e) for e = `restitution`."""
        e = restitution
        return 8.0 * (1.0 - e) / (5.0 * e)
