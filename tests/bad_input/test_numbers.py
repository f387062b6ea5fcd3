"""NaN, infinity and things that are no number, in every numeric field of every public record."""

import inspect
import math
from dataclasses import fields, is_dataclass, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from public_names import BY_LAST_NAME

import flexmb as fm
from flexmb.errors import InputError

O, A, B = (0.0, 0.0), (0.2, 0.0), (0.5, 0.1)
BAR = fm.Rectangle(width=0.01, height=0.02)
CRANK = fm.RigidLink("crank", O, A, mass=0.5, inertia=2e-3, centre=0.4, velocity=(0.0, 0.0, 1.0))
ARM = fm.RigidLink("arm", A, B, mass=0.4, inertia=3e-3)
PLATE = fm.PlaneBody(
    "plate", fm.meshes.rectangle(0.2, 0.1, 2, 1), at=O, thickness=0.01, material=fm.STEEL, pins=("left",)
)
LAW = fm.LankaraniNikravesh(stiffness=1e9)
HYSTERESIS = (
    fm.HuntCrossley, fm.contact.HerbertMcWhannell, fm.contact.LeeWang, fm.contact.Gonthier, fm.contact.ZhiyingQishao,
    fm.contact.Flores, fm.contact.HuGuo, fm.contact.CarvalhoMartins, fm.contact.ExactRestitution, fm.LankaraniNikravesh,
)  # fmt: skip
CYLINDERS = (
    fm.contact.Johnson,
    fm.contact.Radzimovsky,
    fm.contact.Goldsmith,
    fm.contact.DubowskyFreudenstein,
    fm.contact.ESDU78035,
)
TIMES = (0.0, 0.1, 0.3, 0.4, 1.0)

SPECIMENS = {
    "Rectangle": BAR,
    "Circle": fm.Circle(0.02),
    "Tube": fm.Tube(outer=0.02, inner=0.01),
    "GeneralSection": fm.GeneralSection(area=1e-4, second_moment=1e-9, outer_fibre=0.01, shear_factor=0.8),
    "Tapered": fm.Tapered(BAR, fm.Rectangle(width=0.01, height=0.03)),
    "Material": fm.Material(207e9, 7801.0, 0.29, yield_stress=350e6),
    "RigidBody": fm.RigidBody("body", A, 1.0, 0.1, theta=0.2, velocity=(1.0, 2.0, 3.0), outline=(O, A, B)),
    "RigidLink": CRANK,
    "FlexibleLink": fm.FlexibleLink(
        "link", O, B, section=BAR, material=fm.STEEL, elements=(0.3, 0.7), mass=2.0, damping=1e-4, mass_damping=2.0,
        pivot_inertia=1e-3, rotary_inertia=1e-4, velocity=(0.0, 0.0, 1.0), displacement=lambda s: (0.0, 1e-3 * s, 1e-3),
        shear=0.8,
    ),
    "FlexibleFrame": fm.FlexibleFrame(
        "frame", (O, (0.4, 0.05), (0.1, 0.3)), ((0, 1), (1, 2), (2, 0)), section=BAR, material=fm.STEEL, elements=2,
        mass=4.0, inertia=0.105, damping=1e-4, mass_damping=2.0, rotary_inertia=1e-4, velocity=((0.0, 1.0, 2.0),) * 6,
        shear=0.8, turns=(0.1, 0.2, 0.3),
    ),
    "Revolute": fm.Revolute("pin", CRANK, ARM, at=A, friction=fm.ModifiedCoulomb(0.1), radius=0.01, preload=2.0),
    "Fixed": fm.Fixed("weld", CRANK, ARM, at=A),
    "Clamp": fm.Clamp("clamp", CRANK, ARM, at=A, angle=fm.ConstantSpeed(2.0), x=fm.drives.Ramp(1.0, 0.5)),
    "Prismatic": fm.Prismatic(
        "guide", fm.GROUND, CRANK, at=A, along=(1.0, 0.5), friction=fm.ModifiedCoulomb(0.1), length=0.1, preload=2.0
    ),
    "Bushing": fm.Bushing(
        "bush", CRANK, ARM, at=A, stiffness=(1e4, 2e4), damping=(1.0, 2.0), torsion=3.0, torsion_damping=0.1
    ),
    "PinSlot": fm.PinSlot("slot", CRANK, ARM, at=A, along=(1.0, 0.5)),
    "PinSlotClearance": fm.PinSlotClearance(
        "slot", CRANK, ARM, at=A, along=(1.0, 0.5), clearance=1e-4, pin_radius=5e-3, length=0.1, normal=LAW
    ),
    "PrismaticClearance": fm.PrismaticClearance(
        "play", CRANK, ARM, at=A, along=(1.0, 0.5), clearance=1e-4, half_length=0.02, half_height=0.01, normal=LAW,
        corner_radius=1e-3,
    ),
    "RevoluteClearance": fm.RevoluteClearance(
        "play", CRANK, ARM, at=A, clearance=1e-4, bearing_radius=5e-3, normal=LAW, friction=fm.ModifiedCoulomb(0.1),
        start=(3e-5, -4e-5),
    ),
    "JournalBearing": fm.JournalBearing(
        "play", CRANK, ARM, at=A, clearance=1e-4, bearing_radius=5e-3, normal=LAW, friction=fm.ModifiedCoulomb(0.1),
        start=(3e-5, -4e-5), film=fm.ShortBearing(viscosity=0.02, width=0.01), roughness=1e-6,
    ),
    "SliderBearing": fm.SliderBearing(
        "play", CRANK, ARM, at=A, along=(1.0, 0.5), clearance=1e-4, half_length=0.02, half_height=0.01, normal=LAW,
        film=fm.ShortBearing(viscosity=0.02, width=0.01), roughness=1e-6, corner_radius=1e-3,
    ),
    "Oil": fm.Oil(viscosities=((40.0, 0.04), (100.0, 0.006)), density=870.0, heat_capacity=2000.0),
    "Archard": fm.Archard(bearing=1e-13, width=0.02),
    "EnergyWear": fm.EnergyWear(journal=1e-12, width=0.02),
    "ShortBearing": fm.ShortBearing(viscosity=0.02, width=0.01, density=870.0),
    "LongBearing": fm.LongBearing(viscosity=0.02, width=0.01, density=870.0),
    "FiniteBearing": fm.FiniteBearing(
        viscosity=0.02, width=0.01, density=870.0, grooves=(0.0, 2.0), groove_width=0.3
    ),
    **{kind.__name__: kind(stiffness=1e9, restitution=0.95, materials=(fm.STEEL, fm.STEEL)) for kind in HYSTERESIS},
    "Hertz": fm.contact.Hertz(stiffness=1e9, materials=(fm.STEEL, fm.STEEL)),
    "KelvinVoigt": fm.KelvinVoigt(1e6, 10.0, ramp=1e-6),
    **{kind.__name__: kind(0.02, (fm.STEEL, fm.STEEL)) for kind in CYLINDERS},
    "ModifiedCoulomb": fm.ModifiedCoulomb(0.1),
    "SmoothCoulomb": fm.friction.SmoothCoulomb(0.1),
    "Threlfall": fm.friction.Threlfall(0.1),
    "BengisuAkay": fm.friction.BengisuAkay(0.2, 0.1),
    "Stribeck": fm.friction.Stribeck(0.2, 0.1),
    "BrownMcPhee": fm.friction.BrownMcPhee(0.2, 0.1),
    "LuGre": fm.friction.LuGre(0.2, 0.1),
    "Stop": fm.Stop("end", "pin", above=1.0, below=-1.0, normal=LAW, radius=0.1, along=(1.0, 0.5)),
    "PointMass": fm.bodies.PointMass("bob", A, mass=1.0, velocity=(0.1, 0.2)),
    "Coupling": fm.couplings.Coupling("mesh", {"pin": 2.0}, value=0.1),
    "Cable": fm.couplings.Cable("rope", CRANK, ARM, at=O, to=B, free_length=1.0, normal=LAW),
    "OneWayClutch": fm.couplings.OneWayClutch("clutch", CRANK, ARM, at=A, stiffness=10.0, damping=1.0),
    "SpringDamper": fm.SpringDamper("spring", CRANK, ARM, O, B, stiffness=10.0, damping=1.0, free_length=0.1),
    "TorsionSpring": fm.TorsionSpring("coil", CRANK, ARM, stiffness=1.0, damping=1.0, free_angle=0.1, at=A),
    "Force": fm.Force("load", CRANK, at=A, force=(1.0, 2.0), history=fm.drives.Harmonic(2.0, 3.0), follower=True),
    "EdgeLoad": fm.loads.EdgeLoad("load", PLATE, "top", (1e5, 2e5), history=fm.drives.Harmonic(2.0, 3.0)),
    "EdgePressure": fm.loads.EdgePressure("load", PLATE, "top", 1e5, 2e5),
    "BodyForce": fm.loads.BodyForce("load", PLATE, (1e5, 2e5), follower=True),
    "Torque": fm.Torque("moment", CRANK, 3.0, at=A, history=fm.drives.Pulse(2.0, start=0.1, end=0.2)),
    "ConstantSpeed": fm.ConstantSpeed(6.0),
    "CycloidalRamp": fm.drives.CycloidalRamp(6.0, 0.5),
    "Ramp": fm.drives.Ramp(6.0, 0.5),
    "Harmonic": fm.drives.Harmonic(0.1, frequency=2.0, phase=0.3, mean=0.2),
    "Pulse": fm.drives.Pulse(2.0, start=0.1, end=0.2),
    "PiecewiseLinear": fm.drives.PiecewiseLinear((0.0, 0.5, 1.0), (0.0, 2.0, 1.0)),
    "Polynomial": fm.drives.Polynomial((0.0, 1.0, 2.0)),
    "Table": fm.drives.Table(TIMES, tuple(t * t for t in TIMES), slopes=(0.0, 2.0)),
    "Newmark": fm.Newmark(),
    "FixedStep": fm.FixedStep(1e-3),
    "Adaptive": fm.Adaptive(rtol=1e-3, atol=1e-6, max=1e-3, min=1e-9, impact_steps=20),
    "Mechanism": fm.Mechanism("pair", (CRANK, ARM), gravity=(0.0, -9.81)),
}  # fmt: skip
"""One sound record of each kind; NaN is put into each of its numbers in turn."""

WITHOUT_NUMBERS = {"DormandPrince", "Drive", "Frictionless", "RungeKutta4"}
"""Public records that hold no number of their own."""

MADE_BY_THE_LIBRARY = {"Solution", "Element", "Part", "NormalLaw", "FrictionLaw", "Motion", "HysteresisLaw"}
"""Results and bases, which nobody fills in by hand."""


RECORDS_OF_PARTS = {"Attachment", "ConstraintContribution", "ContactContribution", "Reaction", "SignalContribution"}
"""Records by which parts describe themselves to the compiler, which checks their kernels and numbers."""


def numbers(value, path=()):
    """Paths to all floats of a record: fields, and places in tuples."""
    if isinstance(value, float):
        yield path
    elif isinstance(value, tuple):
        for k, item in enumerate(value):
            yield from numbers(item, (*path, k))
    elif is_dataclass(value) and not (path and isinstance(value, fm.Part)):
        for f in fields(value):
            if f.init:
                yield from numbers(getattr(value, f.name), (*path, f.name))


def with_value(record, path, value):
    """`record` with the number at a path replaced."""
    if not path:
        return value
    head, *rest = path
    if isinstance(record, tuple):
        return tuple(with_value(x, rest, value) if k == head else x for k, x in enumerate(record))
    return replace(record, **{head: with_value(getattr(record, head), rest, value)})


PLACES = [(kind, path) for kind, record in SPECIMENS.items() for path in numbers(record)]


def owner(kind, path):
    """The class that a message must name: the innermost record on the path."""
    record, found = SPECIMENS[kind], kind
    for step in path:
        record = record[step] if isinstance(record, tuple) else getattr(record, step)
        if is_dataclass(record):
            found = type(record).__name__
    return found


def expected(path):
    """The field that a message must name: the last word of the path."""
    return [step for step in path if isinstance(step, str)][-1]


def test_there_are_many_places():
    assert len(PLACES) > 100
    assert ("Tapered", ("end", "height")) in PLACES
    assert ("FlexibleFrame", ("points", 1, 0)) in PLACES


def test_every_public_record_is_tried():
    """A new public record must be added above."""
    public = {name: kind for name, kind in BY_LAST_NAME.items() if inspect.isclass(kind)}
    written = {n for n, kind in public.items() if is_dataclass(kind) and "__init__" in vars(kind)}
    concrete = {n for n in written if not inspect.isabstract(public[n])}
    simple = {
        n
        for n in concrete - set(SPECIMENS) - WITHOUT_NUMBERS - MADE_BY_THE_LIBRARY - RECORDS_OF_PARTS
        if made_by_hand(public[n])
    }
    assert not simple, f"add a specimen of {sorted(simple)}"


BELOW = ("elastic.beams", *(f"parts.{room}" for room in ("bodies", "joints", "contact", "drives", "loads")), "model")


def made_by_hand(kind):
    """Parts, laws, sections, methods, steps: what stands below the floors that compute."""
    return kind.__module__.startswith(tuple(f"flexmb.{room}." for room in BELOW))


@given(place=st.sampled_from(PLACES), bad=st.sampled_from([math.nan, math.inf, -math.inf]))
def test_number_that_is_not_finite_is_refused(place, bad):
    kind, path = place
    with pytest.raises(InputError) as caught:
        with_value(SPECIMENS[kind], path, bad)
    message = str(caught.value)
    assert message.startswith(owner(kind, path)), message
    assert expected(path) in message, message
    assert str(bad) in message or repr(bad) in message, message


@given(place=st.sampled_from(PLACES), bad=st.sampled_from(["1.0", None, True, 1j, [1.0], object]))
def test_thing_that_is_no_number_is_refused(place, bad):
    kind, path = place
    optional = len(path) == 1 and bad is None and optional_field(SPECIMENS[kind], path[0])
    if optional:
        assert with_value(SPECIMENS[kind], path, bad) is not None
        return
    with pytest.raises(InputError) as caught:
        with_value(SPECIMENS[kind], path, bad)
    assert str(caught.value).startswith(owner(kind, path))
    assert expected(path) in str(caught.value)


def optional_field(record, name):
    """Whether None is a sound value of the field: it says so itself."""
    return "None" in str(next(f.type for f in fields(record) if f.name == name))


def test_every_place_once():
    """Hypothesis draws; this one goes through all of them."""
    for kind, path in PLACES:
        with pytest.raises(InputError, match=expected(path)):
            with_value(SPECIMENS[kind], path, math.nan)
