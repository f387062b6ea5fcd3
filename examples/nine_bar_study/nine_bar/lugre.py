"""LuGre friction law of the paper, with a stiffness of the bristles proportional to the normal force."""

import math

from flexmb.fields import field, not_negative, positive, record
from flexmb.kernels import friction_law
from flexmb.parts.contact.friction import StaticKinetic

(DEFLECTION,) = range(1)
"""Index of the bristle deflection in the history."""


@friction_law
def load_scaled_lugre_kernel(p, h, slip, N, z, z_new):
    """z' = slip - sigma0 |slip| z/g, T = -(sigma0 z + sigma1 z' + sigma2 slip) N; implicit in z.

    From z_new = z + h (slip - sigma0 |slip| z_new/g) follows z_new = (z + h slip) g/(g + h sigma0 |slip|).
    """
    mu_s, mu_k, vs, sigma0, sigma1, sigma2 = p
    if N <= 0.0:
        z_new[DEFLECTION] = 0.0
        return 0.0, 0.0, 0.0
    fall = math.exp(-((slip / vs) ** 2))
    g = mu_k + (mu_s - mu_k) * fall
    dg = (mu_s - mu_k) * (fall * -(2.0 * (slip / vs) * (1.0 / vs)))
    wear, dwear = sigma0 * abs(slip), sigma0 * (1.0 if slip > 0.0 else -1.0 if slip < 0.0 else 0.0)
    pushed, room = z[DEFLECTION] + h * slip, g + h * wear
    new = pushed * g / room
    dnew = 1.0 / room * (g * h + pushed * dg) + -new / room * (dg + h * dwear)
    z_new[DEFLECTION] = new
    lost = wear * new / g
    dlost = 1.0 / g * (new * dwear + wear * dnew) + -lost / g * dg
    share = -(sigma0 * new + sigma1 * (slip - lost) + sigma2 * slip)
    return share * N, N * -(sigma0 * dnew + sigma1 * (1.0 - dlost) + sigma2), share


@record
class LoadScaledLuGre(StaticKinetic):
    """LuGre friction with a stiffness of the bristles proportional to the normal force.

    z' = slip - sigma_0 |slip| z / g,  g = mu_k + (mu_s - mu_k) exp(-(slip/v_s)^2),
    T = -(sigma_0 z + sigma_1 z' + sigma_2 slip) N,
    z [m] is the bristle deflection, the history of the law.  A separation of the surfaces sets z = 0.

    Raises
    ------
    InputError : a negative number, static < kinetic, kinetic, speed or stiffness not > 0.

    Notes
    -----
    The law reproduces the paper and may produce energy.  A growing normal force increases the strain energy of the
    bristles.  At high slip the damping force opposes the rate of the bristles instead of the slip.  The law
    `flexmb.friction.LuGre` is passive.  Bristles are advanced by Euler's rule; where the journal slides, as it nearly
    always does, they settle in some 5 us.
    Source: Chen, Jiang, Deng, Wang, Nonlinear Dynamics (2018), their references 32 and 33.
    """

    kinetic: float = field("coefficient of kinetic friction mu_k", rule=positive)
    stribeck_speed: float = field("v_s, slip of the transition from static to kinetic friction", "m/s", positive)
    stiffness: float = field("sigma_0 of the bristles per normal force", "1/m", positive)
    damping: float = field("sigma_1 of the bristles per normal force", "s/m", not_negative, default=0.0)
    viscous: float = field("sigma_2, viscous friction per normal force", "s/m", not_negative, default=0.0)

    kernel = load_scaled_lugre_kernel

    def history(self) -> tuple[float, ...]:
        """Initial bristle deflection [m]."""
        return (0.0,)

    def _creep_speed(self, r: float) -> float:
        return 0.0 if r <= 1.0 else math.inf
