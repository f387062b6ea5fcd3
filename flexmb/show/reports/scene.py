"""Moving mechanism of a page: frames that carry nodes, shapes, flexible parts, stresses; its player, also of a cell."""

import html
from collections.abc import Mapping, Sequence
from string import Template
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import ElasticBody
from flexmb.model.shape import ArrowShape, BeamShape, CircleShape, LineShape, MeshShape, Place, PointShape, RigidShape
from flexmb.results import drawing
from flexmb.results.drawing import GROUND, Surface, nearest_instants, parts, pose
from flexmb.results.positions import flexible_motions
from flexmb.results.solution import Solution
from flexmb.results.stress import of_beams
from flexmb.show.reports.document import COARSE, FINE, MIDDLE, Markup, asset, document, instants, joined, quantised, tag


def stresses(sol: Solution, mechanism: Mechanism | None, instants: np.ndarray) -> np.ndarray | None:
    """Largest stress (n, m) of each beam element, >= 0 [Pa], at its ends and in its middle as of `Solution.stress`."""
    # None where the mechanism is unknown, or a section does not know its outer fibre. Elements stand in the order of
    # the shapes, instants by the numbers (n,) of saved ones.
    beams = [shape for shape in sol.shapes if isinstance(shape, BeamShape)]
    if mechanism is None or not all(drawing.beam_motion(sol, shape, instants) for shape in beams):
        return None
    known, columns = dict(zip(mechanism.names, mechanism.parts, strict=True)), []
    for body in map(known.get, dict.fromkeys(shape.part for shape in beams)):
        if not isinstance(body, ElasticBody) or not body.knows_stress:
            return None
        along = of_beams(sol, body, mechanism, instants)[1]["von_mises"]
        columns.append(along.reshape(len(instants), -1, 3).max(axis=2))
    return np.concatenate(columns, axis=1) if columns else None


MOST_POINTS = 1500  # mesh points of a page, about, whose stress is shown; of a finer mesh some points stand for all
LOOP_POINTS = 160  # largest number of points of an outline or of a hole, about
WIDER = 1.1  # factor by which the squares grow, in each of which one point is kept, until there are few enough


def coarse(surface: Surface, most: int) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Numbers of representative points of a mesh, and the triangles and loops between these."""
    # Squares of one size lie over the mesh; one point of each stands for the others, one of the outline where there is
    # one. Triangles whose corners fall together are left out.
    points, triangles = np.array(surface.shape.points), surface.triangles
    loops = [np.array(loop)[:: -(-len(loop) // LOOP_POINTS)] for loop in surface.shape.loops]
    if len(points) > most:
        rim = np.zeros(len(points), dtype=bool)
        rim[np.concatenate([np.array(loop) for loop in surface.shape.loops])] = True
        # Number (n,) of the point that stands for each point
        low, high = points.min(axis=0), points.max(axis=0)
        side = float(np.sqrt(np.prod(high - low) / most))
        while True:
            squares, of = np.unique(np.floor((points - low) / side).astype(np.int64), axis=0, return_inverse=True)
            if len(squares) <= most:
                break
            side *= WIDER
        of = of.ravel()
        counts = np.bincount(of)
        middle = np.stack([np.bincount(of, points[:, k]) / counts for k in (0, 1)], axis=1)
        away = np.hypot(*(points - middle[of]).T) + np.where(rim, 0.0, 10.0 * side)
        order = np.lexsort((away, of))
        first = order[np.searchsorted(of[order], np.arange(len(squares)))]
        triangles = np.asarray(first[of])[triangles]
        whole = [triangles[:, k] != triangles[:, j] for k, j in ((0, 1), (1, 2), (2, 0))]
        triangles = triangles[np.logical_and.reduce(whole)]
        triangles = triangles[np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)[1]]
    kept = np.unique(np.concatenate([triangles.ravel(), *loops]))
    number = np.zeros(len(points), dtype=np.int64)
    number[kept] = np.arange(len(kept))
    return kept, number[triangles], [number[loop] for loop in loops]


# Moving mechanism of a page: frames that carry nodes, shapes on these nodes, section forces, joint forces

STANDING = -1  # number of the frame of the ground


class Nodes:
    """Nodes of all shapes with the frames that carry them, at n saved instants, given by their numbers."""

    def __init__(self, sol: Solution, instants: np.ndarray) -> None:
        self.sol, self.instants = sol, instants
        self.places: dict[tuple[str, str], int] = {(GROUND, ""): 0}
        self.rows: list[list[float]] = [[STANDING, 0.0, 0.0, 0.0, STANDING]]
        self.displacements: list[np.ndarray] = []
        self.bodies = {body.part: (k, body) for k, body in enumerate(flexible_motions(sol, instants))}
        self.frames = [body.motion for _, body in self.bodies.values()]

    def of(self, part: str, node: str) -> int:
        """Number of a node; a node of a rigid body is its frame itself."""
        if part == GROUND:
            return 0
        if (part, node) not in self.places:
            self.places[part, node] = len(self.rows)
            if part in self.bodies:
                frame, body = self.bodies[part]
                k = body.nodes.index(node)
                self.rows.append([frame, *body.reference[k].tolist(), len(self.displacements)])
                self.displacements.append(body.displacements[:, k])
            else:
                self.rows.append([len(self.frames), 0.0, 0.0, 0.0, STANDING])
                self.frames.append(pose(self.sol, part, node, self.instants))
        return self.places[part, node]

    def at(self, place: Place) -> list[float]:
        """Number of the node of a place, and the point in its frame [m]."""
        part, node, (x, y) = place
        return [self.of(part, node), x, y]

    def packed(self) -> dict[str, Any]:
        """Nodes and motions for the page."""
        none = np.zeros((len(self.instants), 0))
        frames = quantised(np.concatenate([none, *self.frames], axis=1), FINE)
        moved = quantised(np.concatenate([none, *self.displacements], axis=1), MIDDLE)
        return {"nodes": self.rows, "frames": frames, "displacements": moved}


def scene(sol: Solution, mechanism: Mechanism | None, instants: np.ndarray) -> dict[str, Any]:
    """Mechanism at saved instants (n,) for the page; its poses must be saved; stresses need the moved one."""
    drawing.require_nodes(sol)
    nodes, beams = Nodes(sol, instants), [shape for shape in sol.shapes if isinstance(shape, BeamShape)]
    rigid = [shape for shape in sol.shapes if isinstance(shape, RigidShape)]
    points = [shape for shape in sol.shapes if isinstance(shape, PointShape)]
    drawn = {
        "parts": drawing.bodies(sol),
        "rigid": [{"part": s.part, "node": nodes.of(s.part, s.node), "lines": s.lines} for s in rigid],
        "meshes": _meshes(nodes),
        "beams": [_beam(nodes, beam) for beam in beams],
        "points": [
            {"part": s.part, "kind": s.kind, "at": nodes.at((s.body, s.node, s.offset)), "ground": s.body == GROUND}
            for s in points
        ],
        "symbols": [s for s in (_symbol(nodes, shape) for shape in sol.shapes) if s is not None],
    }
    stress = stresses(sol, mechanism, instants)
    fields: dict[str, Any] = {}
    if beams:  # bending moments [N m] and axial forces [N] at both ends of all elements
        lines = [line for line in drawing.lines(sol, instants, 2) if line.is_beam]
        for key, name in (("moment", "bending_moment"), ("axial", "axial_force")):
            fields[key] = quantised(np.concatenate([b.fields[name] for b in lines], axis=1), COARSE, common=True)
    if stress is not None:
        fields["stress"] = quantised(stress, COARSE, common=True)
    forced = [part for part in dict.fromkeys(s.part for s in points) if f"{part}.fx" in sol and f"{part}.fy" in sol]
    if forced:  # forces on the second bodies of joints [N], two columns for each
        columns = [sol.array(f"{part}.{axis}")[instants] for part in forced for axis in ("fx", "fy")]
        fields |= {"forced": forced, "forces": quantised(np.nan_to_num(np.stack(columns, axis=1)), MIDDLE)}
    return {**drawn, **nodes.packed(), **fields}


def scene_or_reason(
    sol: Solution, mechanism: Mechanism | None, instants: np.ndarray
) -> tuple[dict[str, Any] | None, str]:
    """Moving mechanism, or None with the reason why it cannot be drawn."""
    if not sol.shapes:
        return None, "The solution has no shapes to draw."
    try:
        return scene(sol, mechanism, instants), ""
    except FlexmbError as error:  # poses that were not saved
        return None, str(error)


def fields_of(drawn: Mapping[str, Any]) -> list[str]:
    """Fields by which the bodies of a result of `scene` can be coloured: "moment", "axial", "stress"."""
    found = [field for field in ("moment", "axial", "stress") if field in drawn]
    return [*found, "stress"] if any("stress" in mesh for mesh in drawn["meshes"]) and "stress" not in found else found


def _meshes(nodes: Nodes) -> list[dict[str, Any]]:
    """Meshes of the flexible bodies; each has its share of the points of a page."""
    meshes = [shape for shape in nodes.sol.shapes if isinstance(shape, MeshShape)]
    total, found = sum(len(shape.points) for shape in meshes), []
    for shape in meshes:
        frame, body = nodes.bodies[shape.part]
        surface = drawing.surface(nodes.sol, shape, nodes.instants)
        kept, triangles, loops = coarse(surface, MOST_POINTS * len(shape.points) // total)
        points, reference = surface.points[:, kept], np.array(shape.points)[kept]
        weights, shapes = body.deformation(points, reference)
        mesh: dict[str, Any] = {
            "part": body.part, "frame": frame, "points": quantised(reference, FINE),
            "triangles": triangles.ravel().tolist(), "loops": [loop.tolist() for loop in loops],
            "largest": float(np.abs(body.seen(points) - reference).max(initial=0.0)),
            "weights": quantised(weights, FINE),
            "shapes": quantised(shapes.transpose(2, 1, 0).reshape(-1, len(shapes)), FINE),
        }  # fmt: skip
        if surface.has_stress:
            mesh["stress"] = quantised(surface.von_mises[:, kept], COARSE, common=True)
        found.append(mesh)
    return found


def _beam(nodes: Nodes, beam: BeamShape) -> list[Any]:
    a, b = nodes.of(beam.part, beam.start), nodes.of(beam.part, beam.end)
    return [beam.part, a, b, beam.length, beam.start_angle, beam.end_angle, *(beam.shear if any(beam.shear) else ())]


def _symbol(nodes: Nodes, shape: object) -> dict[str, Any] | None:
    """A spring, damper, rod, cable, force or pitch circle; None for another shape."""
    if isinstance(shape, LineShape):
        first, second = nodes.at(shape.first), nodes.at(shape.second)
        return {"part": shape.part, "kind": shape.kind, "first": first, "second": second}
    if isinstance(shape, ArrowShape):
        extra = {"direction": shape.direction, "turns": shape.turns}
        return {"part": shape.part, "kind": "force", "at": nodes.at(shape.at), **extra}
    if isinstance(shape, CircleShape):
        return {"part": shape.part, "kind": "circle", "at": nodes.at(shape.at), "radius": shape.radius}
    return None


MAGNIFICATIONS = ("1", "3", "10", "30", "100", "300", "1000", "3000", "10000")  # of displacements of flexible parts
# Names of the fields by which bodies are coloured.
COLOURED = {"moment": "bending moment", "axial": "axial force", "stress": "stress"}


def player(sol: Solution, heading: str, *, fields: Sequence[str]) -> Markup:
    """Picture, time slider and controls; fields as of `reports.scene.fields_of`."""
    names = parts(sol)
    listed = ", ".join(names[:30]) + (", ..." if len(names) > 30 else "")
    text = f"Moving picture of {heading}: {listed}. Plots and tables hold the same in numbers."
    flexible = any(isinstance(shape, BeamShape | MeshShape) for shape in sol.shapes)
    page = Template(asset("player.html"))
    return Markup(page.substitute(text=html.escape(text), flexible=choices(fields) if flexible else ""))


def choices(fields: Sequence[str]) -> Markup:
    """Choices of magnification and colour of flexible parts; fields as of `reports.scene.fields_of`."""
    factors = {"auto": "auto", **{x: f"{x} \u00d7" for x in MAGNIFICATIONS}}
    colours = {"part": "parts", **{field: COLOURED[field] for field in fields}}
    chosen = list(colours)[min(1, len(fields))]
    return joined([_choice("magnification", "Deformation", factors, "1"), _choice("colour", "Colour", colours, chosen)])


def _choice(name: str, label: str, options: dict[str, str], chosen: str) -> Markup:
    made = [tag("option", text, value=value, selected=value == chosen) for value, text in options.items()]
    return tag("label", label, Markup(" "), tag("select", *made, id=name))


SCRIPTS = ("mesh.js", "scene.js", "drawing.js", "player.js", "cell.js")
FRAMES = (200, 100, 50, 25)  # numbers of frames, of which the first is taken that keeps to `MOST_SIGNS`
MOST_SIGNS = 200_000  # length of the HTML of a player at most
HEIGHT = 460  # height of the frame [CSS pixel]

STYLE = """
body { background: none; }
.player { height: 100vh; display: flex; flex-direction: column; padding: 10px 12px; }
.picture { flex: 1; min-height: 0; display: flex; flex-direction: column; }
#picture { flex: 1; min-height: 0; height: auto; }
#keys { display: none; }
"""


def cell(sol: Solution) -> Markup:
    """Frame with the player of a run; empty for a run that cannot be drawn, or whose motion is too long a text."""
    finite = np.flatnonzero(np.isfinite(sol.values).all(axis=1))
    for most in FRAMES if sol.shapes and len(finite) else ():
        frames = finite
        if len(finite) > most:
            along = np.linspace(sol.time[finite[0]], sol.time[finite[-1]], most)
            frames = np.intersect1d(nearest_instants(sol, along), finite)
        try:
            # Frame that holds the page of a player, whose scripts reach nothing outside of it
            drawn = scene(sol, sol.mechanism, frames)
            data = {"time": instants(sol.time[frames]), "scene": drawn}
            text = document(sol.name, player(sol, sol.name, fields=fields_of(drawn)), SCRIPTS, data, own=(STYLE, ""))
            style = f"width: 100%; height: {HEIGHT}px; border: 0"
            made = tag("iframe", srcdoc=text, sandbox="allow-scripts", title=f"Motion of {sol.name}", style=style)
        except FlexmbError:  # poses that were not saved
            break
        if len(made) <= MOST_SIGNS:
            return made
    return Markup()
