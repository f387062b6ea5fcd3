"""Broken mechanisms, each with the codes and names that `check` must tell."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

import flexmb as fm

O, A, B, C, D = (0.0, 0.0), (0.1, 0.0), (0.5, 0.3), (0.5, 0.0), (0.2, 0.25)
THREAD = fm.RigidLink("thread", (1.0, 0.0), (1.0, 0.5), mass=0.0, inertia=0.0)
LEVER = fm.RigidBody("lever", (0.2, 0.2), 0.1, 1e-3)
STEEL_BAR = fm.Rectangle(width=0.01, height=0.01)


@dataclass(frozen=True)
class WrongRate(fm.Motion):
    """A ramp whose rate is half of the true one."""

    speed: float

    @fm.drive_kernel
    def kernel(p, t):
        return p[0] * t, 0.5 * p[0], 0.0


@dataclass(frozen=True)
class WrongAcceleration(fm.Motion):
    """A swing whose acceleration has the wrong sign."""

    amplitude: float

    @fm.drive_kernel
    def kernel(p, t):
        return p[0] * math.sin(5.0 * t), 5.0 * p[0] * math.cos(5.0 * t), 25.0 * p[0] * math.sin(5.0 * t)


@dataclass(frozen=True)
class Jumping(fm.Motion):
    """A slow turn that jumps at 0.4321 s without announcing it."""

    height: float

    @fm.drive_kernel
    def kernel(p, t):
        return t + (p[0] if t > 0.4321 else 0.0), 1.0, 0.0


@dataclass(frozen=True)
class NotFinite(fm.Motion):
    """A motion that ends at 0.5 s with the root of a negative number."""

    scale: float

    @fm.drive_kernel
    def kernel(p, t):
        s = math.sqrt(0.5 - t) if t <= 0.5 else math.nan
        return p[0] * s, -0.5 * p[0] / s, -0.25 * p[0] / s**3


@dataclass(frozen=True)
class Pulling(fm.NormalLaw):
    """A spring that pulls a journal back to the middle before it touches."""

    stiffness: float

    @fm.normal_law
    def kernel(p, h, gap, gap_rate, z, z_new):
        return -p[0] * gap, -p[0], 0.0


@dataclass(frozen=True)
class Sticky(fm.NormalLaw):
    """A damped spring that pulls while the surfaces part."""

    stiffness: float
    damping: float

    @fm.normal_law
    def kernel(p, h, gap, gap_rate, z, z_new):
        if gap > 0.0:
            return 0.0, 0.0, 0.0
        return -p[0] * gap - p[1] * gap_rate, -p[0], -p[1]


@dataclass(frozen=True)
class WrongStiffness(fm.NormalLaw):
    """A linear spring with the derivative of a stiffer one."""

    stiffness: float

    @fm.normal_law
    def kernel(p, h, gap, gap_rate, z, z_new):
        if gap > 0.0:
            return 0.0, 0.0, 0.0
        return -p[0] * gap, -3.0 * p[0], 0.0


@dataclass(frozen=True)
class Driving(fm.FrictionLaw):
    """Friction with the wrong sign."""

    coefficient: float

    @fm.friction_law
    def kernel(p, h, slip, N, z, z_new):
        return p[0] * N * math.tanh(slip / 1e-3)


@dataclass(frozen=True)
class OneWay(fm.FrictionLaw):
    """A force that always points forwards, as a belt that someone forgot to move."""

    coefficient: float

    @fm.friction_law
    def kernel(p, h, slip, N, z, z_new):
        return p[0] * N, 0.0, p[0]


@dataclass(frozen=True)
class WrongTangent(fm.Element):
    """A spring to the ground whose stiffness has the wrong sign."""

    body: fm.Part
    stiffness: float
    coords = ("body.x",)

    @fm.element_kernel
    def kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
        r[0] = p[0] * q[0]
        K[0, 0] = -p[0]


@dataclass(frozen=True)
class Repelling(fm.Element):
    """A magnet that pushes a body away from the middle, r = -k theta."""

    body: fm.Part
    strength: float
    coords = ("body.theta",)

    @fm.element_kernel
    def kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
        r[0] = -p[0] * (q[0] - 0.5 * math.pi)
        K[0, 0] = -p[0]


@dataclass(frozen=True)
class NotANumber(fm.Element):
    """A force that is not a number at rest."""

    body: fm.Part
    strength: float
    coords = ("body.x",)

    @fm.element_kernel
    def kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
        r[0] = p[0] * v[0] / abs(v[0])


def link(name, start, end, mass=0.4, **more):
    """A slender rigid bar."""
    length = math.dist(start, end)
    return fm.RigidLink(name, start, end, mass=mass, inertia=more.pop("inertia", mass * length**2 / 12.0), **more)


def beam(name, start, end, section=STEEL_BAR, material=fm.STEEL, **more):
    """A flexible bar."""
    return fm.FlexibleLink(name, start, end, section=section, material=material, **more)


def slider_crank(*more, without=(), motion=None, **instead):
    """A sound slider-crank: crank, rod, slider, O, A, B, guide, motor; parts left out, in place of others, or added."""
    crank, rod = link("crank", O, (0.0, 0.1)), link("rod", (0.0, 0.1), C)
    slider = fm.RigidBody("slider", C, 0.3, 1e-3)
    parts = {
        "crank": crank, "rod": rod, "slider": slider,
        "O": fm.Revolute("O", fm.GROUND, crank, at=O), "A": fm.Revolute("A", crank, rod, at=(0.0, 0.1)),
        "B": fm.Revolute("B", rod, slider, at=C), "guide": fm.Prismatic("guide", fm.GROUND, slider, at=C, along=(1, 0)),
        "motor": fm.Drive("motor", "O", motion or fm.ConstantSpeed(10.0)),
    }  # fmt: skip
    parts.update(instead)
    gravity = parts.pop("gravity", (0.0, 0.0))
    return fm.Mechanism("broken", [*(p for n, p in parts.items() if n not in without), *more], gravity=gravity)


def four_bar(lengths=(0.1, 0.3, 0.25, 0.3), angle=math.pi / 2, motion=None, *more, **bodies):
    """A four-bar with crank, coupler, rocker and base of these lengths, assembled where its lengths allow it."""
    crank, coupler, rocker, base = lengths
    P, Q = (crank * math.cos(angle), crank * math.sin(angle)), (base, 0.0)
    far = math.dist(P, Q)
    along = (coupler**2 - rocker**2 + far**2) / (2.0 * far)
    high = math.sqrt(max(coupler**2 - along**2, 0.0))
    ex, ey = (Q[0] - P[0]) / far, (Q[1] - P[1]) / far
    R = (P[0] + along * ex - high * ey, P[1] + along * ey + high * ex)
    crank, coupler, rocker = link("crank", O, P), link("coupler", P, R), link("rocker", Q, R)
    joints = [
        fm.Revolute("O", fm.GROUND, crank, at=O), fm.Revolute("A", crank, coupler, at=P),
        fm.Revolute("B", coupler, rocker, at=R), fm.Revolute("D", fm.GROUND, rocker, at=Q),
    ]  # fmt: skip
    drive = [fm.Drive("motor", "O", motion)] if motion else []
    return fm.Mechanism("four-bar", [crank, coupler, rocker, *joints, *drive, *more])


def worn(name="A", **numbers):
    """The slider-crank with clearance in one joint."""
    sound = slider_crank()
    joint = sound.find(name)
    numbers = {
        "clearance": 1e-4, "bearing_radius": 0.01, "normal": fm.LankaraniNikravesh(2e9, restitution=0.9), **numbers
    }  # fmt: skip
    return sound.with_part(fm.RevoluteClearance(name, joint.first, joint.second, at=joint.at, **numbers))


def _wet():
    """The slider-crank with oil in a joint with a clearance of a fiftieth of its radius."""
    dry = worn()["A"]
    oil = fm.ShortBearing(viscosity=0.02, width=0.01)
    return slider_crank().with_part(
        fm.JournalBearing(
            "A", dry.first, dry.second, at=dry.at, clearance=2e-4, bearing_radius=0.01, normal=dry.normal, film=oil
        )
    )


def _unsized():
    """The slider-crank with a joint that wears and has no width."""
    return slider_crank().with_part(worn()["A"].worn_by(fm.Archard(bearing=1e-13)))


def pendulum(*more, body=None, gravity=(0.0, -9.81), **changes):
    """One link on a pin."""
    arm = body or link("arm", O, (0.3, -0.2), **changes)
    return fm.Mechanism("pendulum", [arm, fm.Revolute("O", fm.GROUND, arm, at=O), *more], gravity=gravity)


def column(section, force, length=1.0, material=fm.STEEL, direction=(0.0, -1.0), elements=4):
    """An upright cantilever with a load at its top."""
    mast = beam("mast", O, (0.0, length), section, material, elements=elements)
    load = fm.Force("load", mast, at=(0.0, length), force=(force * direction[0], force * direction[1]))
    return fm.Mechanism("column", [mast, fm.Fixed("base", fm.GROUND, mast, at=O), load])


def _bare_hook():
    """A quarter ring with a radius of twice its height, of which area and second moment alone are known."""
    section = fm.GeneralSection(area=2e-4, second_moment=6.7e-9, outer_fibre=0.01)
    mast = beam("mast", O, (0.04, 0.04), section, YIELDING, elements=8, turn=math.pi / 2, shear=5 / 6)
    return fm.Mechanism("hook", [mast, fm.Fixed("base", fm.GROUND, mast, at=O)])


def upright(share):
    """A link that stands on its pin, held by a share of the spring m g l/2 that it needs."""
    arm = link("arm", O, (0.0, 0.3))
    spring = fm.TorsionSpring("spring", fm.GROUND, arm, stiffness=share * 0.4 * 9.81 * 0.15) if share else None
    return pendulum(*([spring] if spring else []), body=arm)


def tall_mast(share):
    """An upright strip as long as a share of Greenhill's length, (7.837 E I/(rho A g))^(1/3), under its own weight."""
    strip = fm.Rectangle(width=0.01, height=1e-3)
    bending = fm.STEEL.young * 1e-3**2 / 12.0
    length = share * (7.837 * bending / (fm.STEEL.density * 9.81)) ** (1.0 / 3.0)
    return replace(column(strip, 1.0, length).without_part("load"), gravity=(0.0, -9.81))


def two_masses(low, high):
    """Two masses of 1 kg above each other, on a spring each."""
    bodies = [fm.RigidBody(name, (0.0, y), 1.0, 0.1) for name, y in (("low", 1.0), ("high", 2.0))]
    guides = [fm.Prismatic(f"guide{b.name}", fm.GROUND, b, at=b.at, along=(0, 1)) for b in bodies]
    springs = [
        fm.SpringDamper("spring1", fm.GROUND, bodies[0], O, (0.0, 1.0), stiffness=low),
        fm.SpringDamper("spring2", *bodies, (0.0, 1.0), (0.0, 2.0), stiffness=high),
    ]
    return fm.Mechanism("masses", [*bodies, *guides, *springs], gravity=(0.0, -9.81))


def servo(kp, kd, ki=0.0):
    """A link on a pin that a controller turns."""
    arm = link("arm", O, (0.3, -0.2))
    parts = [fm.Torque("actuator", arm, 1.0), fm.PID("servo", "arm.theta", "actuator", target=0.5, kp=kp, kd=kd, ki=ki)]
    return pendulum(*parts, body=arm)


def truss(*points):
    """Two bars between two fixed points and one joint."""
    one, two = link("one", points[0], points[1]), link("two", points[1], points[2])
    pins = [fm.Revolute("P", fm.GROUND, one, at=points[0]), fm.Revolute("Q", one, two, at=points[1])]
    return fm.Mechanism("truss", [one, two, *pins, fm.Revolute("R", fm.GROUND, two, at=points[2])])


def parallel_cranks(third=0.2):
    """A coupler on three equal cranks, or with a third one of another length."""
    bars = [link(f"crank{k}", (0.4 * k, 0.0), (0.4 * k, 0.2 if k < 2 else third)) for k in range(3)]
    coupler = fm.RigidBody("coupler", (0.4, 0.2), 1.0, 0.1)
    low = [fm.Revolute(f"O{k}", fm.GROUND, bar, at=bar.start) for k, bar in enumerate(bars)]
    high = [fm.Revolute(f"A{k}", bar, coupler, at=bar.end) for k, bar in enumerate(bars)]
    return fm.Mechanism("cranks", [*bars, coupler, *low, *high, fm.Drive("motor", "O0", fm.ConstantSpeed(1.0))])


LOOSE, SECOND = link("loose", (1.0, 0.0), (1.2, 0.0)), link("second", (1.2, 0.0), (1.5, 0.0))
PAIR = fm.Revolute("hinge", LOOSE, SECOND, at=(1.2, 0.0))
STONE = fm.RigidBody("stone", (2.0, 0.0), 1.0, 0.1)
WAVE = fm.drives.Table((0.0, 0.1, 0.11, 0.12, 0.13, 1.0), (0.0, 0.0, 1.0, 1.0, 0.0, 0.0))


def _second_drive():
    return slider_crank(fm.Drive("push", "guide", fm.drives.Harmonic(0.01, 3.0)))


def _two_cranks_driven():
    mech = four_bar()
    return replace(
        mech,
        parts=(*mech.parts, fm.Drive("m1", "O", fm.ConstantSpeed(1.0)), fm.Drive("m2", "D", fm.ConstantSpeed(2.0))),
    )


def _two_cranks_at_odds():
    mech = four_bar()
    return replace(
        mech,
        parts=(
            *mech.parts,
            fm.Drive("m1", "O", fm.ConstantSpeed(1.0)),
            fm.Drive("m2", "D", fm.drives.Polynomial((0.4, 1.0))),
        ),
    )


def _driven_truss():
    mech = truss(O, (0.3, 0.4), (0.6, 0.0))
    return replace(mech, parts=(*mech.parts, fm.Drive("motor", "P", fm.ConstantSpeed(1.0))))


def _two_slides():
    block = fm.RigidBody("block", O, 1.0, 0.1)
    slides = [fm.Prismatic(f"slide{k}", fm.GROUND, block, at=(0.0, 0.1 * k), along=(1, 0)) for k in range(2)]
    return fm.Mechanism("slides", [block, *slides])


def _crossed_slides():
    block = fm.RigidBody("block", O, 1.0, 0.1)
    slides = [fm.Prismatic(f"slide{k}", fm.GROUND, block, at=O, along=(1, k)) for k in range(2)]
    return fm.Mechanism("slides", [block, *slides, fm.Drive("push", "slide0", fm.drives.Ramp(0.1, 1.0))])


def _twice_pinned():
    arm = link("arm", O, (0.3, 0.0))
    pins = [fm.Revolute(f"pin{k}", fm.GROUND, arm, at=O) for k in range(2)]
    return fm.Mechanism("pins", [arm, *pins])


def _welded_loop():
    mech = four_bar()
    return mech.with_part(fm.Fixed("A", mech.find("crank"), mech.find("coupler"), at=mech.find("A").at)).with_part(
        fm.Fixed("B", mech.find("coupler"), mech.find("rocker"), at=mech.find("B").at)
    )


def _dead_centre():
    crank, rod = link("crank", O, A), link("rod", A, C)
    slider = fm.RigidBody("slider", C, 0.3, 1e-3)
    joints = [
        fm.Revolute("O", fm.GROUND, crank, at=O), fm.Revolute("A", crank, rod, at=A),
        fm.Revolute("B", rod, slider, at=C),
        fm.Prismatic("guide", fm.GROUND, slider, at=C, along=(1, 0)),
        fm.Drive("push", "guide", fm.drives.Harmonic(0.01, 3.0)),
    ]  # fmt: skip
    return fm.Mechanism("dead", [crank, rod, slider, *joints])


def _flat_parallelogram():
    mech = four_bar((0.2, 0.4, 0.2, 0.4), angle=1e-14)
    return replace(mech, parts=(*mech.parts, fm.Drive("motor", "O", fm.ConstantSpeed(1.0))))


def _offset_loop(gap):
    """A four-bar whose drive starts where the loop cannot be."""
    return four_bar((0.3, 0.1, 0.12, 0.3), 0.2, fm.drives.Polynomial((gap, 0.1)))


def _joint_away():
    sound = slider_crank()
    rod = link("rod", (0.0, 0.1), (0.05, 0.09))
    parts = [rod if part.name == "rod" else part for part in sound.parts if part.name != "B"]
    far = (0.4, 0.02)
    slider = fm.RigidBody("slider", far, 0.3, 1e-3)
    parts = [slider if part.name == "slider" else part for part in parts if part.name != "guide"]
    guide = fm.Prismatic("guide", fm.GROUND, slider, at=far, along=(1, 0))
    return fm.Mechanism("away", [*parts, fm.Revolute("B", rod, slider, at=far), guide])


def _headstand():
    arm = link("arm", O, (0.0, 0.3))
    return pendulum(Repelling("magnet", arm, 50.0), body=arm, gravity=(0.0, 0.0))


def _thrown():
    arm = link("arm", O, (0.3, 0.0), velocity=(5.0, 0.0, 0.0))
    return fm.Mechanism("thrown", [arm, fm.Revolute("O", fm.GROUND, arm, at=O)])


def _one_layer():
    """A cantilever of squares with four nodes, one over the height: 48 % too stiff in bending."""
    x, y = np.tile(np.linspace(0.0, 1.0, 11), 2), np.repeat([0.0, 0.1], 11)
    first = np.arange(10)
    cells = np.column_stack([first, first + 1, first + 12, first + 11])
    mesh = fm.meshes.PlaneMesh(np.column_stack([x, y]), cells, "quad4", sets={"left": np.flatnonzero(x == 0.0)})
    lever = fm.PlaneBody("lever", mesh, at=O, thickness=0.01, material=fm.STEEL, pins=("left",))
    return fm.Mechanism("lever", [lever, fm.Fixed("wall", fm.GROUND, lever, at=(0.0, 0.05))])


def _thrown_pair():
    one = link("one", O, (0.3, 0.0), velocity=(0.0, 1.0, 0.0))
    two = link("two", (0.3, 0.0), (0.6, 0.0), velocity=(0.0, -1.0, 0.0))
    pin = fm.Revolute("pin", one, two, at=(0.3, 0.0))
    return fm.Mechanism("pair", [one, two, pin, fm.Fixed("weld", fm.GROUND, one, at=O)])


SOFT = fm.LankaraniNikravesh(2e9 / 10.0**4.5, restitution=0.9)
"""A stiffness in N/mm^1.5."""
HEAVY = replace(fm.STEEL, density=7.85)
GIGA = replace(fm.STEEL, young=207.0)
YIELDING = replace(fm.STEEL, yield_stress=2.5e8)

Case = tuple[Callable[[], fm.Mechanism], dict[str, set[str]]]
CASES: dict[str, Case] = {
    # bodies that hang on nothing
    "one loose link": (lambda: slider_crank(LOOSE), {"free-body": {"loose"}}),
    "two loose links in one group": (lambda: slider_crank(LOOSE, SECOND, PAIR), {"free-body": {"loose", "second"}}),
    "a loose link and a stone": (lambda: slider_crank(LOOSE, STONE), {"free-body": {"loose", "stone"}}),
    "a forgotten guide": (lambda: slider_crank(without=("guide",)), {"free-motion": {"slider"}}),
    "a forgotten pin in the middle": (lambda: slider_crank(without=("A",)), {"free-motion": {"rod"}}),
    "only a force holds it": (
        lambda: slider_crank(LOOSE, fm.Force("load", LOOSE, at=(1.0, 0.0), force=(1.0, 0.0))), {"free-body": {"loose"}},
    ),
    "two flying bodies": (lambda: fm.Mechanism("sky", [LOOSE, STONE]), {"free-body": {"loose", "stone"}}),
    # branches that cross
    "a parallelogram that passes through its flat pose": (
        lambda: four_bar((0.2, 0.4, 0.2, 0.4), 1.0, fm.ConstantSpeed(1.0)), {"branch-point": set()},
    ),
    "a drive that begins beyond the flat pose": (
        lambda: four_bar((0.2, 0.4, 0.2, 0.4), 1.0, fm.drives.Polynomial((3.0, 0.1))), {"other-branch": set()},
    ),
    # drives too many
    "two drives on one freedom": (_second_drive, {"over-driven": {"motor", "push"}}),
    "both cranks of a four-bar driven": (_two_cranks_driven, {"over-driven": {"m1", "m2"}}),
    "a driven truss": (_driven_truss, {"over-driven": {"motor"}}),
    "a driven block in two slides": (_crossed_slides, {"over-driven": {"push"}}),
    "a drive too many beside clearance": (
        lambda: worn("B").with_part(fm.Drive("push", "guide", fm.drives.Harmonic(0.01, 3.0))),
        {"hidden-over-drive": {"motor", "push"}},
    ),
    # joints that repeat or contradict one another
    "two parallel slides": (_two_slides, {"redundant-joints": {"slide0", "slide1"}}),
    "one pin twice": (_twice_pinned, {"redundant-joints": {"pin0", "pin1"}}),
    "three parallel cranks": (parallel_cranks, {"redundant-joints": {"O1", "A1", "A2"}}),
    "welded joints in a loop": (_welded_loop, {"redundant-joints": {"A", "B", "O", "D"}}),
    "two drives that start at odds": (_two_cranks_at_odds, {"contradicting-joints": {"m1", "m2"}}),
    # singular poses
    "a slider-crank pushed at its dead centre": (_dead_centre, {"singular-pose": {"push"}}),
    "a flat parallelogram": (_flat_parallelogram, {"singular-pose": {"O", "A", "B", "D"}}),
    "a straight truss": (lambda: truss(O, (0.3, 0.0), (0.6, 0.0)), {"singular-pose": {"P", "Q", "R"}}),
    # loops that cannot close
    "a drive that starts out of reach": (lambda: _offset_loop(2.0), {"open-loop": {"motor"}}),
    "a drive that starts just out of reach": (lambda: _offset_loop(0.6), {"open-loop": {"motor"}}),
    "a guide that is driven too far": (
        lambda: slider_crank(without=("motor",), push=fm.Drive("push", "guide", fm.drives.Polynomial((0.5, 0.0)))),
        {"open-loop": {"push"}},
    ),
    # loops that close only in a part of the motion
    "a driven rocker": (
        lambda: four_bar((0.3, 0.1, 0.3, 0.32), 1.2, fm.ConstantSpeed(1.0)), {"locking-drive": {"motor"}},
    ),
    "a driven rocker, backwards": (
        lambda: four_bar((0.3, 0.1, 0.3, 0.32), 1.2, fm.ConstantSpeed(-1.0)), {"locking-drive": {"motor"}},
    ),
    "a triple rocker": (
        lambda: four_bar((0.25, 0.2, 0.25, 0.45), 0.9, fm.ConstantSpeed(3.0)), {"locking-drive": {"motor", "A", "B"}},
    ),
    "a swing beyond its reach": (
        lambda: four_bar((0.3, 0.1, 0.3, 0.32), 1.2, fm.drives.Harmonic(1.5, 2.0)), {"locking-drive": {"motor"}},
    ),
    # numbers in other units
    "millimetres": (
        lambda: pendulum(body=link("arm", O, (300.0, -200.0))), {"odd-units": {"arm"}},
    ),
    "a crank of 45 m": (lambda: pendulum(body=link("arm", O, (45.0, 0.0))), {"odd-units": set()}),
    "a truss at its place on a map": (
        lambda: truss((5e5, 4e6), (5e5 + 0.3, 4e6 + 0.4), (5e5 + 0.6, 4e6)), {"far-origin": set()},
    ),
    "gravity in mm/s^2": (lambda: pendulum(gravity=(0.0, -9810.0)), {"odd-units": set()}),
    "inertia in kg mm^2": (lambda: pendulum(inertia=4e3), {"odd-units": {"arm"}}),
    "inertia of a speck": (lambda: pendulum(inertia=1e-9), {"odd-units": {"arm"}}),
    "density in g/cm^3": (lambda: column(STEEL_BAR, 1.0, material=HEAVY), {"odd-units": {"mast"}}),
    "Young's modulus in GPa": (lambda: column(STEEL_BAR, 1e-9, material=GIGA), {"odd-units": {"mast"}}),
    "yield stress in MPa": (
        lambda: column(STEEL_BAR, 1.0, material=replace(fm.STEEL, yield_stress=250.0)), {"odd-units": {"mast"}},
    ),
    "speed in rpm": (lambda: slider_crank(motion=fm.ConstantSpeed(3e4)), {"odd-units": {"motor"}}),
    # dimensions
    "a joint far from its link": (_joint_away, {"far-joint": {"B", "rod"}}),
    "a clearance in mm": (lambda: worn("A", clearance=0.1, bearing_radius=0.2), {"large-clearance": {"A"}}),
    "a clearance as large as the radius": (
        lambda: worn("A", clearance=5e-3, bearing_radius=0.01), {"large-clearance": {"A"}},
    ),
    "a gap too wide for a film": (_wet, {"thick-film": {"A"}}),
    "wear without a width": (_unsized, {"width-of-wear": {"A"}}),
    "stiffness in N/mm^1.5": (lambda: worn("A", normal=SOFT), {"soft-contact": {"A"}}),
    "stiffness of rubber under weight": (
        lambda: replace(worn("B", normal=fm.contact.Hertz(2e3)), gravity=(0.0, -9.81)), {"soft-contact": {"B"}},
    ),
    "a beam as thick as it is long": (
        lambda: column(fm.Rectangle(width=0.1, height=0.2), 1.0, length=0.2), {"stubby-beam": {"mast"}},
    ),
    "a hook whose outline is unknown": (_bare_hook, {"thick-arc": {"mast"}}),
    "a round block": (lambda: column(fm.Circle(0.3), 1.0, length=1.0), {"stubby-beam": {"mast"}}),
    # loads
    "a load beyond yield": (
        lambda: column(STEEL_BAR, 200.0, material=YIELDING, direction=(1.0, 0.0)), {"overload": {"mast"}},
    ),
    "strains of a tenth": (lambda: column(STEEL_BAR, 4e3, direction=(1.0, 0.0), elements=8), {"overload": {"mast"}}),
    "a buckled column": (lambda: column(STEEL_BAR, 600.0), {"buckled": set()}),
    "a column near buckling": (lambda: column(STEEL_BAR, 300.0), {"near-buckling": set()}),
    "an inverted pendulum": (_headstand, {"unstable-reference": {"arm"}}),
    "a pendulum that stands on its head": (lambda: upright(0.0), {"unstable-reference": {"arm"}}),
    "a pendulum on a spring that is too soft": (lambda: upright(0.95), {"unstable-reference": {"arm"}}),
    "a mast that buckles under its own weight": (
        lambda: tall_mast(1.05), {"unstable-reference": {"mast"}, "buckled": set()},
    ),
    # stiffness
    "a spring of 1e17 N/m": (lambda: two_masses(1e17, 1e3), {"stiffness-ratio": {"low"}}),
    "springs of 1e12 and 1e-4 N/m": (
        lambda: replace(two_masses(1e12, 1e-4), gravity=(0.0, 0.0)), {"stiffness-ratio": {"low"}},
    ),
    # joints on wrong bodies
    "a pin on another body than the rod's": (
        lambda: slider_crank(
            LEVER, fm.Revolute("L", fm.GROUND, LEVER, at=(0.2, 0.2)),
            B=fm.Revolute("B", LEVER, fm.RigidBody("slider", C, 0.3, 1e-3), at=C),
        ),
        {"left-out-link": {"B", "rod"}},
    ),
    # control
    "a servo with the wrong sign": (lambda: servo(-200.0, -20.0), {"unstable-loop": {"servo"}}),
    "a servo without damping that reads late": (lambda: servo(200.0, 0.0, 500.0), {"unstable-loop": {"servo"}}),
    # motions
    "a rate of half the true size": (lambda: slider_crank(motion=WrongRate(10.0)), {"wrong-rate": {"motor"}}),
    "an acceleration of the wrong sign": (
        lambda: slider_crank(motion=WrongAcceleration(0.5)), {"wrong-rate": {"motor"}},
    ),
    "a jump that is not announced": (lambda: slider_crank(motion=Jumping(0.2)), {"jumping-drive": {"motor"}}),
    "a small jump": (lambda: slider_crank(motion=Jumping(0.004)), {"jumping-drive": {"motor"}}),
    "a table that overshoots": (lambda: slider_crank(motion=WAVE), {"overshooting-table": {"motor"}}),
    "a motion that ends": (lambda: slider_crank(motion=NotFinite(1.0)), {"broken-kernel": {"motor"}}),
    # speeds, angles, gravity
    "5000 rpm as rad/s": (lambda: slider_crank(motion=fm.ConstantSpeed(5000.0)), {"odd-units": {"motor"}}),
    "a swing of 30 degrees as rad": (
        lambda: slider_crank(motion=fm.drives.Harmonic(30.0, 2.0)), {"odd-units": {"motor"}},
    ),
    "a stop at 60 degrees as rad": (
        lambda: pendulum().with_part(fm.Stop("end", joint="O", above=60.0, normal=fm.KelvinVoigt(1e4, 1.0, 1e-4))),
        {"odd-units": {"end"}},
    ),
    "gravity upwards": (lambda: replace(pendulum(), gravity=(0.0, 9.81)), {"upward-gravity": set()}),
    "a pendulum without gravity": (lambda: replace(pendulum(), gravity=(0.0, 0.0)), {"nothing-moves": set()}),
    # laws
    "a normal law that pulls at a distance": (lambda: worn("A", normal=Pulling(1e6)), {"pulling-contact": {"A"}}),
    "a normal law that sticks": (lambda: worn("A", normal=Sticky(1e6, 1e4)), {"pulling-contact": {"A"}}),
    "a normal law with another law's stiffness": (
        lambda: worn("A", normal=WrongStiffness(1e6)), {"broken-kernel": {"A"}},
    ),
    "friction that drives": (lambda: worn("A", friction=Driving(0.1)), {"driving-friction": {"A"}}),
    "friction that points forwards": (lambda: worn("B", friction=OneWay(0.1)), {"driving-friction": {"B"}}),
    "friction that drives in an ideal joint": (
        lambda: slider_crank(
            O=fm.Revolute("O", fm.GROUND, link("crank", O, (0.0, 0.1)), at=O, friction=Driving(0.1), radius=0.01)
        ),
        {"driving-friction": {"O"}},
    ),
    "a spring with a wrong tangent": (
        lambda: slider_crank(WrongTangent("spring", link("crank", O, (0.0, 0.1)), 100.0)),
        {"broken-kernel": {"spring"}},
    ),
    "a force that is not a number": (
        lambda: slider_crank(NotANumber("force", link("crank", O, (0.0, 0.1)), 100.0)), {"not-compilable": {"force"}},
    ),
    "a beam of one layer of squares": (_one_layer, {"coarse-cells": {"lever"}}),
    # start
    "a pinned link thrown along its axis": (_thrown, {"forbidden-velocity": {"O"}}),
    "a welded link thrown": (_thrown_pair, {"forbidden-velocity": {"pin"}}),
    # several at once
    "loose, over-driven and in mm/s^2": (
        lambda: slider_crank(LOOSE, fm.Drive("push", "guide", fm.drives.Harmonic(0.01, 3.0)), gravity=(0.0, -9810.0)),
        {"free-body": {"loose"}, "over-driven": {"motor", "push"}, "odd-units": set()},
    ),
    "a drive that starts out of reach, and a massless pendulum": (
        lambda: four_bar(
            (0.3, 0.1, 0.12, 0.3), 0.2, fm.drives.Polynomial((2.0, 0.1)),
            THREAD, fm.Revolute("T", fm.GROUND, THREAD, at=(1.0, 0.0)),
        ),
        {"open-loop": {"motor"}, "no-inertia": {"thread"}},
    ),
    "soft, driven by friction, with a loose stone": (
        lambda: worn("A", normal=SOFT, friction=Driving(0.2)).with_part(STONE),
        {"soft-contact": {"A"}, "driving-friction": {"A"}, "free-body": {"stone"}},
    ),
    "a wrong rate in a mechanism with one pin twice": (
        lambda: slider_crank(
            fm.Revolute("again", fm.GROUND, link("crank", O, (0.0, 0.1)), at=O), motion=WrongRate(2.0)
        ),
        {"wrong-rate": {"motor"}, "redundant-joints": {"O", "again"}},
    ),
    "a large clearance, sticky, with a table that overshoots": (
        lambda: worn("B", clearance=5e-3, normal=Sticky(1e6, 1e4)).with_part(fm.Drive("motor", "O", WAVE)),
        {"large-clearance": {"B"}, "pulling-contact": {"B"}, "overshooting-table": {"motor"}},
    ),
}  # fmt: skip
"""Mechanisms by what is wrong with them: function that makes one, and names of parts by the codes that must appear."""
