"""Options of a run for the compiled loops: coefficients of the method and limits of the step control."""

from flexmb.compiled.records import Record

GEAR_GUPTA_LEIMKUHLER, POSITION, VELOCITY = range(3)
FORMS = {"gear-gupta-leimkuhler": GEAR_GUPTA_LEIMKUHLER, "position": POSITION, "velocity": VELOCITY}
"""Form of the constraints by its public name."""

NEVER = 1e300
"""Save interval [s] of a run that saves no instants; also an accepted error [m] that rejects no step."""


class Coefficients(Record, frozen=True):
    """Coefficients of a method of the Newmark family, see `Newmark`."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float


class Options(Record, frozen=True):
    """Options of method and step control.

    regular, first : coefficients of regular steps, and of first steps (at the start, after a jump)
    form : form of the constraints, a value of `FORMS`
    tolerance : tolerance of Newton's corrections relative to h^2 |a|
    iterations : most Newton iterations
    length : size of the mechanism [m]
    adaptive : whether the error estimate chooses the steps
    error : accepted error of positions in a step [m]
    h_min, h_max : smallest and largest step [s]
    t_end : end [s]
    save_interval : time between saved instants [s]; 0: every step is saved
    """

    regular: Coefficients
    first: Coefficients
    form: int
    tolerance: float
    iterations: int
    length: float
    adaptive: bool
    error: float
    h_min: float
    h_max: float
    t_end: float
    save_interval: float
