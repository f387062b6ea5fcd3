"""Tornado: relative derivatives of each measure in a panel of its own, the largest on top."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError


def pushed(mass: float = 2.0, force: float = 1.0) -> fm.Mechanism:
    body = fm.RigidBody("body", (0.0, 0.0), mass, 1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(1.0, 0.0))
    return fm.Mechanism("pushed", [body, guide, fm.Force("push", body, at=(0.0, 0.0), force=(force, 0.0))])


@pytest.fixture(scope="module")
def found():
    return fm.design.sensitivity(pushed, {"mass": 2.0, "force": 1.0}, of=["body.x"], t_end=1.0, save=4)


def test_bars_are_relative_derivatives(found):
    """x = F t^2 / (2 m): 1 % of the mass takes 1 % of the value at the end, 1 % of the force adds 1 %."""
    figure = fm.plots.plot_tornado(found, "end of body.x")
    (ax,) = figure.axes
    bars = [bar.get_width() for bar in ax.patches]
    assert np.sort(bars) == pytest.approx([-1.0, 1.0], rel=1e-6)
    assert {text.get_text() for text in ax.get_yticklabels()} == {"mass", "force"}


def test_each_measure_has_a_panel(found):
    figure = fm.plots.plot_tornado(found, "body.x")
    assert [ax.get_title() for ax in figure.axes] == ["mean", "rms", "peak", "end"]


def test_other_signals_and_objects_are_refused(found):
    with pytest.raises(InputError, match=r"body\.y.*has no measures"):
        fm.plots.plot_tornado(found, "body.y")
    with pytest.raises(InputError, match="result of"):
        fm.plots.plot_tornado(3.0, "body.x")
