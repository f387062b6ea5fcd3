"""Methods of integration in derivatives: those of the Newmark family carry them, all others are refused in words."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from test_fit import GOOD, moved, oscillator

import flexmb as fm
from flexmb.engine.step.method import Method
from flexmb.errors import InputError

BOUNDS = {"rate": (60.0, 120.0), "damping": (0.1, 2.0)}


@dataclass(frozen=True)
class Own(Method):
    """A method of a user."""

    def stepper(self, program: Any, mechanism: Any = None) -> Any:
        return fm.RadauIIA().stepper(program)


@dataclass(frozen=True)
class OwnSteps(fm.Newmark):
    """A Newmark method with steps of a user, which carry no derivatives."""

    def stepper(self, program: Any, mechanism: Any = None) -> Any:
        return fm.RadauIIA().stepper(program)


def sensitivity(**how: Any) -> Any:
    return fm.design.sensitivity(oscillator, {"rate": 90.0, "damping": 0.7}, of=["body.x"], t_end=1.0, **how)


def fit(**how: Any) -> Any:
    return fm.design.fit(oscillator, BOUNDS, GOOD, signals=["body.x"], **how)


def optimise(**how: Any) -> Any:
    return fm.design.optimise(oscillator, BOUNDS, objective=fm.design.rms("body.x"), t_end=1.0, **how)


@pytest.mark.parametrize("step", [None, 1e-3])
@pytest.mark.parametrize("method", [fm.RadauIIA(), fm.RungeKutta4(), Own(), OwnSteps(), "newmark"])
@pytest.mark.parametrize("asked", [sensitivity, fit, optimise])
def test_other_methods_are_refused_with_what_to_use(asked: Callable[..., Any], method: Any, step: Any):
    """The same answer with each step: no advice on steps leads into the next refusal."""
    with pytest.raises(InputError) as caught:
        asked(method=method, step=step)
    assert f"{asked.__name__}: method is {method!r}; only the steps of Newmark(...) itself" in str(caught.value)
    assert "give Newmark.generalised_alpha()" in str(caught.value)


@pytest.mark.quick(1)
@pytest.mark.parametrize("step", [fm.Adaptive(rtol=1e-7), 5e-4])
@pytest.mark.parametrize(
    "method",
    [
        fm.Newmark.trapezoidal(),
        fm.Newmark.hht(),
        fm.Newmark.wbz(),
        fm.Newmark.generalised_alpha(),
        fm.Newmark.generalised_alpha(constraints="position"),
        fm.Newmark.generalised_alpha(constraints="velocity"),
    ],
)
def test_methods_of_the_newmark_family_carry_derivatives(method: fm.Newmark, step: Any):
    """Derivatives of the closed form by central differences, at all saved instants."""
    found = sensitivity(method=method, step=step)
    t, h = found.dataset["time"].values, 1e-3
    for name, (rate, damping) in {"rate": (h, 0.0), "damping": (0.0, h)}.items():
        exact = (moved(t, 90.0 + rate, 0.7 + damping, 0.1) - moved(t, 90.0 - rate, 0.7 - damping, 0.1)) / (2.0 * h)
        error = found["body.x"].sel(parameter=name).values - exact
        assert np.abs(error).max() < 1e-3 * np.abs(exact).max()


def test_tangents_are_refused_of_steps_that_carry_none():
    mechanism = oscillator(90.0, 0.7)
    with pytest.raises(InputError, match="only the steps of Newmark"):
        fm.chaos.MechanismFlow(mechanism, method=OwnSteps(), period=1.0)
