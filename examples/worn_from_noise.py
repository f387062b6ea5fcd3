"""Wear from a noisy acceleration: clearance, restitution and friction of a pin, from the acceleration of the slider.

The piston pin of a slider-crank at 955 rpm has worn. A sensor on the slider shows a third of a turn, half a dozen
contacts, with an error of 2 % of the peak; here a run with known numbers takes its place. Each number that is found
has a standard error, from that of the sensor.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import flexmb as fm
from flexmb.mechanisms import slider_crank

TRUE = {"clearance": 1.2e-4, "restitution": 0.75, "friction": 0.06}
BOUNDS = {"clearance": (5e-5, 3e-4), "restitution": (0.5, 0.95), "friction": (0.01, 0.2)}
END = 0.02


def worn(clearance: float, restitution: float, friction: float) -> fm.Mechanism:
    normal = fm.contact.ExactRestitution.from_materials(fm.STEEL, fm.STEEL, restitution=restitution)
    rough = fm.friction.SmoothCoulomb(friction, v0=0.01)
    return slider_crank(speed=100.0, clearance=clearance, friction=rough).with_({"B.normal": normal})


run = fm.simulate(worn(**TRUE), t_end=END, save=1000)
print(f"{len(run.episodes('B').start)} contacts in {END:g} s")
data = run.dataset[["slider.ax"]].copy()
exact = data["slider.ax"].values
noise = 0.02 * float(abs(exact).max())
data["slider.ax"] = ("time", exact + noise * np.random.default_rng(1).standard_normal(len(exact)))

found = fm.design.fit(worn, BOUNDS, data, signals=["slider.ax"], noise=noise)
print(f"{found.message} The residuals are {found.rms:.3f} of the noise of {noise:.0f} m/s^2.")
for name, true in TRUE.items():
    value, error = found.parameters[name], found.errors[name]
    print(f"{name:11s} {value:.5g} +- {error:.2g} (true {true:g})")

fitted = fm.simulate(worn(**found.parameters), t_end=END, save=20000)
figure = Figure(figsize=(7.0, 4.5), layout="constrained")
for axes, span in zip(figure.subplots(2), ((0.0, 1e3 * END), (1.2, 2.8)), strict=True):
    axes.plot(1e3 * run.time, 1e-3 * data["slider.ax"].values, ".", color="0.6", markersize=4, label="measured")
    axes.plot(1e3 * fitted.time, 1e-3 * fitted.array("slider.ax"), color="C0", linewidth=1, label="fitted")
    axes.set(xlim=span, xlabel="time [ms]", ylabel="slider.ax [km/s$^2$]")
axes.set(ylim=(-11.0, 2.0))
axes.legend()
Path("out").mkdir(exist_ok=True)
figure.savefig("out/worn_from_noise.png", dpi=150)
