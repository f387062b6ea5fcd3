"""Pictures of VTK files, drawn by pyvista without a display."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flexmb import checks
from flexmb.errors import FileFormatError
from flexmb.jobs.files import whole_file
from flexmb.pictures.style import words_of
from flexmb.results.vtk import UNITS


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
    import pyvista

    mesh = _frame(Path(source), time)
    checks.one_of("screenshot_vtk", "field", field, mesh.point_data.keys())
    target = Path(path)
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


def _frame(source: Path, time: float | None) -> Any:
    """The mesh of a .vtu file, or of the frame of a collection nearest to `time`."""
    import pyvista

    if not source.is_file():
        raise FileFormatError(f"{str(source)!r}: there is no such file. Check the path; write_vtk(...) writes one.")
    try:
        reader = pyvista.get_reader(str(source))
        if source.suffix == ".pvd":
            instants = reader.time_values
            when = instants[-1] if time is None else min(instants, key=lambda t: abs(t - time))
            reader.set_active_time_value(when)
            return reader.read()[0]
        return reader.read()
    except (OSError, ValueError, KeyError, IndexError) as error:
        text = f"{str(source)!r}: no file of VTK that pyvista reads ({error}). Write it with write_vtk."
        raise FileFormatError(text) from error
