"""Path synthesis of a four-bar: eighteen points that a point of its coupler is to meet, and lengths that meet them.

Crank a, coupler b, rocker c, ground 0.4 m, coupler point (u, v) along and across the coupler from the crank pin. The
points are those of known lengths, by the closed form of the loop; the search has bounds of 5 and 10 % around them.
"""

import math

import numpy as np
import xarray as xr

import flexmb as fm

LENGTHS = {"a": 0.12, "b": 0.35, "c": 0.30, "u": 0.20, "v": 0.15}
GROUND, SPEED = 0.4, 2.0 * math.pi


def corners(a, b, c, angle):
    """Crank pin, rocker pin and direction of the coupler at an angle of the crank."""
    pin = a * np.exp(1j * angle)
    way = GROUND - pin
    along = (b**2 - c**2 + abs(way) ** 2) / (2.0 * abs(way))
    far = pin + (along + 1j * math.sqrt(b**2 - along**2)) * way / abs(way)
    return pin, far, (far - pin) / b


def four_bar(a: float, b: float, c: float, u: float, v: float) -> fm.Mechanism:
    pin, far, along = corners(a, b, c, 0.0)
    crank = fm.RigidLink("crank", (0.0, 0.0), (pin.real, pin.imag), mass=0.2, inertia=1e-3)
    middle = 0.5 * (pin + far)
    coupler = fm.RigidBody("coupler", (middle.real, middle.imag), mass=0.5, inertia=5e-3)
    rocker = fm.RigidLink("rocker", (GROUND, 0.0), (far.real, far.imag), mass=0.4, inertia=4e-3)
    point = pin + (u + 1j * v) * along
    joints = [
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
        fm.Revolute("A", crank, coupler, at=(pin.real, pin.imag)),
        fm.Revolute("B", coupler, rocker, at=(far.real, far.imag)),
        fm.Revolute("C", fm.GROUND, rocker, at=(GROUND, 0.0)),
    ]
    pen = fm.Marker("pen", coupler, at=(point.real, point.imag))
    motor = fm.Drive("motor", "O", fm.ConstantSpeed(SPEED))
    return fm.Mechanism("path synthesis", [crank, coupler, rocker, *joints, pen, motor])


times = np.arange(18) / 18.0
wanted = []
for angle in SPEED * times:
    pin, _, along = corners(*(LENGTHS[k] for k in "abc"), angle)
    wanted.append(pin + (LENGTHS["u"] + 1j * LENGTHS["v"]) * along)

data = xr.Dataset({"pen.x": ("time", np.real(wanted)), "pen.y": ("time", np.imag(wanted))}, {"time": times})
bounds = {name: (0.95 * length, 1.1 * length) for name, length in LENGTHS.items()}
found = fm.design.fit(four_bar, bounds, data, signals=["pen.x", "pen.y"], step=1.0 / 720.0)
for name, length in LENGTHS.items():
    print(f"{name} = {found.parameters[name]:.10f} m (exact {length:.2f})")
print(f"largest distance from a point {max(float(abs(found.residuals[s]).max()) for s in ('pen.x', 'pen.y')):.1e} m")
sol = fm.simulate(four_bar(**found.parameters), periods=1)
fm.render(sol, path="out/path_synthesis.png")
