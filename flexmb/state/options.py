"""Numbers of the method and of step control, as the compiled loops read them."""

from flexmb.compiled.records import Record

GEAR_GUPTA_LEIMKUHLER, POSITION, VELOCITY = range(3)
FORMS = {"gear-gupta-leimkuhler": GEAR_GUPTA_LEIMKUHLER, "position": POSITION, "velocity": VELOCITY}

NEVER = 1e300
"""A save interval of a run that saves nothing, an error that refuses no step."""


class Coefficients(Record, frozen=True):
    """Numbers of a step of the Newmark family, see `Newmark`."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float


class Options(Record, frozen=True):
    """Numbers of method and step control.

    regular, first : coefficients of all steps, and of those that begin anew
    """

    regular: Coefficients
    first: Coefficients
    form: int
    tolerance: float  # Newton: part of h^2 |a|
    iterations: int
    length: float  # size of the mechanism [m]
    adaptive: bool
    error: float  # accepted error of a step [m]
    h_min: float
    h_max: float
    t_end: float
    save_interval: float  # 0: every step
