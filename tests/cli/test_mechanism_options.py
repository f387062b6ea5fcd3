"""Options from the signature of a function."""

import argparse
import inspect
from typing import Annotated

import pytest

from flexmb.cli.arguments.parser import add_options, keywords_of, options_of
from flexmb.cli.arguments.source import find, ready
from flexmb.errors import InputError
from flexmb.mechanisms import nine_bar


def maker(
    speed: Annotated[float, "rad/s"],
    *,
    clearance: Annotated[float | None, "m"] = None,
    flexible: bool = False,
    elements: int = 4,
    start: Annotated[tuple[float, float], "rad"] = (0.0, 1.0),
    friction: "str | None" = "coulomb",
    material: object = None,
    bare=0.5,
    **rest,
):
    """A mechanism.

    Parameters
    ----------
    speed : of the crank; may be < 0.
    clearance : play; None: none.
    start : angles, each in [0, 1]
        of both cranks.
    bare : share.
    material : of the links.
    """
    return locals()


def parsed(*arguments):
    parser = argparse.ArgumentParser()
    options = add_options(parser, maker, "options")
    return keywords_of(parser.parse_args(arguments), options)


def test_kinds_and_units():
    found = {o.name: (o.kind, o.unit) for o in options_of(maker)}
    assert found == {
        "speed": ("number", "rad/s"),
        "clearance": ("number", "m"),
        "flexible": ("flag", ""),
        "elements": ("count", ""),
        "start": ("numbers", "rad"),
        "friction": ("text", ""),
        "bare": ("number", ""),
    }


def test_help_has_the_units():
    texts = {o.name: o.help for o in options_of(maker)}
    assert texts["speed"] == "of the crank [rad/s]; may be < 0."
    assert texts["start"] == "angles, each in [0, 1] of both cranks [rad]."
    assert texts["bare"] == "share."


def test_what_is_not_typed_is_not_passed_on():
    assert parsed("--speed", "2") == {"speed": 2.0}


def test_values():
    typed = "--speed 60rpm --clearance 0.5mm --flexible --elements 6 --start 0,90deg --friction none --bare 0.25"
    found = parsed(*typed.split())
    assert found.pop("speed") == pytest.approx(6.283185307179586, rel=1e-15)
    assert found.pop("start") == pytest.approx((0.0, 1.5707963267948966))
    assert found == {"clearance": 5e-4, "flexible": True, "elements": 6, "friction": None, "bare": 0.25}
    assert parsed("--speed", "1", "--no-flexible", "--clearance", "none") == {
        "speed": 1.0,
        "flexible": False,
        "clearance": None,
    }


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        ("--elements 2.5", "--elements: '2.5' is no whole number"),
        ("--clearance 3rpm", "--clearance.*is an angular speed"),
    ],
)
def test_wrong_values(typed, message):
    with pytest.raises(InputError, match=message):
        parsed("--speed", "1", *typed.split())


def test_required_options(capsys):
    with pytest.raises(SystemExit):
        parsed()
    assert "--speed" in capsys.readouterr().err


@pytest.mark.parametrize("name", list(ready()))
def test_every_ready_mechanism_says_what_its_options_are(name):
    options = options_of(find(name).make)
    assert options
    assert not [o.name for o in options if not o.help]
    units = {o.name: o.unit for o in options}
    if name in {"nine-bar", "slider-crank", "four-bar"}:  # the others have no crank at a given speed, and no play
        assert units["speed"] == "rad/s"
        assert units["clearance"] == "m"


@pytest.mark.parametrize("name", list(ready()))
def test_no_number_of_a_ready_mechanism_is_left_out(name):
    parameters = inspect.signature(find(name).make).parameters
    offered = {o.name for o in options_of(find(name).make)}
    assert set(parameters) - offered <= {"data", "material"}


def test_the_nine_bar_takes_a_folder_of_meshes():
    """`flexmb run nine-bar --mesh meshes`."""
    (option,) = (option for option in options_of(nine_bar) if option.name == "mesh")
    assert (option.flag, option.kind, option.value("meshes"), option.value("none")) == (
        "--mesh",
        "text",
        "meshes",
        None,
    )
