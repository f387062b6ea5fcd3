"""Numbers and choices that may vary: their ranges, units and meanings; refused values; texts of the mechanism."""

from typing import Annotated, Literal

import pytest

import flexmb as fm
from flexmb.mechanisms import nine_bar, slider_crank
from flexmb.show.live.knobs import Knobs


def pendulum(
    length: Annotated[float, "m"] = 0.5, *, parts: int = 1, kind: Literal["rod", "ring"] = "rod"
) -> fm.Mechanism:
    """A pendulum.

    Parameters
    ----------
    length : length of the arm.
    parts : number of arms.
    kind : form of the arm.
    """
    inertia = {"rod": length**2 / 12.0, "ring": length**2 / 4.0}[kind]
    arms, joints, before = [], [], fm.GROUND
    for k in range(parts):
        arm = fm.RigidLink(f"arm{k}", (k * length, 0.0), ((k + 1) * length, 0.0), mass=1.0, inertia=inertia)
        joints.append(fm.Revolute(f"J{k}", before, arm, at=(k * length, 0.0)))
        arms.append(arm)
        before = arm
    return fm.Mechanism("pendulum", [*arms, *joints], gravity=(0.0, -9.81))


def test_arguments_have_units_meanings_and_ranges():
    knobs = Knobs(pendulum, None, {})
    length, parts, kind = knobs.known.values()
    assert (length.kind, length.low, length.high, length.unit) == ("number", 0.1, 2.5, "m")
    assert length.meaning == "length of the arm."
    assert (parts.kind, parts.low, parts.high) == ("count", 1, 4)
    assert (kind.kind, kind.labels, kind.value) == ("choice", ("rod", "ring"), "rod")
    changed = knobs.mechanism({**knobs.start, "length": 0.4, "parts": 2, "kind": "ring"})
    assert changed.names == ("arm0", "arm1", "J0", "J1")
    assert changed.find("arm1").inertia == pytest.approx(0.04)


@pytest.mark.filterwarnings("ignore::flexmb.errors.RestitutionWarning")
def test_numbers_of_parts_stay_within_what_their_part_allows():
    mech = slider_crank(clearance=1e-4)
    knobs = Knobs(mech, None, {})
    restitution = knobs.known["B.normal.restitution"]
    assert 0.9 < restitution.high <= 1.0
    assert knobs.known["crank.mass"].unit == "kg"
    assert knobs.known["crank.mass"].meaning.startswith("mass")
    for name, knob in knobs.known.items():
        for end in (knob.low, knob.high):
            with_end = knobs.mechanism({**knobs.start, name: knobs.known[name].checked(end)})
            assert isinstance(with_end, fm.Mechanism)


def test_a_value_outside_the_range_starts_at_its_end_and_none_in_the_middle():
    knobs = Knobs(slider_crank, {"speed": (50.0, 500.0), "clearance": (1e-5, 4e-5)}, {})
    assert knobs.known["speed"].value == 500.0
    assert knobs.known["clearance"].value == pytest.approx(2e-5)
    assert knobs.known["clearance"].optional
    ideal = knobs.mechanism(knobs.start | knobs.checked({"clearance": None}))
    assert isinstance(ideal.find("B"), fm.Revolute)


def test_choices_by_label_are_objects_in_python():
    laws = {"Coulomb": fm.ModifiedCoulomb(0.1, 1e-4, 1e-3), "none": None}
    knobs = Knobs(slider_crank, {"friction": laws, "flexible": [False, True]}, {"clearance": 1e-4})
    made = knobs.mechanism(knobs.checked({"friction": "Coulomb", "flexible": True}))
    assert made.find("B").friction.coefficient == 0.1
    assert isinstance(made.find("rod"), fm.FlexibleLink)
    assert knobs.known["friction"].described()["choices"] == ["Coulomb", "none"]


def test_the_text_makes_the_same_mechanism():
    knobs = Knobs(slider_crank, {"speed": (50.0, 500.0), "clearance": (1e-5, 5e-4)}, {"friction": "coulomb"})
    values = knobs.start | knobs.checked({"speed": 300.0, "clearance": 2e-4})
    text = knobs.code(values)
    assert text == "slider_crank(friction='coulomb', speed=300.0, clearance=0.0002)"
    assert eval(text, {"slider_crank": slider_crank}) == knobs.mechanism(values)
    mech = slider_crank(clearance=1e-4)
    knobs = Knobs(mech, {"B.clearance": (1e-5, 5e-4), "slider.mass": (0.1, 0.5)}, {})
    values = knobs.start | {"B.clearance": 2e-4}
    assert knobs.code(values) == "mech.with_({'B.clearance': 0.0002})"
    assert eval(knobs.code(values), {"mech": mech}) == knobs.mechanism(values)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"spead": 1.0}, "Did you mean 'speed'"),
        ({"speed": 1e300}, "speed"),
        ({"speed": float("nan")}, "speed"),
        ({"speed": float("inf")}, "speed"),
        ({"speed": 10**5000}, "speed"),
        ({"speed": "300 mm"}, "speed"),
        ({"speed": "30**2"}, "speed"),
        ({"speed": "9" * 61}, "speed"),
        ({"speed": True}, "speed"),
        ({"speed": None}, "speed"),
        ({"speed": [300.0]}, "speed"),
        ({"speed": {"__class__": 1}}, "speed"),
        ({"flexible": "maybe"}, "choose no or yes"),
        ({"flexible": 1.0}, "choose no or yes"),
        ({"flexible": "x" * 10**6}, "choose no or yes"),
        ({"elements": 2.5}, "elements"),
    ],
)
def test_other_values_are_refused_by_name(values, words):
    knobs = Knobs(slider_crank, {"speed": (50.0, 500.0), "flexible": [False, True], "elements": (1, 8)}, {})
    with pytest.raises(fm.errors.InputError, match=words) as refused:
        knobs.checked(values)
    assert len(str(refused.value)) < 400


@pytest.mark.parametrize(
    ("model", "vary", "words"),
    [
        (3, None, "must be a Mechanism, or a function"),
        (slider_crank, {"sped": (1.0, 2.0)}, "Did you mean 'speed'"),
        (slider_crank, {"speed": (2.0, 1.0)}, "lower end"),
        (slider_crank, {"speed": (1.0, float("nan"))}, "speed"),
        (slider_crank, ["clearance"], "cannot be guessed"),
        (slider_crank, {"friction": ["coulomb"]}, "at least two"),
        (slider_crank, [], "nothing can vary"),
        (slider_crank(), {"B.clearance": (1e-5, 1e-4)}, "no clearance"),
        (slider_crank(), {"B": (1e-5, 1e-4)}, "no number of a part"),
    ],
)
def test_what_cannot_vary_is_told(model, vary, words):
    with pytest.raises(fm.errors.FlexmbError, match=words):
        Knobs(model, vary, {})


def test_a_text_with_none_is_a_choice():
    friction = Knobs(nine_bar, None, {}).known["friction"]
    assert (friction.labels, friction.value) == (("coulomb", "none"), "coulomb")
    assert friction.argument("none") is None


def test_fixed_arguments_that_are_unknown_are_refused_at_once():
    with pytest.raises(fm.errors.InputError, match="name in fixed is 'zz'"):
        Knobs(slider_crank, {"speed": (50.0, 500.0)}, {"zz": 3})
