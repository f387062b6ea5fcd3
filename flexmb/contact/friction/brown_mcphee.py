"""Friction law of Brown and McPhee."""

import math
from dataclasses import dataclass

from flexmb import checks
from flexmb.contact.friction.creep import first_balance, static_not_below_kinetic
from flexmb.contact.friction.creep import load_ratio as checked_ratio
from flexmb.kernels import friction_law
from flexmb.model.law import FrictionLaw


@friction_law
def brown_mcphee_kernel(p, h, slip, N, z, z_new):
    """T = -N [mu_k tanh(4 s) + (mu_s - mu_k) s / (s^2/4 + 3/4)^2] - c slip tanh(4 N/N_t), s = slip/v_t."""
    mu_s, mu_k, vt, c, Nt = p
    s = slip / vt
    rise = math.tanh(4.0 * s)
    bowl = 0.25 * s * s + 0.75
    mu = mu_k * rise + (mu_s - mu_k) * s / (bowl * bowl)
    slope = 4.0 * mu_k * (1.0 - rise * rise) + (mu_s - mu_k) * (bowl - s * s) / (bowl * bowl * bowl)
    wet = math.tanh(4.0 * N / Nt)
    return -mu * N - c * slip * wet, -slope * N / vt - c * wet, -mu - 4.0 * c * slip * (1.0 - wet * wet) / Nt


@dataclass(frozen=True)
class BrownMcPhee(FrictionLaw):
    """Static, kinetic and viscous friction in one smooth curve of the slip speed.

    T = -N {mu_k tanh(4 s) + (mu_s - mu_k) s / [(s/2)^2 + 3/4]^2} - c slip tanh(4 N/N_t) with s = slip/v_t.

    Parameters
    ----------
    static : mu_s >= mu_k.
    kinetic : mu_k >= 0.
    transition_speed : v_t, slip speed of the largest friction [m/s], > 0.
    viscous : c >= 0 [N s/m].
    transition_load : N_t, normal force above which the viscous part acts in full [N], > 0.

    Raises
    ------
    InputError : a negative coefficient, static < kinetic, a speed or load <= 0.

    Notes
    -----
    All derivatives are continuous.  Nothing sticks: the contact creeps under load at the speed that `creep_speed`
    finds, which is of the order of v_t/4 and nears v_t at full load.  At v_t friction is (mu_s - 7e-4 mu_k) N, nearly
    its peak.
    Source: P. Brown, J. McPhee, A continuous velocity-based friction model for dynamics and control with physically
    meaningful parameters, Journal of Computational and Nonlinear Dynamics 11 (2016) 054502.
    """

    static: float
    kinetic: float
    transition_speed: float = 1e-3
    viscous: float = 0.0
    transition_load: float = 1.0

    kernel = brown_mcphee_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        static_not_below_kinetic("BrownMcPhee", self.static, self.kinetic)
        checks.positive("BrownMcPhee", "transition_speed", self.transition_speed, "m/s")
        checks.not_negative("BrownMcPhee", "viscous", self.viscous, "N s/m")
        checks.positive("BrownMcPhee", "transition_load", self.transition_load, "N")

    def creep_speed(self, load_ratio: float) -> float:
        """Slip speed [m/s] that balances the dry load `load_ratio` mu_s N; inf where no speed of creep does."""
        r = checked_ratio("BrownMcPhee", load_ratio)
        dry = BrownMcPhee(self.static, self.kinetic, self.transition_speed)
        return first_balance(dry, r * self.static, 3.0 * self.transition_speed)
