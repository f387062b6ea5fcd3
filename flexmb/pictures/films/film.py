"""Films of a run: GIF and MP4 files, and the moving picture of the HTML report."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.model.shape import MARKER, TRACE, Place, PointShape, nodes_of
from flexmb.pictures.films.film_files import write_gif, write_mp4
from flexmb.pictures.films.film_frames import Film
from flexmb.results.solution import Solution

ENDINGS = (".mp4", ".gif", ".html")


def animate(
    sol: Solution,
    path: str | Path,
    *,
    seconds: float = 4.0,
    fps: float = 25.0,
    times: tuple[float, float] | None = None,
    magnify: float = 1.0,
    colour: str | None = "moment",
    traces: bool | Sequence[str] | None = None,
    forces: bool | Sequence[str] = False,
    size: tuple[int, int] | None = None,
) -> Path:
    """Film of a run: seconds x fps frames, evenly over the time, whose ends the first and the last frame show.

    Between two saved rows positions follow cubic polynomials (`flexmb.results.resampling.at_times`), so a film may have
    more frames than the run has rows.  Beams are drawn with their depth and coloured by a section force, whose colours
    end at the 98th percentile of its absolute value.

    Parameters
    ----------
    sol : the solution.
    path : file of the film: .mp4, .gif (repeated for ever), or .html (the report of the run); its folder is made.
    seconds : length of the film [s].
    fps : frames a second.
    times : begin and end of the motion that is shown [s]; None: all of it.
    magnify : factor of the deformation of beams.
    colour : "moment", "axial" or "shear", the section force that colours the beams; None: a colour for each body.
    traces : True: paths of all markers; names of markers, bodies or nodes ("coupler.end"); None: those with a trace.
    forces : True: arrows of the forces of all joints; names of joints.  Forces beyond the 98th percentile have arrows
        of one length.
    size : width and height [pixel], made even for .mp4; None: 800 pixels wide, as high as the mechanism needs.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError : another ending, numbers that are not positive, no saved rows, unknown names, a path that cannot be
        written.
    MissingPackageError : for .mp4, no package imageio-ffmpeg.
    """
    target = checks.path("animate", path)
    if target.suffix.lower() not in ENDINGS:
        listed = ", ".join(ENDINGS)
        raise InputError(f"animate: path is {str(path)!r}; it must end in one of {listed}.")
    if target.suffix.lower() == ".html":
        return Path(import_module("flexmb.report.report").report(sol, target))
    rate = checks.positive("animate", "fps", fps)
    count = max(1, round(checks.positive("animate", "seconds", seconds, "s") * rate))
    film = Film(
        sol,
        instants(sol, times, count),
        checks.positive("animate", "magnify", magnify),
        colour,
        traced_points(sol, traces),
        joints_with_forces(sol, forces),
        size,
    )
    write = write_gif if target.suffix.lower() == ".gif" else write_mp4
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        write(target, film, rate)
    except OSError as error:
        text = f"animate: {str(target)!r} cannot be written ({error.strerror or error})."
        raise InputError(f"{text} Give a file in a writable folder.") from error
    return target


def instants(sol: Solution, times: tuple[float, float] | None, count: int) -> np.ndarray:
    """Instants (count,) of the frames [s].

    Parameters
    ----------
    sol : the solution.
    times : begin and end [s]; None: those of the saved rows.
    count : number of frames.

    Raises
    ------
    InputError : no rows, no shapes, times outside the run or in the wrong order.
    """
    if not len(sol.time):
        raise InputError("animate: the solution has no saved instants. Save some, e.g. by simulate(..., save=...).")
    if not sol.shapes:
        raise InputError("animate: the solution has no shapes to draw. Build it from a mechanism with bodies.")
    first, last = float(sol.time[0]), float(sol.time[-1])
    if times is not None:
        given = checks.sequence("animate", "times", times, "two instants [s]")
        if len(given) != 2:
            raise InputError(f"animate: times is {times!r}; give begin and end, e.g. times=(0.0, 0.5).")
        begin, end = (checks.between("animate", f"times[{k}]", t, first, last, "s") for k, t in enumerate(given))
        if end <= begin:
            raise InputError(f"animate: times is {times!r}; the end must be later than the begin.")
        first, last = begin, end
    return np.linspace(first, last, count)


def traced_points(sol: Solution, traces: bool | Sequence[str] | None) -> dict[str, Place]:
    """Points whose paths are drawn, by name: body, node, and place in its frame.

    Parameters
    ----------
    sol : the solution.
    traces : see `animate`.

    Raises
    ------
    InputError : a name that is neither a marker nor a body nor a node.
    """
    markers = {s.part: s for s in sol.shapes if isinstance(s, PointShape) and s.kind in (MARKER, TRACE)}
    if traces is None:
        names = [name for name, shape in markers.items() if shape.kind == TRACE]
    elif isinstance(traces, bool):
        names = list(markers) if traces else []
    else:
        names = [str(name) for name in checks.sequence("animate", "traces", traces, "names such as 'coupler.end'")]
    nodes = {node for shape in sol.shapes for node in nodes_of(shape)}
    known = {f"{part}.{node}" if node else part: (part, node, (0.0, 0.0)) for part, node in nodes}
    known |= {other: known[own] for other, own in sol.aliases.items() if own in known}
    known |= {name: (shape.body, shape.node, shape.offset) for name, shape in markers.items()}
    return {name: known[checks.one_of("animate", "traces", name, sorted(known))] for name in names}


def joints_with_forces(sol: Solution, forces: bool | Sequence[str]) -> tuple[str, ...]:
    """Names of the joints whose forces are drawn.

    Parameters
    ----------
    sol : the solution.
    forces : see `animate`.

    Raises
    ------
    InputError : a name that is no joint with forces.
    """
    drawn = [s.part for s in sol.shapes if isinstance(s, PointShape) and f"{s.part}.fx" in sol]
    if isinstance(forces, bool):
        return tuple(drawn) if forces else ()
    names = checks.sequence("animate", "forces", forces, "names of joints")
    return tuple(checks.one_of("animate", "forces", str(name), drawn) for name in names)
