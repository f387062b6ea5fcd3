"""The nine-bar mechanism of plates beside that of beams: forces and stresses of its impacts.

The links are bars with round ends and panel 7 is a plate, each a mesh of plane stress that is reduced to its pins and a
few vibrations.  Masses are those of the mechanism of beams, and so are the depth of the links, the moment of inertia of
the panel, and those of cranks and rocker about their axes; the cranks sit on shafts of 18 mm.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import flexmb as fm

YIELD = 355e6  # Pa
DEPTH_CELLS = 6
SHAFT = 0.009  # m, radius
ON_THE_FRAME = {"crank1": "O1", "crank4": "O4", "rocker6": "O6"}


def bar(body, material, modes):
    """A beam as a bar with round ends of the same depth, length and mass: its holes take away what the ends add."""
    depth, width, length = body.section.height, body.section.width, math.dist(body.start, body.end)
    area = body.total_mass() / (width * material.density)
    hole = math.sqrt((length * depth + math.pi * depth**2 / 4.0 - area) / (2.0 * math.pi))
    holes = (SHAFT if body.name.startswith("crank") else hole, hole)
    mesh = fm.meshes.link_with_eyes(length, eye=depth / 2.0, hole=holes, width=depth, size=depth / DEPTH_CELLS)
    points = {"start": body.start, "end": body.end}
    plate = fm.PlaneBody(body.name, mesh, **points, thickness=width, material=material, damping=body.damping)
    return fm.Reduced(plate, modes=modes)


def hub(body, plate, pivot):
    """Mass and inertia about the axis that the bar lacks, as a rigid body fixed to it."""
    whole, own = body.properties(), plate.body.properties()
    about_axis = [p.inertia + p.mass * math.dist(p.centre, pivot) ** 2 for p in (whole, own)]
    mass = max(whole.mass - own.mass, 1e-3)
    ring = fm.RigidBody(f"hub_{body.name}", at=pivot, mass=mass, inertia=about_axis[0] - about_axis[1])
    return ring, fm.Fixed(f"fit_{body.name}", plate, ring, at=pivot)


def panel(frame, material, modes):
    """A frame of three beams as a plate: the triangle, grown about its incircle, of the frame's mass and inertia."""
    corners, mass = np.array(frame.points), frame.total_mass()
    sides = np.array([math.dist(corners[k - 2], corners[k - 1]) for k in range(3)])
    growth = math.sqrt(36.0 * frame.properties().inertia / (mass * (sides**2).sum()))
    middle = sides @ corners / sides.sum()
    outline = middle + growth * (corners - middle)
    holes = {name: (tuple(corner), 0.003) for name, corner in zip("ABC", corners.tolist(), strict=True)}
    mesh = fm.meshes.plate_with_holes(outline.tolist(), holes, size=0.008)
    unit = fm.PlaneBody(frame.name, mesh, at=(0.0, 0.0), thickness=1.0, material=material, damping=frame.damping)
    return fm.Reduced(replace(unit, thickness=mass / unit.total_mass()), modes=modes)


def of_plates(mechanism, modes=3):
    """The mechanism with plates in place of beams."""
    for body in mechanism.bodies:
        if isinstance(body, fm.FlexibleLink):
            plate = bar(body, replace(body.material, yield_stress=YIELD), modes)
            mechanism = mechanism.with_part(plate)
            if body.name in ON_THE_FRAME:
                for part in hub(body, plate, mechanism.find(ON_THE_FRAME[body.name]).at):
                    mechanism = mechanism.with_part(part)
    frame = mechanism.find("panel7")
    return mechanism.with_part(panel(frame, replace(frame.material, yield_stress=YIELD), modes))


def of_beams(mechanism):
    """The mechanism of beams that look for their largest stress."""
    for body in mechanism.bodies:
        if isinstance(body, fm.FlexibleLink | fm.FlexibleFrame):
            mechanism = mechanism.with_part(replace(body, material=replace(body.material, yield_stress=YIELD)))
    return mechanism


def largest_stress(sol):
    """Name of the body with the largest von Mises stress, and its peak."""
    names = [name for name in sol.names if name.endswith(".von_mises")]
    name = max(names, key=lambda name: sol.peak(name).value)
    return name.partition(".")[0], sol.peak(name)


def stress_picture(sol, time):
    """Von Mises stress of all plates at an instant, on the moved meshes."""
    figure = Figure(figsize=(9.0, 4.6), layout="constrained")
    axes = figure.subplots()
    plates = [body for body in sol.mechanism.bodies if isinstance(body, fm.Reduced)]
    stress = {body.name: sol.stress(body.name, times=[time])["von_mises"].values[0] / 1e6 for body in plates}
    top = max(values.max() for values in stress.values())
    for body in plates:
        at = sol.positions(body.name, times=[time]).isel(time=0)
        x, y, cells = at["x"].values, at["y"].values, body.body.mesh.cells
        corners = 4 if body.body.mesh.kind == "quad9" else 3
        fan = [(0, k, (k + 1) % corners) for k in range(1, corners - 1)]
        triangles = np.concatenate([cells[:, one] for one in fan])
        drawn = axes.tripcolor(x, y, triangles, stress[body.name], shading="gouraud", vmin=0.0, vmax=top, cmap="turbo")
    figure.colorbar(drawn, ax=axes, label="von Mises stress [MPa]")
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"stress at t = {1e3 * time:.2f} ms")
    return figure


def main():
    speed = 2.0 * math.pi
    beams = of_beams(fm.mechanisms.nine_bar(speed, flexible=True))
    models = {"beams": beams, "plates": of_plates(beams)}
    for label, mech in models.items():
        first = ", ".join(f"{f:.1f}" for f in fm.modes(mech).frequencies[:3])
        mass = sum(body.total_mass() for body in mech.bodies)
        print(f"{label}: {mass:.3f} kg, first frequencies with held cranks {first} Hz")

    worn = fm.mechanisms.nine_bar(speed, clearance=5e-4).find("P1")
    for label, mech in models.items():
        sol = fm.simulate(mech.with_part(worn), t_end=0.02, save=2000)
        if not sol.ok:
            raise SystemExit(sol.status)
        force = sol.peak("P1.force")
        body, peak = largest_stress(sol)
        print(
            f"{label}: first impact with {force.value:.0f} N at {1e3 * force.time:.2f} ms; largest stress "
            f"{peak.value / 1e6:.1f} MPa in {body}, safety {YIELD / peak.value:.1f}"
        )
    Path("out").mkdir(exist_ok=True)
    stress_picture(sol, force.time).savefig("out/nine_bar_plates.png", dpi=150)


if __name__ == "__main__":
    main()
