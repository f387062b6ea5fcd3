"""An own contact law: one kernel and one frozen class in the user's own file; nothing else has to be told about it.

The law is that of Hunt and Crossley (J. Appl. Mech. 42 (1975) 440-445), N = k depth^n (1 + a depth_rate).  A ring is
brought to a constant speed; the ball inside it, at rest at first, is hit and then thrown to and fro.  Seen from the
ring an impact with the speed v ends with the speed v' for which, whatever k and n,

    a v - ln(1 + a v) = -a v' - ln(1 - a v'),

the integral of m v dv / (1 + a v) = -k depth^n d(depth) from the first touch to the last.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

from scipy.optimize import brentq

import flexmb as fm


@fm.normal_law
def hunt_crossley_kernel(p, h, gap, gap_rate, z, z_new):
    """N = k depth^n (1 + a depth_rate), never pulling; the library finds its derivatives by differences."""
    k, n, a = p
    if gap >= 0.0:
        return 0.0
    return max(k * (-gap) ** n * (1.0 - a * gap_rate), 0.0)


@dataclass(frozen=True)
class HuntCrossley(fm.NormalLaw):
    """Power of the depth, damped in proportion to it."""

    k: float  # [N/m^n]
    n: float  # [1]
    a: float  # [s/m]
    kernel = hunt_crossley_kernel


law = HuntCrossley(k=1e8, n=1.5, a=1.0)
speed = 0.5
centre = (0.0, 0.0)
ring = fm.RigidBody("ring", at=centre, mass=1.0, inertia=1e-3)
ball = fm.RigidBody("ball", at=centre, mass=0.1, inertia=1e-5)
guide = fm.Prismatic("guide", fm.GROUND, ring, along=(1.0, 0.0))
push = fm.Drive("push", joint="guide", motion=fm.drives.Ramp(speed, time=1e-3))
play = fm.RevoluteClearance("play", ring, ball, at=centre, clearance=1e-3, bearing_radius=1e-2, normal=law)
mech = fm.Mechanism("ball in a ring", [ring, ball, guide, push, play], gravity=(0.0, 0.0))
sol = fm.simulate(mech, t_end=0.02, step=2e-6, save="steps")
if not sol.ok:
    raise SystemExit(sol.status)


def speed_after(before):
    def balance(after):
        av, aw = law.a * before, law.a * after
        return av - math.log(1 + av) + aw + math.log(1 - aw)

    return brentq(balance, 1e-6 * before, before)


flight = (sol.array("play.mode") == 0.0) & (sol.time > 1e-3)
speeds = list(dict.fromkeys(float(f"{v:.7f}") for v in abs(sol.array("play.vex")[flight])))
for before, after in pairwise(speeds):
    print(f"an impact with {before:.6f} m/s ends with {after:.6f} m/s, exact {speed_after(before):.6f} m/s")
