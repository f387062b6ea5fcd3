"""Normal law of Hunt and Crossley."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.contact.normal.hysteresis import HysteresisLaw


@dataclass(frozen=True)
class HuntCrossley(HysteresisLaw):
    """Elastic contact with hysteresis damping, chi = 3 (1 - e)/2.

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
    For restitution near 1: within 5 % of what is asked for from e = 0.79 on, above it everywhere.
    Source: K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact, Journal
    of Applied Mechanics 42 (1975) 440-445, whose lambda = 3 alpha K/2 with e = 1 - alpha v is this chi.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        """3 (1 - e)/2 for e = `restitution`."""
        e = restitution
        return 1.5 * (1.0 - e)
