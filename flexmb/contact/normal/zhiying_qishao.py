"""Normal law of Zhiying and Qishao."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexmb.contact.normal.hysteresis import HysteresisLaw


@dataclass(frozen=True)
class ZhiyingQishao(HysteresisLaw):
    """Elastic contact with hysteresis damping, chi = 3 (1 - e^2)/4 exp[2 (1 - e)].

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
    For middle and high restitution; within 5 % of what is asked for from e = 0.34 on.
    Source: Q. Zhiying, L. Qishao, Analysis of impact process based on restitution coefficient, Journal of Dynamics
    and Control 4 (2006) 294-298.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        """3 (1 - e^2)/4 exp[2 (1 - e)] for e = `restitution`."""
        e = restitution
        return 0.75 * (1.0 - e * e) * math.exp(2.0 * (1.0 - e))
