"""Friction laws, one class each."""

import math
from abc import abstractmethod
from itertools import pairwise

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import field, not_negative, positive, record
from flexmb.kernels import compiled, friction_law
from flexmb.late import scipy
from flexmb.model.law import FrictionLaw

SCANNED = 4000  # number of speeds at which a law is evaluated before bisection finds its balance with the load


class Creeping(FrictionLaw):
    """Base of laws that know the slip speed under which a contact creeps."""

    def creep_speed(self, load_ratio: float) -> float:
        """Slip speed [m/s] that balances a tangential load of `load_ratio` mu N or mu_s N; inf where none does."""
        return self._creep_speed(checks.not_negative(type(self).__name__, "load_ratio", load_ratio))

    @abstractmethod
    def _creep_speed(self, r: float) -> float: ...


def first_balance(law: FrictionLaw, wanted: float, fastest: float) -> float:
    """The smallest slip speed [m/s], up to `fastest`, at which a law without history gives `wanted` N; else inf."""

    def balance(speed: float) -> float:
        force, _, _ = law.kernel.python(law.parameters(), 0.0, speed, 1.0, (), ())
        return float(-force - wanted)

    if wanted <= 0.0:
        return 0.0
    for low, high in pairwise(fastest * k / SCANNED for k in range(SCANNED + 1)):
        if balance(high) >= 0.0:
            return float(scipy.optimize.bisect(balance, low, high, xtol=math.ulp(0.0), maxiter=200))
    return math.inf


@friction_law
def frictionless_kernel(p, h, slip, N, z, z_new):
    """T = 0."""
    return 0.0, 0.0, 0.0


@record
class Frictionless(Creeping):
    """Surfaces without friction."""

    kernel = frictionless_kernel

    def _creep_speed(self, r: float) -> float:
        return math.inf if r > 0.0 else 0.0


@friction_law
def modified_coulomb_kernel(p, h, slip, N, z, z_new):
    """T = -mu cd N sign(slip); cd rises from 0 at |slip| = v0 to 1 at v1."""
    mu, v0, v1 = p
    speed = abs(slip)
    if speed <= v0:
        return 0.0, 0.0, 0.0
    sign = 1.0 if slip > 0.0 else -1.0
    if speed >= v1:
        return -mu * N * sign, 0.0, -mu * sign
    cd = (speed - v0) / (v1 - v0)
    return -mu * cd * N * sign, -mu * N / (v1 - v0), -mu * cd * sign


@record
class ModifiedCoulomb(Creeping):
    """Coulomb friction that rises from nothing at the slip speed v0 to mu N at v1.

    Equation (5.13) of docs/theory/contact.md.

    Raises
    ------
    InputError : a negative coefficient, v0 >= v1.

    Notes
    -----
    There is no force below v0, so nothing sticks: under a tangential load of r mu N, 0 < r <= 1, the contact creeps at
    v0 + r (v1 - v0).
    Source: J. Ambrosio, in W. Schiehlen (ed.), Virtual Nonlinear Multibody Systems, Kluwer 2003, 57-81;
    equations (7)-(8) of Chen et al., Nonlinear Dynamics (2018).
    """

    coefficient: float = field("mu", rule=not_negative)
    v0: float = field("slip speed up to which there is no friction", "m/s", not_negative, default=1e-4)
    v1: float = field("slip speed from which friction is mu N, > v0", "m/s", default=1e-3)

    kernel = modified_coulomb_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.v1 <= self.v0:
            raise InputError(f"ModifiedCoulomb: v1 is {self.v1:g} m/s; it must be > v0 = {self.v0:g} m/s.")

    def _creep_speed(self, r: float) -> float:
        if r == 0.0:
            return 0.0
        return self.v0 + r * (self.v1 - self.v0) if r <= 1.0 else math.inf


@friction_law
def smooth_coulomb_kernel(p, h, slip, N, z, z_new):
    """T = -mu N tanh(slip / v0)."""
    mu, v0 = p
    share = math.tanh(slip / v0)
    return -mu * N * share, -mu * N * ((1.0 - share * share) * (1.0 / v0)), share * -mu


@record
class SmoothCoulomb(Creeping):
    """Coulomb friction without a corner, T = -mu N tanh(slip/v0).

    Raises
    ------
    InputError : a negative coefficient, v0 <= 0.

    Notes
    -----
    Nothing sticks: under a tangential load of r mu N, r < 1, the contact creeps at v0 artanh(r).  For sliding, and
    where slow creep does not matter; not for stick-slip, since static and kinetic friction are the same.
    Source: the family of smooth Coulomb laws in F. Marques, P. Flores, J. C. Pimenta Claro,
    H. M. Lankarani, A survey and comparison of several friction force models for dynamic analysis of multibody
    mechanical systems, Nonlinear Dynamics 86 (2016) 1407-1443.
    """

    coefficient: float = field("mu", rule=not_negative)
    v0: float = field("slip speed at which 76 % of mu N are reached", "m/s", positive, default=1e-3)

    kernel = smooth_coulomb_kernel

    def _creep_speed(self, r: float) -> float:
        return self.v0 * math.atanh(r) if r < 1.0 else math.inf


@record
class StaticKinetic(Creeping):
    """Base of laws whose friction falls from static to kinetic."""

    static: float = field("mu_s, >= mu_k", rule=not_negative)
    kinetic: float = field("mu_k", rule=not_negative)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.static < self.kinetic:
            text = f"{type(self).__name__}: static is {self.static:g};"
            raise InputError(f"{text} it must be >= kinetic = {self.kinetic:g}. Did you exchange the two?")


@friction_law
def stribeck_kernel(p, h, slip, N, z, z_new):
    """T = -N [(mu_k + (mu_s - mu_k) exp(-|slip/vs|^n)) tanh(slip/v0) + c slip]."""
    mu_s, mu_k, vs, v0, n, c = p
    s = abs(slip) / vs
    power = s**n
    fall = (mu_s - mu_k) * math.exp(-power)
    c0 = math.tanh(slip / v0)
    mu = (mu_k + fall) * c0 + c * slip
    by_speed = -n * fall * (power / s if s > 0.0 else 0.0) / vs
    slope = by_speed * abs(c0) + (mu_k + fall) * (1.0 - c0 * c0) / v0 + c
    return -mu * N, -slope * N, -mu


@record
class Stribeck(StaticKinetic):
    """Friction that falls from static to kinetic with the slip speed, and may rise again.

    T = -N {[mu_k + (mu_s - mu_k) exp(-|slip/v_s|^n)] tanh(slip/v0) + c slip}.

    Equation (5.14) of docs/theory/contact.md.

    Raises
    ------
    InputError : a negative coefficient, static < kinetic, a speed <= 0, v0 >= stribeck_speed, exponent < 1.

    Notes
    -----
    Nothing sticks: the contact creeps under load at the speed that `creep_speed` finds, v0 artanh(r) when v0 << v_s.
    The largest force stays below mu_s N, by (v0/v_s)^n and more: choose v0 ten times below v_s.
    Source: L. C. Bo, D. Pavelescu, The friction-speed relation and its influence on the critical velocity of
    stick-slip motion, Wear 82 (1982) 277-289, for the curve; B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, A
    survey of models, analysis tools and compensation methods for the control of machines with friction, Automatica 30
    (1994) 1083-1138; tanh for the sign as in S. Andersson, A. Soderberg, S. Bjorklund, Tribology International 40
    (2007) 580-587.
    """

    stribeck_speed: float = field("v_s, slip speed of the fall", "m/s", positive, default=1e-2)
    v0: float = field("slip speed of the rise from rest, < stribeck_speed", "m/s", positive, default=1e-3)
    exponent: float = field("n >= 1; 2 gives a bell, 1 an exponential", default=2.0)
    viscous: float = field("c of a part that rises with the slip, in proportion to N", "s/m", not_negative, default=0.0)

    kernel = stribeck_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.between(
            "Stribeck", "v0", self.v0, 0.0, math.nextafter(self.stribeck_speed, 0.0), "m/s",
            "Friction must rise faster than it falls; choose v0 ten times below stribeck_speed.",
        )  # fmt: skip
        if self.exponent < 1.0:
            raise InputError(f"Stribeck: exponent is {self.exponent:g}; it must be >= 1, or the slope has no bound.")

    def _creep_speed(self, r: float) -> float:
        return first_balance(self, r * self.static, 3.0 * self.stribeck_speed)


@friction_law
def bengisu_akay_kernel(p, h, slip, N, z, z_new):
    """|T| = N mu(|slip|): a parabola up to (v0, mu_s), then an exponential down to mu_k."""
    mu_s, mu_k, v0, xi = p
    v = abs(slip)
    if v <= v0:
        left = 1.0 - v / v0
        mu = mu_s * (1.0 - left * left)
        slope = 2.0 * mu_s * left / v0
    else:
        fall = (mu_s - mu_k) * math.exp(-xi * (v - v0))
        mu = mu_k + fall
        slope = -xi * fall
    signed = math.copysign(mu, slip)
    return -signed * N, -slope * N, -signed


@record
class BengisuAkay(StaticKinetic):
    """Static friction reached on a parabola at v0, falling to kinetic friction exponentially.

    |T| / N = mu_s [1 - (|slip|/v0 - 1)^2] up to v0, mu_k + (mu_s - mu_k) exp(-xi (|slip| - v0)) beyond.

    Raises
    ------
    InputError : a negative coefficient, static < kinetic, v0 or decay <= 0.

    Notes
    -----
    Nothing sticks: under a tangential load of r mu_s N, r <= 1, the contact creeps at v0 [1 - sqrt(1 - r)].
    The falling branch is a negative damping that drives stick-slip; steps must stay below 2 m / [xi (mu_s - mu_k) N]
    where a mass m passes through it, or a step has more than one solution.
    Source: M. T. Bengisu, A. Akay, Stability of friction-induced vibrations in multi-degree-of-freedom systems, Journal
    of Sound and Vibration 171 (1994) 557-570; F. Marques et al., Nonlinear Dynamics 86 (2016) 1407-1443.
    """

    v0: float = field("slip speed at which mu_s is reached", "m/s", positive, default=1e-3)
    decay: float = field("xi, rate of the fall from mu_s to mu_k", "s/m", positive, default=1e3)

    kernel = bengisu_akay_kernel

    def _creep_speed(self, r: float) -> float:
        return self.v0 * (1.0 - math.sqrt(1.0 - r)) if r <= 1.0 else math.inf


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


@record
class BrownMcPhee(StaticKinetic):
    """Static, kinetic and viscous friction in one smooth curve of the slip speed.

    T = -N {mu_k tanh(4 s) + (mu_s - mu_k) s / [(s/2)^2 + 3/4]^2} - c slip tanh(4 N/N_t) with s = slip/v_t.

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

    transition_speed: float = field("v_t, slip speed of the largest friction", "m/s", positive, default=1e-3)
    viscous: float = field("c", "N s/m", not_negative, default=0.0)
    transition_load: float = field("N_t, from which the viscous part acts in full", "N", positive, default=1.0)

    kernel = brown_mcphee_kernel

    def _creep_speed(self, r: float) -> float:
        dry = BrownMcPhee(self.static, self.kinetic, self.transition_speed)
        return first_balance(dry, r * self.static, 3.0 * self.transition_speed)


@friction_law
def threlfall_kernel(p, h, slip, N, z, z_new):
    """T = -mu N (1 - exp(-3 |slip| / v0)) sign(slip)."""
    mu, v0 = p
    short = -math.expm1(-3.0 * abs(slip) / v0)
    c = math.copysign(short, slip)
    return -mu * N * c, -3.0 * mu * N * (1.0 - short) / v0, -mu * c


@record
class Threlfall(Creeping):
    """Coulomb friction that rises exponentially with the slip speed, T = -mu N (1 - exp(-3 |slip|/v0)) sign(slip).

    Raises
    ------
    InputError : a negative coefficient, v0 <= 0.

    Notes
    -----
    Nothing sticks: under a tangential load of r mu N, r < 1, the contact creeps at -(v0/3) ln(1 - r).  The slope is
    continuous through zero slip, its derivative is not.  The surveys hold the force at 0.95 mu N above v0; here the
    exponential goes on to mu N, without a corner.
    Source: D. C. Threlfall, The inclusion of Coulomb friction in mechanisms programs with particular reference to DRAM,
    Mechanism and Machine Theory 13 (1978) 475-483; F. Marques et al., Nonlinear Dynamics 86 (2016) 1407-1443.
    """

    coefficient: float = field("mu", rule=not_negative)
    v0: float = field("slip speed at which 95 % of mu N are reached", "m/s", positive, default=1e-3)

    kernel = threlfall_kernel

    def _creep_speed(self, r: float) -> float:
        return -self.v0 / 3.0 * math.log1p(-r) if r < 1.0 else math.inf


# Largest damping sigma_1 v_s/mu_k [1] of passive bristles: sigma_1(v) v is largest at v_s/sqrt(2), with the value
# sigma_1 v_s/sqrt(2 e), and must not exceed 4 mu_k.
PASSIVE = 4.0 * math.sqrt(2.0 * math.e)
SHORT_DECAY = 0.1  # rate of decay times step below which the fitted weight is a series
DEFLECTION, RATE = range(2)  # places in the history: bristle deflection [m]; its rate [m/s] at the last state


@compiled
def fitted_weight(x):
    """Weight 1/(1 - exp(-x)) - 1/x of the end of a step, and its derivative; x: rate of decay times step, >= 0."""
    if x < SHORT_DECAY:
        square = x * x
        return 0.5 + x * (1.0 - square * (1.0 - square / 42.0) / 60.0) / 12.0, (1.0 - square / 20.0) / 12.0
    gone = -math.expm1(-x)
    return 1.0 / gone - 1.0 / x, 1.0 / x / x - (1.0 - gone) / (gone * gone)


@friction_law
def lugre_kernel(p, h, slip, N, z, z_new):
    """z' = slip - sigma0 |slip| z/(g N), T = -[sigma0 z + N (sigma1(slip) z' + sigma2 slip)]; fitted rule for z."""
    # Equations (5.15) and (5.16) of docs/theory/contact.md; quotients are finite however small N is.
    mu_s, mu_k, vs, sigma0, sigma1, sigma2 = p
    if N < 1e-200:
        z_new[DEFLECTION] = z_new[RATE] = 0.0
        return 0.0, 0.0, 0.0
    bell = math.exp(-((slip / vs) ** 2))
    g = mu_k + (mu_s - mu_k) * bell
    g_v = -2.0 * (mu_s - mu_k) * bell * slip / (vs * vs)  # _v: by slip, _N: by N
    pull = math.copysign(sigma0, slip)
    x = h * pull * slip / (g * N)
    theta, steep = fitted_weight(x)
    H, H_v, H_N = h * theta, h * steep * h * pull * (1.0 - slip * g_v / g) / (g * N), -h * steep * x / N
    begun = z[RATE]
    old, old_N = z[DEFLECTION] + (h - H) * begun, 0.0
    most = mu_s / sigma0  # times N: largest deflection; a falling load releases the bristles
    if abs(old) > most * N:
        old_N = math.copysign(most, old)
        old, begun = old_N * N, 0.0
    whole = g * N + H * pull * slip
    kept, load = g * N / whole, N / whole
    c = (old + H * slip) / whole
    c_v = H + H_v * (slip - begun) - c * (g_v * N + (H + H_v * slip) * pull)  # whole dc/dslip
    c_N = old_N + H_N * (slip - begun) - c * (g + H_N * pull * slip)  # whole dc/dN
    rate = slip - pull * slip * c
    rate_v = N * (1.0 - pull * c) - pull * slip * c_v * load  # N d(rate)/dslip
    rate_N = -pull * slip * c_N * load  # N d(rate)/dN
    damping = sigma1 * bell
    damping_v = -2.0 * damping * slip / (vs * vs)
    inner = damping * rate + sigma2 * slip
    z_new[DEFLECTION], z_new[RATE] = c * g * N, rate
    return (
        -(sigma0 * c * g * N + N * inner),
        -(sigma0 * (kept * c_v + c * g_v * N) + N * (damping_v * rate + sigma2) + damping * rate_v),
        -(sigma0 * (kept * c_N + c * g) + inner + damping * rate_N),
    )


@record
class LuGre(StaticKinetic):
    """Friction of surfaces with elastic bristles: stiction, break-away and sliding.

    z' = slip - sigma_0 |slip| z / (g N),  g = mu_k + (mu_s - mu_k) exp(-(slip/v_s)^2),
    T = -[sigma_0 z + N (sigma_1 exp(-(slip/v_s)^2) z' + sigma_2 slip)],
    z [m] is the deflection of the bristles; z and z' are the history of the law.

    Equations (5.15) to (5.18) of docs/theory/contact.md.

    Raises
    ------
    InputError : a negative number, static < kinetic, kinetic, speed or stiffness not > 0, damping above its limit.

    Notes
    -----
    Stiction: below mu_s N the surfaces shift by load/stiffness and do not creep.  As in all first-order bristle laws a
    load that oscillates below mu_s N makes the contact drift.  A load that grows at a rate f causes an early
    break-away, at about mu_s N (1 - f / (sigma_0 v_s)).  The equation of z is integrated with second order, in closed
    form: as a spring by the trapezoidal rule while it sticks, quasi-statically where bristles are shorter than the slip
    in a step, so the stiffness sets no limit to the step.  A mass m vibrates on its bristles with sqrt(stiffness/m),
    which some 20 steps in a period resolve, damped critically with N sigma_1 = 2 sqrt(stiffness m).
    Keep sigma_1 v_s well below mu_k: else T falls steeply while damping fades, and a step may have several solutions.
    The law never produces energy, for any change of N: T slip <= -d(sigma_0 z^2 / 2)/dt at every instant, and over
    steps that do not grow, equation (5.18); steps that grow may produce some.  Three properties ensure this.  The
    stiffness is absolute [N/m] as in the source below: a stiffness proportional to N would store energy that a growing
    load multiplies.  Bristles longer than mu_s N / sigma_0 are released as N falls.  The damping fades with the slip
    and has a limit.
    Source: C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, A new model for control of systems with friction,
    IEEE Transactions on Automatic Control 40 (1995) 419-425, equations for z, F and g; the fading of sigma_1 from
    K. J. Astrom, C. Canudas de Wit, Revisiting the LuGre friction model, IEEE Control Systems Magazine 28 (2008)
    101-114.
    """

    kinetic: float = field("mu_k", rule=positive, hint="For surfaces without friction use Frictionless().")
    stribeck_speed: float = field("v_s, slip speed of the fall to kinetic friction", "m/s", positive, default=1e-2)
    stiffness: float = field("sigma_0 of all bristles together", "N/m", positive, default=1e6)
    damping: float = field("sigma_1 for each newton of load, <= 9.33 mu_k / v_s", "s/m", not_negative, default=0.0)
    viscous: float = field("sigma_2 for each newton of load", "s/m", not_negative, default=0.0)

    kernel = lugre_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        most = PASSIVE * self.kinetic / self.stribeck_speed
        if self.damping > most:
            text = f"LuGre: damping is {self.damping:g} s/m; it must be <= 9.33 kinetic/stribeck_speed = {most:g} s/m,"
            raise InputError(f"{text} or the bristles could produce energy. Lower it or the stribeck_speed.")

    def history(self) -> tuple[float, ...]:
        """Deflection of the bristles [m], and its rate [m/s]."""
        return 0.0, 0.0

    def _creep_speed(self, r: float) -> float:
        return 0.0 if r <= 1.0 else math.inf
