"""The worked example of docs/own_constraint.md runs as it stands; its reactions, moments and powers are right."""

import importlib.util
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import KernelError

PAGE = Path(__file__).resolve().parents[2] / "docs" / "own_constraint.md"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The module of the page's code, in a file of its own, as a user would have it."""
    text = PAGE.read_text(encoding="utf-8")
    path = tmp_path_factory.mktemp("own") / "crossed_belt.py"
    path.write_text(text.partition("```python\n")[2].partition("```")[0], encoding="utf-8")
    spec = importlib.util.spec_from_file_location("crossed_belt", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["crossed_belt"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["crossed_belt"]


def test_the_example_says_what_the_page_says(page):
    sol = page.sol
    assert sol.ok, sol.status
    assert sol["two.omega"].values[-1] == pytest.approx(-4.0, abs=1e-12)
    assert sol["motor.torque"].values[-1] == pytest.approx(-1.2, abs=1e-9)
    assert sol["belt.two_moment"].values[-1] == pytest.approx(3.0, abs=1e-9)
    assert sol["belt.one_moment"].values[1:] == pytest.approx(3.0 * 0.02 / 0.05, abs=1e-9)
    assert sol["belt.two_power"].values[1:] == pytest.approx(-12.0, abs=1e-8)
    assert sol["belt.one_power"].values + sol["belt.two_power"].values == pytest.approx(0.0, abs=1e-9)
    assert sol.units("belt.one_moment") == "N m"


def test_it_is_the_belt_of_the_library(page):
    """All signals of both agree to the last digits."""
    own = page.sol
    ours = fm.simulate(
        page.drive.with_part(fm.couplings.Belt("belt", page.one, page.two, radii=(0.02, 0.05), crossed=True)), t_end=1.0
    )
    assert own["belt.two_moment"].values == pytest.approx(ours["belt.second_torque"].values, abs=1e-9)
    assert own["belt.two_power"].values == pytest.approx(ours["belt.power"].values, abs=1e-9)


@fm.kernels.constraint_kernel
def circle(p, t, q, v, lam, g, G, g_t, gamma, H):
    """A point of the plane stays on a circle about the origin; q = (x, y)."""
    (radius,) = p
    g[0] = 0.5 * (q[0] * q[0] + q[1] * q[1] - radius * radius)
    G[0, 0], G[0, 1] = q[0], q[1]
    gamma[0] = -v[0] * v[0] - v[1] * v[1]
    H[0, 0] = H[1, 1] = lam[0]


@dataclass(frozen=True)
class OnCircle(fm.Part):
    """A body whose centre stays on a circle about the origin."""

    body: fm.Part
    radius: float
    rate: str = ""

    def contributions(self, mechanism):
        coordinates = ((self.body.name, "", 0), (self.body.name, "", 1))
        more = {"reactions": (fm.model.Reaction("power", "W", rate=self.rate),)} if self.rate else {}
        return [fm.model.ConstraintContribution(self.name, circle, coordinates, (self.radius,), 1, **more)]


def ring(**more):
    bead = fm.RigidBody("bead", at=(0.5, 0.0), mass=2.0, inertia=0.1, velocity=(0.0, 3.0, 0.0))
    return fm.Mechanism("ring", [bead, OnCircle("ring", bead, 0.5, **more)])


def test_forces_of_a_curved_constraint():
    """A bead runs around: m v^2/r towards the centre at every instant, without power, though G turns."""
    fm.testing.check_part(ring(), "ring")
    sol = fm.simulate(ring(), t_end=1.0, step=fm.Adaptive(rtol=1e-7))
    angle = 3.0 / 0.5 * sol.time
    force = 2.0 * 9.0 / 0.5
    late = sol.time > 0.02
    assert sol["ring.bead_fx"].values[late] == pytest.approx(-force * np.cos(angle)[late], abs=1e-3 * force)
    assert sol["ring.bead_fy"].values[late] == pytest.approx(-force * np.sin(angle)[late], abs=1e-3 * force)
    assert np.abs(sol["ring.bead_power"].values).max() < 1e-3 * force * 3.0
    assert math.hypot(sol["bead.x"].values[-1], sol["bead.y"].values[-1]) == pytest.approx(0.5, abs=1e-10)


def test_a_rate_that_is_no_signal_is_refused():
    with pytest.raises(KernelError, match=r"Part 'ring': reaction 'power' has the rate 'speed', which is no signal"):
        fm.simulate(ring(rate="speed"), t_end=0.1)
