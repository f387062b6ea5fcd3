"""Plane bodies in the shapes of the nine-bar mechanism's links and panel."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import arguments, checks
from flexmb.errors import InputError
from flexmb.mechanisms.geometry import Point
from flexmb.mechanisms.nine_bar_data import NineBarData
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Joint

if TYPE_CHECKING:
    from flexmb.planes.mesh import PlaneMesh
    from flexmb.planes.plane_body import PlaneBody

HINGES = {
    "crank1": ("O1", "P1"),
    "link2": ("P1", "B2"),
    "link3": ("P4", "B3"),
    "crank4": ("O4", "P4"),
    "rocker6": ("O6", "A"),
    "panel7": ("A", "B2"),
    "link8": ("C", "S"),
}
"""Joints at the origin of each mesh, and on its x-axis."""

PANEL_HOLE = 0.0025
"""Radius of the holes of panel 7 [m]."""

WIDEST_HOLE = 0.8
"""Largest radius of a hole over that of its eye [1]."""


@arguments.checked
def nine_bar_plates(
    mechanism: Mechanism, data: NineBarData | None = None, size: float = 0.0125
) -> dict[str, PlaneBody]:
    """Links and panel of a nine-bar mechanism as plane bodies of the same names, in the same places.

    `mechanism.with_part(plates["panel7"])` exchanges one of them; joints stay.

    Parameters
    ----------
    mechanism : the mechanism, from `nine_bar`.
    data : data that it was made with; None: `NineBarData()`.
    size : length of a cell's edge [m].

    Raises
    ------
    InputError : another mechanism, masses that no such plate has.

    Notes
    -----
    Links have two eyes of the bars' depth and a shank of that width; the radius of their holes, "start" and "end",
    makes their mass that of the data.  Panel 7 is the triangle of its hinges with a rim of half the bars' depth and the
    holes "A", "B" and "C" of 2.5 mm; its thickness makes its mass that of the data.  The cranks and rocker 6 lack the
    inertia on the axis in the frame that beams have there; it does not matter where a drive turns them steadily.

    Examples
    --------
    >>> from flexmb.mechanisms import nine_bar
    >>> mech = nine_bar(clearance=0.5e-3, flexible=True)
    >>> plate = nine_bar_plates(mech)["panel7"]
    >>> [pin.name for pin in plate.pin_nodes], round(plate.total_mass(), 3)
    (['A', 'B', 'C'], 4.334)
    """
    from flexmb.planes.plane_body import PlaneBody  # here, since other mechanisms need no meshes

    data = NineBarData() if data is None else data
    if not isinstance(mechanism, Mechanism) or not isinstance(data, NineBarData):
        raise InputError("nine_bar_plates: give a mechanism of nine_bar(...), and the NineBarData it was made with.")
    checks.positive("nine_bar_plates", "size", size, "m")
    found = {}
    for name, mesh in plate_meshes(data, size).items():
        start, ahead = (_place(mechanism, joint) for joint in HINGES[name])
        place: dict[str, Any] = {"at": start, "angle": math.atan2(ahead[1] - start[1], ahead[0] - start[0])}
        found[name] = PlaneBody(
            name, mesh, thickness=plate_thickness(data, name), material=data.material, damping=data.damping, **place
        )
    return found


def _place(mechanism: Mechanism, name: str) -> Point:
    """Place of a joint in the reference configuration [m]."""
    joint = mechanism.find(name)
    if not isinstance(joint, Joint) or joint.at is None:
        raise InputError(f"nine_bar_plates: {name!r} of mechanism {mechanism.name!r} is no joint at a point.")
    return joint.at


def plate_meshes(data: NineBarData, size: float) -> dict[str, PlaneMesh]:
    """Meshes by body, each with its first hinge at (0, 0) and the next one on the x-axis.

    Parameters
    ----------
    data : data of the mechanism.
    size : length of a cell's edge [m].
    """
    from flexmb.planes.outlines import link_with_eyes

    found = {}
    for name in HINGES:
        if name == "panel7":
            found[name] = _panel_mesh(data, size)
        else:
            length, eye = getattr(data, f"length{name[-1]}"), 0.5 * data.depth
            found[name] = link_with_eyes(length, eye, _link_hole(data, name), data.depth, size)
    return found


def plate_thickness(data: NineBarData, name: str) -> float:
    """Thickness of a plate [m]: that of the bar, or for panel 7 the one with its mass.

    Parameters
    ----------
    data : data of the mechanism.
    name : name of the body.
    """
    if name != "panel7":
        return data.thickness3 if name == "link3" else data.thickness
    corners, rim = _panel_corners(data), 0.5 * data.depth
    triangle = 0.5 * abs(corners[1, 0] * corners[2, 1])
    area = triangle + (data.side_ab + data.side_ac + data.side_bc) * rim + math.pi * (rim**2 - 3.0 * PANEL_HOLE**2)
    return float(data.mass7 / (data.density * area))


def _link_hole(data: NineBarData, name: str) -> float:
    """Radius of the holes with which a link has its mass [m]."""
    k, eye = name[-1], 0.5 * data.depth
    mass, length = getattr(data, f"mass{k}"), getattr(data, f"length{k}")
    full = length * data.depth + math.pi * eye**2
    square = (full - mass / (data.density * plate_thickness(data, name))) / (2.0 * math.pi)
    if not 0.0 < square < (WIDEST_HOLE * eye) ** 2:
        raise InputError(
            f"nine_bar_plates: mass{k} is {mass:g} kg; no holes give a plate {length:g} m long with eyes of {eye:g} m "
            f"this mass: without holes it has {full * data.density * plate_thickness(data, name):.4g} kg. "
            "Change mass, density, depth or thickness."
        )
    return math.sqrt(square)


def _panel_corners(data: NineBarData) -> np.ndarray:
    """A, B, C (3, 2) [m], clockwise as in the mechanism."""
    x = (data.side_ab**2 + data.side_ac**2 - data.side_bc**2) / (2.0 * data.side_ab)
    return np.array([(0.0, 0.0), (data.side_ab, 0.0), (x, -math.sqrt(data.side_ac**2 - x**2))])


def _panel_mesh(data: NineBarData, size: float) -> PlaneMesh:
    """The triangle with a round rim and three holes."""
    from flexmb.planes.plates import plate_with_holes

    hinges, rim = _panel_corners(data), 0.5 * data.depth
    ahead = np.roll(hinges, -1, axis=0) - hinges
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    outwards = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    both = outwards + np.roll(outwards, 1, axis=0)
    corners = hinges + 2.0 * rim * both / (both**2).sum(axis=1)[:, None]
    holes = {name: ((float(x), float(y)), PANEL_HOLE) for name, (x, y) in zip("ABC", hinges, strict=True)}
    return plate_with_holes([(float(x), float(y)) for x, y in corners], holes, 2.0 * size, fillet=rim)
