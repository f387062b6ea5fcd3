"""Time of the gap kernels of curves: a cam of many points against a line, a roller and another cam.

python tests/speed/curve_time.py
"""

import math
import time

import numba
import numpy as np

import flexmb as fm
from flexmb.kernels import GAP_SIZE

CALLS, ROUNDS = 20_000, 5


def disc(x, points):
    """A disc of 30 mm, a little out of round."""
    return fm.ClosedCurve.from_function(
        lambda u: (x + 0.03 * math.cos(u) + 2e-5 * math.cos(2.0 * u), 0.03 * math.sin(u)), points
    )


def call_time(contact):
    """Least mean time of a call over some rounds, at places all around both bodies [us]."""
    kernel, p = contact.gap.dispatcher, np.array(contact.p)

    @numba.njit
    def calls(p, q, v, out, n):
        for i in range(n):
            q[2], q[5], q[4] = i * 0.37, -i * 0.51, 1e-4 * math.sin(i)
            kernel(p, q, v, out)

    q, v, out = np.array([0.0, 0.0, 0.0, 0.0601, 0.0, 0.0]), np.ones(6), np.zeros(GAP_SIZE)
    calls(p, q, v, out, 10)
    best = math.inf
    for _ in range(ROUNDS):
        start = time.perf_counter()
        calls(p, q, v, out, CALLS)
        best = min(best, (time.perf_counter() - start) / CALLS)
    return 1e6 * best


def main():
    """Print a table."""
    law = fm.contact.Hertz(stiffness=1e8)
    one, two = (fm.RigidBody(n, at=(x, 0.0), mass=1.0, inertia=1e-3) for n, x in (("one", 0.0), ("two", 0.0601)))
    for points in (180, 720):
        others = {
            "line": fm.Line((0.0301, -0.2), (0.0301, 0.2)),
            "roller": fm.cams.CircularCurve((0.0401, 0.0), 0.01),
            "cam": disc(0.0601, points),
        }
        for name, other in others.items():
            part = fm.CurveOnCurve("pair", one, disc(0.0, points), two, other, normal=law)
            contact = part.contributions(fm.Mechanism("pair", [one, two, part]))[0]
            print(f"{points:4d} points against a {name:6s}: {call_time(contact):6.2f} us")


if __name__ == "__main__":
    main()
