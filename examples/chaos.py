"""The driven damped pendulum of J. R. Taylor, Classical Mechanics (2005), chapter 12, built of parts.

    phi'' + 2 b phi' + w0^2 sin phi = G w0^2 cos(w t),    w = 2 pi /s, w0 = 1.5 w, b = w0 / 4.

Table 12.1: its swing of one period of the drive doubles at G = 1.0663, that of two at G = 1.0793.  At G = 1.503 it is
chaotic.  Damping alone makes volumes of states shrink, so the two exponents add up to -2 b = -4.712389 /s exactly.
"""

import math
from pathlib import Path

import numpy as np

import flexmb as fm

OMEGA = 2.0 * math.pi  # of the drive [rad/s]
OMEGA0 = 1.5 * OMEGA  # of small swings [rad/s]
B = OMEGA0 / 4.0  # [1/s]
MASS, GRAVITY = 1.0, 9.81
LENGTH = 1.5 * GRAVITY / OMEGA0**2  # of an even rod [m]
INERTIA = MASS * LENGTH**2 / 3.0  # about its pin [kg m2]
DOUBLINGS = (1.0663, 1.0793)


def pendulum(drive: float) -> fm.Mechanism:
    """An even rod that starts at phi = -pi/2; `drive` is G."""
    rod = fm.RigidLink("rod", (0.0, 0.0), (-LENGTH, 0.0), mass=MASS, inertia=INERTIA / 4.0)
    pin = fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0))
    damper = fm.TorsionSpring("damper", fm.GROUND, rod, stiffness=0.0, damping=2.0 * B * INERTIA, at=(0.0, 0.0))
    clock = fm.drives.Harmonic(1.0, frequency=OMEGA / (2.0 * math.pi), phase=math.pi / 2.0)  # a cosine
    push = fm.Torque("push", rod, torque=drive * UNIT, history=clock)
    return fm.Mechanism("driven pendulum", [rod, pin, damper, push], gravity=(0.0, -GRAVITY))


UNIT = OMEGA0**2 * INERTIA  # torque for G = 1 [N m]
STEP, PERIOD = 1.0 / 400, 1.0  # [s]

orbit = fm.chaos.periodic_orbit(fm.chaos.MechanismFlow(pendulum(1.06), step=STEP, period=PERIOD), settle=40)
begin = 1.06 * UNIT
for number, published in enumerate(DOUBLINGS):
    branch = fm.chaos.follow(orbit, "push.torque", (begin, (published + 0.001) * UNIT), step=0.1, largest=0.5)
    flip = next(event for event in branch.events if event.kind == "flip")
    found = flip.value / UNIT
    error = found - published
    print(f"period {2**number} doubles at G = {found:.4f}, published {published:.4f}, error {error:+.4f}")
    orbit = branch.switch(flip, step=0.005)  # the orbit of twice the period that begins there
    begin = None  # where it is
print(
    f"behind the second doubling the orbit takes {orbit.period:g} s and is {'stable' if orbit.stable else 'unstable'}"
)

for drive in (1.06, 1.07, 1.503):
    found = fm.lyapunov(
        fm.chaos.MechanismFlow(pendulum(drive), step=STEP, period=PERIOD), skip=50, periods=200, count=2
    )
    print(f"G = {drive}: largest exponent {found.value:.3f} +- {found.error:.2g} /s, {found.verdict}")
    print(f"  both add up to {found.sum:.4f} /s, exact {-2 * B:.4f} /s, error {abs(found.sum / (2 * B) + 1):.1e}")

drives = np.linspace(1.06, 1.087, 19)
options = {"skip": 100, "keep": 100, "direction": "up", "step": STEP, "period": PERIOD}
diagram = fm.bifurcation(pendulum, "drive", drives, **options)
Path("out").mkdir(exist_ok=True)
fm.plots.plot_bifurcation(diagram, "rod.theta").savefig("out/pendulum.png", dpi=150)
print("verdicts:", ", ".join(dict.fromkeys(str(verdict) for verdict in diagram["verdict"].values.ravel())))
print("written: out/pendulum.png")
