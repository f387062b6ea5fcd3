"""Spin-up of a beam: it bends backwards while its hub speeds up, and is stretched when the hub turns steadily.

The beam of J. C. Simo, L. Vu-Quoc (J. Applied Mechanics 53 (1986) 855-863) is clamped to a hub that reaches 6 rad/s in
15 s.  That is more than its first bending frequency at rest: without the stiffening by centrifugal forces it would run
away.  Afterwards it is longer by rho A Om^2 L^3/(3 E A); the source gives 5.14e-4 m, and 0.0036 m for the vibration
that is left.  The largest deflection was computed once by an independent nonlinear beam code, to 0.2 %.
"""

import numpy as np

import flexmb as fm

data = fm.mechanisms.SpinningBeamData()
sol = fm.simulate(fm.mechanisms.spinning_beam(data, elements=8), t_end=20.0, step=2.5e-3, save="steps")
if not sol.ok:
    raise SystemExit(sol.status)
x, y, angle = sol.array("beam.end.x"), sol.array("beam.end.y"), sol.array("hub.angle")
along, across = np.cos(angle) * x + np.sin(angle) * y - data.length, np.cos(angle) * y - np.sin(angle) * x
late = sol.time > data.time
stretch = data.density * data.speed**2 * data.length**3 / (3.0 * data.young)
print(f"bends back by {-across.min():.4f} m (independent 0.5738)")
print(f"steady stretch {along[late].mean():.4e} m (exact {stretch:.4e})")
print(f"vibration afterwards {np.abs(across[late]).max():.4f} m (published 0.0036)")
fm.render(sol, times=np.linspace(0.0, 8.5, 6), path="out/spin_up.png")
