"""Validity of normal laws: extremes of a run, kept in the history of a law, and remarks on the limits of its theory."""

import math
from collections.abc import Iterator, Sequence

from flexmb.kernels import compiled
from flexmb.model.law import Material
from flexmb.parts.contact.onset import APPROACH, HISTORY

# Start values: history of the onset; approach speed of the present contact; largest approach speed, depth, force, cut
# tension and excess of the whole run.
HISTORY_WITH_EXTREMES = (*HISTORY, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
MOST_APPROACH, DEPTH, FORCE, TENSION, EXCESS = range(4, 9)  # places of the extremes in the history

# Approach speed over sqrt(E/rho) [1] above which an impact is not elastic.
# Source: A. E. H. Love, A Treatise on the Mathematical Theory of Elasticity, as taken up by H. M. Lankarani, P. E.
# Nikravesh, Continuous contact force models for impact analysis in multibody systems, Nonlinear Dynamics 5 (1994)
# 193-207.
LOVE = 1e-5

# Peak pressure over yield stress [1] at which a contact begins to yield by von Mises' criterion: of a point, of a line.
# Source: K. L. Johnson, Contact Mechanics, Cambridge University Press 1985, eq. (6.9) for nu = 0.3, and eq. (6.4).
YIELD_OF_POINT, YIELD_OF_LINE = 1.60, 1.79
# Half-width of a contact over the radius [1] above which a run has a remark.
# Hertz's theory asks for a ratio much smaller than 1 (Johnson 1985, section 4.2) without a number; 0.3 is our choice.
WIDE = 0.3
SMALL_TENSION, SMALL_EXCESS = 0.01, 0.01  # cut tension and excess over the largest force [1] up to which all is well


@compiled
def keep_extremes(depth, force, tension, excess, z, z_new):
    """Update the extremes of a run; the approach speed is read from z_new."""
    z_new[MOST_APPROACH] = max(z[MOST_APPROACH], z_new[APPROACH])
    z_new[DEPTH], z_new[FORCE] = max(z[DEPTH], depth), max(z[FORCE], force)
    z_new[TENSION], z_new[EXCESS] = max(z[TENSION], tension), max(z[EXCESS], excess)


def effective_modulus(materials: Sequence[Material]) -> float:
    """E* of two materials [Pa], 1/E* the sum of both compliances; source: Johnson 1985, eq. (4.20)."""
    return 1.0 / sum(m.compliance for m in materials)


def relative_radius(bearing_radius: float, journal_radius: float) -> float:
    """R of a journal in a hollow, 1/R = 1/R2 - 1/R1 [m]."""
    return bearing_radius * journal_radius / (bearing_radius - journal_radius)


def cut_or_pressed(tension: float, excess: float, force: float) -> Iterator[str]:
    """A remark on surfaces that further forces pressed together or released faster than a free impact does."""
    # Else one on the tension [N] that was cut; `excess` and the largest `force` [N].
    if excess > SMALL_EXCESS * force:
        yield (
            "the surfaces were pressed together, or let go, faster than they had met, and the law takes its damping "
            f"from the speed at which they met: up to {excess:.3g} N of damping are beyond what it is made for "
            f"(largest force {force:.3g} N). See what reference_speed='largest' changes (docs/contact.md, slow impacts)"
        )
    elif tension > SMALL_TENSION * force:
        yield f"a pull of its damping of up to {tension:.3g} N was cut (largest force {force:.3g} N)"


def too_fast(approach: float, materials: Sequence[Material]) -> Iterator[str]:
    """A remark on the largest approach speed [m/s]."""
    limit = LOVE * min((math.sqrt(m.young / m.density) for m in materials), default=math.inf)
    if approach > limit:
        yield (
            f"the surfaces met with up to {approach:.3g} m/s, above {limit:.3g} m/s = 1e-5 sqrt(E/rho) (Love's "
            "criterion): such an impact also dents the surfaces and sends waves through the bodies, which this law "
            "leaves out; the true impact loses more energy"
        )


def too_wide(half_width: float, radius: float) -> Iterator[str]:
    """A remark on the half-width of the contact [m] against the journal's radius [m]."""
    if half_width > WIDE * radius:
        text = f"the area of contact grew to a half-width of {half_width / radius:.2g} of the journal's radius;"
        yield (f"{text} the stiffness is that of a much smaller area (Johnson 1985, section 4.2)")


def yielded(pressure: float, factor: float, materials: Sequence[Material]) -> Iterator[str]:
    """A remark on the peak pressure [Pa]; yielding begins at `factor` times the yield stress."""
    known = [m.yield_stress for m in materials if m.yield_stress is not None]
    if known and pressure > factor * min(known):
        yield (
            f"the pressure between the surfaces reached {pressure:.3g} Pa; from {factor * min(known):.3g} Pa on "
            f"({factor:.2f} times the yield stress) they yield and keep dents (Johnson 1985, section 6.1), which this "
            "elastic law leaves out"
        )
