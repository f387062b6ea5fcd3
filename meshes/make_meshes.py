"""Write the meshes of the nine-bar mechanism: python meshes/make_meshes.py [--elements N] [--size M] [--out DIR].

Format: gmsh 2.2, ASCII, lengths in metres; gmsh and ParaView open it.

NAME.msh        lines; the physical tag names the section: 1 = 25 mm x 12 mm, 2 = 25 mm x 6 mm.  A link lies along +x
                from (0, 0); the panel is the triangle A, B, C with A at (0, 0), B along +x, C below
                as in the mechanism.
NAME_plane.msh  cells of second order (`flexmb.mechanisms.nine_bar_plates`) whose holes are physical curves: "start" and
                "end" of a link, "A", "B" and "C" of the panel.

`flexmb run nine-bar --mesh meshes` takes the lines, `flexmb.mechanisms.nine_bar_plates` tells how the cells lie.

It prints mass and moment of inertia about the centre of mass of each plane mesh beside those of the mechanism.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import pairwise
from math import sqrt
from pathlib import Path

import meshio
import numpy as np

from flexmb.mechanisms import NineBarData, nine_bar, nine_bar_plates
from flexmb.planes.mesh import PlaneMesh

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


def write_planes(folder: Path, size: float) -> list[Path]:
    """The plane meshes; prints what they come to beside the bodies of the mechanism."""
    mechanism, files = nine_bar(), []
    print("body      nodes  mass [kg] (mechanism)   inertia [kg m^2] (mechanism)")
    for name, plate in nine_bar_plates(mechanism, size=size).items():
        own, rigid = plate.properties(), mechanism.find(name)
        inertia = NineBarData().inertia7 if name == "panel7" else NineBarData().own_inertia(int(name[-1]))
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
