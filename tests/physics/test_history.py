"""History is state: forces can be evaluated at will, rejected steps leave no trace, restarts go on bit for bit."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.newmark.implicit_step import implicit_step
from flexmb.engine.newmark.method import advance
from flexmb.engine.state.record import RUNNING
from flexmb.engine.system.evaluate import evaluate, evaluate_accepted
from flexmb.run.run import Run
from flexmb.statics.start.consistent import consistent_start

MID_IMPACT = 2.45e-4  # [s]; the first contact of the model lasts from 2.27e-4 s to about 2.8e-4 s


@pytest.fixture
def run_in_impact(slider_crank):
    """A run of the slider-crank with play that stands in the middle of its first impact."""
    mechanism = slider_crank()
    program = fm.compile(mechanism)
    run = Run(program, fm.Newmark.generalised_alpha(0.8), fm.FixedStep(1e-6), MID_IMPACT, None)
    run.begin(consistent_start(mechanism, program))
    run.run_to(MID_IMPACT, saving=None)
    contact = program.tables.contacts
    assert run.record.signals[contact.out[0] + 4] > 1e-5  # penetration [m]
    assert run.flow.z[contact.z[0, 1]] > 4.0  # approach speed [m/s]
    return run


def frozen(arrays):
    """Bytes of every array of a record."""
    return {name: array.tobytes() for name, array in arrays.saved().items()}


RESULTS = ("r", "Gl", "g", "gv", "gamma", "lu", "z_new", "contact", "drive", "joint")
"""What an evaluation leaves in its workspace; the rest is scratch space."""


def evaluated(run, h=2e-6):
    """The results of an evaluation with a matrix and one without, at a state a little further on."""
    program, flow, work = run.program, run.flow, run.work
    q = flow.q + h * flow.v
    common = (program.tables, program.addresses, flow.clock.t + h, h)
    evaluate(*common, q, flow.v, flow.a, flow.lam, flow.z, 1.0, 1e6, 1e12, True, work)
    first = {name: getattr(work, name).tobytes() for name in RESULTS}
    still = np.zeros_like(q)
    evaluate_accepted(*common, q, flow.v, flow.a, flow.lam, flow.z, still, still, work)
    later = {name: getattr(work, name).tobytes() for name in RESULTS}
    return first, {**later, "power": work.power.numbers().tobytes()}


def test_forces_evaluated_twice_are_the_same_bits(run_in_impact):
    run = run_in_impact
    before = frozen(run.flow)
    first = evaluated(run)
    assert np.frombuffer(first[0]["contact"]).reshape(1, -1)[0, -2] > 1e3  # a normal force [N] that depends on history
    for _ in range(3):
        assert evaluated(run) == first
    assert frozen(run.flow) == before


def test_an_evaluation_elsewhere_leaves_no_trace(run_in_impact):
    """Far out of the contact and deep in it, forwards and backwards: the next evaluation does not know of it."""
    run = run_in_impact
    first = evaluated(run)
    for h in (1e-3, -1e-4, 1e-9, 0.0):
        evaluated(run, h)
    assert evaluated(run) == first


def step_of(run, h):
    """The code of one step of size h that is tried and not accepted."""
    options = run.options(1.0, 0.0)
    ratio = h / run.flow.clock.last_step
    program = run.program
    return implicit_step(
        program.tables,
        program.addresses,
        run.lu,
        h,
        ratio,
        options.regular,
        options,
        run.flow,
        run.trial,
        run.work,
        run.record,
    )


@pytest.mark.slow
def test_a_step_that_fails_or_is_thrown_away_leaves_no_trace(run_in_impact):
    run = run_in_impact
    before = frozen(run.flow)
    codes = [step_of(run, h) for h in (1e-6, 0.2, 5e-2, 1e-3, 3e-5)]
    assert codes[0] == RUNNING
    assert any(code != RUNNING for code in codes)
    assert frozen(run.flow) == before


@pytest.mark.slow
def test_a_run_goes_on_after_thrown_away_steps_as_if_they_had_not_been(slider_crank, run_in_impact):
    run = run_in_impact
    for h in (0.2, 5e-2, 1e-3, 3e-5):
        step_of(run, h)
    run.run_to(5e-4, saving=None)
    mechanism = slider_crank()
    program = fm.compile(mechanism)
    other = Run(program, run.method, run.step, MID_IMPACT, None)
    other.begin(consistent_start(mechanism, program))
    other.run_to(MID_IMPACT, saving=None)
    other.run_to(5e-4, saving=None)
    assert frozen(run.flow) == frozen(other.flow)


def take_one_step(run):
    """One step of the loop, accepted or rejected; its size when it was accepted, else None."""
    program, before = run.program, run.record.count.steps
    options = run.options(run.t_end, 0.0)
    advance(program.tables, program.addresses, run.lu, options, run.flow, run.trial, run.work, run.record, 1)
    run._fetch_buffer()
    return float(run.record.report.size) if run.record.count.steps > before else None


def test_rejected_steps_of_the_step_control_leave_no_trace(slider_crank):
    """The accepted steps of a controlled run with rejections, taken once more without the rejected ones."""
    mechanism = slider_crank()
    program, method = fm.compile(mechanism), fm.Newmark.generalised_alpha(0.8)
    controlled = Run(program, method, fm.Adaptive(atol=1e-8, max=5e-6), 1e-3, None)
    controlled.begin(consistent_start(mechanism, program))
    sizes, anew = [], []
    while controlled.flow.clock.t < 9e-4:
        sizes.append(take_one_step(controlled))
        anew.append(controlled.flow.clock.last_step == 0.0)  # the next step is a first step, after the end of a contact
    assert sizes.count(None) > 3
    replayed = Run(program, method, fm.FixedStep(1e-3), 1.0, None)
    replayed.begin(consistent_start(mechanism, program))
    for size, again in zip(sizes, anew, strict=True):
        if size is None:
            continue
        replayed.flow.clock.step_size = size
        assert take_one_step(replayed) == size
        if again:
            replayed.flow.clock.last_step, replayed.flow.x[:] = 0.0, replayed.flow.a
    one, other = frozen(controlled.flow), frozen(replayed.flow)
    for name in ("clock", "past", "impacts", "largest_speeds"):  # what the step control remembers
        one.pop(name), other.pop(name)
    assert one == other


# Restart

CASES = {
    "fixed": {"step": fm.FixedStep(1e-6)},
    "adaptive": {"step": fm.Adaptive(rtol=1e-5)},
    "trapezoidal": {"step": fm.FixedStep(1e-6), "method": fm.Newmark.trapezoidal()},
    "rk4": {"step": fm.FixedStep(1e-6), "method": fm.RungeKutta4()},
}


def cut_in_impact(mechanism, options):
    """A run that is stopped by `max_steps` while the journal is in the bearing."""
    whole = fm.simulate(mechanism, t_end=1e-3, save="steps", **options)
    steps = int(np.flatnonzero(whole.time > MID_IMPACT)[0])
    cut = fm.simulate(mechanism, t_end=1e-3, save="steps", max_steps=steps, **options)
    assert not cut.ok
    assert cut.stats.steps == steps
    assert cut.array("C.penetration")[-1] > 1e-5
    return whole, cut


def same_end(one, other):
    assert one.restart.keys() == other.restart.keys()
    for name, array in one.restart.items():
        assert array.tobytes() == other.restart[name].tobytes(), name


@pytest.mark.quick(5)
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("through_file", [False, True])
def test_a_restart_in_mid_impact_goes_on_bit_for_bit(slider_crank, tmp_path, case, through_file):
    options = CASES[case]
    whole, cut = cut_in_impact(slider_crank(), options)
    if through_file:
        cut = fm.load(cut.to_netcdf(tmp_path / "cut.nc"))
    rest = fm.simulate(slider_crank(), t_end=1e-3, save="steps", restart=cut.restart, **options)
    assert rest.ok, rest.status
    same_end(rest, whole)
    later = whole.time > cut.time[-1]
    assert rest.values[-later.sum() :].tobytes() == whole.values[later].tobytes()
    assert cut.stats.steps + rest.stats.steps == whole.stats.steps


def test_a_restart_with_a_grid_of_saved_instants(slider_crank):
    """Instants of the grid are saved once each, in both parts together, with the same bits."""
    options = {"t_end": 1e-3, "save": 777, "step": fm.FixedStep(1e-6)}
    whole = fm.simulate(slider_crank(), **options)
    cut = fm.simulate(slider_crank(), max_steps=245, **options)
    rest = fm.simulate(slider_crank(), restart=cut.restart, **options)
    np.testing.assert_array_equal(np.concatenate([cut.time, rest.time]), whole.time)
    assert np.concatenate([cut.values, rest.values]).tobytes() == whole.values.tobytes()


def test_the_same_input_gives_the_same_bits(slider_crank):
    one, other = (fm.simulate(slider_crank(), t_end=2e-3, save="steps", step=fm.Adaptive(rtol=2e-5)) for _ in range(2))
    assert one.values.tobytes() == other.values.tobytes()
    same_end(one, other)


def test_a_restart_of_another_model_is_refused(slider_crank):
    sol = fm.simulate(slider_crank(), t_end=1e-5, step=1e-6)
    with pytest.raises(fm.errors.InputError, match="restart does not fit this model"):
        fm.simulate(slider_crank(clearance=None), t_end=1e-5, step=1e-6, restart=sol.restart)


def test_a_longer_run_with_another_grid_of_saved_instants(slider_crank):
    """A finished run goes on to a later end: the instants that lie ahead are saved, none is lost."""
    options = {"step": fm.FixedStep(1e-6)}
    first = fm.simulate(slider_crank(), t_end=5e-4, save=100, **options)
    rest = fm.simulate(slider_crank(), t_end=1e-3, save=50, restart=first.restart, **options)
    whole = fm.simulate(slider_crank(), t_end=1e-3, save=50, **options)
    np.testing.assert_allclose(rest.time, whole.time[whole.time > 5e-4 + 1e-9], rtol=1e-12)
    assert rest.restart["q"].tobytes() != first.restart["q"].tobytes()
