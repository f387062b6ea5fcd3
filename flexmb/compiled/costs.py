"""Processor time of compiling the large functions, measured by `python tests/speed/compile.py --costs`."""

REFERENCE_PACE = 0.0125
"""Time of the measure of pace on the machine of these costs [s] (`notice.pace`)."""

FIRST_STAGE = "the equations of motion"
"""Stage of kernels and other small functions."""

STAGES: dict[str, dict[str, float]] = {
    FIRST_STAGE: {
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
        "flexmb.energy.balance.update_balance": 1.5,
        "flexmb.system.outputs.write_outputs": 0.9,
    },
    "what saves many instants within a step": {"flexmb.step.saved_instants.save_instants": 5.0},
    "the time loop": {"flexmb.step.newmark.loop.advance": 26.5},
    "the explicit time loop": {"flexmb.step.runge_kutta.advance_explicit": 10.9},
    "the time loop of Radau's method": {"flexmb.step.radau.method.advance_radau": 30.0},
    "the loop of exponents": {
        "flexmb.sensitivity.linearise.linearise": 4.4,
        "flexmb.sensitivity.linearise.advance_histories": 4.0,
        "flexmb.sensitivity.tangent_step.advance_with_tangents": 10.9,
    },
}
"""Processor time of compiling large functions [s], by stage; small functions represent others, too."""

UNPIECED_FACTOR = 4.5
"""Factor of the time with a version of numba without pieces (`flexmb/compiled/pieces.py`)."""
