"""The approach speed of a contact, found where the gap closes inside a step."""

from flexmb.kernels import compiled

HISTORY = (0.0, 1.0, 0.0)
"""Start values: approach speed (0: open), gap and gap rate at the last accepted state."""


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
    """Value of the cubic Hermite interpolant at fraction s, and its derivative by s."""
    d0, d1 = h * rate0, h * rate1
    rise = gap1 - gap0
    c2, c3 = 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise
    return gap0 + s * (d0 + s * (c2 + s * c3)), d0 + s * (2.0 * c2 + 3.0 * s * c3)


@compiled
def approach_speed(h, gap, gap_rate, least, z, z_new):
    """Approach speed of the present contact and its derivatives by gap and gap rate; 0 while the gap is open.

    The speed is taken where the gap falls through zero between the last accepted state (z) and now, not at the end of
    the step, and is kept as long as the contact lasts.  `least` is its lower bound.
    """
    speed, gap0, rate0 = z[0], z[1], z[2]
    by_gap, by_rate = 0.0, 0.0
    if gap > 0.0:
        speed = 0.0
    elif speed == 0.0:
        speed = -gap_rate
        by_rate = -1.0
        if h > 0.0 and gap0 > 0.0:
            speed, by_gap, by_rate = _located(h, gap0, rate0, gap, gap_rate)
        if speed < least:
            speed, by_gap, by_rate = least, 0.0, 0.0
    z_new[0], z_new[1], z_new[2] = speed, gap, gap_rate
    return speed, by_gap, by_rate


@compiled
def _located(h, gap0, rate0, gap, gap_rate):
    """Speed at the crossing and its derivatives by gap and gap rate at the end of the step."""
    s = crossing(h, gap0, rate0, gap, gap_rate)
    _, slope = cubic(s, h, gap0, rate0, gap, gap_rate)
    if slope >= 0.0:
        return 0.0, 0.0, 0.0  # grazing: the least approach speed holds
    d0, d1 = h * rate0, h * gap_rate
    rise = gap - gap0
    curve = 2.0 * (3.0 * rise - 2.0 * d0 - d1) + 6.0 * s * (d0 + d1 - 2.0 * rise)
    value_gap, slope_gap = s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s)
    value_rate, slope_rate = h * s * s * (s - 1.0), h * s * (3.0 * s - 2.0)
    by_gap = -(slope_gap - curve * value_gap / slope) / h
    by_rate = -(slope_rate - curve * value_rate / slope) / h
    return -slope / h, by_gap, by_rate
