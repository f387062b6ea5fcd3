"""Record of a run in the compiled loop: saved instants, peaks, counters, codes; options, kept poses."""

import numpy as np

from flexmb.engine.compiled.records import LARGEST, Flags, Integers, IntegerTable, Matrix, Record, Vector
from flexmb.engine.state.flow import EPISODE_ROW_SIZE
from flexmb.engine.system.work import new_from_template
from flexmb.program.numbering import CONTACT_PENETRATION
from flexmb.program.program import Program

GEAR_GUPTA_LEIMKUHLER, POSITION, VELOCITY = range(3)
# Form of the constraints by its public name.
FORMS = {"gear-gupta-leimkuhler": GEAR_GUPTA_LEIMKUHLER, "position": POSITION, "velocity": VELOCITY}
NEVER = 1e300  # save interval [s] of a run that saves no instants; also an accepted error [m] that rejects no step


class Coefficients(Record, frozen=True):
    """Coefficients of a method of the Newmark family, see `Newmark`."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float


class Options(Record, frozen=True):
    """Options of method and step control."""

    # regular, first: coefficients of regular steps, and of starting steps (at the start, after a jump)
    regular: Coefficients
    first: Coefficients
    form: int  # form of the constraints, a value of `FORMS`
    tolerance: float  # tolerance of Newton's corrections relative to h^2 |a|
    iterations: int  # most Newton iterations
    length: float  # size of the mechanism [m]
    leap: float  # displacement up to which predicted accelerations are trusted [m]
    adaptive: bool  # whether the error estimate chooses the steps
    error: float  # accepted error of positions in a step [m]
    h_min: float  # h_min, h_max: smallest and largest step [s]
    h_max: float
    t_end: float  # end [s]
    save_interval: float  # time between saved instants [s]; 0: every step is saved


# Poses that a run keeps for its watch: signals and histories of some accepted steps, whatever is saved

# Number of poses, at most and at least; numbers of all poses (2 MB) beyond which there are fewer.
MOST_POSES, LEAST_POSES, POSE_NUMBERS = 256, 32, 1 << 18


class PoseNumbers(Record, limits={"count": (0, MOST_POSES), "stride": (1, LARGEST), "wait": (0, LARGEST)}):
    """Numbers of a table of poses."""

    count: int  # number of the poses so far, without the most strained one, which is the last row
    stride: int  # stride, wait: steps between two poses, steps until the next one
    wait: int
    strain: float  # strain energy of the most strained one [J]


class Poses(Record):
    """Poses of accepted steps: every k-th one, with k doubled when the table is full, and the most strained one."""

    number: PoseNumbers  # see `PoseNumbers`
    times: Vector  # times, sizes: (rows,) instants of the poses [s], sizes of the steps that led there [s]
    sizes: Vector
    values: Matrix  # (rows, n_y) all signals
    z: Matrix  # (rows, n_z) histories


def new_poses(program: Program, histories: int | None = None) -> Poses:
    """An empty table of poses with the signals of a model, and its histories or another number of them."""
    n_y, n_z = program.tables.sizes.n_y, program.tables.sizes.n_z if histories is None else histories
    rows = max(LEAST_POSES, min(MOST_POSES, POSE_NUMBERS // (n_y + n_z))) // 2 * 2 + 1
    return Poses(PoseNumbers(0, 1, 0, 0.0), times=rows, sizes=rows, values=(rows, n_y), z=(rows, n_z))


def kept_poses(poses: Poses, t: float, signals: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, ...]:
    """Instants, signals, histories, sizes of steps of all poses in order, and which are even; the present one last."""
    # The present instant t [s] has all signals (n_y,) and histories z (n_z,).
    count, strained = poses.number.count, poses.number.strain > 0.0
    rows = np.array([*range(count), *([len(poses.times) - 1] if strained else [])])
    rows = rows[np.argsort(poses.times[rows], kind="stable")]
    times, values, histories = np.append(poses.times[rows], t), poses.values[rows], poses.z[rows]
    sizes, even = np.append(poses.sizes[rows], 0.0), np.append(rows < count, False)
    return times, np.concatenate([values, signals[None]]), np.concatenate([histories, z[None]]), sizes, even


# Codes with which a compiled loop returns (`results/status.py` has a sentence for each). Not converged, singular, not
# finite: a step of a method (`engine/newmark/implicit_step.py`, Radau, Runge-Kutta); with error control only when the
# step cannot be shorter. Energies: `check_balance` of `engine/energy.py`.
RUNNING, DONE, BUFFER_FULL, NEWTON_FAILED, SINGULAR, NOT_FINITE, STEP_TOO_SMALL = range(7)
ENERGY_MISSING, ENERGY_MADE, ENERGY_LOST = 20, 21, 22
(CONDITION_MET,) = range(30, 31)
# Codes of `Counters.evaluated`: nothing of the trial state is evaluated, all of it, or its constraints alone.
NOT_EVALUATED, EVALUATED, JOINTS_EVALUATED = range(3)
# Columns of `RunRecord.levels`: level of a stop condition; 1 for rising through it, -1 for falling, 0 for neither; 1
# for a condition of the user, 0 for a fault.
LEVEL, DIRECTION, ASKED = range(3)


class Counters(Record):
    """Counters of a run, and codes of its last step."""

    steps: int  # steps, rejected, iterations, evaluations, factorisations, solves: totals of the run
    rejected: int
    # rejected_at_contacts: for a contact event or a jump of a law within; not_converged: since Newton failed
    rejected_at_contacts: int
    not_converged: int
    iterations: int
    evaluations: int
    factorisations: int
    rows: int  # rows, episodes: instants and ended contact intervals in the buffers
    lost_pivot: int  # unknown whose pivot was lost
    held_steps: int  # number of steps with held multipliers
    held_code: int  # code of the last step, see `held_code` of `engine/newmark/jacobian_reuse.py`
    evaluated: int  # evaluation of the trial state (`NOT_EVALUATED`, ...)
    solves: int
    rejecting_contact: int  # 1 + number of the contact that had the last trial rejected; 0: no contact
    episodes: int
    condition: int  # 1 + number of the stop condition that was met in the last step; 0: none


class StepReport(Record):
    """Step sizes of a run, and the last Newton correction."""

    smallest: float  # smallest, largest: smallest and largest accepted step [s]
    largest: float
    correction: float  # correction, tolerance: last correction and its tolerance, both lengths [m] or both angles [rad]
    tolerance: float
    start: float  # start, size: start and size of the last accepted step [s]
    size: float
    first_held_time: float  # first time with held multipliers [s]
    round_off: float  # fraction of round-off in `tolerance`
    rejected_size: float  # size of the last rejected step [s]
    length_tolerance: float  # length_tolerance, angle_tolerance: tolerances of lengths [m] and of angles [rad]
    angle_tolerance: float


LEAST, INSTANT = range(2)  # columns of `RunRecord.lows`: least value of a signal, and when [s]
# Columns of `RunRecord.places`: the signal of a place, and the signal at whose peak it is wanted.
PLACE, OF_PEAK = range(2)


class RunRecord(Record):
    """Record of a run: saved instants, peaks, contact intervals, counters."""

    count: Counters
    report: StepReport
    times: Vector  # (rows,) saved instants [s]
    values: Matrix  # (rows, n_s) their saved signals
    saved_places: Integers  # (n_s,) places of the saved signals among all signals; empty: all signals are saved
    save_times: Vector  # (n,) given instants to be saved [s]; empty: the save grid of the options
    within: Vector  # (n_y,) all signals at an instant within a step
    last_signals: Vector  # last_signals, signals: (n_y,) all signals at the ends of the last accepted step
    signals: Vector
    last_lam: Vector  # last_lam, last_z: (n_c,) multipliers and (n_z,) histories at its start
    last_z: Vector
    watched: Integers  # (w,) places of the signals of stop conditions
    levels: Matrix  # (w, 3) LEVEL, DIRECTION, ASKED of each
    peak: Vector  # peak, peak_time: (n_y,) largest absolute values so far and their times [s]
    peak_time: Vector
    # (n_y,) signals whose peak is the largest positive value (a penetration is negative in free flight)
    one_sided: Flags
    places: IntegerTable  # (k, 2) signals of places, and the signals at whose peaks they are wanted
    place_then: Vector  # (k,) their values
    low_places: Integers  # (l,) places of signals whose least value is watched
    lows: Matrix  # (l, 2) LEAST and INSTANT of each
    poses: Poses  # poses that are kept for the watch
    held_rows: Flags  # (n_c,) constraint equations whose multipliers were not unique
    passed: Vector  # (contacts,) first instants at which a fixed step passed a contact unseen [s]; 0: none
    episodes: Matrix  # (rows, EPISODE_ROW_SIZE) contact intervals that ended (`engine/step/contact_events.py`)


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
        times=rows, values=(rows, n_y if saved_places is None else len(saved_places)),
        saved_places=np.zeros(0, dtype=np.int64) if saved_places is None else saved_places, save_times=0,
        **dict.fromkeys(("within", "last_signals", "signals", "peak", "peak_time"), n_y), watched=0, levels=(0, 3),
        low_places=0, lows=(0, 2), poses=new_poses(program), last_lam=program.n_c, last_z=program.tables.sizes.n_z,
        one_sided=one_sided, places=program.tables.measured.places, place_then=len(program.tables.measured.places),
        count=Counters.zeros(), report=StepReport(np.inf, *(0.0,) * 10), held_rows=program.n_c,
        passed=len(program.tables.contacts.kernel),
        episodes=(rows + len(program.tables.contacts.kernel), EPISODE_ROW_SIZE),
    )  # fmt: skip
