"""The record of a run in the compiled loop: saved instants, peaks, counters, and how it ended."""

from __future__ import annotations

import numpy as np

from flexmb.compiled.records import Flags, Integers, Matrix, Record, Vector
from flexmb.program.program import Program
from flexmb.program.signals import CONTACT_PENETRATION
from flexmb.state.flow import EPISODE_ROW
from flexmb.system.templates import fresh

RUNNING, DONE, BUFFER_FULL, NEWTON_FAILED, SINGULAR, NOT_FINITE, STEP_TOO_SMALL = range(7)
ENERGY_MISSING, ENERGY_MADE, ENERGY_LOST = 20, 21, 22
NOTHING_KNOWN, ALL_KNOWN, JOINTS_KNOWN = range(3)
"""What the last evaluation of a step says of the state it ends with: nothing, all, or the rows of its joints alone."""


class Counters(Record):
    """Counters of a run, and codes of its last step.

    steps, rejected, iterations, evaluations, factorisations, solves : of the run so far
    rows, episodes : instants and episodes of contact in the buffers
    lost : unknown whose pivot was lost
    held_steps : steps with held multipliers;  outcome : of the last step (`step/newmark/redundant_constraints.py`)
    known : what is known of the trial state (`ALL_KNOWN`, ...)
    contact : 1 + the contact that had the last trial refused
    """

    steps: int
    rejected: int
    iterations: int
    evaluations: int
    factorisations: int
    rows: int
    lost: int
    held_steps: int
    outcome: int
    known: int
    solves: int
    contact: int
    episodes: int


class StepReport(Record):
    """Sizes of steps and of Newton's corrections.

    smallest, largest : accepted steps [s];  began, size : of the last one [s];  refused : last refused one [s]
    correction, wanted : last correction, and what was wanted of it, of lengths [m] or of angles
    wanted_length, wanted_angle : what was wanted of both [m, rad];  round_off : the part of round-off in `wanted`
    first_held : first instant with held multipliers [s]
    """

    smallest: float
    largest: float
    correction: float
    wanted: float
    began: float
    size: float
    first_held: float
    round_off: float
    refused: float
    wanted_length: float
    wanted_angle: float


class RunRecord(Record):
    """What the loop writes: saved instants, peaks, counters.

    held : (n_c,) rows whose multipliers were not unique
    peak : largest absolute values; largest positive ones where one_sided (a penetration is negative in free flight)
    episodes : (rows, EPISODE_ROW) episodes of contact that ended (`step/contact_log.py`)
    values : (rows, n_s) signals that are saved;  kept : (n_s,) their places among all, empty: all are
    between : all signals at an instant inside a step; empty where all are saved
    """

    count: Counters
    step: StepReport
    times: Vector
    values: Matrix
    kept: Integers
    between: Vector
    old: Vector
    new: Vector
    peak: Vector
    peak_time: Vector
    one_sided: Flags
    held: Flags
    episodes: Matrix


def new_record(program: Program, rows: int, kept: np.ndarray | None = None) -> RunRecord:
    """Buffers for `rows` instants of the signals `kept` (places; None: all), and for episodes that end meanwhile."""
    if kept is None or len(kept) == program.tables.sizes.n_y:
        return fresh(program, ("record", rows), lambda: _blank_record(program, rows, None))
    return _blank_record(program, rows, kept)


def _blank_record(program: Program, rows: int, kept: np.ndarray | None) -> RunRecord:
    n_y = program.tables.sizes.n_y
    one_sided = np.zeros(n_y, dtype=np.bool_)
    one_sided[program.tables.contacts.out + CONTACT_PENETRATION] = True
    return RunRecord(
        times=rows,
        values=(rows, n_y if kept is None else len(kept)),
        kept=np.zeros(0, dtype=np.int64) if kept is None else kept,
        between=0 if kept is None else n_y,
        **dict.fromkeys(("old", "new", "peak", "peak_time"), n_y),
        one_sided=one_sided,
        count=Counters.zeros(),
        step=StepReport(np.inf, *(0.0,) * 10),
        held=program.n_c,
        episodes=(rows + len(program.tables.contacts.kernel), EPISODE_ROW),
    )
