"""Record of a run in the compiled loop: saved instants, peaks, counters, codes."""

from __future__ import annotations

import numpy as np

from flexmb.compiled.records import Flags, Integers, IntegerTable, Matrix, Record, Vector
from flexmb.program.program import Program
from flexmb.program.signals import CONTACT_PENETRATION
from flexmb.state.flow import EPISODE_ROW_SIZE
from flexmb.state.poses import Poses, new_poses
from flexmb.system.templates import new_from_template

RUNNING, DONE, BUFFER_FULL, NEWTON_FAILED, SINGULAR, NOT_FINITE, STEP_TOO_SMALL = range(7)
ENERGY_MISSING, ENERGY_MADE, ENERGY_LOST = 20, 21, 22
(CONDITION_MET,) = range(30, 31)
"""Codes with which a compiled loop returns (`results/status.py` has a sentence for each)."""

NOT_EVALUATED, EVALUATED, JOINTS_EVALUATED = range(3)
"""Codes of `Counters.evaluated`: nothing of the trial state is evaluated, all of it, or its constraints alone."""

LEVEL, DIRECTION = range(2)
"""Columns of `RunRecord.levels`: level of a stop condition; 1 for rising through it, -1 for falling, 0 for neither."""


class Counters(Record):
    """Counters of a run, and codes of its last step.

    steps, rejected, iterations, evaluations, factorisations, solves : totals of the run
    rows, episodes : instants and ended contact intervals in the buffers
    lost_pivot : unknown whose pivot was lost
    held_steps : number of steps with held multipliers
    held_code : code of the last step, see `held_code` of `step/newmark/redundant_constraints.py`
    evaluated : evaluation of the trial state (`NOT_EVALUATED`, ...)
    rejecting_contact : 1 + number of the contact that had the last trial rejected; 0: no contact
    condition : 1 + number of the stop condition that was met in the last step; 0: none
    """

    steps: int
    rejected: int
    iterations: int
    evaluations: int
    factorisations: int
    rows: int
    lost_pivot: int
    held_steps: int
    held_code: int
    evaluated: int
    solves: int
    rejecting_contact: int
    episodes: int
    condition: int


class StepReport(Record):
    """Step sizes of a run, and the last Newton correction.

    smallest, largest : smallest and largest accepted step [s]
    start, size : start and size of the last accepted step [s]
    rejected_size : size of the last rejected step [s]
    correction, tolerance : last correction and its tolerance, both lengths [m] or both angles [rad]
    length_tolerance, angle_tolerance : tolerances of lengths [m] and of angles [rad]
    round_off : fraction of round-off in `tolerance`
    first_held_time : first time with held multipliers [s]
    """

    smallest: float
    largest: float
    correction: float
    tolerance: float
    start: float
    size: float
    first_held_time: float
    round_off: float
    rejected_size: float
    length_tolerance: float
    angle_tolerance: float


LEAST, INSTANT = range(2)
"""Columns of `RunRecord.lows`: least value of a signal, and when [s]."""

PLACE, OF_PEAK = range(2)
"""Columns of `RunRecord.places`: the signal of a place, and the signal at whose peak it is wanted."""


class RunRecord(Record):
    """Record of a run: saved instants, peaks, contact intervals, counters.

    times : (rows,) saved instants [s];  values : (rows, n_s) their saved signals
    saved_places : (n_s,) places of the saved signals among all signals; empty: all signals are saved
    save_times : (n,) given instants to be saved [s]; empty: the save grid of the options
    within : (n_y,) all signals at an instant within a step
    last_signals, signals : (n_y,) all signals at the ends of the last accepted step
    last_lam, last_z : (n_c,) multipliers and (n_z,) histories at its start
    watched : (w,) places of the signals of stop conditions;  levels : (w, 2) LEVEL and DIRECTION of each
    peak, peak_time : (n_y,) largest absolute values so far and their times [s]
    one_sided : (n_y,) signals whose peak is the largest positive value (a penetration is negative in free flight)
    places : (k, 2) signals of places, and the signals at whose peaks they are wanted;  place_then : (k,) their values
    low_places : (l,) places of signals whose least value is watched;  lows : (l, 2) LEAST and INSTANT of each
    poses : poses that are kept for the watch
    held_rows : (n_c,) constraint equations whose multipliers were not unique
    passed : (contacts,) first instants at which a fixed step passed a contact unseen [s]; 0: none
    episodes : (rows, EPISODE_ROW_SIZE) contact intervals that ended (`step/contact_log.py`)
    """

    count: Counters
    report: StepReport
    times: Vector
    values: Matrix
    saved_places: Integers
    save_times: Vector
    within: Vector
    last_signals: Vector
    signals: Vector
    last_lam: Vector
    last_z: Vector
    watched: Integers
    levels: Matrix
    peak: Vector
    peak_time: Vector
    one_sided: Flags
    places: IntegerTable
    place_then: Vector
    low_places: Integers
    lows: Matrix
    poses: Poses
    held_rows: Flags
    passed: Vector
    episodes: Matrix


def new_record(program: Program, rows: int, saved_places: np.ndarray | None = None) -> RunRecord:
    """Buffers for `rows` instants of the signals at `saved_places` (None: all), and for as many contact intervals."""
    if saved_places is None or len(saved_places) == program.tables.sizes.n_y:
        return new_from_template(program, ("record", rows), lambda: _empty_record(program, rows, None))
    return _empty_record(program, rows, saved_places)


def _empty_record(program: Program, rows: int, saved_places: np.ndarray | None) -> RunRecord:
    n_y = program.tables.sizes.n_y
    one_sided = np.zeros(n_y, dtype=np.bool_)
    one_sided[program.tables.contacts.out + CONTACT_PENETRATION] = True
    return RunRecord(
        times=rows,
        values=(rows, n_y if saved_places is None else len(saved_places)),
        saved_places=np.zeros(0, dtype=np.int64) if saved_places is None else saved_places,
        save_times=0,
        **dict.fromkeys(("within", "last_signals", "signals", "peak", "peak_time"), n_y),
        watched=0,
        levels=(0, 2),
        low_places=0,
        lows=(0, 2),
        poses=new_poses(program),
        last_lam=program.n_c,
        last_z=program.tables.sizes.n_z,
        one_sided=one_sided,
        places=program.tables.measured.places,
        place_then=len(program.tables.measured.places),
        count=Counters.zeros(),
        report=StepReport(np.inf, *(0.0,) * 10),
        held_rows=program.n_c,
        passed=len(program.tables.contacts.kernel),
        episodes=(rows + len(program.tables.contacts.kernel), EPISODE_ROW_SIZE),
    )
