"""Simeon's slider-crank, its rod as beams, as a plane mesh and reduced: the four bend and stress alike.

The rod is a steel bar of 8 by 8 mm, 0.3 m long, on a crank that turns with 150 rad/s.  Held pins, a rod at rest: the
first frequency of an Euler-Bernoulli beam on two supports is pi h / (2 l^2) sqrt(E / (12 rho)).
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import flexmb as fm

DATA = fm.mechanisms.SimeonData()
TURN = 2.0 * math.pi / DATA.speed
HALF = 0.5 * DATA.side


def mechanism(kind, modes=0, elements=8, cells=(20, 2)):
    """The slider-crank with a rod of "beams" or of a "mesh", reduced to so many modes where these are given."""
    whole = fm.mechanisms.simeon(elements=elements, stretched=False, waving=False)
    rod = replace(whole.find("rod"), stress=True, velocity=None)
    if kind == "mesh":
        rectangle = fm.meshes.rectangle(DATA.rod, DATA.side, *cells)
        steel = fm.Material(DATA.young, DATA.density, poisson=0.3)
        ends = {"at": (DATA.crank, -HALF), "pins": ("left", "right")}
        rod = fm.PlaneBody("rod", rectangle, thickness=DATA.side, material=steel, **ends)
    return whole.with_part(fm.Reduced(rod, modes=modes) if modes else rod)


def deflection(sol):
    """Of the rod's middle from the chord between its ends [m], the mean of both fibres."""
    x = DATA.crank + 0.5 * DATA.rod
    middle = sol.positions("rod", [(x, HALF), (x, -HALF)]).mean("place")
    ax, ay = (DATA.crank * turned(sol.array("crank.theta")) for turned in (np.cos, np.sin))
    bx, by = sol.array("slider.x") - ax, -ay
    return (bx * (middle["y"].values - ay) - by * (middle["x"].values - ax)) / np.hypot(bx, by)


KINDS = {
    "beams": ("beams", 0),
    "beams, 6 modes": ("beams", 6),
    "mesh": ("mesh", 0),
    "mesh, 6 modes": ("mesh", 6),
}


def main():
    exact = math.pi * DATA.side / (2.0 * DATA.rod**2) * math.sqrt(DATA.young / (12.0 * DATA.density))
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axes = figure.subplots()
    for label, (kind, modes) in KINDS.items():
        mech = mechanism(kind, modes)
        (first, *_) = fm.modes(mech).frequencies
        sol = fm.simulate(mech, t_end=TURN, step=2e-5, save=400)
        if not sol.ok:
            raise SystemExit(sol.status)
        w, peak = deflection(sol), sol.peak("rod.von_mises")
        print(
            f"{label:>14}: first frequency {first:.2f} Hz (exact {exact:.2f}), deflection {1e3 * abs(w).max():.4f} mm, "
            f"largest stress {peak.value / 1e6:.1f} MPa at {1e3 * peak.time:.2f} ms"
        )
        axes.plot(1e3 * sol.time, 1e3 * w, label=label, linestyle="-" if modes == 0 else "--")
    axes.set(xlabel="time [ms]", ylabel="deflection of the middle [mm]")
    axes.legend()
    Path("out").mkdir(exist_ok=True)
    figure.savefig("out/rod_of_plates.png", dpi=150)


if __name__ == "__main__":
    main()
