"""Numbers with units as they are typed."""

import math

import pytest

from flexmb.errors import InputError
from flexmb.units import NOUNS, UNITS, known_unit, quantity


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.5mm", "m", 5e-4),
        ("0.3mm", "m", 3e-4),  # 0.3 * 1e-3 is another double
        ("0.3 mm", "m", 3e-4),
        ("50um", "m", 5e-5),
        ("50µm", "m", 5e-5),  # the micro sign
        ("50μm", "m", 5e-5),  # the Greek letter
        ("2", "m", 2.0),
        ("2.m", "m", 2.0),
        (".5m", "m", 0.5),
        ("1e-3m", "m", 1e-3),
        ("2pi", "rad/s", 2 * math.pi),
        ("2 pi", "rad/s", 2 * math.pi),
        ("0.5pi", "rad/s", 0.5 * math.pi),
        ("1.5*pi", "rad/s", 1.5 * math.pi),
        ("1.5 * pi", "rad/s", 1.5 * math.pi),
        ("pi", "rad", math.pi),
        ("pi/2", "rad", math.pi / 2),
        ("-pi/2", "rad", -math.pi / 2),
        ("2pi/4", "rad", math.pi / 2),
        ("2pi rad/s", "rad/s", 2 * math.pi),
        ("2pi", "", 2 * math.pi),
        ("3000rpm", "rad/s", 100 * math.pi),
        ("3000 rpm", "rad/s", 100 * math.pi),
        ("360deg/s", "rad/s", 2 * math.pi),
        ("-90deg", "rad", -math.pi / 2),
        ("+2.5", "rad/s", 2.5),
        ("20us", "s", 2e-5),
        ("0.1ms", "s", 1e-4),
        ("2kN", "N", 2000.0),
        ("1.5Nm", "N m", 1.5),
        ("1.5 N*m", "N m", 1.5),
        ("207GPa", "Pa", 207e9),
        ("250g", "kg", 0.25),
        ("3e-4kg m2", "kg m^2", 3e-4),
        ("7850kg/m3", "kg/m^3", 7850.0),
        ("0", "m", 0.0),
        ("1e-300m", "m", 0.0),  # as good as nothing, and it costs nothing
    ],
)
def test_what_is_understood(text, unit, value):
    assert quantity(text, unit, "--x") == value


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        ("0.5 parsec", "m", r"--x: '0.5 parsec': 'parsec' is no unit known here.*Known: m, cm, mm"),
        ("2 pi mm", "m", "pi goes with angles .* it needs a length in m, e.g. 0.5mm"),
        ("2pi", "m", "pi goes with angles"),
        ("2pi rpm", "rad/s", "pi goes with angles .* give 2pi or 2pi rad/s"),
        ("pi deg", "rad", "pi goes with angles"),
        ("0.5mm", "rad/s", "is a length; give an angular speed in rad/s"),
        ("3000rpm", "m", "is an angular speed; give a length in m"),
        ("5s", "m", "is a time; give a length"),
        ("5m", "s", "is a length; give a time in s"),
        ("5mm", "", "is a length; give a number without unit"),
        ("5furlong", "", "'furlong' is no unit known here"),
        ("1mN", "m", "is a force"),
        ("5MM", "m", "'MM' is no unit.*Known: m, cm"),
        ("", "m", "'' is no number; give a length in m, e.g. --x 0.5mm"),
        ("mm", "m", "is no number"),
        ("nan", "m", "is no number"),
        ("inf", "m", "is no number"),
        ("one", "", "is no number"),
        ("2*mm", "m", "is no number"),
        ("--2", "m", "is no number"),
        ("1,5mm", "m", "no unit known"),
        ("0x10", "m", "no unit known"),
        ("1e999999999", "m", "too large"),
        ("pi/0", "rad", "divides by zero"),
        ("3pint", "rad/s", "no unit known"),
    ],
)
def test_what_is_refused(text, unit, message):
    with pytest.raises(InputError, match=message):
        quantity(text, unit, "--x")


def test_a_tiny_number_costs_no_memory():
    assert quantity("1e-999999999", "m", "--x") == 0.0


@pytest.mark.parametrize("unit", [unit for unit in UNITS if unit])
def test_every_unit_is_its_own_first_one(unit):
    assert quantity(f"1{unit}", unit, "--x") == 1.0
    assert known_unit(unit) == unit


def test_no_spelling_means_two_kinds():
    spellings = [typed for units in UNITS.values() for typed in units]
    assert len(spellings) == len(set(spellings))


def test_units_are_found_however_they_are_written():
    assert known_unit("kg m2") == known_unit("kg*m^2") == "kg m^2"
    assert known_unit("0, 1") is None
    assert set(NOUNS) <= set(UNITS)
