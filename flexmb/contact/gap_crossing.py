"""Zero of the gap within a step: the onset of a contact, and with signs turned its end."""

from flexmb.kernels import compiled


@compiled
def crossing(h, gap0, rate0, gap1, rate1):
    """Fraction s of the step at which the cubic through (gap0, rate0) and (gap1, rate1) falls through zero.

    gap0 > 0 >= gap1.  Bisection guards Newton, so the root is found to round-off.
    """
    low, high = 0.0, 1.0
    s = gap0 / (gap0 - gap1)
    for _ in range(40):
        value, slope = cubic(s, h, gap0, rate0, gap1, rate1)
        if value > 0.0:
            low = s
        else:
            high = s
        new = s - value / slope if slope < 0.0 else 0.5 * (low + high)
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - s) <= 1e-15:
            break
        s = new
    return s


@compiled
def cubic(s, h, gap0, rate0, gap1, rate1):
    """Value of the cubic Hermite interpolant at fraction s, and its derivative by s.

    Equation (6.1) of docs/theory/events.md.
    """
    d0, d1 = h * rate0, h * rate1
    rise = gap1 - gap0
    c2, c3 = 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise
    return gap0 + s * (d0 + s * (c2 + s * c3)), d0 + s * (2.0 * c2 + 3.0 * s * c3)
