"""Parts and laws that are refused when they are made: the message names part, value and remedy."""

import copy
import pickle
import re

import pytest

import flexmb as fm
from flexmb.errors import InputError, KernelError, ModelError
from flexmb.model.contributions import ElementContribution

O, A, B = (0.0, 0.0), (0.2, 0.0), (0.5, 0.1)
BAR = fm.Rectangle(width=0.01, height=0.02)
LAW = fm.LankaraniNikravesh(stiffness=1e9)


def crank(**changes):
    return fm.RigidLink("crank", O, A, **{"mass": 0.5, "inertia": 2e-3, **changes})


def body(**changes):
    return fm.RigidBody("body", **{"at": A, "mass": 0.5, "inertia": 2e-3, **changes})


def link(**changes):
    return fm.FlexibleLink("link", O, A, **{"section": BAR, "material": fm.STEEL, **changes})


def frame(**changes):
    given = {"points": (O, A, B), "edges": ((0, 1), (1, 2)), "section": BAR, "material": fm.STEEL, **changes}
    return fm.FlexibleFrame("frame", **given)


def play(**changes):
    given = {"at": A, "clearance": 1e-4, "bearing_radius": 5e-3, "normal": LAW, **changes}
    return fm.RevoluteClearance("play", fm.GROUND, crank(), **given)


REFUSED = [
    # values out of range
    (lambda: crank(mass=-0.5), "RigidLink 'crank': mass is -0.5 kg; it must be > 0."),
    (lambda: crank(mass=0.0), "RigidLink 'crank': mass is 0 kg; it must be > 0."),
    (lambda: crank(inertia=0.0), "RigidLink 'crank': inertia is 0 kg m^2; it must be > 0."),
    (lambda: crank(centre=1.2), "RigidLink 'crank': centre is 1.2; it must lie between 0 and 1."),
    (
        lambda: fm.RigidLink("crank", A, A, 1.0, 1.0),
        "start and end are both (0.2, 0.0); a link must have a length > 0 m.",
    ),
    (lambda: body(mass=-1.0), "RigidBody 'body': mass is -1 kg; it must be > 0."),
    (lambda: body(inertia=-1.0), "RigidBody 'body': inertia is -1 kg m^2; it must be > 0."),
    (lambda: body(velocity=(1.0, 2.0)), "RigidBody 'body': velocity is (1.0, 2.0); it must be (vx, vy, omega)."),
    (lambda: body(outline=5), "RigidBody 'body': outline is 5; it must be a list of points."),
    (lambda: link(mass=-1.0), "FlexibleLink 'link': mass is -1 kg; it must be > 0."),
    (lambda: link(mass=0.01), "FlexibleLink 'link': mass 0.01 kg cannot be reached by bosses at the ends"),
    (lambda: link(elements=0), "FlexibleLink 'link': elements is 0; it must be at least 1."),
    (lambda: link(elements=1.5), "FlexibleLink 'link': elements is 1.5; it must be a whole number."),
    (lambda: link(elements=(0.5, 0.5)), "fractions must increase strictly between 0 and 1."),
    (lambda: link(damping=-1.0), "FlexibleLink 'link': damping is -1 s; it must be >= 0."),
    (lambda: link(mass_damping=-1.0), "FlexibleLink 'link': mass_damping is -1 1/s; it must be >= 0."),
    (lambda: frame(edges=((0, 1),)), "FlexibleFrame 'frame': corners [2] belong to no edge. Remove them or add edges."),
    (lambda: frame(edges=((0, 3), (1, 2))), "edges[0] is (0, 3); it must join two different corners of 3."),
    (lambda: frame(section=(BAR,)), "FlexibleFrame 'frame': 1 sections for 2 edges; give one each."),
    (lambda: frame(points=3), "FlexibleFrame 'frame': points is 3; it must be a list of corners (x, y)."),
    (lambda: frame(edges=3), "FlexibleFrame 'frame': edges is 3; it must be a list of pairs of corner numbers."),
    (lambda: fm.Rectangle(width=0.0, height=0.01), "Rectangle: width is 0 m; it must be > 0."),
    (lambda: fm.Circle(-0.01), "Circle: diameter is -0.01 m; it must be > 0."),
    (lambda: fm.Tube(outer=0.01, inner=0.02), "inner is 0.02 m and outer is 0.01 m; inner must be smaller than outer."),
    (
        lambda: fm.Material(0.0, 7800.0),
        "Material: young is 0 Pa; it must be > 0. Young's modulus of steel is 207e9 Pa.",
    ),
    (lambda: fm.Material(2e11, 7800.0, 0.5), "Material: poisson is 0.5; it must lie between -1 and 0.5"),
    (
        lambda: play(clearance=-2e-4),
        "RevoluteClearance 'play': clearance is -0.0002 m; it must be > 0. "
        "For a joint without clearance use Revolute(...).",
    ),
    (lambda: play(clearance=0.0), "clearance is 0 m; it must be > 0. For a joint without clearance use Revolute(...)."),
    (
        lambda: play(clearance=5e-3),
        "RevoluteClearance 'play': clearance is 0.005 m; it must be smaller than the bearing radius 0.005 m. "
        "Did you mix up metres and millimetres?",
    ),
    (lambda: play(bearing_radius=0.0), "RevoluteClearance 'play': bearing_radius is 0 m; it must be > 0."),
    (
        fm.LankaraniNikravesh,
        "stiffness is missing; give stiffness=..., or use LankaraniNikravesh.from_materials",
    ),
    (lambda: fm.LankaraniNikravesh(stiffness=0.0), "LankaraniNikravesh: stiffness is 0 N/m^n; it must be > 0."),
    (lambda: fm.LankaraniNikravesh(1e9, restitution=1.1), "restitution is 1.1; it must lie between 0 and 1."),
    (lambda: fm.LankaraniNikravesh(1e9, restitution=0.0), "LankaraniNikravesh: restitution is 0; it must be > 0."),
    (lambda: fm.ModifiedCoulomb(-0.1), "ModifiedCoulomb: coefficient is -0.1; it must be >= 0."),
    (lambda: fm.ModifiedCoulomb(0.1, v0=1e-3, v1=1e-3), "v1 is 0.001 m/s; it must be > v0 = 0.001 m/s."),
    (
        lambda: fm.Prismatic("guide", fm.GROUND, crank(), along=O),
        "along is (0.0, 0.0); it must be a direction with a length > 0.",
    ),
    (
        lambda: fm.SpringDamper("spring", fm.GROUND, crank(), A, A, stiffness=1.0),
        "SpringDamper 'spring': both points are (0.2, 0.0); a spring without length has no direction.",
    ),
    (
        lambda: fm.SpringDamper("spring", fm.GROUND, crank(), O, A, stiffness=-1.0),
        "stiffness is -1 N/m; it must be >= 0.",
    ),
    (
        lambda: fm.TorsionSpring("coil", fm.GROUND, crank(), stiffness=1.0, damping=-2.0),
        "damping is -2 N m s/rad; it must",
    ),
    (lambda: fm.drives.Ramp(6.0, 0.0), "Ramp: time is 0 s; it must be > 0."),
    (lambda: fm.drives.Polynomial(()), "Polynomial: coefficients is empty; give at least one, e.g. (0.0, 6.28)."),
    (
        lambda: fm.drives.Table((0.0, 1.0), (0.0, 1.0)),
        "Table: 2 times and 2 values; give at least 4 of each, equally many.",
    ),
    (
        lambda: fm.drives.Table((0.0, 1.0, 1.0, 2.0), (0.0,) * 4),
        "Table: times do not increase; sort them and remove duplicates.",
    ),
    (lambda: fm.FixedStep(0.0), "FixedStep: size is 0 s; it must be > 0."),
    (lambda: fm.Adaptive(rtol=-1.0), "Adaptive: rtol is -1; it must be > 0."),
    (lambda: fm.Adaptive(atol=-1.0), "Adaptive: atol is -1 m; it must be > 0."),
    (lambda: fm.Adaptive(rtol=None), "Adaptive: rtol is None; it must be a number."),
    (lambda: fm.Adaptive(rtol=10**400), "Adaptive: rtol is inf; it must be finite."),
    (lambda: fm.Adaptive(impact_steps=0), "Adaptive: impact_steps is 0"),
    (lambda: fm.Adaptive(impact_steps=10**400), "Adaptive: impact_steps is inf; it must be a whole number."),
    (lambda: fm.Adaptive(max=1e-5, min=1e-3), "Adaptive: min is 0.001 s; it must not be larger than max = 1e-05 s."),
    (lambda: fm.Newmark(beta=0.0), "Newmark: beta is 0; it must be > 0."),
    (lambda: fm.Newmark.hht(0.5), "Newmark.hht: alpha is 0.5; it must lie between 0 and 0.333333."),
    (
        lambda: fm.Newmark(constraints="positions"),
        "Did you mean 'position'? Known: gear-gupta-leimkuhler, position, velocity.",
    ),
    # wrong kinds
    (lambda: crank(mass="0.5"), "RigidLink 'crank': mass is '0.5'; it must be a number in kg."),
    (lambda: crank(mass=None), "RigidLink 'crank': mass is None; it must be a number in kg."),
    (lambda: fm.RigidLink("crank", O, 0.2, 1.0, 1.0), "RigidLink 'crank': end is 0.2; it must be a pair (x, y) in m."),
    (lambda: link(section=0.01), "section is 0.01; it must be a cross section such as Rectangle(...)."),
    (lambda: link(material="steel"), "FlexibleLink 'link': material is 'steel'; it must be a Material(...)."),
    (lambda: play(normal="Hertz"), "normal is 'Hertz'; it must be a normal law, e.g. LankaraniNikravesh."),
    (
        lambda: play(normal=fm.friction.Frictionless()),
        "normal is Frictionless(); it must be a normal law, e.g. LankaraniNikravesh.",
    ),
    (lambda: play(friction=LAW), "it must be a friction law, e.g. ModifiedCoulomb."),
    (lambda: play(friction=None), "friction is None; it must be a friction law, e.g. ModifiedCoulomb."),
    (lambda: fm.LankaraniNikravesh(materials=(fm.STEEL,)), "they must be two Material(...), bearing first."),
    (
        lambda: fm.Drive("motor", "O", 6.0),
        "Drive 'motor': motion is 6.0; it must be a motion, e.g. ConstantSpeed(6.28).",
    ),
    (lambda: fm.Drive("motor", 5, fm.ConstantSpeed(1.0)), "Drive 'motor': joint is 5; it must be a joint or its name."),
    (lambda: fm.ConstantSpeed("6"), "ConstantSpeed: speed is '6'; it must be a number in rad/s or m/s."),
    (lambda: fm.drives.Polynomial(3.0), "Polynomial: coefficients is 3.0; it must be a list of numbers."),
    (lambda: fm.drives.Table(3.0, 4.0), "Table: times is 3.0; it must be a list of numbers."),
    (lambda: fm.Torque("load", crank(), "3"), "Torque 'load': torque is '3'; it must be a number in N m."),
    (lambda: fm.Force("load", "crank", O, (1.0, 2.0)), "Force 'load': body is 'crank'; it must be a body or GROUND."),
    (lambda: fm.Force("load", crank(), O, 3.0), "Force 'load': force is 3.0; it must be a pair (x, y) in N."),
    (
        lambda: fm.Force("load", crank(), O, (1.0, 2.0), history=2.0),
        "Force 'load': history is 2.0; it must be a motion whose value multiplies the load, e.g. Pulse(end=0.1)",
    ),
    (
        lambda: fm.Torque("load", crank(), 3.0, history=fm.drives.Pulse),
        "it must be a motion whose value multiplies the load, e.g. Pulse(end=0.1), or None for a constant load.",
    ),
    (
        lambda: fm.Force("load", crank(), O, (1.0, 2.0), follower=1),
        "Force 'load': follower is 1; it must be True (the direction turns with the body) or False (it stays).",
    ),
    (lambda: fm.drives.Pulse(1.0, start=0.5, end=0.5), "Pulse: end is 0.5 s; it must be > start = 0.5 s, by 4e-12 of"),
    (lambda: fm.drives.Pulse(1e10, start=100.3, end=100.3 + 1e-10), "it must be > start = 100.3 s, by 4e-12 of it at"),
    (lambda: fm.drives.Harmonic(1.0, 0.0), "Harmonic: frequency is 0 Hz; it must be > 0."),
    (lambda: fm.drives.CycloidalRamp(6.0, -1.0), "CycloidalRamp: time is -1 s; it must be > 0."),
    (
        lambda: fm.drives.PiecewiseLinear((0.0,), (1.0,)),
        "PiecewiseLinear: 1 times and 1 values; give at least 2 of each, equally many.",
    ),
    (
        lambda: fm.drives.PiecewiseLinear((0.0, 0.0), (0.0, 1.0)),
        "PiecewiseLinear: times do not increase; sort them and remove duplicates.",
    ),
    (
        lambda: fm.Drive("motor", "O", fm.drives.Pulse()),
        "Drive 'motor': motion is Pulse(...), whose value or speed jumps; a joint would need an infinite force to "
        "follow. Drive it with Table, Ramp, CycloidalRamp or Harmonic",
    ),
    (
        lambda: fm.Drive("motor", "O", fm.drives.PiecewiseLinear((0.0, 1.0), (0.0, 1.0))),
        "Drive 'motor': motion is PiecewiseLinear(...), whose value or speed jumps",
    ),
    (lambda: fm.Revolute("A", "crank", crank(), at=A), "Revolute 'A': first is 'crank'; it must be a body or GROUND."),
    (lambda: fm.TorsionSpring("s", crank(), "arm", stiffness=1.0), "second is 'arm'; it must be a body or GROUND."),
    (
        lambda: fm.SpringDamper("s", "crank", crank(), O, A, stiffness=1.0),
        "first is 'crank'; it must be a body or GROUND.",
    ),
    # names
    (
        lambda: fm.RigidBody("a.b", O, 1.0, 1.0),
        "RigidBody: name is 'a.b'; it must be a non-empty string without '.', '/'",
    ),
    (lambda: fm.RigidBody("", O, 1.0, 1.0), "RigidBody: name is ''; it must be a non-empty string"),
    (lambda: fm.RigidBody(3, O, 1.0, 1.0), "RigidBody: name is 3; it must be a non-empty string"),
]


@pytest.mark.parametrize(("make", "message"), REFUSED, ids=[message[:60] for _, message in REFUSED])
def test_refused_with_its_name_value_and_remedy(make, message):
    with pytest.raises(InputError, match=re.escape(message)):
        make()


@pytest.mark.parametrize(
    ("make", "label"),
    [
        (lambda: fm.Force("load", fm.GROUND, O, (1.0, 0.0)), "Force 'load'"),
        (lambda: fm.Force("thrust", fm.GROUND, O, (1.0, 0.0), follower=True), "Force 'thrust'"),
        (lambda: fm.Force("load", fm.GROUND, O, (1.0, 0.0), history=fm.drives.Pulse(end=1.0)), "Force 'load'"),
        (lambda: fm.Torque("moment", fm.GROUND, 1.0), "Torque 'moment'"),
    ],
)
def test_load_on_the_ground(make, label):
    with pytest.raises(ModelError, match=f"{label} acts on the ground, which cannot move. Give a moving body\\."):
        make()


BESIDE = (0.06, 0.0)  # between the nodes of link(elements=2), which stand at 0, 0.1 and 0.2 m


@pytest.mark.parametrize(
    ("load", "label"),
    [
        (lambda beam: fm.Force("load", beam, BESIDE, (1.0, 0.0), follower=True), "Force 'load'"),
        (lambda beam: fm.Force("load", beam, BESIDE, (1.0, 0.0)), "Force 'load'"),
        (lambda beam: fm.Torque("moment", beam, 1.0, BESIDE), "Torque 'moment'"),
        (lambda beam: fm.SpringDamper("spring", fm.GROUND, beam, B, BESIDE, stiffness=1.0), "SpringDamper 'spring'"),
    ],
)
def test_load_between_the_nodes_of_a_beam(load, label):
    beam = link(elements=2)
    message = (
        f"{label}: the point (0.06, 0) is no node of FlexibleLink 'link'; it lies 0.04 m from the nearest. "
        "Nodes nearby: node1 at (0.1, 0), node0 at (0, 0), node2 at (0.2, 0). Move the point there"
    )
    with pytest.raises(InputError, match=re.escape(message)):
        fm.compile(fm.Mechanism("beam", [beam, load(beam)]))


@fm.element_kernel
def push_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = -p[0]


@fm.kernels.energy_kernel
def push_energy(p, t, q, v):
    return -p[0] * q[0], 0.0, 0.0


def test_energy_of_a_load_that_changes_in_time():
    with pytest.raises(
        KernelError, match="Part 'push': kernel 'push_kernel' has a factor in time and an energy kernel"
    ):
        ElementContribution("push", push_kernel, (("b", "", 0),), (1.0,), energy=push_energy, factor=fm.drives.Pulse())


def test_joint_of_a_body_with_itself():
    with pytest.raises(ModelError, match=r"Revolute 'A' joins 'crank' to itself; give two different bodies"):
        fm.Revolute("A", crank(), crank(), at=A)


def test_base_of_laws_is_no_law():
    with pytest.raises(KernelError, match=r"NormalLaw has no kernel; it cannot be used as a law"):
        fm.NormalLaw()


@pytest.mark.parametrize(
    "make",
    [
        lambda: crank(masse=1.0),
        lambda: link(elments=3),
        lambda: play(radius=1.0),
        lambda: fm.ConstantSpeed(velocity=1.0),
        lambda: fm.Adaptive(tolerance=1e-6),
        lambda: fm.Mechanism("m", [crank()], g=9.81),
        lambda: fm.simulate(fm.Mechanism("m", [crank()]), t_end=1.0, h=1e-3),
    ],
)
def test_unknown_keyword_is_refused(make):
    with pytest.raises(
        TypeError, match=r"There is no argument '(masse|elments|radius|velocity|tolerance|g|h)'\. .*Arguments: "
    ):
        make()


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (
            lambda: fm.RigidLink("a", (0.0, 0.0), (1.0, 0.0), mass=1.0),
            r"RigidLink 'a': inertia is missing; give inertia=...*kg m\^2",
        ),
        (lambda: fm.Force("F", force=(0.0, 1.0)), "Force 'F': body is missing; .* at is missing; give at="),
        (lambda: fm.Rectangle(0.1), r"Rectangle: height is missing; give height=.*direction of bending \[m\]"),
        (
            lambda: fm.PlaneBody("rod", fm.meshes.rectangle(0.1, 0.1, 1, 1), material=fm.STEEL),
            "PlaneBody 'rod': thickness is missing; give",
        ),
    ],
)
def test_what_is_missing_is_named(make, text):
    with pytest.raises(InputError, match=text):
        make()


@pytest.mark.parametrize("part", [crank(), fm.Rectangle(0.1, 0.2), fm.STEEL])
def test_copies_and_pickles_are_made_without_arguments(part):
    assert copy.copy(part) == part
    assert pickle.loads(pickle.dumps(part)) == part  # noqa: S301 - our own


def test_a_frame_with_an_edge_twice_is_refused():
    points = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
    with pytest.raises(InputError, match=r"FlexibleFrame 'f': edges\[3\] is \(1, 0\).*remove it"):
        fm.FlexibleFrame(
            "f",
            points,
            ((0, 1), (1, 2), (2, 0), (1, 0)),
            section=fm.Rectangle(width=0.01, height=0.01),
            material=fm.STEEL,
        )
