"""Models, parameters, measures and ends of runs that are not as they should be, and those that only look so."""

from typing import Any, Optional

import pytest

import flexmb as fm
from flexmb.design.parameters import ParameterModel
from flexmb.errors import FlexmbError, InputError, ModelError


def falling(gravity: Any = 9.81) -> fm.Mechanism:
    body = fm.RigidBody("body", (0.0, 0.0), 1.0, 1.0)
    return fm.Mechanism("falling", [body], (0.0, -gravity))


def by_place(gravity, /):
    return falling(gravity)


def of_any(*gravity):
    return falling(*gravity)


def of_two(gravity, mass):
    return falling(gravity * mass)


def tabled(gravity):
    return {}[gravity]


def nothing(gravity):
    return None


@pytest.mark.parametrize(
    ("model", "parameters", "message"),
    [
        (falling, 3, "list of names"),
        (falling, None, "list of names"),
        (falling, "gravity", "list of names"),
        (falling, [["gravity"]], "names such as"),
        (falling, ["gravity", "gravity"], "each of them once"),
        (dict, ["gravity"], "no known arguments"),
        (by_place, {"gravity": 9.81}, "positional-only"),
        (of_any, {"gravity": 9.81}, "unexpected keyword"),
        (of_two, {"gravity": 9.81}, "'mass'"),
        (tabled, {"gravity": 9.81}, "failed at .*KeyError: 9.81"),
        (nothing, {"gravity": 9.81}, "returned NoneType"),
    ],
)
def test_models_that_cannot_be_called_are_refused_in_words(model, parameters, message):
    with pytest.raises(FlexmbError, match=message):
        fm.design.sensitivity(model, parameters, of=["body.y"], t_end=0.1)


def optional(gravity: Optional[float] = 9.81) -> fm.Mechanism:  # noqa: UP045 - as users write it
    return falling(gravity)


def unclear(gravity: "a number" = 9.81) -> fm.Mechanism:  # noqa: F722 - as users write it
    return falling(gravity)


@pytest.mark.parametrize("model", [falling, optional, unclear])
def test_arguments_of_other_declared_kinds_are_numbers(model):
    assert ParameterModel("test", model, ["gravity"]).values == (9.81,)


def whole(gravity: int = 10) -> fm.Mechanism:
    return falling(gravity)


def test_arguments_that_are_declared_whole_are_refused():
    with pytest.raises(InputError, match="'gravity' is int"):
        ParameterModel("test", whole, ["gravity"])


def test_an_error_of_a_model_keeps_its_cause():
    with pytest.raises(ModelError) as caught:
        ParameterModel("test", tabled, {"gravity": 9.81}).at([9.81])
    assert isinstance(caught.value.__cause__, KeyError)


def test_an_end_of_zero_is_told_as_such():
    with pytest.raises(InputError, match="t_end is 0"):
        fm.design.sensitivity(falling, ["gravity"], of=["body.y"], t_end=0.0)


@pytest.mark.parametrize("signal", [3, ["body.y"], None])
def test_measures_of_what_is_no_name_are_refused(signal):
    with pytest.raises(InputError, match="name of one"):
        fm.design.mean(signal)
