"""What compiling the large functions of the package takes: `python tests/speed/compile.py --costs` measures it."""

WORK = 0.0125
"""Seconds that the measure of the machine's pace took there (`notice.pace`)."""

FIRST = "the equations of motion"
"""The stage to which kernels and other small functions belong."""

STAGES: dict[str, dict[str, float]] = {
    FIRST: {
        "flexmb.system.evaluate.evaluate": 6.4,
        "flexmb.joints.prismatic.direction_row": 0.5,
        "flexmb.joints.revolute.coincide": 1.0,
        "flexmb.bodies.inertia.node_force": 1.6,
    },
    "the accounts of a run": {
        "flexmb.linalg.lu.factor": 2.5,
        "flexmb.system.evaluate.evaluate_accepted": 3.9,
        "flexmb.system.constraints.report_forces": 0.3,
        "flexmb.energy.contact_work.contact_losses": 0.8,
        "flexmb.energy.balance.keep_account": 1.5,
        "flexmb.system.outputs.write_outputs": 0.9,
    },
    "the time loop": {"flexmb.step.newmark.loop.advance": 26.5},
    "the explicit time loop": {"flexmb.step.runge_kutta.advance_explicit": 10.9},
    "the time loop of Radau's method": {"flexmb.step.radau.method.advance_radau": 30.0},
    "the staggered time loop": {
        "flexmb.study.nine_bar.staggered.loop.begin_elastic": 12.8,
        "flexmb.study.nine_bar.staggered.loop.whole_motion": 0.9,
        "flexmb.study.nine_bar.staggered.loop.write_whole": 0.4,
        "flexmb.study.nine_bar.staggered.loop.advance_staggered": 14.6,
    },
    "the loop of exponents": {
        "flexmb.sensitivity.linearise.linearise": 4.4,
        "flexmb.sensitivity.linearise.follow_histories": 4.0,
        "flexmb.sensitivity.tangent_step.advance_with": 10.9,
    },
}
"""Functions that are compiled one soon after the other, with processor time [s]; small ones stand for others, too."""

ONE_BY_ONE = 4.5
"""How much longer it takes with a numba for which there are no pieces (`flexmb/compiled/pieces.py`)."""
