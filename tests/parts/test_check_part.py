"""`check_part`: every part of the library keeps its contracts, and every broken contract is found."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from cases import slow_where
from public_names import PUBLIC

import flexmb as fm
from flexmb.controllers import DCMotor
from flexmb.errors import KernelError, ModelError
from flexmb.testing import Report, check_part

O, A, B, C = (0.0, 0.0), (0.1, 0.17), (0.5, 0.1), (0.7, -0.1)
BAR = fm.Rectangle(width=0.01, height=0.02)
TAPER = fm.Tapered(fm.Rectangle(width=0.01, height=0.03), fm.Rectangle(width=0.01, height=0.012))
MOTION, WOBBLE = fm.ConstantSpeed(6.0), fm.drives.Polynomial((0.0, 0.1, -0.3, 0.2))


def crank():
    return fm.RigidLink("crank", O, A, mass=0.4, inertia=2e-3, centre=0.4)


def arm():
    return fm.RigidLink("arm", A, B, mass=0.8, inertia=8e-3)


def two_links(*parts, second=None):
    """Crank and arm with further parts."""
    second = arm() if second is None else second
    pin = fm.Revolute("O", fm.GROUND, crank(), at=O)
    return fm.Mechanism("two links", [crank(), second, pin, *parts], gravity=(1.3, -9.81))


def alone(*parts):
    return fm.Mechanism("alone", parts, gravity=(1.3, -9.81))


def plane_body(**changes):
    """A soft plate with three kinds of nodes: of a rigid pin, of an averaged pin, free ones."""
    mesh = fm.meshes.rectangle(0.3, 0.1, 2, 1, "tri6")
    values = {"at": (0.1, 0.2), "angle": 0.4, "thickness": 0.01, "pins": ("left", "right"), "damping": 2e-4}
    values |= {"interface": {"right": "averaged"}, "material": fm.Material(1e6, 2000.0)}
    return fm.PlaneBody("plate", mesh, **{**values, **changes})


def growing(points):
    return 1e3 * points


def mesh_loads(body):
    """Loads on free nodes and on nodes of pins, dead and following."""
    return (
        fm.loads.EdgeLoad("load", body, "top", (2e3, -1e3)),
        fm.loads.EdgeLoad("load", body, "left", growing, follower=True, history=fm.drives.Harmonic(0.7, 3.0, 0.4, 0.1)),
        fm.loads.EdgePressure("load", body, "top", 3e3, 1e3),
        fm.loads.EdgePressure("load", body, "left", 0.0, 1e3),
        fm.loads.BodyForce("load", body, growing),
        fm.loads.BodyForce("load", body, (2e3, -4e3), follower=True),
    )


def sliding():
    """A slider with an offset, guided along a moving link."""
    slider = fm.RigidBody("slider", (0.3, 0.2), mass=0.3, inertia=1e-3, theta=0.4)
    joint = fm.Prismatic("slide", crank(), slider, at=(0.05, 0.085), along=(0.9, 0.3))
    return joint, slider


def clearance(normal, friction):
    return fm.RevoluteClearance(
        "pin", crank(), arm(), at=A, clearance=2e-4, bearing_radius=8e-3, normal=normal, friction=friction
    )


LN = fm.LankaraniNikravesh(stiffness=2e9, restitution=0.85)
NORMAL_LAWS = (
    *(
        kind(stiffness=2e9, restitution=0.95)
        for kind in (
            fm.HuntCrossley, fm.contact.HerbertMcWhannell, fm.contact.LeeWang, fm.contact.Gonthier,
            fm.contact.ZhiyingQishao, fm.contact.Flores, fm.contact.HuGuo, fm.contact.CarvalhoMartins,
        )
    ),
    fm.contact.ExactRestitution(stiffness=2e9, exponent=10.0 / 9.0, restitution=0.3),
    fm.contact.Hertz(stiffness=2e9),
    fm.KelvinVoigt(2e7, 3e3, ramp=5e-5),
    *(
        kind(0.01, (fm.STEEL, fm.STEEL), restitution=0.4)
        for kind in (
            fm.contact.Johnson, fm.contact.Radzimovsky, fm.contact.Goldsmith, fm.contact.DubowskyFreudenstein,
            fm.contact.ESDU78035,
        )
    ),
)  # fmt: skip
COULOMB = fm.ModifiedCoulomb(0.2, v0=1e-4, v1=1e-2)
SOFT = fm.KelvinVoigt(2e7, 3e3, ramp=5e-5)
JOINT, SLIDER = sliding()
OIL = {"viscosity": 0.02, "width": 0.012}
FILMS = {
    "short": fm.ShortBearing(**OIL),
    "short, half": fm.ShortBearing(**OIL, cavitation="half"),
    "long": fm.LongBearing(**OIL),
    "long, all round": fm.LongBearing(**OIL, cavitation="none"),
    "finite": fm.FiniteBearing(**OIL),
    "finite, supplied everywhere": fm.FiniteBearing(**OIL, supply="everywhere"),
}
WEAR = {"bearing": fm.Archard(bearing=1e-13, width=0.02), "journal": fm.EnergyWear(journal=1e-12, width=0.02)}
WAVES = 2.0 * np.pi * np.arange(360) / 180.0
RUBBER = {"stiffness": (1e4, 3e4), "damping": (3.0, 1.0), "torsion": 5.0, "torsion_damping": 0.1, "along": (1.0, 0.3)}
SLOT = {"clearance": 2e-4, "pin_radius": 8e-3, "normal": LN, "friction": COULOMB}
GUIDE = {"clearance": 2e-4, "half_length": 0.03, "half_height": 0.01, "normal": LN, "friction": COULOMB}
DISC = fm.ClosedCurve.from_function(lambda u: (0.05 + 0.07 * math.cos(u), 0.1 + 0.05 * math.sin(u)), 60)
FACE = fm.Line((0.12, 0.0), (0.125, 0.2))
MOON = fm.cams.Outline((O, (0.1, 0.0)), (-0.3, 1.0))
HALF = fm.cams.Outline(((0.03, 0.06), (0.09, 0.06)), (0.0, 1.0))
HOOK = fm.cams.Outline((O, (0.1, 0.0), (0.05, 0.03), (0.0, 0.1)), (0.0, 0.0, -0.1, 0.2))
TIMES = tuple(np.linspace(0.0, 1.0, 9))
WAVE = tuple(0.2 * math.sin(2.0 * math.pi * t) for t in TIMES)


def flexible(**changes):
    given = {"section": BAR, "material": fm.STEEL, "elements": 2, **changes}
    return fm.FlexibleLink("arm", A, B, **given)


def frame():
    return fm.FlexibleFrame(
        "frame", (O, (0.4, 0.05), (0.1, 0.3)), ((0, 1), (1, 2), (2, 0)), section=BAR, material=fm.STEEL, elements=1,
        mass=4.0, inertia=0.105, damping=1e-4,
    )  # fmt: skip


def driven(motion):
    return two_links(fm.Revolute("A", crank(), arm(), at=A), fm.Drive("motor", "A", motion))


@fm.control_kernel
def mixer(p, t, u, x, dx, y):
    """A law that is not linear."""
    last = u[u.shape[0] - 1]
    dx[0] = -p[0] * x[0] + u[0] * last
    y[0] = p[1] * u[0] ** 3 + x[0] * last + math.sin(t)


COIL = {"resistance": 1.0, "torque_constant": 0.1}


def controlled(*controllers):
    """Crank and arm with a marker, a torque and a follower force."""
    pin, tip = fm.Revolute("pin", crank(), arm(), at=A), fm.Marker("tip", arm(), at=B)
    thrust = fm.Force("thrust", arm(), at=B, force=(3.0, -7.0), follower=True)
    return two_links(pin, tip, fm.Torque("torque", arm(), 2.0), thrust, *controllers)


BUILT_IN = {
    "RigidLink": (two_links(), "crank"),
    "RigidBody": (alone(fm.RigidBody("body", A, mass=2.0, inertia=0.1, theta=0.3)), "body"),
    "PointMass": (alone(fm.bodies.PointMass("bob", A, mass=2.0)), "bob"),
    "FlexibleLink": (alone(flexible()), "arm"),
    # so soft that gravity bends it as much as its stiffness resists: the tangent of gravity shows
    "FlexibleLink, soft": (alone(flexible(material=fm.Material(1e3, 2000.0))), "arm"),
    "FlexibleLink, tapered": (alone(flexible(section=TAPER)), "arm"),
    "FlexibleLink, bosses": (alone(flexible(mass=2.0, inertia=0.075, pivot_inertia=1e-3)), "arm"),
    "FlexibleLink, damped": (alone(flexible(damping=2e-4)), "arm"),
    "FlexibleLink, mass damping": (alone(flexible(mass=2.0, inertia=0.075, mass_damping=30.0)), "arm"),
    "FlexibleLink, stress": (alone(flexible(stress=True)), "arm"),
    "FlexibleLink, uneven": (alone(flexible(elements=(0.1, 0.4))), "arm"),
    "Reduced": (alone(fm.Reduced(flexible(damping=2e-4), modes=3)), "arm"),
    # so soft and coarse that stiffening, gravity and inertia show beside stiffness
    "Reduced, soft, by a pin": (
        alone(
            fm.Reduced(
                flexible(material=fm.Material(1e4, 2000.0), elements=4), modes=4, frame="pin", damping_ratios=0.1
            )
        ),
        "arm",
    ),
    "Reduced, soft": (alone(fm.Reduced(flexible(material=fm.Material(1e4, 2000.0), elements=4), modes=4)), "arm"),
    "Reduced, one pin": (alone(fm.Reduced(flexible(), modes=3, pins=("start",))), "arm"),
    "FlexibleLink, shear": (alone(flexible(section=TAPER, shear=True, damping=2e-4)), "arm"),
    "FlexibleLink, deep, shear": (alone(flexible(section=fm.Rectangle(0.01, 0.4), shear=5.0 / 6.0)), "arm"),
    "FlexibleLink, arc": (alone(flexible(turn=0.8, damping=2e-4)), "arm"),
    "FlexibleLink, arc, soft": (alone(flexible(turn=-0.8, material=fm.Material(1e3, 2000.0), shear=True)), "arm"),
    "FlexibleLink, arc, mass damping": (alone(flexible(turn=0.8, mass_damping=30.0)), "arm"),
    "FlexibleFrame, arcs": (alone(replace(frame(), turns=(0.3, 0.0, 1.0), inertia=0.12, shear=True)), "frame"),
    "FlexibleFrame, mean mass": (alone(frame()), "frame"),
    "FlexibleFrame, mass damping": (alone(replace(frame(), mass_damping=30.0)), "frame"),
    "PlaneBody": (alone(plane_body()), "plate"),
    "PlaneBody, total Lagrange": (alone(plane_body(formulation="total-lagrange")), "plate"),
    "Revolute": (two_links(fm.Revolute("A", crank(), arm(), at=A)), "A"),
    "Revolute, friction": (
        two_links(fm.Revolute("A", crank(), arm(), at=A, friction=COULOMB, radius=0.01, preload=2.0)),
        "A",
    ),
    "Prismatic, friction": (
        two_links(replace(JOINT, friction=COULOMB, length=0.05, preload=2.0), second=SLIDER),
        "slide",
    ),
    "Revolute on ground": (two_links(), "O"),
    "Revolute on a beam": (two_links(fm.Revolute("A", crank(), flexible(), at=A), second=flexible()), "A"),
    "Fixed": (two_links(fm.Fixed("A", crank(), arm(), at=A)), "A"),
    "FlexibleLink, bent and moving": (
        alone(flexible(displacement=lambda s: (0.0, 0.01 * s, 0.04 * s), velocity=lambda s: (s, -s * s, 2.0))), "arm",
    ),
    "Clamp": (two_links(fm.Clamp("A", crank(), arm(), at=A, angle=MOTION, x=fm.drives.Ramp(0.2, 0.8), y=WOBBLE)), "A"),
    "Clamp on ground": (two_links(fm.Clamp("A", fm.GROUND, arm(), at=A, y=WOBBLE)), "A"),
    "Prismatic": (two_links(JOINT, second=SLIDER), "slide"),
    "RevoluteClearance": (two_links(clearance(LN, fm.friction.Frictionless())), "pin"),
    **{
        f"JournalBearing, {name}": (
            two_links(
                fm.JournalBearing(
                    "pin", crank(), arm(), at=A, clearance=2e-4, bearing_radius=8e-3, normal=LN, friction=COULOMB,
                    film=film, roughness=3e-6,
                )
            ),
            "pin",
        )
        for name, film in FILMS.items()
    },
    **{
        f"WornClearance, {name}": (
            two_links(clearance(LN, COULOMB).worn_by(law).with_depths(1e-4 * (1.0 - np.cos(WAVES)))), "pin",
        )
        for name, law in WEAR.items()
    },
    "WornBearing": (
        two_links(
            fm.JournalBearing(
                "pin", crank(), arm(), at=A, clearance=2e-4, bearing_radius=8e-3, normal=LN, friction=COULOMB,
                film=FILMS["short"], roughness=3e-6,
            ).worn_by(WEAR["bearing"]).with_depths(1e-4 * (1.0 - np.cos(WAVES)))
        ),
        "pin",
    ),
    "WornGuide": (
        two_links(
            fm.PrismaticClearance("pin", crank(), arm(), at=A, along=(1.0, 0.3), **GUIDE)
            .worn_by(WEAR["bearing"], length=0.2).with_depths(1e-5 * (1.0 - np.cos(np.tile(WAVES, 2))))
        ),
        "pin",
    ),
    "WornSlot": (
        two_links(
            fm.PinSlotClearance("pin", crank(), arm(), at=A, along=(1.0, 0.3), **SLOT)
            .worn_by(WEAR["bearing"], length=0.2).with_depths(1e-5 * (1.0 - np.cos(np.tile(WAVES, 2))))
        ),
        "pin",
    ),
    "Bushing": (two_links(fm.Bushing("pin", crank(), arm(), at=A, **RUBBER)), "pin"),
    "Bushing, one stiff axis": (
        two_links(fm.Bushing("pin", crank(), arm(), at=A, **{**RUBBER, "stiffness": (0.0, 3e4)})), "pin",
    ),
    "PinSlot": (two_links(fm.PinSlot("pin", crank(), arm(), at=A, along=(1.0, 0.3))), "pin"),
    "PinSlotClearance": (
        two_links(fm.PinSlotClearance("pin", crank(), arm(), at=A, along=(1.0, 0.3), length=1e-4, **SLOT)),
        "pin",
    ),
    "PrismaticClearance": (
        two_links(fm.PrismaticClearance("pin", crank(), arm(), at=A, along=(1.0, 0.3), **GUIDE)),
        "pin",
    ),
    "SliderBearing": (
        two_links(
            fm.SliderBearing(
                "pin", crank(), arm(), at=A, along=(1.0, 0.3), **GUIDE, film=FILMS["short"], roughness=3e-6
            )
        ),
        "pin",
    ),
    "RevoluteClearance, friction": (two_links(clearance(LN, COULOMB)), "pin"),
    "SpringDamper": (
        two_links(fm.SpringDamper("spring", crank(), arm(), at=(0.05, 0.085), to=B, stiffness=300.0, damping=4.0)),
        "spring",
    ),
    "SpringDamper on ground": (
        two_links(fm.SpringDamper("spring", fm.GROUND, arm(), at=C, to=B, stiffness=300.0, free_length=0.1)),
        "spring",
    ),
    "TorsionSpring": (
        two_links(fm.TorsionSpring("spring", crank(), arm(), stiffness=20.0, damping=0.3, free_angle=0.2)), "spring",
    ),
    "SpringDamper, moving end": (
        two_links(
            fm.SpringDamper(
                "spring", crank(), arm(), at=(0.05, 0.085), to=B, stiffness=300.0, damping=4.0,
                free_length=fm.drives.Harmonic(0.05, 1.3, 0.4, 0.4),
            )
        ),
        "spring",
    ),
    "TorsionSpring, moving end": (
        two_links(fm.TorsionSpring("spring", crank(), arm(), stiffness=20.0, free_angle=fm.drives.Ramp(2.0, 0.3))),
        "spring",
    ),
    "Force": (two_links(fm.Force("load", arm(), at=B, force=(30.0, -70.0))), "load"),
    "Force, follower": (two_links(fm.Force("load", arm(), at=B, force=(30.0, -70.0), follower=True)), "load"),
    "Force, follower on a beam": (
        two_links(fm.Force("load", flexible(), at=B, force=(30.0, -70.0), follower=True), second=flexible()), "load",
    ),
    "Force, Pulse": (
        two_links(fm.Force("load", arm(), at=B, force=(3.0, 1.0), history=fm.drives.Pulse(2.0, 0.3, 1.1))), "load",
    ),
    "Force, PiecewiseLinear": (
        two_links(fm.Force("load", arm(), at=B, force=(3.0, 1.0), history=fm.drives.PiecewiseLinear(TIMES, WAVE))),
        "load",
    ),
    "Torque": (two_links(fm.Torque("load", arm(), 12.0)), "load"),
    "Torque, Harmonic": (
        two_links(fm.Torque("load", arm(), 12.0, history=fm.drives.Harmonic(0.7, 3.0, 0.4, 0.1))), "load",
    ),
    **{
        f"{type(load).__name__}{number}, {name}": (alone(body, load), "load")
        for name, body in (("all nodes", plane_body()), ("reduced", fm.Reduced(plane_body(), 3)))
        for number, load in enumerate(mesh_loads(plane_body()))
    },
    "Gear": (two_links(fm.Gear("mesh", crank(), arm(), teeth=(20, 35))), "mesh"),
    "Gear, internal": (two_links(fm.Gear("mesh", crank(), arm(), teeth=(20, 35), internal=True)), "mesh"),
    "Gear, backlash": (
        two_links(
            fm.Gear(
                "mesh", crank(), arm(), teeth=(20, 35), backlash=1e-4, normal=LN, pressure_angle=math.radians(30.0),
                centres=[(body.nodes()[0].x, body.nodes()[0].y) for body in (crank(), arm())],
            )
        ),
        "mesh",
    ),
    "CurveOnCurve": (two_links(fm.CurveOnCurve("cam", crank(), DISC, arm(), FACE, friction=COULOMB)), "cam"),
    "CurveOnCurve, contact": (
        two_links(fm.CurveOnCurve("cam", crank(), DISC, arm(), FACE, normal=LN, start="open")), "cam",
    ),
    "PointOnCurve": (two_links(fm.cams.PointOnCurve("pin", crank(), DISC, arm(), (0.12, 0.1))), "pin"),
    "OutlineContact": (
        two_links(
            fm.cams.OutlineContact(
                "pin", crank(), HOOK, arm(),
                fm.cams.CircularCurve((0.08, 0.06), 0.01), normal=LN, friction=COULOMB,
            )
        ),
        "pin",
    ),
    "OutlineOnOutline": (
        two_links(fm.cams.OutlineOnOutline("moon", crank(), MOON, arm(), HALF, normal=LN, friction=COULOMB)), "moon",
    ),
    "Belt": (two_links(fm.couplings.Belt("belt", crank(), arm(), radii=(0.04, 0.03), crossed=True)), "belt"),
    "Belt, friction": (
        two_links(
            fm.couplings.Belt("belt", crank(), arm(), radii=(0.04, 0.03), coefficient=0.3, pretension=50.0, creep=0.1)
        ), "belt",
    ),
    "Rack": (two_links(fm.couplings.Rack("rack", crank(), arm(), at=B, along=(0.2, 1.0))), "rack"),
    "SameRotation": (two_links(fm.couplings.SameRotation("same", crank(), arm())), "same"),
    "Distance": (two_links(fm.couplings.Distance("rod", fm.GROUND, arm(), at=(0.1, 0.5), to=B)), "rod"),
    "Coupling": (
        two_links(
            JOINT, fm.couplings.Coupling("mesh", {"O": 0.3, "slide": 2.0}), second=SLIDER
        ),
        "mesh",
    ),
    "Cable": (
        two_links(fm.couplings.Cable("rope", crank(), arm(), at=(0.05, 0.085), to=B, free_length=0.455, normal=SOFT)),
        "rope",
    ),
    "OneWayClutch": (
        two_links(fm.couplings.OneWayClutch("A", crank(), arm(), at=A, stiffness=80.0, damping=0.3)), "A",
    ),
    "Stop": (
        two_links(
            fm.Revolute("A", crank(), arm(), at=A),
            fm.Stop("end", "A", above=1e-3, below=-1e-3, normal=SOFT, radius=0.1, along=(1.0, 0.3)),
        ),
        "end",
    ),
    "Stop of a Prismatic": (
        two_links(JOINT, fm.Stop("end", "slide", above=1e-3, below=-1e-3, normal=SOFT), second=SLIDER), "end",
    ),
    "Marker": (two_links(fm.Marker("P", arm(), at=B)), "P"),
    "Control": (
        controlled(fm.Control("servo", ["tip.vx", "tip.y"], ["torque"], mixer, numbers=(3.0, 40.0), states=1)), "servo",
    ),
    "Control, sampled": (
        controlled(fm.Control("servo", ["pin.fx"], ["torque"], mixer, numbers=(3.0, 40.0), states=1, sample=0.01)),
        "servo",
    ),
    "Control of a follower force": (
        controlled(fm.Control("servo", ["arm.theta", "arm.omega"], ["thrust"], mixer, numbers=(3.0, 40.0), states=1)),
        "servo",
    ),
    "PID": (
        controlled(fm.PID("servo", "tip.theta", "torque", target=0.3, kp=20.0, ki=5.0, kd=3.0, limit=40.0)), "servo",
    ),
    "PID, rate": (
        controlled(
            fm.PID("servo", "tip.y", "torque", target=fm.drives.Harmonic(0.2, 3.0), kp=20.0, kd=3.0, rate="tip.vy",
                   derivative_of="error")
        ),
        "servo",
    ),
    "DCMotor": (controlled(DCMotor("servo", "tip.omega", "torque", voltage=9.0, inductance=1e-3, **COIL)), "servo"),
    "DCMotor, without inductance": (
        controlled(DCMotor("servo", "tip.omega", "torque", voltage="pid.output", **COIL),
                   fm.PID("pid", "tip.theta", kp=3.0, ki=2.0, target=0.1)),
        "servo",
    ),
    "ConstantSpeed": (driven(MOTION), "motor"),
    "CycloidalRamp": (driven(fm.drives.CycloidalRamp(6.0, 0.8)), "motor"),
    "Ramp": (driven(fm.drives.Ramp(6.0, 0.8)), "motor"),
    "Harmonic": (driven(fm.drives.Harmonic(0.4, 1.5, 0.3, 0.2)), "motor"),
    "Polynomial": (driven(fm.drives.Polynomial((0.1, 2.0, -0.4, 0.3))), "motor"),
    "Table": (driven(fm.drives.Table(TIMES, WAVE)), "motor"),
    "Table, end slopes": (driven(fm.drives.Table(TIMES, WAVE, slopes=(0.0, 1.0))), "motor"),
    "Table, periodic": (driven(fm.drives.Table(TIMES, (*WAVE[:-1], WAVE[0] + 0.5), periodic=True)), "motor"),
    "Drive of a Prismatic": (
        two_links(JOINT, fm.Drive("motor", "slide", fm.ConstantSpeed(0.2)), second=SLIDER), "motor",
    ),
}  # fmt: skip
"""Name -> (mechanism, part)."""

LAWS = {
    **{type(law).__name__: (law, fm.friction.Frictionless()) for law in NORMAL_LAWS},
    "SmoothCoulomb": (LN, fm.friction.SmoothCoulomb(0.2)),
    "Threlfall": (LN, fm.friction.Threlfall(0.2)),
    "BengisuAkay": (LN, fm.friction.BengisuAkay(0.3, 0.2)),
    "Stribeck": (LN, fm.friction.Stribeck(0.3, 0.2, viscous=0.1)),
    "Stribeck, exponential": (LN, fm.friction.Stribeck(0.3, 0.2, exponent=1.0)),
    "ModifiedCoulomb": (LN, fm.friction.ModifiedCoulomb(0.2)),
    "BrownMcPhee": (LN, fm.friction.BrownMcPhee(0.3, 0.2, viscous=3.0)),
    "LuGre": (LN, fm.friction.LuGre(0.3, 0.2, damping=50.0, viscous=0.1)),
}
"""Name -> (normal law, friction law)."""


def keeps_its_contracts(mechanism, part):
    report = check_part(mechanism, part)
    assert max(check.error for check in report.checks) < 1e-6
    assert sum(check.skipped for check in report.checks) <= 3, str(report)
    return report


VARIANTS = {
    "FlexibleLink, mass damping",
    "FlexibleLink, arc, mass damping",
    "FlexibleFrame, mean mass",
    "FlexibleFrame, mass damping",
    "PlaneBody, total Lagrange",
    "Reduced, soft",
    "Reduced, soft, by a pin",
    "JournalBearing, finite, supplied everywhere",
    "JournalBearing, short, half",
    "JournalBearing, long, all round",
    "WornClearance, journal",
    "WornBearing",
    "WornGuide",
    "WornSlot",
}
"""Slow ones, whose branches others here or the tests of their own file take."""


@pytest.mark.usefixtures("states")
@pytest.mark.parametrize("kind", slow_where(lambda n: n in VARIANTS, BUILT_IN))
def test_built_in_part_keeps_its_contracts(kind):
    keeps_its_contracts(*BUILT_IN[kind])


@pytest.mark.usefixtures("states")
@pytest.mark.parametrize("kind", LAWS)
def test_built_in_law_keeps_its_contracts(kind, monkeypatch):
    """In one joint, whose gap the test of `RevoluteClearance` checks."""
    monkeypatch.setattr("flexmb.testing.constraints.check_gap", lambda *_: 2e-4)
    report = keeps_its_contracts(two_links(clearance(*LAWS[kind])), "pin")
    assert {"dN/d(gap)", "dT/d(slip)"} <= {check.name.rpartition(" = ")[2] for check in report.checks}


def test_contact_is_seen_open_and_closed():
    mechanism, part = BUILT_IN["RevoluteClearance, friction"]
    found = {check.name.rpartition(", ")[2]: check.states for check in check_part(mechanism, part).checks}
    assert min(found[where] for where in ("in contact", "in free flight", "open", "closed")) >= 5


def test_kinds_of_part_are_complete():
    """A part added to the public names must be added to the table above."""
    from flexmb.model.part import Element, Ground, Part

    kinds = {x.__name__ for x in PUBLIC.values() if isinstance(x, type) and issubclass(x, Part)} - {"Part", "Element"}
    used = {type(p).__name__ for mechanism, _ in BUILT_IN.values() for p in mechanism.parts}
    assert kinds <= used
    assert {Element.__name__, Ground.__name__}.isdisjoint(kinds)


def test_normal_laws_are_complete():
    """A law added to the public names must be added to the tuple above."""
    laws = {x for x in PUBLIC.values() if isinstance(x, type) and issubclass(x, fm.NormalLaw)}
    assert laws - {fm.NormalLaw, fm.contact.HysteresisLaw} == {type(law) for law in (LN, *NORMAL_LAWS)}


def test_friction_laws_are_complete():
    """So must a friction law."""
    laws = {x for x in PUBLIC.values() if isinstance(x, type) and issubclass(x, fm.FrictionLaw)}
    assert laws - {fm.FrictionLaw} == {type(law) for _, law in LAWS.values()}


def test_report_reads_as_a_table():
    report = check_part(*BUILT_IN["TorsionSpring"])
    assert isinstance(report, Report)
    lines = str(report).splitlines()
    assert lines[0] == "Part 'spring' (TorsionSpring): keeps its contracts"
    assert any("torsion_spring_kernel: K = dr/dq" in line and "12 states" in line for line in lines)


@pytest.mark.slow
def test_same_seed_same_report():
    mechanism, part = BUILT_IN["SpringDamper"]
    assert check_part(mechanism, part, seed=3) == check_part(mechanism, part, seed=3)
    assert check_part(mechanism, part, seed=3) != check_part(mechanism, part, seed=4)


def test_unknown_part_is_refused():
    with pytest.raises(ModelError, match=r"no part 'arn'.*Did you mean 'arm'"):
        check_part(two_links(), "arn")


# -- broken contracts ------------------------------------------------------------------------------------------------


@fm.element_kernel
def sound_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    k = p[0]
    r[0] = k * (q[0] - q[1])
    r[1] = -r[0]
    K[0, 0] = K[1, 1] = k
    K[0, 1] = K[1, 0] = -k


@fm.element_kernel
def wrong_stiffness(p, t, h, q, v, a, z, r, K, C, M, z_new):
    k = p[0]
    r[0] = k * (q[0] - q[1])
    r[1] = -r[0]
    K[0, 0] = K[1, 1] = k
    K[0, 1] = K[1, 0] = -1.01 * k


@fm.element_kernel
def wrong_sign(p, t, h, q, v, a, z, r, K, C, M, z_new):
    k = p[0]
    r[0] = k * (v[0] - v[1])
    r[1] = -r[0]
    C[0, 0] = C[1, 1] = -k
    C[0, 1] = C[1, 0] = k


@fm.element_kernel
def forgotten_mass(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = p[0] * a[0]
    r[1] = p[0] * a[1]
    M[0, 0] = p[0]


CALLS = [0]


@fm.element_kernel
def counting(p, t, h, q, v, a, z, r, K, C, M, z_new):
    CALLS[0] += 1
    r[0] = p[0] * CALLS[0]
    r[1] = -r[0]


@fm.element_kernel
def rolling_dice(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = p[0] * np.random.rand()  # noqa: NPY002 - the only one that numba knows
    r[1] = -r[0]


@fm.element_kernel
def one_sided(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = p[0] * (q[0] - q[1])
    K[0, 0] = p[0]
    K[0, 1] = -p[0]


@fm.element_kernel
def not_a_number(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = p[0] * np.sqrt(1.25 - (q[0] - q[1]))  # 1.21 in the reference configuration
    r[1] = -r[0]
    K[0, 0] = K[1, 1] = -0.5 * p[0] / np.sqrt(1.25 - (q[0] - q[1]))
    K[0, 1] = K[1, 0] = -K[0, 0]


@fm.element_kernel
def divides_by_h(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = p[0] * (q[0] - q[1]) * (h / h)
    r[1] = -r[0]
    K[0, 0] = K[1, 1] = p[0]
    K[0, 1] = K[1, 0] = -p[0]


@fm.element_kernel
def writes_to_q(p, t, h, q, v, a, z, r, K, C, M, z_new):
    q[0] = 0.0


@fm.element_kernel
def writes_to_history(p, t, h, q, v, a, z, r, K, C, M, z_new):
    z[0] += 1.0


@fm.element_kernel
def noisy(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = np.sin(1e13 * (q[0] - q[1]) ** 2)
    r[1] = -r[0]


@fm.element_kernel
def two_numbers(p, t, h, q, v, a, z, r, K, C, M, z_new):
    k, d = p
    r[0] = k + d


BROKEN = {
    wrong_stiffness: r"K\[0, 1\]: the kernel says -20.2, differences say -20 .*K = dr/dq",
    wrong_sign: r"C\[0, 0\]: the kernel says -20, differences say 20 .*C = dr/dv",
    forgotten_mass: r"M\[1, 1\]: the kernel says 0, differences say 20 .*M = dr/da",
    counting: r"r\[0\] is .* and then .* for the same input.*remember nothing but z",
    rolling_dice: r"r\[0\] is .* and then .* for the same input",
    one_sided: r"moments about the origin are out of balance by .*action must equal reaction",
    not_a_number: r"r\[0\] is nan; it must be finite at every state",
    divides_by_h: "failed in the reference configuration.*ZeroDivisionError.*safe there, also for t = h = 0",
    writes_to_q: r"changes its input q; write to the outputs only",
    writes_to_history: r"changes its input z",
    noisy: r"no derivative is found at \d+ of \d+ states; the values must change smoothly",
}


@dataclass(frozen=True)
class Broken(fm.Element):
    """A torsion spring whose kernel is set by each test."""

    first: fm.Part
    second: fm.Part
    k: float
    kernel = sound_kernel
    coords = ("first.theta", "second.theta")

    def history(self):
        return (0.0,)


def specimen(kernel):
    """A mechanism with an element of that kernel, of a class that can be found again when it is unpickled."""

    @dataclass(frozen=True)
    class Local(Broken):
        pass

    Local.kernel = kernel
    return two_links(Local("s", crank(), arm(), 20.0))


def test_sound_specimen_passes():
    assert check_part(two_links(Broken("s", crank(), arm(), 20.0)), "s").checks


@pytest.mark.quick(2)
@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")
@pytest.mark.parametrize("kernel", BROKEN, ids=lambda k: k.name)
def test_broken_contract_is_found(kernel):
    with pytest.raises(KernelError, match=f"(?s)^Part 's'.*{kernel.name}.*{BROKEN[kernel]}"):
        check_part(specimen(kernel), "s")


def test_wrong_number_of_parameters_is_found():
    with pytest.raises(KernelError, match=r"Part 's'.*two_numbers.*1 parameters p = \(20\).*not enough values"):
        check_part(specimen(two_numbers), "s")


def test_class_that_cannot_be_pickled_is_found():
    with pytest.raises(KernelError, match=r"Part 's'.*the part cannot be pickled"):
        check_part(specimen(sound_kernel), "s")


@fm.kernels.energy_kernel
def wrong_energy(p, t, q, v):
    return 0.6 * p[0] * (q[0] - q[1]) ** 2, 0.0, 0.0


@fm.kernels.energy_kernel
def wrong_damping(p, t, q, v):
    return 0.5 * p[0] * (q[0] - q[1]) ** 2, 0.0, 0.1 * (v[0] - v[1]) ** 2


@dataclass(frozen=True)
class WithEnergy(fm.Element):
    """A torsion spring with an account of its energy."""

    first: fm.Part
    second: fm.Part
    k: float
    wrong: str
    kernel = sound_kernel
    coords = ("first.theta", "second.theta")

    def contributions(self, mechanism):
        energy = {"strain": wrong_energy, "damping": wrong_damping}[self.wrong]
        return [replace(contribution, energy=energy) for contribution in super().contributions(mechanism)]


@pytest.mark.parametrize(("wrong", "rule"), [("strain", "force = dV/dq"), ("damping", r"power = d\(T \+ V\)/dt")])
def test_wrong_energy_is_found(wrong, rule):
    with pytest.raises(KernelError, match=rule):
        check_part(two_links(WithEnergy("s", crank(), arm(), 20.0, wrong)), "s")


@fm.element_kernel
def wind(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """A pull along x only between two bodies: balanced, but it does not turn with them."""
    r[0] = p[0] * (q[0] - q[3])
    r[3] = -r[0]
    K[0, 0] = K[3, 3] = p[0]
    K[0, 3] = K[3, 0] = -p[0]


@fm.element_kernel
def couple(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Forces across the line of centres: their sum vanishes, their moment does not."""
    r[0] = -p[0] * (q[4] - q[1])
    r[1] = p[0] * (q[3] - q[0])
    r[3] = -r[0]
    r[4] = -r[1]
    K[0, 4] = K[3, 1] = -p[0]
    K[0, 1] = K[3, 4] = p[0]
    K[1, 3] = K[4, 0] = p[0]
    K[1, 0] = K[4, 3] = -p[0]


@dataclass(frozen=True)
class Full(fm.Element):
    """An element on all coordinates of two bodies."""

    first: fm.Part
    second: fm.Part
    k: float
    coords = tuple(f"{body}.{axis}" for body in ("first", "second") for axis in ("x", "y", "theta"))


@dataclass(frozen=True)
class Wind(Full):
    """See its kernel."""

    kernel = wind


@dataclass(frozen=True)
class Couple(Full):
    """See its kernel."""

    kernel = couple


@pytest.mark.parametrize("kind", [Wind, Couple])
def test_lonely_moment_is_found(kind):
    with pytest.raises(KernelError, match="moments about the origin are out of balance"):
        check_part(two_links(kind("s", crank(), arm(), 20.0)), "s")


@fm.element_kernel
def compass(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """A spring between two rotations whose stiffness knows where X is: balanced, but not free of the frame."""
    x = q[2] - q[5]
    r[2] = p[0] * (2.0 + np.cos(q[2])) * x
    r[5] = -r[2]
    K[2, 2] = p[0] * (2.0 + np.cos(q[2]) - np.sin(q[2]) * x)
    K[2, 5] = -p[0] * (2.0 + np.cos(q[2]))
    K[5, 2] = -K[2, 2]
    K[5, 5] = -K[2, 5]


@dataclass(frozen=True)
class Compass(Full):
    """See its kernel."""

    kernel = compass


def test_dependence_on_the_frame_is_found():
    with pytest.raises(KernelError, match=r"r\[\d\] depends on the frame"):
        check_part(two_links(Compass("s", crank(), arm(), 20.0)), "s")


# -- broken laws, gaps, motions, constraints -------------------------------------------------------------------------


@fm.normal_law
def pulling(p, h, gap, gap_rate, z, z_new):
    return -p[0] * gap if gap < 0.5e-4 else 0.0, -p[0] if gap < 0.5e-4 else 0.0, 0.0


@fm.normal_law
def wrong_rate(p, h, gap, gap_rate, z, z_new):
    depth = max(-gap, 0.0)
    return p[0] * depth * (3.0 - np.tanh(gap_rate)), -p[0] * (3.0 - np.tanh(gap_rate)) if depth else 0.0, 0.0


@dataclass(frozen=True)
class Pulling(fm.NormalLaw):
    """A sticky contact."""

    k: float = 1e6
    kernel = pulling


@dataclass(frozen=True)
class WrongRate(fm.NormalLaw):
    """A damped contact that forgets the derivative by the rate."""

    k: float = 1e6
    kernel = wrong_rate


@fm.friction_law
def wrong_by_force(p, h, slip, N, z, z_new):
    c = np.tanh(slip / 1e-2)
    return -p[0] * N * c, -p[0] * N * (1.0 - c * c) / 1e-2, p[0] * c


@dataclass(frozen=True)
class WrongByForce(fm.FrictionLaw):
    """Friction with the wrong sign of dT/dN."""

    mu: float = 0.1
    kernel = wrong_by_force


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("normal", "friction", "message"),
    [
        (Pulling(), fm.friction.Frictionless(), "Pulling.*N is -.*a contact pushes"),
        (
            WrongRate(),
            fm.friction.Frictionless(),
            r"WrongRate.*dN_drate: the kernel says 0, differences say .*dN/d\(gap_rate\)",
        ),
        (LN, WrongByForce(), r"WrongByForce.*dT_dN: the kernel says .*relative error 2\)"),
    ],
)
def test_broken_law_is_found(normal, friction, message):
    with pytest.raises(KernelError, match=f"(?s)Part 'pin'.*{message}"):
        check_part(two_links(clearance(normal, friction)), "pin")


@fm.drive_kernel
def hasty(p, t):
    return p[0] * t * t, 2.0 * p[0] * t, p[0]


@dataclass(frozen=True)
class Hasty(fm.Motion):
    """s = k t^2 with half its acceleration."""

    k: float = 1.0
    kernel = hasty


def test_broken_motion_is_found():
    with pytest.raises(KernelError, match=r"(?s)Part 'motor'.*Hasty.*s_ddot: the kernel says 1, differences say 2"):
        check_part(driven(Hasty()), "motor")


def broken_guide(missing):
    """The rod of constant length between two bodies, with one entry left out or wrong."""

    @fm.kernels.constraint_kernel
    def rod(p, t, q, v, lam, g, G, g_t, gamma, H):
        dx, dy = q[3] - q[0], q[4] - q[1]
        g[0] = 0.5 * (dx * dx + dy * dy - p[0] * p[0])
        row = (-dx, -dy, 0.0, dx, dy, 0.0)
        for i in range(6):
            G[0, i] = row[i]
        if missing == "G":
            G[0, 4] = 0.0
        if missing == "g_t":
            g_t[0] = 1.0
        if missing != "gamma":
            gamma[0] = -((v[3] - v[0]) ** 2) - (v[4] - v[1]) ** 2
        if missing != "H":
            H[0, 0] = H[1, 1] = H[3, 3] = H[4, 4] = lam[0]
            H[0, 3] = H[3, 0] = H[1, 4] = H[4, 1] = -lam[0]

    return rod


@dataclass(frozen=True)
class Rod(fm.Part):
    """A massless rod between the centres of two bodies."""

    first: fm.Part
    second: fm.Part
    missing: str

    def contributions(self, mechanism):
        from flexmb.model.contributions import ConstraintContribution, node_coordinates

        coordinates = (*node_coordinates(self.first.name, ""), *node_coordinates(self.second.name, ""))
        return [
            ConstraintContribution(
                self.name, broken_guide(self.missing), coordinates, (0.3,), 1, second=coordinates[3:]
            )
        ]


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("missing", "message"),
    [
        ("G", r"G\[0, 4\]: the kernel says 0"),
        ("g_t", "g_t: the kernel says 1, differences say 0"),
        ("gamma", "gamma: the kernel says 0"),
        ("H", r"H\[0, 0\]: the kernel says 0"),
    ],
)
def test_broken_constraint_is_found(missing, message):
    with pytest.raises(KernelError, match=f"(?s)Part 'rod' .*{message}"):
        check_part(two_links(Rod("rod", crank(), arm(), missing)), "rod")


def test_sound_constraint_passes():
    names = {c.name.partition(": ")[2] for c in check_part(two_links(Rod("rod", crank(), arm(), "")), "rod").checks}
    assert {"G = dg/dq", "g_t = dg/dt", "H = d(G^T lam)/dq", "gamma = -d(G v + g_t)/dt"} <= names
