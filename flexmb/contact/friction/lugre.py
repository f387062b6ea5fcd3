"""LuGre friction: elastic bristles."""

import math
from dataclasses import dataclass

from flexmb import checks
from flexmb.contact.friction.creep import load_ratio as checked_ratio
from flexmb.contact.friction.creep import static_not_below_kinetic
from flexmb.errors import InputError
from flexmb.kernels import friction_law
from flexmb.model.law import FrictionLaw

PASSIVE = 4.0 * math.sqrt(2.0 * math.e)
"""Largest damping sigma_1 v_s/mu_k [1] of passive bristles: sigma_1(v) v is largest at v_s/sqrt(2), with the value
sigma_1 v_s/sqrt(2 e), and must not exceed 4 mu_k."""

(DEFLECTION,) = range(1)
"""Place in the history: bristle deflection [m]."""


@friction_law
def lugre_kernel(p, h, slip, N, z, z_new):
    """z' = slip - sigma0 |slip| z/(g N), T = -[sigma0 z + N (sigma1(slip) z' + sigma2 slip)]; implicit in z.

    From z_new = z + h (slip - sigma0 |slip| z_new/(g N)) follows z_new = (z + h slip) g N/(g N + h sigma0 |slip|).
    Quotients are formed so that each stays finite however small N is.

    Equations (5.15) and (5.16) of docs/theory/contact.md.
    """
    mu_s, mu_k, vs, sigma0, sigma1, sigma2 = p
    if N < 1e-200:
        z_new[DEFLECTION] = 0.0
        return 0.0, 0.0, 0.0
    bell = math.exp(-((slip / vs) ** 2))
    g = mu_k + (mu_s - mu_k) * bell
    g_v = -2.0 * (mu_s - mu_k) * bell * slip / (vs * vs)  # _v: by slip, _N: by N
    most = mu_s / sigma0  # times N: largest deflection; a falling load releases the bristles
    old, old_N = z[DEFLECTION], 0.0
    if abs(old) > most * N:
        old_N = math.copysign(most, old)
        old = old_N * N
    pull = math.copysign(sigma0, slip)
    whole = g * N + h * pull * slip
    kept, load = g * N / whole, N / whole
    c = (old + h * slip) / whole
    c_v = (h * g - (old + h * slip) * g_v - h * pull * (old / N)) * load * load  # N dc/dslip
    new = c * g * N
    new_v = h * kept + c * (g_v * N * (1.0 - kept) - kept * h * pull)
    new_N = old_N * kept + c * g * (1.0 - kept)
    rate = slip - pull * slip * c
    rate_v = N * (1.0 - pull * c) - pull * slip * c_v  # N d(rate)/dslip
    rate_N = -pull * slip * (old_N - c * g) * load  # N d(rate)/dN
    damping = sigma1 * bell
    damping_v = -2.0 * damping * slip / (vs * vs)
    inner = damping * rate + sigma2 * slip
    z_new[DEFLECTION] = new
    return (
        -(sigma0 * new + N * inner),
        -(sigma0 * new_v + N * (damping_v * rate + sigma2) + damping * rate_v),
        -(sigma0 * new_N + inner + damping * rate_N),
    )


@dataclass(frozen=True)
class LuGre(FrictionLaw):
    """Friction of surfaces with elastic bristles: stiction, break-away and sliding.

    z' = slip - sigma_0 |slip| z / (g N),  g = mu_k + (mu_s - mu_k) exp(-(slip/v_s)^2),
    T = -[sigma_0 z + N (sigma_1 exp(-(slip/v_s)^2) z' + sigma_2 slip)],
    z [m] is the deflection of the bristles and the history of the law.

    Equations (5.15) and (5.17) of docs/theory/contact.md.

    Parameters
    ----------
    static : mu_s >= mu_k.
    kinetic : mu_k > 0.
    stribeck_speed : v_s, slip speed of the fall from static to kinetic friction [m/s], > 0.
    stiffness : sigma_0 of all bristles together [N/m], > 0.
    damping : sigma_1 of the bristles for each newton of load [s/m]; 0 <= sigma_1 <= 9.33 mu_k / v_s.
    viscous : sigma_2 for each newton of load [s/m], >= 0.

    Raises
    ------
    InputError : a negative number, static < kinetic, kinetic, speed or stiffness not > 0, damping above its limit.

    Notes
    -----
    Stiction: below mu_s N the surfaces shift by load/stiffness and do not creep.  As in all first-order bristle laws a
    load that oscillates below mu_s N makes the contact drift.  A load that grows at a rate f causes an early
    break-away, at about mu_s N (1 - f / (sigma_0 v_s)).  The equation of z is solved implicitly within the step, in
    closed form, so the stiffness sets no limit to the step; bristles shorter than a step are found quasi-statically.  A
    mass m vibrates on its bristles with sqrt(stiffness/m), damped critically with N sigma_1 = 2 sqrt(stiffness m).
    Keep sigma_1 v_s well below mu_k: else T falls steeply while damping fades, and a step may have several solutions.
    The law never produces energy, for any step and any change of N: T slip <= -d(sigma_0 z^2 / 2)/dt.  Three properties
    ensure this.  The stiffness is absolute [N/m] as in the source below: a stiffness proportional to N would store
    energy that a growing load multiplies.  Bristles longer than mu_s N / sigma_0 are released as N falls.  The damping
    fades with the slip and has a limit.
    Source: C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, A new model for control of systems with friction,
    IEEE Transactions on Automatic Control 40 (1995) 419-425, equations for z, F and g; the fading of sigma_1 from
    K. J. Astrom, C. Canudas de Wit, Revisiting the LuGre friction model, IEEE Control Systems Magazine 28 (2008)
    101-114.
    """

    static: float
    kinetic: float
    stribeck_speed: float = 1e-2
    stiffness: float = 1e6
    damping: float = 0.0
    viscous: float = 0.0

    kernel = lugre_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        static_not_below_kinetic("LuGre", self.static, self.kinetic)
        hint = "For surfaces without friction use Frictionless()."
        checks.positive("LuGre", "kinetic", self.kinetic, hint=hint)
        checks.positive("LuGre", "stribeck_speed", self.stribeck_speed, "m/s")
        checks.positive("LuGre", "stiffness", self.stiffness, "N/m")
        checks.not_negative("LuGre", "damping", self.damping, "s/m")
        checks.not_negative("LuGre", "viscous", self.viscous, "s/m")
        most = PASSIVE * self.kinetic / self.stribeck_speed
        if self.damping > most:
            raise InputError(
                f"LuGre: damping is {self.damping:g} s/m; it must be <= 9.33 kinetic/stribeck_speed = {most:g} s/m, or "
                "the bristles could produce energy. Lower it or the stribeck_speed."
            )

    def history(self) -> tuple[float, ...]:
        """Deflection of the bristles [m]."""
        return (0.0,)

    def creep_speed(self, load_ratio: float) -> float:
        """Slip speed [m/s] that balances the tangential load `load_ratio` mu_s N: 0 up to 1, inf above."""
        return 0.0 if checked_ratio("LuGre", load_ratio) <= 1.0 else math.inf
