"""A run in a window of pyvista, and pictures of VTK files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.jobs.files import whole_file
from flexmb.errors import FileFormatError
from flexmb.late import mpl, pyvista
from flexmb.results import drawing
from flexmb.results.positions import magnified
from flexmb.results.solution import Solution, require_rows
from flexmb.results.vtk import UNITS
from flexmb.show.pictures import films
from flexmb.show.pictures.pose import SYMBOLS, THINNEST, body_colours, edges, is_point, with_arms
from flexmb.show.pictures.scene import Scene, box_about, scene_of
from flexmb.show.pictures.style import CLEARANCE, DIVERGING, SEQUENTIAL, TRACED, words_of


def screenshot_vtk(
    source: str | Path, path: str | Path, *, time: float | None = None, field: str = "bending_moment"
) -> Path:
    """Image of one frame of `write_vtk`, coloured by a field.

    VTK must be able to draw off screen on this machine; `flexmb.render` draws with matplotlib anywhere.

    Parameters
    ----------
    source : a .pvd collection or a .vtu frame.
    path : file of the image; its folder is created.
    time : instant [s] in a collection, replaced by the nearest frame; None: the last frame.
    field : name of the point data for the colour.

    Raises
    ------
    FileFormatError : a missing file, or a file that is no VTK file.
    InputError : an unknown field; a path that cannot be written.
    """
    given = checks.path("screenshot_vtk", source)
    if not given.is_file():
        raise FileFormatError(f"{str(given)!r}: there is no such file. Check the path; write_vtk(...) writes one.")
    try:
        reader: Any = pyvista.get_reader(str(given))
        if given.suffix == ".pvd":
            instants = reader.time_values
            reader.set_active_time_value(instants[-1] if time is None else min(instants, key=lambda t: abs(t - time)))
        mesh = reader.read()[0] if given.suffix == ".pvd" else reader.read()
    except (OSError, ValueError, KeyError, IndexError) as error:
        text = f"{str(given)!r}: no file of VTK that pyvista reads ({error}). Write it with write_vtk."
        raise FileFormatError(text) from error
    checks.one_of("screenshot_vtk", "field", field, mesh.point_data.keys())
    target = checks.path("screenshot_vtk", path)
    plotter = pyvista.Plotter(off_screen=True, window_size=(1200, 800))
    plotter.set_background("white")
    tube = {"line_width": 5, "point_size": 9, "render_points_as_spheres": True}
    bar = {"title": bar_title(field, UNITS.get(field, "")), "color": "black", "vertical": True}
    bar |= {"position_x": 0.86, "position_y": 0.2, "height": 0.6, "title_font_size": 18, "label_font_size": 16}
    plotter.add_mesh(mesh, scalars=field, scalar_bar_args=bar, **tube)
    plotter.view_xy()
    try:
        with whole_file(target, "screenshot_vtk") as part:
            plotter.screenshot(str(part))
    finally:
        plotter.close()
    return target


def bar_title(field: str, units: str) -> str:
    """Title of a colour bar: field and unit, in two lines."""
    return "\n".join([words_of(field), *([f"[{units}]"] if units else []), ""])


MOST_FRAMES = 500  # number of poses that are prepared, at most
INTERVAL = 30  # time between two frames while the motion plays [ms]
SIZE = (1200, 800)  # size of the window [pixel]
KEYS = "space: play and stop    left, right: frame by frame    mouse: move and zoom    r: whole picture    q: close"


@arguments.checked
def view(
    sol: Solution, *, magnify: float = 1.0, colour: str | None = "moment", forces: bool | Sequence[str] = False,
    off_screen: bool = False, time: float | None = None, follow: str | None = None,
) -> pyvista.Plotter:  # fmt: skip
    """The run in a window, with a slider of the time; the space bar plays the motion.

    The poses are saved rows, at most 500 of them.  The call returns when the window is closed.

    Parameters
    ----------
    sol : the solution.
    magnify : factor of the deformation of flexible bodies; 0: undeformed.
    colour : "moment", "axial" or "shear", the section force that colours the beams; "von_mises", the stress that
        colours meshes, as the others do where there are no beams; None: a colour for each body.
    forces : True: arrows of the forces of all joints; or names of joints.
    off_screen : True: no window; the plotter is returned at once, for `plotter.screenshot(path)` and `close()`.
    time : instant of the first pose [s], replaced by the nearest row; None: the first row.
    follow : name of a marker, body or node that the view moves with; None: the view holds the whole run.

    Raises
    ------
    InputError : no saved rows, no shapes, an unknown colour or joint, a time outside the run.
    """
    require_rows("view", sol)
    if colour is not None:
        checks.one_of("view", "colour", colour, (*films.FIELDS, films.STRESS))
    rows = np.unique(np.linspace(0, len(sol.time) - 1, min(len(sol.time), MOST_FRAMES)).round().astype(int))
    shown = magnified(sol, checks.not_negative("view", "magnify", magnify))
    centres = None if follow is None else drawing.path(shown, films.known_point("view", sol, "follow", follow), rows)
    box = None if centres is None else box_about(shown, 0, centres[0])
    true = sol if magnify != 1.0 else None
    scene = scene_of(shown, rows, box=box, forces=films.joints_with_forces("view", sol, forces), true=true)
    window = Window(scene, colour, off_screen=off_screen, centres=centres)
    if time is not None:
        when = checks.between("view", "time", time, float(sol.time[0]), float(sol.time[-1]), "s")
        window.go_to(int(np.abs(scene.time - when).argmin()))
    if not off_screen:
        window.plotter.show(title=sol.name)
    return window.plotter


class Window:
    """Meshes of a scene in a plotter, and the number of their pose; the view moves with `centres` (n, 2) [m]."""

    def __init__(
        self, scene: Scene, colour: str | None, *, off_screen: bool, centres: np.ndarray | None = None
    ) -> None:
        self.plotter = pyvista.Plotter(off_screen=off_screen, window_size=list(SIZE))
        self.plotter.set_background("white")
        self._scene, self._now, self._plays = scene, 0, False
        self._slider: Any = None
        self._centres = np.zeros((len(scene.time), 2)) if centres is None else centres
        self._moving: list[tuple[Any, np.ndarray, dict[str, np.ndarray]]] = []
        field = films.field_of(scene, colour) or films.field_of(scene, None if colour is None else films.STRESS)
        self._bodies(field)
        self._meshes(field)
        for sign in (*self._scene.signs, *self._scene.forces):
            look = SYMBOLS[sign.kind]
            style = {"color": mpl.colors.to_hex(look["color"]), "line_width": 1.6 * look["linewidth"]}
            self._lines([sign.points], {**style, "depth": 0.002 if sign.kind == "force" else -0.002})
        for path, _ in self._scene.paths.values():
            self._lines([np.repeat(path[None], len(self._scene.time), axis=0)], {"color": TRACED, "line_width": 2})
        for mark in (mark for mark in self._scene.marks if mark.kind != "journal"):
            clear = mark.kind == "clearance"
            style = {"color": CLEARANCE if clear else "black", "point_size": 14 if clear else 9, "depth": 0.004}
            self._point(mark.points, {**style, "render_points_as_spheres": True})
        name = scene.name.encode("latin-1", "backslashreplace").decode("latin-1")  # VTK's font has no others
        self.plotter.add_text(name, position="upper_left", font_size=10, color="black")
        # Parallel view on the plane that holds the whole run
        (x0, x1), (y0, y1) = self._scene.box
        self.plotter.view_xy()
        self.plotter.enable_parallel_projection()
        camera = self.plotter.camera
        camera.focal_point = (0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.0)
        camera.position = (0.5 * (x0 + x1), 0.5 * (y0 + y1), 10.0 * self._scene.size)
        camera.parallel_scale = 0.55 * max(y1 - y0, (x1 - x0) * SIZE[1] / SIZE[0])
        self.plotter.enable_image_style()
        self._controls()
        self.go_to(0)

    def go_to(self, now: int) -> None:
        """Show the pose number `now`; beyond the last one the motion begins again."""
        before, self._now = self._now, now % len(self._scene.time)
        shift, camera = np.append(self._centres[self._now] - self._centres[before], 0.0), self.plotter.camera
        camera.focal_point, camera.position = camera.focal_point + shift, camera.position + shift
        for mesh, points, data in self._moving:
            mesh.points = points[self._now]
            for name, values in data.items():
                mesh.point_data[name] = values[self._now]
        if self._slider is not None:  # it calls back while it is made
            self._slider.GetRepresentation().SetValue(float(self._scene.time[self._now]))

    def _add(self, points: np.ndarray, data: dict[str, np.ndarray], style: dict[str, Any], **cells: np.ndarray) -> None:
        """Add a mesh that moves: points (n, m, 2) and point data (n, m)."""
        depth = np.full((*points.shape[:2], 1), style.pop("depth", 0.0) * self._scene.size)
        flat = np.concatenate([points, depth], axis=2)
        mesh = pyvista.PolyData(flat[0], **cells)
        for name, values in data.items():
            mesh.point_data[name] = values[0]
        self.plotter.add_mesh(mesh, lighting=False, **style)
        self._moving.append((mesh, flat, data))

    def _bodies(self, field: tuple[str, str] | None) -> None:
        own = body_colours(self._scene)
        for line in with_arms(self._scene):
            if not line.is_beam:
                colour = own[line.part] if field is None else "#707070"
                if is_point(line):
                    self._point(line.points[:, 0], {"color": colour, "point_size": 24})
                else:
                    self._lines([line.points], {"color": colour, "line_width": 2 if line.kind == drawing.MESH else 5})
        beams = [line for line in self._scene.lines if line.is_beam]
        for name in dict.fromkeys(line.part for line in beams):
            mine = [line for line in beams if line.part == name]
            sides = [edges(line, THINNEST * self._scene.size) for line in mine]
            points = np.concatenate([side for pair in sides for side in pair], axis=1)
            quads, first = [], 0
            for m in (line.points.shape[1] for line in mine):
                k = first + np.arange(m - 1)  # of the left edge; the right one follows
                quads.append(np.stack([np.full(m - 1, 4), k, k + 1, k + m + 1, k + m], axis=1))
                first += 2 * m
            cells = np.concatenate(quads).ravel()
            style = {"color": "#404040", "line_width": 1.5, "depth": 1e-3}
            self._lines([side for pair in sides for side in pair], style)
            if field is None or field[0] == films.STRESS:
                self._add(points, {}, {"color": own[name] if field is None else "#b0b0b0"}, faces=cells)
                continue
            values = np.concatenate([line.fields[field[0]] for line in mine for _ in (0, 1)], axis=1)
            top = films.field_limit(self._scene, field[0])
            style = {"clim": (-top, top), "cmap": DIVERGING}
            self._add(points, {field[0]: values}, {**style, **_coloured(field)}, faces=cells)

    def _meshes(self, field: tuple[str, str] | None) -> None:
        """Meshes in the colours of their stress or of their bodies."""
        own = body_colours(self._scene)
        for surface in self._scene.surfaces:
            triangles = surface.triangles
            cells = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
            if field is None or field[0] != films.STRESS:
                style: dict[str, Any] = {"color": own[surface.part] if field is None else "#b0b0b0", "opacity": 0.35}
                self._add(surface.points, {}, {**style, "depth": -1e-3}, faces=cells)
                continue
            style = {"clim": (0.0, films.stress_limit(self._scene)), "cmap": SEQUENTIAL, "depth": -1e-3}
            self._add(surface.points, {films.STRESS: surface.von_mises}, {**style, **_coloured(field)}, faces=cells)

    def _lines(self, lines: list[np.ndarray], style: dict[str, Any]) -> None:
        """Add polylines (n, m, 2) of one style."""
        cells, first = [], 0
        for points in lines:
            m = points.shape[1]
            cells.append(np.array([m, *range(first, first + m)]))
            first += m
        self._add(np.concatenate(lines, axis=1), {}, style, lines=np.concatenate(cells))

    def _point(self, points: np.ndarray, style: dict[str, Any]) -> None:
        """Add a point (n, 2) that moves."""
        self._add(points[:, None], {}, style, verts=np.array([1, 0]))

    def _controls(self) -> None:
        time = self._scene.time
        span = float(time[0]), float(time[-1]) if len(time) > 1 else float(time[0]) + 1.0
        at = {"pointa": (0.08, 0.12), "pointb": (0.82, 0.12), "slider_width": 0.02, "tube_width": 0.004}
        look = {"title": "t [s]", "title_height": 0.02, "color": "black", "style": "modern", "fmt": "%.4g"}
        self._slider = self.plotter.add_slider_widget(
            lambda value: self.go_to(int(np.abs(time - value).argmin())), span, interaction_event="always", **at, **look
        )
        self.plotter.add_text(KEYS, position=(10, 8), font_size=7, color="gray")
        self.plotter.add_key_event("space", self._toggle)
        self.plotter.add_key_event("Right", lambda: self._step(1))
        self.plotter.add_key_event("Left", lambda: self._step(-1))
        self.plotter.add_timer_event(max_steps=2**31 - 1, duration=INTERVAL, callback=lambda _: self._tick())

    def _toggle(self) -> None:
        self._plays = not self._plays

    def _step(self, by: int) -> None:
        self.go_to(self._now + by)
        self.plotter.render()

    def _tick(self) -> None:
        if self._plays:
            self._step(1)


def _coloured(field: tuple[str, str]) -> dict[str, Any]:
    """Style of a mesh with the colours of a field, and with their bar."""
    bar = {"title": bar_title(*field), "color": "black", "vertical": True}
    bar |= {"position_x": 0.86, "position_y": 0.25, "title_font_size": 18, "label_font_size": 16}
    return {"scalars": field[0], "scalar_bar_args": {**bar, "height": 0.55, "n_labels": 5}}
