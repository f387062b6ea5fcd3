"""Simeon's slider-crank, its rod as beams, as a plane mesh and reduced: the four bend and stress alike.

The rod is a steel bar of 8 by 8 mm, 0.3 m long, on a crank that turns with 150 rad/s.  Held pins, a rod at rest: the
first frequency of an Euler-Bernoulli beam on two supports is pi h / (2 l^2) sqrt(E / (12 rho)).
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import flexmb as fm

CRANK, ROD, SIDE = 0.15, 0.30, 0.008  # lengths, side of the rod's section [m]
YOUNG, DENSITY = 2e11, 7870.0
SPEED = 150.0  # rad/s
TURN = 2.0 * math.pi / SPEED
HALF = 0.5 * SIDE


def slider_crank(rod) -> fm.Mechanism:
    """The mechanism of B. Simeon (Mathematical Modelling of Systems 2 (1996) 1-18), all on a line; no gravity."""
    O, A, B = (0.0, 0.0), (CRANK, 0.0), (CRANK + ROD, 0.0)
    crank = fm.RigidLink("crank", O, A, mass=0.36, inertia=0.002727 - 0.36 * (CRANK / 2.0) ** 2)
    slider = fm.RigidBody("slider", B, mass=0.075552, inertia=0.075552e-4)
    joints = [
        fm.Revolute("O", fm.GROUND, crank, at=O),
        fm.Revolute("A", crank, rod, at=A),
        fm.Revolute("B", rod, slider, at=B),
        fm.Prismatic("guide", fm.GROUND, slider, at=B, along=(1.0, 0.0)),
    ]
    motor = fm.Drive("motor", "O", fm.ConstantSpeed(SPEED))
    return fm.Mechanism("Simeon's slider-crank", [crank, rod, slider, *joints, motor])


def rod_of_beams(elements=8, **options):
    section, steel = fm.Rectangle(width=SIDE, height=SIDE), fm.Material(YOUNG, DENSITY)
    ends = (CRANK, 0.0), (CRANK + ROD, 0.0)
    return fm.FlexibleLink("rod", *ends, section=section, material=steel, elements=elements, **options)


def rod_of_cells(cells):
    steel = fm.Material(YOUNG, DENSITY, poisson=0.3)
    place = {"at": (CRANK, -HALF), "pins": ("left", "right")}
    return fm.PlaneBody("rod", fm.meshes.rectangle(ROD, SIDE, *cells), thickness=SIDE, material=steel, **place)


def mechanism(kind, modes=0, elements=8, cells=(20, 2)):
    """The slider-crank with a rod of "beams" or of a "mesh", reduced to so many modes where these are given."""
    rod = rod_of_cells(cells) if kind == "mesh" else rod_of_beams(elements, stress=True)
    return slider_crank(fm.Reduced(rod, modes=modes) if modes else rod)


def deflection(sol):
    """Of the rod's middle from the chord between its ends [m], the mean of both fibres."""
    x = CRANK + 0.5 * ROD
    middle = sol.positions("rod", [(x, HALF), (x, -HALF)]).mean("place")
    ax, ay = (CRANK * turned(sol.array("crank.theta")) for turned in (np.cos, np.sin))
    bx, by = sol.array("slider.x") - ax, -ay
    return (bx * (middle["y"].values - ay) - by * (middle["x"].values - ax)) / np.hypot(bx, by)


KINDS = {
    "beams": ("beams", 0),
    "beams, 6 modes": ("beams", 6),
    "mesh": ("mesh", 0),
    "mesh, 6 modes": ("mesh", 6),
}


def main():
    exact = math.pi * SIDE / (2.0 * ROD**2) * math.sqrt(YOUNG / (12.0 * DENSITY))
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
