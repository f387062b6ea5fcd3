"""Normal law of Gonthier, McPhee, Lange and Piedboeuf."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.contact.normal.hysteresis import HysteresisLaw


@dataclass(frozen=True)
class Gonthier(HysteresisLaw):
    """Elastic contact with hysteresis damping, chi = (1 - e^2)/e.

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
    For any restitution above 0; exact to first order near 0, and never more than 0.032 off.
    Source: Y. Gonthier, J. McPhee, C. Lange, J.-C. Piedboeuf, A regularized contact model with asymmetric damping and
    dwell-time dependent friction, Multibody System Dynamics 11 (2004) 209-233.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        """(1 - e^2)/e for e = `restitution`."""
        e = restitution
        return (1.0 - e * e) / e
