"""The nine-bar mechanism of plates: how much do an impact's forces and stresses change against beams?

The links are bars with round ends and panel 7 is a plate, each a mesh of plane stress that is reduced to its pins and a
few vibrations.  Masses are those of the mechanism of beams, and so are the depth of the links and the moment of inertia
of the panel, so that little but the model of the bodies differs.
"""

import math

import numpy as np

import flexmb as fm

CELL = 0.004
YIELD = 355e6


def bar(body, data, material, modes):
    """A beam as a bar with round ends of the same depth, length and mass: pins take away what the ends add."""
    section = body.section
    length = math.dist(body.start, body.end)
    area = body.total_mass() / (section.width * data.density)
    hole = math.sqrt((length * section.height + math.pi * section.height**2 / 4.0 - area) / (2.0 * math.pi))
    mesh = fm.meshes.link_with_eyes(length, eye=section.height / 2.0, hole=hole, width=section.height, size=CELL)
    plate = fm.PlaneBody(
        body.name,
        mesh,
        start=body.start,
        end=body.end,
        thickness=section.width,
        material=material,
        damping=data.damping,
    )
    return fm.Reduced(plate, modes=modes)


def panel(frame, data, material, modes):
    """The frame A, B, C as a plate: the triangle grown about its incircle until mass and inertia are those of panel 7."""
    corners = np.array(frame.points)
    sides = np.array([math.dist(corners[(k + 1) % 3], corners[(k + 2) % 3]) for k in range(3)])
    growth = math.sqrt(36.0 * data.inertia7 / (data.mass7 * (sides**2).sum()))
    middle = sides @ corners / sides.sum()
    names = ("A", "B", "C")
    holes = {name: (tuple(point), 0.003) for name, point in zip(names, corners.tolist(), strict=True)}
    mesh = fm.meshes.plate_with_holes((middle + growth * (corners - middle)).tolist(), holes, size=2.0 * CELL)
    thin = fm.PlaneBody("panel7", mesh, at=(0.0, 0.0), thickness=1.0, material=material)
    thickness = data.mass7 / thin.total_mass()
    plate = fm.PlaneBody(
        "panel7", mesh, at=(0.0, 0.0), thickness=thickness, material=material, damping=data.damping
    )
    return fm.Reduced(plate, modes=modes)


def of_plates(mechanism, data, modes=3):
    """The mechanism with plates in place of beams."""
    material = fm.Material(data.young, data.density, data.contact_poisson, yield_stress=YIELD)
    for body in mechanism.bodies:
        if isinstance(body, fm.FlexibleLink):
            mechanism = mechanism.with_part(bar(body, data, material, modes))
    return mechanism.with_part(panel(mechanism.find("panel7"), data, material, modes))
