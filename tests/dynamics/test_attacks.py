"""What a demanding user tries: strong contraction, spectra in contact, idle and wrong arguments."""

import warnings

import mechanisms
import numpy as np
import pytest
import systems

import flexmb as fm
from flexmb.dynamics.lyapunov import Schedule, TangentVectors, growth_to_next_point
from flexmb.dynamics.systems.dynamics import orthonormalise
from flexmb.errors import InputError


def stiff(rate=150.0):
    """x' = -rate x + cos t, y' = -y: exponents -1 and -rate, which is e^-942 in a period."""

    def rates(t, x):
        return [-rate * x[0] + np.cos(t), -x[1]]

    return fm.chaos.ODE(rates, [1.0, 1.0], period=systems.TURN, method="Radau", rtol=1e-5, atol=1e-8)


@pytest.mark.slow
def test_contraction_beyond_all_numbers_in_a_period_is_measured():
    found = fm.lyapunov(stiff(), periods=50, count=2, confirm=False)  # a second run takes minutes
    assert found.ok, found.status
    assert found.spectrum == pytest.approx([-1.0, -150.0], rel=2e-3)


def test_lengths_whose_squares_are_no_numbers():
    W = np.array([[3e200, 1.0], [4e200, 1e-200], [7.0, 7.0]])
    lengths = orthonormalise(W, np.array([1.0, 1.0, 0.0]))
    # the second column is (1, 1e-200), less its part along (0.6, 0.8): 0.8 is left
    assert lengths == pytest.approx([5e200, 0.8])
    V = np.array([[3e-200], [4e-200]])
    assert orthonormalise(V, np.ones(2)) == pytest.approx([5e-200])
    assert V[:, 0] == pytest.approx([0.6, 0.8])


def test_directions_that_one_iteration_mixes_up_are_a_status():
    mixed = fm.chaos.Map(lambda x: [0.5 * x[0], 1e-30 * x[1]], [0.3, 0.1], jacobian=lambda x: np.diag([0.5, 1e-30]))
    found = fm.lyapunov(mixed, periods=60, count=2)
    assert not found.ok
    assert "fewer exponents" in found.status
    assert fm.lyapunov(mixed, periods=60).value == pytest.approx(np.log(0.5))


def worn(rpm):
    return fm.mechanisms.slider_crank(systems.TURN * rpm / 60.0, clearance=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    "make", [lambda: worn(1000.0), lambda: worn(5000.0), lambda: fm.mechanisms.four_bar(clearance=5e-4)]
)
def test_whole_spectrum_of_a_mechanism_in_contact(make):
    """One period shrinks the last direction by e^-50 to e^-120; what contacts note of it must not outgrow it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = fm.lyapunov(make(), skip=5, periods=50, count=4)
        one = fm.lyapunov(make(), skip=5, periods=50)
    assert found.ok, found.status
    assert np.isfinite(found.history).all()
    assert (np.diff(found.spectrum) < 0.0).all()
    assert found.sum < 0.0
    # chaotic: both runs are other parts of one motion
    assert found.value == pytest.approx(one.value, rel=0.4)


def test_what_contacts_only_note_is_known():
    flow = fm.chaos.MechanismFlow(worn(3000.0))
    n = flow.program.n_q
    assert list(flow.records - 2 * n) == [1, 8, 9, 10, 11, 12, 13]
    strobe = fm.chaos.StroboscopicMap(flow)
    assert (strobe.records == flow.records).all()
    flow.advance(0.02)
    kept, other = flow.snapshot(), flow.copy()
    here = kept[0]
    flow.advance(0.004)
    for z in flow.records - 2 * n:
        other.run.flow.z[z] += 1.0 if z > 1 else 1e-5
    other.advance(0.004)
    assert (other.state()[: 2 * n] == flow.state()[: 2 * n]).all()  # the motion does not depend on it
    assert len(here) > 0


def test_a_snapshot_of_other_parameters_is_refused():
    """It would go on with forces and energies of another mechanism."""
    flow, other = fm.chaos.MechanismFlow(worn(3000.0)), fm.chaos.MechanismFlow(worn(3000.0))
    flow.advance(0.002)
    other.reset(parameters={"B.clearance": 2e-4})
    with pytest.raises(InputError, match=r"'B.clearance': 0.0002.*reset\(state, parameters"):
        other.restore(flow.snapshot())
    other.reset(parameters={"B.clearance": 5e-4})
    later = other.snapshot()
    other.advance(0.002)
    other.restore(later)
    assert other.time == 0.0


@pytest.mark.slow
def test_a_hard_look_is_divided_and_others_are_not():
    plan = Schedule(stiff(), systems.TURN, 0, 50)
    logs = growth_to_next_point(plan, TangentVectors(plan.system.tangent_basis(2, 0), np.ones(2)), 1)
    assert np.isfinite(logs).all()
    assert logs.sum() == pytest.approx(-151.0 * systems.TURN, rel=2e-3)
    assert plan.system.time == pytest.approx(systems.TURN)


def driven():
    return fm.chaos.ODE(lambda t, x: [x[1], -x[0] - 0.1 * x[1] + np.cos(t)], [1.0, 0.0], period=systems.TURN)


def tent():
    return fm.chaos.Map(lambda x, a: a * np.minimum(x, 1.0 - x), [0.3], parameters={"a": 1.5})


@pytest.mark.parametrize("tool", [fm.lyapunov, fm.chaos.benettin])
@pytest.mark.parametrize(
    ("make", "given", "words"),
    [
        (tent, {"periods": 100, "period": 3.0}, "period= belongs to a flow"),
        (lambda: fm.chaos.StroboscopicMap(driven()), {"periods": 60, "period": 3.0}, "period= belongs to a flow"),
        (driven, {"periods": 60, "interval": 0.1}, "interval= goes with duration="),
        (driven, {"duration": 60.0, "period": 1.0}, "period= goes with periods="),
        (tent, {"periods": 100, "seed": -1}, "seed is -1"),
        (tent, {"periods": 100, "seed": None}, "seed is None"),
    ],
)
def test_arguments_without_influence_are_refused(tool, make, given, words):
    with pytest.raises(InputError, match=words):
        tool(make(), **given)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: fm.chaos.ODE(3, [1.0]), "function is 3"),
        (lambda: fm.chaos.Map(3, [1.0]), "function is 3"),
        (lambda: fm.chaos.ODE(lambda t, x: -x, [1.0], jacobian=3), "jacobian is 3"),
        (lambda: fm.chaos.ODE(lambda t, x: -x, [1.0], names=5), "names is 5"),
        (lambda: fm.chaos.ODE(lambda t, x: -x, [1.0], names="x"), "names is 'x'"),
        (lambda: fm.chaos.ODE(lambda t, x: -x, [1.0, 2.0], names=["x", "x"]), "no name twice"),
        (lambda: fm.chaos.ODE(lambda t, x: -x, [1.0], parameters=["a"]), "must be a dictionary"),
        (lambda: tent().reset(parameters=["a"]), "must be a dictionary"),
        (lambda: tent().advance(1, np.ones((2, 1))), r"float64 array \(1, k\)"),
        (lambda: driven().advance(1.0, np.ones(2)), r"float64 array \(2, k\)"),
        (lambda: driven().advance(1.0, np.full((2, 1), np.inf)), "not finite"),
        (
            lambda: fm.chaos.Map(lambda x: x / 2, [1.0], jacobian=lambda x: [[1, 2]]).advance(1, np.ones((1, 1))),
            "jacobian has",
        ),
        (lambda: fm.chaos.periodic_orbit(driven(), autonomous="yes"), "True or False"),
        (lambda: fm.chaos.judge(np.zeros((50, 1)), ["x"], exponent="a"), "exponent is 'a'"),
        (lambda: fm.chaos.judge(np.zeros((50, 1)), ["x"], sizes=["a"]), "must be a number"),
        (lambda: fm.chaos.judge(1j * np.ones((50, 1)), ["x"]), "no table of numbers"),
        (lambda: fm.chaos.rosenstein(1j * np.ones(500)), "no list of numbers"),
        (lambda: fm.chaos.zero_one_test(1e300 * np.sin(np.arange(500.0))), "Give another unit"),
        (lambda: fm.chaos.embedding(1e-310 * np.sin(np.arange(500.0))), "Give another unit"),
        (lambda: fm.sweeps.load_sweep(3), "the path is 3"),
    ],
)
def test_wrong_arguments_are_named(make, words):
    with pytest.raises(InputError, match=words):
        make()


def test_a_map_that_divides_by_zero_ends_with_a_status():
    falling = fm.chaos.Map(lambda x: [x[0] - 1.0 if 1.0 / float(x[0]) else 0.0], [3.0])
    assert not falling.advance(10)
    assert "not finite" in falling.status
    assert not falling.advance(1)


def test_an_ode_tells_its_period_to_orbits():
    orbit = fm.chaos.periodic_orbit(driven())
    assert orbit.ok, orbit.status
    assert orbit.period == pytest.approx(systems.TURN)
    assert orbit.state == pytest.approx([0.0, 10.0], abs=1e-6)  # x = 10 sin t


def wall(phase):
    """A mass between impacts with a wall that moves as 0.1 cos(t + phase)."""
    return fm.chaos.ImpactODE(
        fm.chaos.ODE(lambda t, x: [x[1], -1.0], [0.5, 0.0], period=systems.TURN),
        gap=lambda t, x: x[0] - 0.1 * np.cos(t + phase),
        jump=lambda t, x: [x[0], -0.8 * x[1] - 1.8 * 0.1 * np.sin(t + phase)],
    )


def test_tangent_of_an_impact_does_not_depend_on_how_late_it_is():
    late, T = wall(0.0), np.eye(2)
    T_late, later = np.eye(2), 40000 * systems.TURN
    early = wall(0.0)
    assert early.advance(1.5, T)
    late.reset(np.array([0.5, 0.0]), time=later)
    assert late.advance(1.5, T_late)
    np.testing.assert_allclose(T_late, T, rtol=1e-5, atol=1e-6)


def test_carried_tangents_give_the_orbit_of_a_mechanism():
    found = {
        tangent: fm.chaos.periodic_orbit(mechanisms.rod_flow(push=0.3, damping=0.5), tangent=tangent)
        for tangent in ("carried", "differences")
    }
    assert all(orbit.ok for orbit in found.values())
    np.testing.assert_allclose(found["carried"].state[:4], found["differences"].state[:4], atol=1e-7)
    multipliers = found["carried"].multipliers
    np.testing.assert_allclose(multipliers, found["differences"].multipliers, atol=1e-6)
    # Liouville: the product of both is that of the mean divergence
    assert abs(np.prod(multipliers)) == pytest.approx(np.exp(-0.5 * systems.TURN), rel=1e-3)


@pytest.mark.slow
def test_two_trajectories_in_contact_stay_closer_than_its_depth():
    """At 5000 rpm the exponent is 467 +/- 20 by tangents over 360 periods; from 2.6e-7 m apart 356 +/- 7 came out."""
    mechanism = worn(5000.0)
    pair = fm.chaos.benettin(mechanism, skip=20, periods=100, step=1e-6)
    tangent = fm.lyapunov(mechanism, skip=20, periods=100, step=1e-6)
    assert pair.ok
    assert tangent.ok
    assert pair.value == pytest.approx(467.0, abs=75.0)
    assert tangent.value == pytest.approx(467.0, abs=75.0)


def test_crossings_are_located_within_fixed_steps():
    flow = mechanisms.rod_flow()
    section = fm.chaos.SectionMap(flow, "rod.omega", direction="down")
    place = flow.names.index("rod.omega")
    for _ in range(3):
        assert section.advance(1), section.status
        assert abs(flow.observe()[place]) < 1e-9


@pytest.mark.slow
def test_two_trajectories_that_approach_in_lasting_contact():
    """A ball at rest on a damped spring: damping/(2 mass) = 150 1/s; histories that do not shrink were blown up."""
    ball = fm.RigidBody("ball", (0.0, 0.05), 1.0, 1e-3)
    guide = fm.Prismatic("guide", fm.GROUND, ball, at=(0.0, 0.05), along=(0.0, 1.0))
    floor = fm.Stop("floor", joint="guide", below=-0.05, normal=fm.KelvinVoigt(1e5, 300.0))
    mechanism = fm.Mechanism("ball", [ball, guide, floor], gravity=(0.0, -9.81))
    found = fm.chaos.benettin(mechanism, period=0.02, periods=60, skip=20, step=1e-5)
    assert found.ok, found.status
    assert found.value == pytest.approx(-150.0, rel=0.02)
