"""Limits of the steps of a run, from mechanism, method and span."""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from flexmb.errors import InputError
from flexmb.model.law import CHORDS_OF_A_SINE, Motion
from flexmb.state.options import NEVER
from flexmb.state.trial import rigid_coordinates
from flexmb.step.step_size import FLIGHT_WEIGHT, FixedStep

if TYPE_CHECKING:
    from flexmb.run.run import Run

LEAST_STEP = 16.0
"""Smallest step by default over the round-off of the time."""

LEAST_SEEN, LEAST_CLEAR = 2.0, 8.0
"""Fixed steps in a cycle up to which these show another motion, and below which it is told."""


def step_limits(run: Run) -> tuple[float, float, float, tuple[float, ...]]:
    """Largest and smallest step [s], accepted error of a step [m], and the numbers of `StepControl`.

    The least speed crosses the mechanism in 100 runs or periods; with clearance, 100 clearances if these are less,
    so that the steps resolve a contact that comes to rest.
    """
    if isinstance(run.step, FixedStep):
        return run.step.size, run.step.size, NEVER, (1.0, 1.0, 1.0, 1.0)
    span = run.t_end if run.period is None else min(run.period, run.t_end)
    clearance, length, rtol = run.program.least_clearance, run.program.length, run.step.rtol
    steps = run.method.fewest_steps(contacts=clearance is not None)
    largest = run.step.max or span / steps
    flight, loose = (FLIGHT_WEIGHT, 2.0) if rigid_coordinates(run.program).all() else (1.0, 4.0)
    part = 1e-3 * length if clearance is None else loose * min(clearance, 1e-2 * length)
    way = length if clearance is None else min(length, 1e2 * clearance)
    bounds = (rtol, 1e-2 / steps * way / largest, run.step.steps_of_an_impact, flight)
    return largest, run.step.min or min(1e-9 * largest, least_step(run.t_end)), run.step.atol or rtol * part, bounds


def least_step(t: float) -> float:
    """Smallest step by which the time t [s] can be advanced [s]."""
    return LEAST_STEP * float(np.spacing(t))


class Chords:
    """Longest steps that follow the drives, the histories of loads and the inputs of controllers of a run.

    Raises
    ------
    InputError : a fixed step that sees another motion than that of a drive or load.
    """

    def __init__(self, run: Run) -> None:
        self.pieces: list[tuple[Motion, list[float], list[float]]] = []
        for motion in run.program.motions:
            inside = sorted(t for t in motion.breaks(run.t_end) if 0.0 < t < run.t_end)
            edges = [0.0, *inside, run.t_end]
            chords = [motion.longest_chord(*ends) for ends in pairwise(edges)]
            if min(chords) < math.inf:
                self.pieces.append((motion, edges[1:-1], chords))
        self.remarks = tuple(self._coarse(run.program.name, run.step.size)) if isinstance(run.step, FixedStep) else ()

    def longest(self, t: float) -> float:
        """Longest step about the instant t [s]; inf: any."""
        return min((chords[bisect(edges, t)] for _, edges, chords in self.pieces), default=math.inf)

    def _coarse(self, name: str, h: float) -> Iterator[str]:
        """Remarks on a fixed step h [s] that hardly sees a motion."""
        for motion, _, chords in self.pieces:
            cycle = CHORDS_OF_A_SINE * min(chords)
            if h <= cycle / LEAST_CLEAR * (1.0 - 1e-9):
                continue
            what = type(motion).__name__
            text = f"fixed step of {h:.3g} s is {h / cycle:.2g} cycles of {what}, whose shortest lasts {cycle:.3g} s"
            remedy = f"Take steps of {min(chords):.2g} s, or Adaptive()."
            if h * LEAST_SEEN >= cycle * (1.0 - 1e-9):
                raise InputError(f"simulate {name!r}: a {text}: the steps see another motion. {remedy}")
            yield f"A {text}: few steps see the motion. {remedy}"


def passed_contacts(run: Run) -> tuple[str, ...]:
    """Sentences on contacts that fixed steps have passed without seeing whether these close."""
    names, passed = run.program.names.contacts, run.record.passed
    return tuple(
        f"At t = {t:.6g} s a fixed step went by the contact {name!r}, which was closed then, or at a gap that the ends "
        "of the step do not tell. Take smaller steps, or Adaptive()."
        for name, t in zip(names, passed, strict=True)
        if t != 0.0
    )
