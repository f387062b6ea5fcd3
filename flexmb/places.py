"""Names of places in the output of gap and joint-friction kernels, and parameters packed by place.

A name is an integer constant, so `out[SLIP]` costs what `out[2]` does.  Places of numbers that one file knows are named
there, columns of tables in `flexmb.program.program`, those of results in `flexmb.engine.system.work`.
"""

from collections.abc import Mapping

# Places in the output of a gap kernel: gap, gap rate, slip, normal, arms to the contact point, eccentricity.
(
    GAP, GAP_RATE, SLIP, NORMAL_X, NORMAL_Y, ARM1_X, ARM1_Y, ARM2_X, ARM2_Y,
    ECCENTRICITY_X, ECCENTRICITY_Y, ECCENTRICITY_RATE_X, ECCENTRICITY_RATE_Y,
) = range(13)  # fmt: skip
MASS, INERTIA, GRAVITY_X, GRAVITY_Y = range(4)  # numbers of a mass at a node [kg, kg m^2, m/s^2]
# Places of the first of six derivatives of each component, by the six coordinates.
NORMAL_X_Q, NORMAL_Y_Q, ARM1_X_Q, ARM1_Y_Q, ARM2_X_Q, ARM2_Y_Q = range(13, 49, 6)
NORMAL_FORCE, FRICTION_FORCE = range(49, 51)  # what a contact's row holds behind that
NORMAL, TANGENTIAL = range(2)  # rows of the Jacobian of a contact: of the gap rate J_n v, and of the slip J_t v
# Places in the output of a joint-friction kernel: normal load [N], first of its three derivatives by multipliers.
LOAD, LOAD_BY_LAM = range(2)
# Places of the first of the six entries of J, with the slip J v, and of the six derivatives of the load.
SLIDING, LOAD_BY_Q = range(4, 16, 6)


def packed(numbers: Mapping[int, float]) -> tuple[float, ...]:
    """Numbers by their places 0, 1, 2, ... in order: the p of a kernel that reads them by the same names."""
    return tuple(numbers[place] for place in range(len(numbers)))


# Formulas that the loops know: two points coincide; a difference of angles; a slider in its guide; a journal's gap.
PIN, ANGLE, GUIDE, JOURNAL = 1, 2, 3, 4
