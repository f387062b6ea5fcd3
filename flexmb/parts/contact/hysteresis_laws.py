"""Published normal laws N = K depth^n (1 + chi depth_rate/w): a class for each, with damping factor, range and source.

w is the reference speed of `hysteresis.py`, by default the speed at which the surfaces met.  A further law is a further
class: its formula in the first line, its range and source in the notes, and chi(e).
"""

from __future__ import annotations

import math

from flexmb.fields import variant
from flexmb.parts.contact.hysteresis import HysteresisLaw
from flexmb.parts.contact.restitution import exact_chi


@variant
class ExactRestitution(HysteresisLaw):
    """Hysteresis damping whose free impacts return exactly e: chi (1 + e) = ln[(1 + chi)/(1 - chi e)], chi > 0.

    Notes
    -----
    For every K, n, mass and speed of a free impact between two bodies.  Further forces during the impact change the
    coefficient of restitution.
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
        return exact_chi(restitution)


@variant
class HuntCrossley(HysteresisLaw):
    """Hysteresis damping, chi = 3 (1 - e)/2.

    Notes
    -----
    For e near 1: free impacts return e within 5 % from e = 0.79 on, and more than e everywhere.
    Source: K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact, Journal
    of Applied Mechanics 42 (1975) 440-445, whose lambda = 3 alpha K/2 with e = 1 - alpha v is this chi.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 1.5 * (1.0 - restitution)


@variant
class HerbertMcWhannell(HysteresisLaw):
    """Hysteresis damping, chi = 6 (1 - e)/[(2 e - 1)^2 + 3].

    Notes
    -----
    Free impacts return e within 5 % from e = 0.66 on, and more than e everywhere.
    Source: R. G. Herbert, D. C. McWhannell, Shape and frequency composition of pulses from an impact pair, Journal of
    Engineering for Industry 99 (1977) 513-518.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 6.0 * (1.0 - restitution) / ((2.0 * restitution - 1.0) ** 2 + 3.0)


@variant
class LeeWang(HysteresisLaw):
    """Hysteresis damping, chi = 3 (1 - e)/4.

    Notes
    -----
    Half the damping of Hunt and Crossley: free impacts return more than e also near e = 1; within 5 % from e = 0.92 on.
    Source: T. W. Lee, A. C. Wang, On the dynamics of intermittent-motion mechanisms, part 1, Journal of Mechanisms,
    Transmissions, and Automation in Design 105 (1983) 534-540.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 0.75 * (1.0 - restitution)


@variant
class LankaraniNikravesh(HysteresisLaw):
    """Hysteresis damping, chi = 3 (1 - e^2)/4.

    Notes
    -----
    For e near 1: free impacts return e within 5 % from e = 0.82 on, and far more than e at low e.
    Source: H. M. Lankarani, P. E. Nikravesh, A contact force model with hysteresis damping for impact analysis of
    multibody systems, Journal of Mechanical Design 112 (1990) 369-376.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 0.75 * (1.0 - restitution * restitution)


@variant
class Gonthier(HysteresisLaw):
    """Hysteresis damping, chi = (1 - e^2)/e.

    Notes
    -----
    For any e above 0: free impacts return e within 0.032, and exactly to first order near e = 0.
    Source: Y. Gonthier, J. McPhee, C. Lange, J.-C. Piedboeuf, A regularized contact model with asymmetric damping and
    dwell-time dependent friction, Multibody System Dynamics 11 (2004) 209-233.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return (1.0 - restitution * restitution) / restitution


@variant
class ZhiyingQishao(HysteresisLaw):
    """Hysteresis damping, chi = 3 (1 - e^2)/4 exp[2 (1 - e)].

    Notes
    -----
    For middle and high e: free impacts return e within 5 % from e = 0.34 on.
    Source: Q. Zhiying, L. Qishao, Analysis of impact process based on restitution coefficient, Journal of Dynamics
    and Control 4 (2006) 294-298.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 0.75 * (1.0 - restitution * restitution) * math.exp(2.0 * (1.0 - restitution))


@variant
class Flores(HysteresisLaw):
    """Hysteresis damping, chi = 8 (1 - e)/(5 e).

    Notes
    -----
    For any e above 0: free impacts return somewhat less than e, within 5 % from e = 0.54 on.
    Source: P. Flores, M. Machado, M. T. Silva, J. M. Martins, On the continuous contact force models for soft
    materials in multibody dynamics, Multibody System Dynamics 25 (2011) 357-375.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 8.0 * (1.0 - restitution) / (5.0 * restitution)


@variant
class HuGuo(HysteresisLaw):
    """Hysteresis damping, chi = 3 (1 - e)/(2 e).

    Notes
    -----
    For any e above 0: free impacts return e within 5 % from e = 0.41 on.
    Source: S. Hu, X. Guo, A dissipative contact force model for impact analysis in multibody dynamics, Multibody
    System Dynamics 35 (2015) 131-151.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 1.5 * (1.0 - restitution) / restitution


@variant
class CarvalhoMartins(HysteresisLaw):
    """Hysteresis damping, chi = (3/2) (1 - e) (11 - e)/(1 + 9 e).

    Notes
    -----
    A fit of the exact factor: free impacts return e within 5 % from e = 0.21 on.
    Source: A. S. Carvalho, J. M. Martins, Exact restitution and generalizations for the Hunt-Crossley contact model,
    Mechanism and Machine Theory 139 (2019) 174-194.
    """

    @staticmethod
    def chi(restitution: float) -> float:
        return 1.5 * (1.0 - restitution) * (11.0 - restitution) / (1.0 + 9.0 * restitution)
