"""What compiling the large functions of the package takes: `python tests/speed/compile.py --costs` measures it."""

WORK = 0.0095
"""Seconds that the measure of the machine's pace took there (`notice.pace`)."""

FIRST = "the equations of motion"
"""The stage to which kernels and other small functions belong."""

STAGES: dict[str, dict[str, float]] = {
    FIRST: {
        "flexmb.system.evaluate.evaluate": 8.0,
    },
}
"""Functions that are compiled one soon after the other, with processor time [s]."""

ONE_BY_ONE = 4.5
"""How much longer it takes with a numba for which there are no pieces (`flexmb/compiled/pieces.py`)."""
