"""Random combinations of parts: two or three groups of parts side by side, coupled by springs and cables."""

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from scene import Body, Scene, Units

import flexmb as fm


@fm.control_kernel
def brake(p, t, u, x, dx, y):
    """Output -p0 u0 + x0 with a slow state that follows -p1 u0."""
    dx[0] = 5.0 * (-p[1] * u[0] - x[0])
    y[0] = -p[0] * u[0] + x[0]


def chain(scene: Scene, at: complex) -> None:
    """One to three bars that hang or are driven, with friction or clearance in a pin at times."""
    place, before = at, fm.GROUND
    driven = scene.chance(0.4)
    loose = int(scene.rng.integers(6))
    for k in range(int(scene.rng.integers(1, 4))):
        kind = scene.one("rigid", "rigid", "rigid", "flexible", "reduced", "plane") if k else "rigid"
        end = place + scene.polar(scene.between(0.15, 0.4))
        bar = scene.bar(place, end, scene.between(0.3, 2.0), kind)
        name = scene.name("pin")
        if k and k == loose:
            scene.words.append("RevoluteClearance")
            c = scene.between(2e-4, 2e-3)
            scene.add(fm.RevoluteClearance(
                name, before, bar.part, at=scene.p(place), clearance=scene.s(c), bearing_radius=scene.s(0.01 + c),
                normal=scene.law(bar.mass), friction=scene.rubbing() or fm.friction.Frictionless()
            ))  # fmt: skip
        else:
            rubbing = scene.rubbing() if not (driven and k == 0) else None
            scene.add(fm.Revolute(
                name, before, bar.part, at=scene.p(place), friction=rubbing, radius=scene.s(0.01) if rubbing else None
            ))  # fmt: skip
            if driven and k == 0:
                scene.add(fm.Drive(scene.name("motor"), name, scene.motion(1.0)))
            elif scene.chance(0.3) and kind == "rigid":
                _stop(scene, name, bar.mass * 0.1)
        before, place = bar.part, end


def _stop(scene: Scene, joint: str, mass: float) -> None:
    scene.words.append("Stop")
    low, high = -scene.between(0.05, 0.5), scene.between(0.05, 0.5)
    low, high = (-high, -low) if scene.units.mirror else (low, high)
    scene.add(fm.Stop(
        scene.name("stop"), joint, above=high, below=low, normal=scene.law(mass), radius=scene.s(0.1)
    ))  # fmt: skip


def carriage(scene: Scene, at: complex) -> None:
    """A block on a guide with a spring, and a load with history, a controller or a bump stop."""
    body = scene.block(at, scene.between(0.5, 3.0))
    along = scene.polar(1.0)
    scene.add(fm.Prismatic(scene.name("guide"), fm.GROUND, body.part, at=scene.p(at), along=scene.d(along)))
    k = body.mass * scene.between(5.0, 30.0) ** 2
    scene.add(fm.SpringDamper(
        scene.name("spring"), fm.GROUND, body.part, scene.p(at - 0.3 * along), scene.p(at), stiffness=scene.k(k),
        damping=scene.k(0.02 * math.sqrt(k * body.mass)), free_length=scene.s(scene.between(0.2, 0.4))
    ))  # fmt: skip
    force = scene.f(body.mass * scene.between(2.0, 20.0))
    push = scene.d(along)
    kind = scene.one("history", "follower", "Control", "PID", "bump")
    scene.words.append(kind)
    name = scene.name("push")
    vector = (force * push[0], force * push[1])
    if kind in ("history", "follower"):
        scene.add(fm.Force(
            name, body.part, scene.p(at), vector, history=scene.motion(-1.0), follower=kind == "follower"
        ))  # fmt: skip
    elif kind == "Control":
        scene.add(fm.Force(name, body.part, scene.p(at), (scene.sign, 0.0)))
        c = scene.k(0.3 * math.sqrt(k * body.mass))
        scene.add(fm.Control(
            scene.name("brake"), [f"{body.part.name}.vx"], [name], brake, states=1,
            numbers=(scene.sign * c, scene.sign * 0.5 * c)
        ))  # fmt: skip
    elif kind == "PID":
        scene.add(fm.Force(name, body.part, scene.p(at), (0.0, 1.0)))
        kp = scene.k(0.5 * k)
        scene.add(fm.PID(
            scene.name("servo"), f"{body.part.name}.y", name, target=scene.s(at.imag + 0.02), kp=kp, ki=kp,
            kd=0.05 * kp, limit=scene.f(50.0), sample=scene.one(None, 0.013)
        ))  # fmt: skip
    else:
        gap = scene.between(0.003, 0.05)
        scene.add(fm.Stop(
            scene.name("bump"), first=fm.GROUND, second=body.part, at=scene.p(at), above=scene.s(gap),
            below=-scene.s(2.0 * gap), normal=scene.law(body.mass), along=scene.d(along)
        ))  # fmt: skip


def wheel(scene: Scene, at: complex, radius: float, mass: float, omega: float = 0.0) -> Body:
    """A wheel on a fixed axis."""
    body = scene.block(at, mass, radius, (0.0, 0.0, omega) if omega else None)
    scene.add(fm.Revolute(scene.name("axis"), fm.GROUND, body.part, at=scene.p(at)))
    return body


def gears(scene: Scene, at: complex) -> None:
    """Two wheels by a gear, with backlash at times, or a belt; or a wheel on a rack."""
    kind = scene.one("Gear", "backlash", "Belt", "creeping", "Rack")
    scene.words.append(kind)
    one = wheel(scene, at, 0.1, scene.between(0.5, 2.0))
    axis = scene.parts[-1].name
    if kind == "Rack":
        bar = scene.block(at - 0.1j, 0.5)
        scene.add(fm.Prismatic(scene.name("guide"), fm.GROUND, bar.part, at=scene.p(bar.at), along=scene.d(1.0)))
        scene.add(fm.couplings.Rack(scene.name("rack"), one.part, bar.part, at=scene.p(bar.at), along=scene.d(1.0)))
        _torsion(scene, one, 3.0)
    else:
        away = scene.polar(0.15 if kind in ("Gear", "backlash") else 0.4)
        two = wheel(scene, at + away, 0.05, scene.between(0.3, 1.0))
        if kind == "Gear":
            scene.add(fm.Gear(scene.name("gear"), one.part, two.part, teeth=(40, 20)))
        elif kind == "backlash":
            scene.add(fm.Gear(
                scene.name("gear"), one.part, two.part, teeth=(40, 20), backlash=scene.s(scene.between(1e-4, 2e-3)),
                normal=scene.law(0.3)
            ))  # fmt: skip
        else:
            more = {}
            if kind == "creeping":
                more = {"coefficient": 0.3, "pretension": scene.f(60.0), "creep": scene.s(0.02)}
            radii = (scene.s(0.1), scene.s(0.05))
            scene.add(fm.couplings.Belt(
                scene.name("belt"), one.part, two.part, radii=radii, crossed=scene.chance(0.3), **more
            ))  # fmt: skip
        _torsion(scene, two, 1.0)
    if scene.chance(0.5):
        scene.add(fm.Drive(scene.name("motor"), axis, scene.motion(1.0)))
    else:
        scene.add(fm.Torque(scene.name("torque"), one.part, scene.a(scene.j(1.0)), history=scene.motion(-1.0)))


def _torsion(scene: Scene, body: Body, stiffness: float) -> None:
    scene.add(fm.TorsionSpring(
        scene.name("torsion"), fm.GROUND, body.part, stiffness=scene.j(stiffness), damping=scene.j(0.01 * stiffness),
        free_angle=scene.a(scene.between(0.1, 1.0))
    ))  # fmt: skip


def hoist(scene: Scene, at: complex) -> None:
    """A weight on a rope from a point or a drum."""
    weight = scene.block(at - 0.5j, scene.between(0.5, 3.0), velocity=(scene.between(-0.5, 0.5), 0.0, 0.0))
    radius, law = 0.06, scene.law(weight.mass)
    if scene.chance(0.6):
        scene.words.append("drum")
        side = scene.one(-1.0, 1.0)
        drum = wheel(scene, at, radius, 1.0)
        axis = scene.parts[-1].name
        scene.add(fm.couplings.Cable(
            scene.name("rope"), drum.part, weight.part, at=scene.p(at), to=scene.p(weight.at),
            radii=(scene.a(scene.s(side * radius)), 0.0), normal=law
        ))  # fmt: skip
        if scene.chance(0.4):
            scene.add(fm.Drive(scene.name("motor"), axis, fm.drives.CycloidalRamp(scene.a(side * 3.0), 0.3)))
        else:
            _torsion(scene, drum, 5.0)
    else:
        slack = scene.one(1.0, 1.05)
        scene.words.append("Cable")
        scene.add(fm.couplings.Cable(
            scene.name("rope"), fm.GROUND, weight.part, at=scene.p(at), to=scene.p(weight.at),
            free_length=scene.s(slack * 0.5), normal=law
        ))  # fmt: skip


def cam(scene: Scene, at: complex) -> None:
    """An eccentric disc that lifts a follower."""
    disc = wheel(scene, at, 0.04, 0.5)
    scene.add(fm.Drive(scene.name("motor"), scene.parts[-1].name, scene.motion(1.0)))
    e, r, kind = 0.01, 0.03, scene.one("PointOnCurve", "CurveOnCurve", "OutlineContact")
    law = scene.law(0.3) if kind == "OutlineContact" or scene.chance(0.6) else None
    rubbing = scene.rubbing() if law else None
    scene.words.append(kind)
    u = np.linspace(0.0, 2.0 * math.pi, 61)[:-1]
    u = math.pi - u if scene.units.mirror else u
    middle = complex(scene.between(-0.7, 0.7) * e, 0.0) if kind == "CurveOnCurve" else complex(e, 0.0)
    points = [scene.p(at + middle + complex(r * math.cos(x), r * math.sin(x))) for x in u]
    if kind == "PointOnCurve":
        top = at + 1j * math.sqrt(r**2 - e**2)
        foot = scene.block(top, 0.3)
        scene.add(fm.cams.PointOnCurve(
            scene.name("cam"), disc.part, fm.ClosedCurve(points), foot.part, scene.p(top), normal=law, friction=rubbing
        ))  # fmt: skip
    elif kind == "CurveOnCurve":
        foot = scene.block(at + 1j * r, 0.3)
        ends = (at + complex(-0.06, r), at + complex(0.06, r))
        line = fm.Line(*(scene.p(z) for z in (ends[::-1] if scene.units.mirror else ends)))
        scene.add(fm.CurveOnCurve(
            scene.name("cam"), disc.part, fm.ClosedCurve(points), foot.part, line, normal=law, friction=rubbing
        ))  # fmt: skip
    else:
        corners = [complex(-0.03, -0.02), complex(0.03, -0.02), complex(0.03, 0.02), complex(-0.03, 0.02)]
        corners = corners[::-1] if scene.units.mirror else corners
        outline = fm.cams.Outline([scene.p(at + z) for z in corners])
        place = at + complex(0.0, 0.02 + 0.015 + scene.between(1e-5, 5e-3))
        foot = scene.block(place, 0.3)
        circle = fm.cams.CircularCurve(scene.p(place), scene.s(0.015))
        scene.add(fm.cams.OutlineContact(
            scene.name("cam"), disc.part, outline, foot.part, circle, normal=law,
            friction=rubbing or fm.friction.Frictionless()
        ))  # fmt: skip
    scene.add(fm.Prismatic(scene.name("guide"), fm.GROUND, foot.part, at=scene.p(foot.at), along=scene.d(1j)))
    scene.add(fm.SpringDamper(
        scene.name("spring"), fm.GROUND, foot.part, scene.p(foot.at + 0.2j), scene.p(foot.at), stiffness=scene.k(300.0),
        damping=scene.k(0.5), free_length=scene.s(0.22)
    ))  # fmt: skip


def thrown(scene: Scene, at: complex) -> None:
    """A ball that is thrown onto a floor."""
    speed = (scene.between(-1.0, 1.0), -scene.between(0.1, 2.0), scene.between(-5.0, 5.0))
    ball = scene.block(at, scene.between(0.2, 2.0), 0.05, speed)
    floor = [complex(-2.0, -0.2), complex(2.0, -0.2), complex(2.0, 0.0), complex(-2.0, 0.0)]
    floor = floor[::-1] if scene.units.mirror else floor
    below = at - 1j * (0.05 + scene.between(0.01, 0.2))
    scene.words.append("ball")
    scene.add(fm.cams.OutlineContact(
        scene.name("floor"), fm.GROUND, fm.cams.Outline([scene.p(below + z) for z in floor]), ball.part,
        fm.cams.CircularCurve(scene.p(at), scene.s(0.05)), normal=scene.law(ball.mass),
        friction=scene.rubbing() or fm.friction.Frictionless()
    ))  # fmt: skip


KINDS = (chain, chain, carriage, gears, hoist, cam, thrown)


def built(seed: int, units: Units = Units()) -> tuple[fm.Mechanism, list[Body], list[str]]:
    """A random combination in some units: mechanism, its bodies, and words for what it is made of."""
    scene = Scene(seed, units)
    count = int(scene.rng.integers(1, 4))
    for k in range(count):
        scene.one(*KINDS)(scene, complex(1.5 * k, 0.0))
    if len(scene.bodies) > 1:
        _joined(scene)
    g = scene.s(9.81) if scene.chance(0.8) else 0.0
    return fm.Mechanism(f"combination{seed}", scene.parts, gravity=(0.0, -g)), scene.bodies, scene.words


def _joined(scene: Scene) -> None:
    """Springs between random bodies."""
    for _ in range(int(scene.rng.integers(0, 3))):
        one, two = (scene.bodies[int(k)] for k in scene.rng.choice(len(scene.bodies), 2, replace=False))
        distance = abs(one.at - two.at)
        if distance > 0.1:
            k = min(one.mass, two.mass) * scene.between(3.0, 15.0) ** 2
            scene.add(fm.SpringDamper(
                scene.name("spring"), one.part, two.part, scene.p(one.at), scene.p(two.at), stiffness=scene.k(k),
                damping=scene.k(0.5), free_length=scene.s(distance * scene.between(0.8, 1.2))
            ))  # fmt: skip
