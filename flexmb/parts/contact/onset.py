"""Onset of a contact: zero of the gap within a step, and the approach speed there."""

from flexmb.kernels import compiled


@compiled
def crossing(h, gap0, rate0, gap1, rate1):
    """Fraction s of a step at which the cubic of gap0 > 0 >= gap1 and rates falls through zero, to round-off."""
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
    # Equation (6.1) of docs/theory/events.md.
    d0, d1 = h * rate0, h * rate1
    rise = gap1 - gap0
    c2, c3 = 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise
    return gap0 + s * (d0 + s * (c2 + s * c3)), d0 + s * (2.0 * c2 + 3.0 * s * c3)


# Places at the beginning of a law's history: reference speed (0: open), gap and gap rate at the last accepted state;
# with `reference_speed` also the approach speed.
SPEED, LAST_GAP, LAST_RATE, APPROACH = range(4)
HISTORY = (0.0, 1.0, 0.0)  # start values: reference speed (0: open), gap and gap rate at the last accepted state

# Least approach speed [m/s] by default; a slower contact refers to the largest speed since its onset.
# Contacts of machines begin with some 1e-3 m/s; with 1e-4 to 1e-6 m/s the means of the nine-bar mechanism agree
# (docs/numbers.md).
LEAST_APPROACH = 1e-6

# Reference speeds: the closing speed at the onset, as the laws are published; the largest speed since the onset.
ONSET, LARGEST = "onset", "largest"


@compiled
def approach_speed(h, gap, gap_rate, least, z, z_new):
    """Approach speed of the present contact and its derivatives by gap and gap rate; 0 while the gap is open."""
    # The closing speed at the instant between the last accepted state (z) and now at which the gap falls through zero.
    # It stays as long as the contact lasts; `least` is its lower bound. Equation (6.2) of docs/theory/events.md.
    speed, by_gap, by_rate = z[SPEED], 0.0, 0.0
    if gap > 0.0:
        speed = 0.0
    elif speed == 0.0:
        speed, by_gap, by_rate = _onset(h, gap, gap_rate, z)
        if speed < least:
            speed, by_gap, by_rate = least, 0.0, 0.0
    z_new[SPEED], z_new[LAST_GAP], z_new[LAST_RATE] = speed, gap, gap_rate
    return speed, by_gap, by_rate


@compiled
def reference_speed(h, gap, gap_rate, least, largest, e, z, z_new):
    """Reference speed w of the present contact and its derivatives by gap and gap rate; 0 while the gap is open."""
    # w is the approach speed, which the history holds. If `largest`, or if the contact began slower than `least` (at
    # rest, or grazing), w is that of Equation (5.9) of docs/theory/contact.md.
    speed, onset, by_gap, by_rate = z[SPEED], z[APPROACH], 0.0, 0.0
    if gap > 0.0:
        speed, onset = 0.0, 0.0
    else:
        if z[LAST_GAP] > 0.0:
            onset, by_gap, by_rate = _onset(h, gap, gap_rate, z)
            speed = max(onset, 0.0)
        if largest or onset < least or onset <= 0.0:
            if -gap_rate > speed:
                speed, by_gap, by_rate = -gap_rate, 0.0, -1.0
            elif gap_rate > e * speed:
                speed, by_gap, by_rate = gap_rate / e, 0.0, 1.0 / e
    z_new[SPEED], z_new[LAST_GAP], z_new[LAST_RATE] = speed, gap, gap_rate
    z_new[APPROACH] = onset
    return speed, by_gap, by_rate


@compiled
def _onset(h, gap, gap_rate, z):
    """Closing speed at the onset of the contact, and its derivatives by gap and gap rate."""
    if h > 0.0 and z[LAST_GAP] > 0.0:
        # Speed at the crossing and its derivatives by gap and gap rate at the end of the step
        gap0, rate0 = z[LAST_GAP], z[LAST_RATE]
        s = crossing(h, gap0, rate0, gap, gap_rate)
        _, slope = cubic(s, h, gap0, rate0, gap, gap_rate)
        if slope >= 0.0:
            return 0.0, 0.0, 0.0  # grazing
        d0, d1 = h * rate0, h * gap_rate
        rise = gap - gap0
        curve = 2.0 * (3.0 * rise - 2.0 * d0 - d1) + 6.0 * s * (d0 + d1 - 2.0 * rise)
        value_gap, slope_gap = s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s)
        value_rate, slope_rate = h * s * s * (s - 1.0), h * s * (3.0 * s - 2.0)
        by_gap = -(slope_gap - curve * value_gap / slope) / h
        return -slope / h, by_gap, -(slope_rate - curve * value_rate / slope) / h
    return -gap_rate, 0.0, -1.0
