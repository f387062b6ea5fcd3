"""Picture of a mechanism before it moves."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flexmb.errors import InputError
from flexmb.model.signal import Signal, Signals
from flexmb.pictures.poses.pose import Pose
from flexmb.pictures.poses.render import figure_size, joint_names, legend
from flexmb.pictures.poses.scene import Scene, scene_of
from flexmb.pictures.style import grid
from flexmb.results.peaks import Peaks
from flexmb.results.solution import Solution
from flexmb.results.stats import Stats

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from flexmb.model.mechanism import Mechanism

UNITS = {"x": "m", "y": "m", "theta": "rad"}


def plot_mechanism(
    mechanism: Mechanism, path: str | Path | None, *, lengths: bool, size: tuple[float, float] | None
) -> Figure:
    """Picture of the reference configuration of a mechanism; see `Mechanism.plot`.

    Lengths of straight links can be written beside them; `size` is width and height [inch], None: from the size of the
    mechanism.
    """
    from flexmb.pictures.figure import Picture

    if not mechanism.bodies:
        raise InputError(f"{mechanism.label} has no bodies to draw. Add some, e.g. a RigidLink.")
    scene = scene_of(reference_solution(mechanism), np.array([0]))
    figure = Picture(figsize=figure_size("plot", scene.box, 1, 1, size), layout="constrained")
    ax = figure.subplots()
    Pose(ax, scene, 0)
    grid(ax)
    ax.set(xlim=scene.box[0], ylim=scene.box[1], aspect="equal", xlabel="x [m]", ylabel="y [m]")
    figure.suptitle(mechanism.name)
    legend(figure, scene)
    joint_names(ax, scene, 0, _lengths(scene) if lengths else [])
    if path is not None:
        figure.savefig(path, dpi=150)
    return figure


def reference_solution(mechanism: Mechanism) -> Solution:
    """Solution with one row, the reference configuration, for drawings."""
    signals, values = [], []
    for part, node in mechanism.nodes():
        stem = f"{part}.{node.name}" if node.name else part
        for axis, value in zip(UNITS, (node.x, node.y, node.theta), strict=True):
            signals.append(Signal(f"{stem}.{axis}", UNITS[axis]))
            values.append(value)
    row = np.array([values])
    return Solution(
        time=np.zeros(1),
        values=row,
        signals=Signals.of(tuple(signals)),
        peaks=Peaks(np.abs(row[0]), np.zeros(len(values))),
        status="Reference configuration.",
        ok=True,
        stats=Stats(),
        shapes=mechanism.shapes(),
        model={"name": mechanism.name},
    )


def _lengths(scene: Scene) -> list[tuple[np.ndarray, str]]:
    """Middles of the straight bodies and their lengths as texts [m]."""
    found = []
    for part in scene.parts:
        points = np.concatenate([line.points[0] for line in scene.lines if line.part == part])
        ends = points[0], points[-1]
        length = math.dist(*ends)
        way = np.hypot(*np.diff(points, axis=0).T).sum()
        if length > 0.0 and way < (1.0 + 1e-6) * length:
            found.append((0.5 * (ends[0] + ends[1]), f"{length:.4g} m"))
    return found
