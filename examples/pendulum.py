"""A rigid pendulum let go at 90 degrees: its period against the complete elliptic integral.

For a bar of length L, hinged at one end and swinging with the amplitude A, the period is

    T = 4 sqrt(2 L / (3 g)) K(sin^2(A / 2)),

K being the complete elliptic integral of the first kind as a function of the parameter m.  For A = pi/2, let go at
rest, the bar is at rest again on the other side after T / 2 and back after T.
"""

import math

from scipy.special import ellipk

import flexmb as fm

L, mass, g = 1.0, 2.0, 9.81
O, tip = (0.0, 0.0), (L, 0.0)

bar = fm.RigidLink("bar", O, tip, mass=mass, inertia=mass * L**2 / 12)
mech = fm.Mechanism("pendulum", [bar, fm.Revolute("O", fm.GROUND, bar, at=O)], gravity=(0.0, -g))

exact = 4 * math.sqrt(2 * L / (3 * g)) * ellipk(math.sin(math.pi / 4) ** 2)
sol = fm.simulate(mech, t_end=1.1 * exact, step=exact / 2000, save="steps", method=fm.Newmark.trapezoidal())
if not sol.ok:
    raise SystemExit(sol.status)

# the bar stands still where its angular speed changes its sign: interpolate between the two steps
omega, time = sol.array("bar.omega"), sol.time
k = next(k for k in range(len(time) // 2, len(time)) if omega[k - 1] > 0.0 >= omega[k])
measured = time[k - 1] + (time[k] - time[k - 1]) * omega[k - 1] / (omega[k - 1] - omega[k])

print(f"period           {measured:.7f} s, exact {exact:.7f} s, error {abs(measured / exact - 1):.1e}")
print(f"energy residual  {sol.peak('energy.residual').value:.1e} J of {mass * g * L / 2:.2f} J")
