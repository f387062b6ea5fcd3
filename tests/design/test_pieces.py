"""Fits of records in pieces, each with a start of its own; starts of searches."""

import numpy as np
import pytest
import xarray as xr

import flexmb as fm
from flexmb.errors import InputError, SolveError

STARTS = [(0.3, 0.0), (-1.0, 2.0), (-2.5, -1.0)]
NOISE = 1e-4


def pendulum(angle: float, rate: float, inertia: float, drag: float) -> fm.Mechanism:
    """A bar of 0.3 m whose start is given; angles count from the x axis."""
    x, y = 0.15 * np.cos(angle), 0.15 * np.sin(angle)
    bar = fm.RigidBody("bar", (x, y), 1.0, inertia, velocity=(-rate * y, rate * x, rate))
    damper = fm.loads.TorsionSpring("damper", fm.GROUND, bar, stiffness=0.0, damping=drag)
    return fm.Mechanism("pendulum", [bar, fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0)), damper], (0.0, -9.81))


def double(angle1: float, angle2: float, rate1: float, rate2: float, inertia: float, mass: float) -> fm.Mechanism:
    """Two bars of 0.3 m from a start that is given."""
    elbow = np.array([0.3 * np.cos(angle1), 0.3 * np.sin(angle1)])
    arm = 0.15 * np.array([np.cos(angle2), np.sin(angle2)])
    at = elbow + arm
    moved = rate1 * np.array([-elbow[1], elbow[0]]) + rate2 * np.array([-arm[1], arm[0]])
    middle = 0.5 * elbow
    upper = fm.RigidBody("upper", middle.tolist(), 1.0, 0.01, velocity=(-rate1 * middle[1], rate1 * middle[0], rate1))
    lower = fm.RigidBody("lower", at.tolist(), mass, inertia, velocity=(*moved.tolist(), rate2))
    pins = [fm.Revolute("O", fm.GROUND, upper, at=(0.0, 0.0)), fm.Revolute("E", upper, lower, at=elbow.tolist())]
    return fm.Mechanism("double pendulum", [upper, lower, *pins], (0.0, -9.81))


@pytest.fixture(scope="module")
def record():
    """Three swings, one behind the other, with noise."""
    rng, t, found = np.random.default_rng(2), np.linspace(0.0, 1.0, 101), []
    for start in STARTS:
        sol = fm.simulate(pendulum(*start, 0.02, 0.01), t_end=1.0, save=t.tolist(), signals=["bar.x", "bar.y"])
        found.append(np.array([sol["bar.x"], sol["bar.y"]]) + NOISE * rng.standard_normal((2, 101)))
    x, y = np.concatenate(found, axis=1)
    times = np.concatenate([t + 1.01 * k for k in range(3)])
    return xr.Dataset({"bar.x": ("time", x), "bar.y": ("time", y)}, {"time": times})


BOUNDS = {"angle": (-3.1, 1.0), "rate": (-4.0, 4.0), "inertia": (0.005, 0.1), "drag": (0.001, 0.1)}
GIVEN = {"signals": ["bar.x", "bar.y"], "noise": NOISE, "pieces": [1.01, 2.02], "free": ["angle", "rate"]}


@pytest.mark.slow
def test_pieces_share_parameters_and_have_starts_of_their_own(record):
    guess = {"inertia": 0.03, "drag": 0.02, "angle": [0.0, -0.8, -2.2], "rate": 0.0}
    found = fm.design.fit(pendulum, BOUNDS, record, start=guess, **GIVEN)
    known = {"inertia": 0.02, "drag": 0.01}
    known |= {f"{name}[{i}]": STARTS[i][k] for i in range(3) for k, name in enumerate(("angle", "rate"))}
    assert set(found.parameters) == set(known)
    for name, value in known.items():
        assert abs(found.parameters[name] - value) < 3.5 * found.errors[name], name
    assert 0.9 < found.rms < 1.1
    assert found.errors["inertia"] < 1e-5


@pytest.mark.slow
def test_a_chaotic_record_is_fitted_in_pieces():
    """A double pendulum over 3 s; within 6 s a small difference grows by more than 1/rtol."""
    begun = {"angle1": 1.5, "angle2": 1.0, "rate1": 0.0, "rate2": 0.0, "inertia": 0.012, "mass": 0.8}
    with pytest.raises(SolveError, match="a small difference grew"):
        fm.design.sensitivity(double, begun, of=["upper.theta"], t_end=6.0, save=10)
    wanted, t = ["upper.theta", "lower.theta"], np.linspace(0.0, 3.0, 301)
    signals = [*wanted, "upper.omega", "lower.omega"]
    sol = fm.simulate(double(**begun), t_end=3.0, save=t.tolist(), signals=signals)
    assert sol.ok
    upper, lower, rate1, rate2 = (np.asarray(sol[name]) for name in signals)
    noise = 1e-3 * np.random.default_rng(3).standard_normal((2, 301))
    # angles of a body count from its start, so a piece is compared from its first sample on
    cuts = np.arange(0, 300, 60)
    parts = [np.array([x[k : k + 60] - x[k] for k in cuts]).ravel() for x in (upper, lower)]
    data = xr.Dataset(
        {name: ("time", x + e[:300]) for name, x, e in zip(wanted, parts, noise, strict=True)}, {"time": t[:300]}
    )
    at = [(1.5 + upper)[cuts] + 0.01, (1.0 + lower)[cuts] - 0.01, rate1[cuts] + 0.05, rate2[cuts] - 0.05]
    names = ["angle1", "angle2", "rate1", "rate2"]
    bounds = {name: (float(x.min()) - 1.0, float(x.max()) + 1.0) for name, x in zip(names, at, strict=True)}
    found = fm.design.fit(
        double,
        {**bounds, "inertia": (0.002, 0.05), "mass": (0.2, 3.0)},
        data,
        signals=wanted,
        noise=1e-3,
        pieces=t[cuts[1:]].tolist(),
        free=names,
        start={"inertia": 0.015, "mass": 1.0, **{name: x.tolist() for name, x in zip(names, at, strict=True)}},
    )
    assert 0.9 < found.rms < 1.1
    for name, value in {"inertia": 0.012, "mass": 0.8}.items():
        assert abs(found.parameters[name] - value) < 3.5 * found.errors[name], name
        assert found.errors[name] < 0.02 * value


@pytest.mark.parametrize(
    ("more", "text"),
    [
        ({"free": ["angle"], "pieces": []}, "one piece alone"),
        ({"free": ["angel"]}, "angle"),
        ({"pieces": [2.02, 1.01]}, "increasing times"),
        ({"pieces": [3.02]}, "two instants in each"),
        ({"start": {"drag": 1.0}}, "within its bounds"),
        ({"start": {"angle": [0.0, 0.0]}}, "one for each of 3 pieces"),
        ({"start": {"drag": [0.01, 0.01, 0.01]}}, "a parameter that is free"),
        ({"start": {"dragg": 0.01}}, "drag"),
    ],
)
def test_odd_pieces_and_starts_are_refused(record, more, text):
    with pytest.raises(InputError, match=text):
        fm.design.fit(pendulum, BOUNDS, record, **GIVEN | more)
