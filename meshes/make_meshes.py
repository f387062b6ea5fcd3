"""Write the meshes of the nine-bar mechanism: python meshes/make_meshes.py [--elements N] [--size M] [--out DIR].

Format: gmsh 2.2, ASCII, lengths in metres; gmsh and ParaView open it.

NAME.msh        lines; the physical tag names the section: 1 = 25 mm x 12 mm, 2 = 25 mm x 6 mm.  A link lies along +x
                from (0, 0); the panel is the triangle A, B, C with A at (0, 0), B along +x, C below
                as in the mechanism.
NAME_plane.msh  cells of second order, which lie in the same way, and whose holes are physical curves: "start" and "end"
                of a link, "A", "B" and "C" of the panel.  Links have two eyes of the bars' depth and a shank of that
                width; the radius of their holes makes their mass that of the mechanism.  The panel is the triangle of
                its hinges with a rim of half the bars' depth; its thickness makes its mass that of the mechanism.

`flexmb run nine-bar --mesh meshes` takes the lines.  Cranks and rocker 6 as plates lack the inertia on the axis in the
frame that the beams have there; it does not matter where a drive turns them steadily.

It prints mass and moment of inertia about the centre of mass of each plane mesh beside those of the mechanism.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import pairwise
from math import atan2, pi, sqrt
from pathlib import Path

import meshio
import numpy as np

import flexmb as fm
from flexmb.elastic.meshes.mesh import PlaneMesh
from flexmb.mechanisms import NineBarData, nine_bar

DATA = NineBarData()

LINKS = {
    "crank1": (0.045, 1),
    "link2": (0.326, 1),
    "link3": (0.497, 2),
    "crank4": (0.095, 1),
    "rocker6": (0.230, 1),
    "link8": (0.336, 1),
}
"""Length [m] and tag of the section."""

PANEL_AB, PANEL_AC, PANEL_BC = 0.229, 0.304, 0.315
"""Sides of panel 7 [m]."""

SECTIONS = {1: "25x12 mm", 2: "25x6 mm"}

HINGES = {
    "crank1": ("O1", "P1"),
    "link2": ("P1", "B2"),
    "link3": ("P4", "B3"),
    "crank4": ("O4", "P4"),
    "rocker6": ("O6", "A"),
    "panel7": ("A", "B2"),
    "link8": ("C", "S"),
}
"""Joints at the origin of each mesh of cells, and on its x-axis."""

PANEL_HOLE = 0.0025
"""Radius of the holes of panel 7 [m]."""


def panel_corners() -> list[tuple[float, float]]:
    """A, B, C [m], clockwise as in the mechanism: C from the three sides."""
    x = (PANEL_AB**2 + PANEL_AC**2 - PANEL_BC**2) / (2.0 * PANEL_AB)
    return [(0.0, 0.0), (PANEL_AB, 0.0), (x, -sqrt(PANEL_AC**2 - x**2))]


def polyline(corners: Sequence[tuple[float, float]], elements: int, closed: bool) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and lines (m, 2), with `elements` lines from each corner to the next."""
    ends = [*corners, corners[0]] if closed else list(corners)
    fraction = np.arange(elements)[:, None] / elements
    pieces = [(1.0 - fraction) * a + fraction * b for a, b in pairwise(np.array(ends))]
    plane = np.concatenate(pieces if closed else [*pieces, [ends[-1]]])
    first = np.arange(len(pieces) * elements)
    return np.pad(plane, ((0, 0), (0, 1))), np.stack([first, (first + 1) % len(plane)], axis=1)


def write(path: Path, points: np.ndarray, lines: np.ndarray, tag: int) -> None:
    """One mesh file, all of its lines with one tag."""
    tags = np.full(len(lines), tag, dtype=np.int32)
    data = {"gmsh:physical": [tags], "gmsh:geometrical": [np.ones_like(tags)]}
    field_data = {SECTIONS[tag]: np.array([tag, 1])}
    mesh = meshio.Mesh(points, [("line", lines)], cell_data=data, field_data=field_data)
    mesh.write(path, file_format="gmsh22", binary=False)


def write_plane(path: Path, mesh: PlaneMesh) -> None:
    """One mesh file of a plane mesh, with its holes as physical curves."""
    blocks = [("line3", mesh.edges_in(name)) for name in mesh.holes]
    blocks.append(("triangle6" if mesh.kind == "tri6" else mesh.kind, mesh.cells))
    tags = [np.full(len(cells), k, dtype=np.int32) for k, (_, cells) in enumerate(blocks, start=1)]
    names = {name: np.array([k, 1]) for k, name in enumerate(mesh.holes, start=1)}
    names["body"] = np.array([len(blocks), 2])
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    found = meshio.Mesh(np.pad(mesh.points, ((0, 0), (0, 1))), blocks, cell_data=data, field_data=names)
    found.write(path, file_format="gmsh22", binary=False, float_fmt=".12g")


def nine_bar_plates(mechanism: fm.Mechanism, size: float) -> dict[str, fm.PlaneBody]:
    """Links and panel of the mechanism `nine_bar` as plates of the same names, in the same places."""
    plates = {}
    for name, joints in HINGES.items():
        start, ahead = (mechanism.find(joint).at for joint in joints)
        angle = atan2(ahead[1] - start[1], ahead[0] - start[0])
        mesh, thickness = plane_mesh(name, size), thickness_of(name)
        plates[name] = fm.PlaneBody(
            name, mesh, at=start, angle=angle, thickness=thickness, material=DATA.material, damping=DATA.damping
        )
    return plates


def plane_mesh(name: str, size: float) -> PlaneMesh:
    """Mesh of a plate with its first hinge at (0, 0) and the next one on the x-axis."""
    if name == "panel7":
        return panel_mesh(size)
    length, _ = LINKS[name]
    eye, mass = 0.5 * DATA.depth, getattr(DATA, f"mass{name[-1]}")
    full = length * DATA.depth + pi * eye**2  # without holes
    hole = sqrt((full - mass / (DATA.density * thickness_of(name))) / (2.0 * pi))
    return fm.meshes.link_with_eyes(length, eye, hole, DATA.depth, size)


def thickness_of(name: str) -> float:
    """Thickness of a plate [m]: that of the bar, or for panel 7 the one with its mass."""
    if name != "panel7":
        return DATA.thickness3 if name == "link3" else DATA.thickness
    corners, rim = np.array(panel_corners()), 0.5 * DATA.depth
    triangle = 0.5 * abs(corners[1, 0] * corners[2, 1])
    area = triangle + (PANEL_AB + PANEL_AC + PANEL_BC) * rim + pi * (rim**2 - 3.0 * PANEL_HOLE**2)
    return float(DATA.mass7 / (DATA.density * area))


def panel_mesh(size: float) -> PlaneMesh:
    """The triangle with a round rim and three holes."""
    hinges, rim = np.array(panel_corners()), 0.5 * DATA.depth
    ahead = np.roll(hinges, -1, axis=0) - hinges
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    outwards = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    both = outwards + np.roll(outwards, 1, axis=0)
    corners = hinges + 2.0 * rim * both / (both**2).sum(axis=1)[:, None]
    holes = {name: (tuple(hinge), PANEL_HOLE) for name, hinge in zip("ABC", hinges.tolist(), strict=True)}
    return fm.meshes.plate_with_holes(corners.tolist(), holes, 2.0 * size, fillet=rim)


def write_planes(folder: Path, size: float) -> list[Path]:
    """The plane meshes; prints what they come to beside the bodies of the mechanism."""
    mechanism, files = nine_bar(), []
    print("body      nodes  mass [kg] (mechanism)   inertia [kg m^2] (mechanism)")
    for name, plate in nine_bar_plates(mechanism, size).items():
        own, rigid = plate.properties(), mechanism.find(name)
        inertia = DATA.inertia7 if name == "panel7" else DATA.own_inertia(int(name[-1]))
        numbers = f"{own.mass:.4f} ({rigid.total_mass():.3f})         {own.inertia:.4e} ({inertia:.4e})"
        print(f"{name:8}  {len(plate.mesh.points):5d}  {numbers}")
        files.append(folder / f"{name}_plane.msh")
        write_plane(files[-1], plate.mesh)
    return files


def main(arguments: Sequence[str] | None = None) -> list[Path]:
    """Write all meshes; returns their files."""
    parser = argparse.ArgumentParser(description="Write the meshes of the nine-bar mechanism.")
    parser.add_argument("--elements", type=int, default=4, metavar="N", help="elements a straight beam (default 4)")
    parser.add_argument("--size", type=float, default=0.0125, metavar="M", help="cells of plates [m] (default 0.0125)")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, metavar="DIR", help="folder to write to")
    options = parser.parse_args(arguments)
    if options.elements < 1:
        parser.error(f"--elements is {options.elements}; it must be at least 1.")
    options.out.mkdir(parents=True, exist_ok=True)
    files = []
    for name, (length, tag) in LINKS.items():
        files.append(options.out / f"{name}.msh")
        write(files[-1], *polyline([(0.0, 0.0), (length, 0.0)], options.elements, closed=False), tag)
    files.append(options.out / "panel7.msh")
    write(files[-1], *polyline(panel_corners(), options.elements, closed=True), 1)
    return [*files, *write_planes(options.out, options.size)]


if __name__ == "__main__":
    for written in main():
        print(written)
