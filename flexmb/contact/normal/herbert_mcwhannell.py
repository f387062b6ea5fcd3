"""Normal law of Herbert and McWhannell."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.contact.normal.hysteresis import HysteresisLaw


@dataclass(frozen=True)
class HerbertMcWhannell(HysteresisLaw):
    """Elastic contact with hysteresis damping, chi = 6 (1 - e)/[(2 e - 1)^2 + 3].

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
    Within 5 % of what is asked for from e = 0.66 on, above it everywhere.
    Source: R. G. Herbert, D. C. McWhannell, Shape and frequency composition of pulses from an impact pair, Journal of
    Engineering for Industry 99 (1977) 513-518.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        """6 (1 - e)/[(2 e - 1)^2 + 3] for e = `restitution`."""
        e = restitution
        return 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0)
