"""Fields with meaning, unit and range: in parts of users, messages, tables, docstrings, and on the command line."""

import inspect
from dataclasses import dataclass, fields, is_dataclass

import pytest
from public_names import PUBLIC

import flexmb as fm
from flexmb.cli.arguments.source import changed
from flexmb.errors import InputError
from flexmb.fields import Input, fields_of
from flexmb.model import field, not_negative, positive, record

ARM = fm.RigidLink("arm", (0.0, 0.0), (1.0, 0.0), mass=1.0, inertia=0.1)


@fm.element_kernel
def drag_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    c, _ = p
    r[0] = c * v[0]
    C[0, 0] = c


@record
class Drag(fm.Element):
    """Resistance of the air."""

    body: fm.Part = field("what moves")
    c: float = field("force over speed", "N s/m", positive, hint="Without air leave it out.")
    span: float = field("extent; of no influence", "m", not_negative, default=0.0)
    kernel = drag_kernel
    coords = ("body.x",)


@dataclass(frozen=True)
class Plain(fm.Element):
    """Resistance of the air, of a dataclass of the standard library."""

    body: object
    c: float
    span: float = 0.0
    kernel = drag_kernel
    coords = ("body.x",)

    def __post_init__(self):
        super().__post_init__()
        if self.c > 5.0:
            raise InputError(f"{self.label}: c is {self.c:g}.")


def test_docstring_has_the_entries():
    text = inspect.getdoc(Drag)
    assert text.startswith("Resistance of the air.\n\nParameters\n----------\nname : its name,")
    assert "c : force over speed [N s/m], > 0.\nspan : extent [m], >= 0; of no influence." in text


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"c": -1}, "Drag 'air': c is -1 N s/m; it must be > 0. Without air leave it out."),
        ({"c": "x"}, "Drag 'air': c is 'x'; it must be a number in N s/m."),
        ({"c": float("nan")}, "Drag 'air': c is nan; it must be finite in N s/m."),
        ({"c": 1, "span": -2.0}, "Drag 'air': span is -2 m; it must be >= 0."),
        ({"c": None, "span": -2.0}, "Drag 'air': c is None; it must be a number in N s/m. Drag 'air': span is -2 m"),
    ],
)
def test_values_out_of_range(wrong, message):
    with pytest.raises(InputError) as caught:
        Drag("air", ARM, **wrong)
    assert str(caught.value).startswith(message)


def test_numbers_are_kept_as_floats():
    air = Drag("air", ARM, 2)
    assert isinstance(air.c, float)
    assert air == Drag("air", ARM, 2.0)
    assert repr(air) == "Drag('air', body='arm', c=2)"


def test_tables_and_the_command_line_have_the_unit():
    air = Drag("air", ARM, 2.0, span=0.5)
    assert ">N s/m</td>" in air._repr_html_()
    mech = fm.Mechanism("m", [ARM, air])
    assert changed(mech, ["air.span=5mm"]).find("air").span == 5e-3
    with pytest.raises(InputError, match="'5kg' is a mass; give a length in m"):
        changed(mech, ["air.span=5kg"])


def test_a_unit_may_depend_on_another_field():
    motor = fm.Drive("motor", fm.Revolute("O", fm.GROUND, ARM, at=(0.0, 0.0)), fm.ConstantSpeed(1.0))
    mech = fm.Mechanism("m", [ARM, fm.Revolute("O", fm.GROUND, ARM, at=(0.0, 0.0)), motor])
    for typed, speed in (("60rpm", 6.283185307179586), ("2mm/s", 2e-3), ("3", 3.0)):
        found = changed(mech, [f"motor.motion.speed={typed}"]).find("motor").motion.speed
        assert found == pytest.approx(speed, rel=1e-15)


def test_plain_fields_go_on():
    assert Plain("air", ARM, 2).c == 2.0
    with pytest.raises(InputError, match=r"^Plain 'air': c is 'x'; it must be a number\.$"):
        Plain("air", ARM, "x")
    with pytest.raises(InputError, match=r"^Plain 'air': c is 9\.$"):
        Plain("air", ARM, 9.0)
    assert "Parameters" not in inspect.getdoc(Plain)


def test_every_public_input_says_what_its_fields_mean():
    classes = {kind for kind in PUBLIC.values() if inspect.isclass(kind) and issubclass(kind, Input)}
    kinds = {kind for kind in classes if is_dataclass(kind)}
    silent = [
        f"{kind.__name__}.{one.name}"
        for kind in kinds
        for one, told in zip(fields(kind), fields_of(kind), strict=True)
        if one.init and not told.meaning and kind is not type(fm.GROUND)
    ]
    assert len(kinds) > 60
    assert not silent
