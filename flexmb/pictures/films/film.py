"""Films of a run: GIF and MP4 files, and the moving picture of the HTML report."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

import numpy as np

from flexmb import arguments, checks
from flexmb.errors import InputError
from flexmb.jobs.files import whole_file
from flexmb.model.shape import MARKER, TRACE, Place, PointShape, nodes_of
from flexmb.pictures.films.film_files import write_gif, write_mp4
from flexmb.pictures.films.film_frames import Film
from flexmb.results.solution import Solution

ENDINGS = (".mp4", ".gif", ".html")

MOST_FRAMES, MOST_PIXELS = 20_000, 4e9
"""Largest number of frames of a film, and of pixels of all frames of a GIF, which is made in memory."""


@arguments.checked
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
    follow: str | None = None,
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
    magnify : factor of the deformation of flexible bodies; 0: undeformed.
    colour : "moment", "axial" or "shear", the section force that colours the beams; "von_mises", the stress that
        colours plane bodies; None: a colour for each body.
    traces : True: paths of all markers; names of markers, bodies or nodes ("coupler.end"); None: those with a trace.
    forces : True: arrows of the forces of all joints; names of joints.  Forces beyond the 98th percentile have arrows
        of one length.
    size : width and height [pixel], made even for .mp4; None: 800 pixels wide, as high as the mechanism needs.
    follow : name of a marker, body or node that stays in the middle, for mechanisms that travel; the picture is as wide
        as the mechanism in the first frame.  None: the picture stands still and holds the whole run.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError : another ending, numbers that are not positive, more than 20000 frames, a .gif of more than 4e9 pixels
        in all, no saved rows, unknown names, a path that cannot be written.
    MissingPackageError : for .mp4, no package imageio-ffmpeg.
    """
    target = checks.path("animate", path)
    if target.suffix.lower() not in ENDINGS:
        listed = ", ".join(ENDINGS)
        raise InputError(f"animate: path is {str(path)!r}; it must end in one of {listed}.")
    if target.suffix.lower() == ".html":
        return Path(import_module("flexmb.reports.report").report(sol, target))
    rate = checks.positive("animate", "fps", fps)
    count = _count(checks.positive("animate", "seconds", seconds, "s") * rate)
    film = Film(
        sol,
        instants(sol, times, count),
        checks.not_negative("animate", "magnify", magnify),
        colour,
        traced_points(sol, traces),
        joints_with_forces("animate", sol, forces),
        size,
        None if follow is None else known_point("animate", sol, "follow", follow),
    )
    is_gif = target.suffix.lower() == ".gif"
    pixels = float(count) * film.size[0] * film.size[1]
    if is_gif and pixels > MOST_PIXELS:
        text = f"animate: {count} frames of {film.size[0]} x {film.size[1]} pixels are {pixels:.2g}, more than a .gif"
        raise InputError(f"{text} holds ({MOST_PIXELS:.0e}). Make an .mp4, or give a smaller size=, fps= or seconds=.")
    write = write_gif if is_gif else write_mp4
    with whole_file(target, "animate") as part:
        write(part, film, rate)
    return target


def _count(frames: float) -> int:
    """Number of frames, at least 1; refused where there are too many."""
    if not frames <= MOST_FRAMES:
        text = f"animate: seconds x fps are {frames:.6g} frames; it must be at most {MOST_FRAMES}"
        raise InputError(f"{text}. Films have 25 to 60 frames a second: give a smaller fps= or seconds=.")
    return max(1, round(frames))


def instants(sol: Solution, times: tuple[float, float] | None, count: int) -> np.ndarray:
    """Instants (count,) of the frames [s], from `times` or, if None, from the saved rows.

    Refused: no rows, no shapes, times outside the run or in the wrong order.
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
    """Points whose paths are drawn, by name: body, node, and place in its frame; see `animate`."""
    if traces is None:
        names = [name for name, shape in _markers(sol).items() if shape.kind == TRACE]
    elif isinstance(traces, bool):
        names = list(_markers(sol)) if traces else []
    else:
        names = [str(name) for name in checks.sequence("animate", "traces", traces, "names such as 'coupler.end'")]
    return {name: known_point("animate", sol, "traces", name) for name in names}


def _markers(sol: Solution) -> dict[str, PointShape]:
    """Markers by name."""
    return {s.part: s for s in sol.shapes if isinstance(s, PointShape) and s.kind in (MARKER, TRACE)}


def known_point(label: str, sol: Solution, argument: str, name: str) -> Place:
    """The marker, body or node of that name, or `InputError`; `label`: name of the caller."""
    nodes = {node for shape in sol.shapes for node in nodes_of(shape)}
    known = {f"{part}.{node}" if node else part: (part, node, (0.0, 0.0)) for part, node in nodes if part != "ground"}
    known |= {other: known[own] for other, own in sol.aliases.items() if own in known}
    known |= {marker: (shape.body, shape.node, shape.offset) for marker, shape in _markers(sol).items()}
    return known[checks.one_of(label, argument, name, sorted(known))]


def joints_with_forces(label: str, sol: Solution, forces: bool | Sequence[str]) -> tuple[str, ...]:
    """Names of the joints whose forces are drawn; see `animate`."""
    drawn = [s.part for s in sol.shapes if isinstance(s, PointShape) and f"{s.part}.fx" in sol]
    if isinstance(forces, bool):
        return tuple(drawn) if forces else ()
    names = checks.sequence(label, "forces", forces, "names of joints")
    return tuple(checks.one_of(label, "forces", str(name), drawn) for name in names)
