"""Force of an oil film between a journal and its bearing: the short and the long film, closed forms.

Angles theta count from the widest gap in the direction of positive spin; H = 1 + eps cos(theta) is the thickness over
the clearance c.  With the eccentricity e = c eps n, the mean spin W of both bodies and u = e_dot - W k x e, the rates
are a = u.n/c (squeeze) and b = -u.t/c (wedge).  The pressure of both films is f(theta) (k b sin - a cos) with a
positive weight f, so the film is positive between alpha = atan2(a, k b) and alpha + pi, for any squeeze.

Equations (15.1) to (15.4) of docs/theory/films.md.
"""

import math

import numpy as np

from flexmb.kernels import compiled

# Kinds of films, as parameters of the kernels hold them.
SHORT, LONG, TABLE, PADS = 0.0, 1.0, 2.0, 3.0
TABLE_BEGIN = 13  # number of parameters before those of a table
# Extents of a film: where its pressure is positive; from the widest to the narrowest gap in the sense of the spin
# beside the line of centres, whatever the squeeze; all round.
POSITIVE, HALF, WHOLE = 0.0, 1.0, 2.0


@compiled
def ends_of_sector(eps, alpha):
    """Sommerfeld's angle g at both ends of the positive film: its sine and cosine, and the difference of the angles."""
    s, x, y = math.sqrt(1.0 - eps * eps), math.cos(alpha), math.sin(alpha)
    near, far = 1.0 + eps * x, 1.0 - eps * x
    sin1, cos1, sin2, cos2 = s * y / near, (x + eps) / near, -s * y / far, (eps - x) / far
    turn = math.atan2(sin2, cos2) - math.atan2(sin1, cos1)
    return sin1, cos1, sin2, cos2, turn if turn > 0.0 else turn + 2.0 * math.pi


@compiled
def moments(eps, alpha, whole):
    """Integrals over g of 1, cos, sin, cos^2, sin cos, sin^2, then their derivatives by eps; `whole`: all round."""
    # The ends are fixed in theta: dg/deps = -sin g/(1 - eps^2).
    if whole:
        return 2.0 * math.pi, 0.0, 0.0, math.pi, 0.0, math.pi, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    sin1, cos1, sin2, cos2, turn = ends_of_sector(eps, alpha)
    both = 0.5 * (sin2 * cos2 - sin1 * cos1)
    r = -1.0 / (1.0 - eps * eps)
    return (
        turn, sin2 - sin1, cos1 - cos2, 0.5 * turn + both, 0.5 * (sin2 * sin2 - sin1 * sin1), 0.5 * turn - both,
        r * (sin2 - sin1), r * (sin2 * cos2 - sin1 * cos1), r * (sin2 * sin2 - sin1 * sin1),
        r * (sin2 * cos2 * cos2 - sin1 * cos1 * cos1), r * (sin2 * sin2 * cos2 - sin1 * sin1 * cos1),
        r * (sin2 * sin2 * sin2 - sin1 * sin1 * sin1),
    )  # fmt: skip


@compiled
def short_weights(eps, alpha, whole):
    """Integrals of cos^2, sin cos, sin^2 over H^3, and their derivatives by eps."""
    I, Ic, Is, Icc, Isc, Iss, J, Jc, Js, Jcc, Jsc, Jss = moments(eps, alpha, whole)
    s2 = 1.0 - eps * eps
    s, r = math.sqrt(s2), eps / s2
    f3 = 1.0 / (s2 * s)
    f4, f5 = f3 / s, f3 / s2
    cc, sc, ss = f5 * (Icc - 2.0 * eps * Ic + eps * eps * I), f4 * (Isc - eps * Is), f3 * Iss
    cc_e = 5.0 * r * cc + f5 * (Jcc - 2.0 * eps * Jc + eps * eps * J - 2.0 * Ic + 2.0 * eps * I)
    return cc, sc, ss, cc_e, 4.0 * r * sc + f4 * (Jsc - eps * Js - Is), 3.0 * r * ss + f3 * Jss


@compiled
def end_terms(eps, alpha, whole):
    """(2 + eps cos)/H^2 at both ends times sin cos, cos^2, sin cos, differences, and their derivatives by eps."""
    # These are what an integration by parts leaves. Sine and cosine change their signs from one end to the other, so
    # their products are the same.
    if whole:
        return 0.0, 0.0, 0.0, 0.0
    x, y = math.cos(alpha), math.sin(alpha)
    near, far = 1.0 + eps * x, 1.0 - eps * x
    f = (2.0 - eps * x) / (far * far) - (2.0 + eps * x) / (near * near)
    f_e = x * (3.0 - eps * x) / (far * far * far) + x * (3.0 + eps * x) / (near * near * near)
    return f * x * y, f * x * x, f_e * x * y, f_e * x * x


@compiled
def long_weights(eps, alpha, whole):
    """Integrals of cos^2, sin cos, sin^2 times 6 (2 + eps cos)/H^2, and their derivatives by eps."""
    I, Ic, Is, Icc, Isc, Iss, J, Jc, Js, Jcc, Jsc, Jss = moments(eps, alpha, whole)
    s2 = 1.0 - eps * eps
    s, r = math.sqrt(s2), eps / s2
    f3 = 1.0 / (s2 * s)
    f4, f5 = f3 / s, f3 / s2
    e_xy, e_xx, e_xy_e, e_xx_e = end_terms(eps, alpha, whole)
    m, k, k_e = 2.0 + eps * eps, 3.0 * eps, 3.0
    sine, across = f3 * Iss, f4 * (Isc - eps * Is)
    along = f5 * (Icc - 2.0 * eps * Ic + eps * eps * I)  # cos^2/H^3, then cos/H^3
    plain = f5 * ((1.0 + eps * eps) * Ic - eps * (Icc + I))
    sine_e, across_e = 3.0 * r * sine + f3 * Jss, 4.0 * r * across + f4 * (Jsc - eps * Js - Is)
    along_e = 5.0 * r * along + f5 * (Jcc - 2.0 * eps * Jc + eps * eps * J - 2.0 * Ic + 2.0 * eps * I)
    plain_e = 5.0 * r * plain + f5 * ((1.0 + eps * eps) * Jc - eps * (Jcc + J) + 2.0 * eps * Ic - Icc - I)
    cc, sc, ss = e_xy + 2.0 * sine, -e_xx - 2.0 * across, -e_xy + m * along + k * plain
    ss_e = -e_xy_e + 2.0 * eps * along + m * along_e + k_e * plain + k * plain_e
    return 6.0 * cc, 6.0 * sc, 6.0 * ss, 6.0 * (e_xy_e + 2.0 * sine_e), -6.0 * (e_xx_e + 2.0 * across_e), 6.0 * ss_e


@compiled
def film_force(kind, extent, eps, a, b):
    """Force over its scale, outwards and along +theta, and derivatives of both by eps, a and b: eight numbers."""
    # The pressure is zero at the ends of a positive film, so their motion adds nothing to first order.
    k, k_e = 1.0, 0.0
    if kind == LONG:
        k = 2.0 / (2.0 + eps * eps)
        k_e = -eps * k * k
    whole = extent == WHOLE
    alpha = math.atan2(a if extent == POSITIVE else 0.0, k * b)
    if kind == LONG:
        cc, sc, ss, cc_e, sc_e, ss_e = long_weights(eps, alpha, whole)
    else:
        cc, sc, ss, cc_e, sc_e, ss_e = short_weights(eps, alpha, whole)
    Fr, Ft = k * b * sc - a * cc, k * b * ss - a * sc
    Fr_e, Ft_e = k * b * sc_e + k_e * b * sc - a * cc_e, k * b * ss_e + k_e * b * ss - a * sc_e
    return Fr, Ft, Fr_e, Ft_e, -cc, k * sc, -sc, k * ss


# Number of places of the positive film that are compared, and of steps by which the best is refined.
SAMPLES, REFINED = 8, 6


@compiled
def pressure_at(kind, eps, g, x, y):
    """Pressure over its scale at Sommerfeld's angle g, and the sign of its slope; x, y: cosine and sine of alpha."""
    q = 1.0 - eps * math.cos(g)
    cos, sin = (math.cos(g) - eps) / q, math.sqrt(1.0 - eps * eps) * math.sin(g) / q
    H, wave, slope = 1.0 + eps * cos, sin * x - cos * y, cos * x + sin * y
    if kind == LONG:
        return (1.0 + H) / (H * H) * wave, slope * H * (1.0 + H) + eps * sin * (2.0 + H) * wave
    return wave / (H * H * H), slope * H + 3.0 * eps * sin * wave


@compiled
def film_pressure(kind, eps, a, b):
    """Largest pressure over its scale [1/s], by the rule of false position (Illinois) between three samples."""
    k = 2.0 / (2.0 + eps * eps) if kind == LONG else 1.0
    size = math.sqrt(a * a + k * k * b * b)
    if size == 0.0:
        return 0.0
    x, y = k * b / size, a / size
    sin1, cos1, _, _, turn = ends_of_sector(eps, math.atan2(y, x))
    begin, step, best, largest = math.atan2(sin1, cos1), turn / (SAMPLES + 1), 0, -1.0
    for i in range(1, SAMPLES + 1):
        now, _ = pressure_at(kind, eps, begin + i * step, x, y)
        if now > largest:
            best, largest = i, now
    left, right = begin + (best - 1) * step, begin + (best + 1) * step
    _, up = pressure_at(kind, eps, left, x, y)
    _, down = pressure_at(kind, eps, right, x, y)
    side = 0
    for _ in range(REFINED):
        if up <= 0.0 or down >= 0.0:
            break
        middle = (left * down - right * up) / (down - up)
        now, slope = pressure_at(kind, eps, middle, x, y)
        largest = max(largest, now)
        if slope > 0.0:
            left, up, down, side = middle, slope, 0.5 * down if side > 0 else down, 1
        else:
            right, down, up, side = middle, slope, 0.5 * up if side < 0 else up, -1
    return size * largest


def pressures(kind: float, extent: float, eps: float, a: float, b: float, theta: np.ndarray) -> np.ndarray:
    """Pressure over its scale [1/s] in the middle of the width at angles from the widest gap (n,)."""
    H, sin = 1.0 + eps * np.cos(theta), np.sin(theta)
    if kind == LONG:
        p = (1.0 + H) / H**2 * (2.0 * b / (2.0 + eps * eps) * sin - a * np.cos(theta))
    else:
        p = (b * sin - a * np.cos(theta)) / H**3
    if extent == WHOLE:
        return np.asarray(p)
    return np.where(b * sin >= 0.0, p, 0.0) if extent == HALF else np.maximum(p, 0.0)
