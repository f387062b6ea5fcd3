"""Andrews' squeezing mechanism: seven bodies in three loops, whirled by a motor of constant torque.

The angles after 0.03 s, when the motor has turned two and a half times, beside those of the Test Set for Initial Value
Problem Solvers (F. Mazzia, C. Magherini, University of Bari, release 2.4), which are good to 1e-9.
"""

import flexmb as fm

PUBLISHED = {
    "beta": 15.81077119629904, "Theta": -15.75637105984298, "gamma": 0.04082224013073101, "Phi": -0.5347301163226948,
    "delta": 0.5244099658805304, "Omega": 0.5347301163226948, "epsilon": 1.048080741042263,
}  # fmt: skip

squeezer = fm.mechanisms.andrews()
sol = fm.simulate(squeezer, t_end=0.03, step=1e-5, save=300, method=fm.RungeKutta4())
if not sol.ok:
    raise SystemExit(sol.status)
for (name, published), angle in zip(PUBLISHED.items(), fm.mechanisms.andrews_angles(sol)[:, -1], strict=True):
    print(f"{name:8s}{angle:14.9f} rad (published {published:.9f})")
fm.render(sol, path="out/andrews.png")
