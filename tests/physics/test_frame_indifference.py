"""Joints and laws know no preferred direction, place or speed of flight; what they do to two bodies is in balance."""

import math
import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from public_names import PUBLIC

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.model.part import Joint

NORMAL = fm.contact.ExactRestitution(stiffness=1e7, restitution=0.6)
ROUGH = fm.friction.SmoothCoulomb(0.3, v0=1e-2)
PLAY, AT = 1e-3, (0.3, 0.1)
ROUND = {"clearance": PLAY, "bearing_radius": 0.02}
DEPTHS = 0.3 * PLAY * (1.0 + np.sin(2.0 * math.pi * np.arange(360) / 180.0)) * np.linspace(0.0, 1.0, 360)

SPECIMENS = runpy.run_path(str(Path(__file__).parents[1] / "bad_input" / "test_numbers.py"))["SPECIMENS"]


class Frame:
    """Turns by `angle` about the origin, shifts, and gives a uniform velocity."""

    def __init__(self, angle=0.0, shift=(0.0, 0.0), velocity=(0.0, 0.0)):
        self.angle, self.shift, self.velocity = angle, shift, velocity
        self.cos, self.sin = math.cos(angle), math.sin(angle)

    def turn(self, x, y):
        return self.cos * x - self.sin * y, self.sin * x + self.cos * y

    def point(self, x, y):
        x, y = self.turn(x, y)
        return x + self.shift[0], y + self.shift[1]

    def speed(self, vx, vy, omega):
        vx, vy = self.turn(vx, vy)
        return vx + self.velocity[0], vy + self.velocity[1], omega


HERE = Frame()
THERE = Frame(2.1, (0.7, -1.3))
FLYING = Frame(-0.8, (-0.4, 0.2), (3.0, -2.0))


def pair(joint, frame, gravity=(0.0, 0.0), relative=(0.3, 0.5, -15.0)):
    """Two free bodies in motion; `joint(frame, first, second)` makes the part "J" between them."""
    first = fm.RigidBody(
        "first", frame.point(0.0, 0.0), 1.3, 0.02, theta=0.2 + frame.angle, velocity=frame.speed(0.4, -0.2, 3.0)
    )
    rigid = (0.4 - 3.0 * 0.15, -0.2 + 3.0 * 0.42)  # of the place of the second body on the first
    velocity = frame.speed(rigid[0] + relative[0], rigid[1] + relative[1], 3.0 + relative[2])
    second = fm.RigidBody("second", frame.point(0.42, 0.15), 0.6, 3e-3, theta=-0.5 + frame.angle, velocity=velocity)
    return fm.Mechanism("pair", (first, second, joint(frame, first, second)), gravity=frame.turn(*gravity))


def worn(normal=NORMAL, friction=ROUGH, start=(2e-4, -3e-4)):
    def joint(frame, first, second):
        options = {"normal": normal, "friction": friction, "start": frame.turn(*start)}
        return fm.RevoluteClearance("J", first, second, at=frame.point(*AT), **ROUND, **options)

    return joint


def along(frame):
    return frame.turn(1.0, 0.4)


GUIDE = {"half_length": 0.04, "half_height": 0.015}
JOINTS = {
    "Revolute": lambda f, a, b: fm.Revolute("J", a, b, at=f.point(*AT)),
    "Revolute, friction": lambda f, a, b: fm.Revolute(
        "J", a, b, at=f.point(*AT), friction=ROUGH, radius=0.02, preload=1.0
    ),
    "Fixed": lambda f, a, b: fm.Fixed("J", a, b, at=f.point(*AT)),
    "Clamp": lambda f, a, b: fm.Clamp("J", a, b, at=f.point(*AT), angle=fm.drives.CycloidalRamp(300.0, 0.01)),
    "Prismatic": lambda f, a, b: fm.Prismatic("J", a, b, at=f.point(*AT), along=along(f)),
    "Prismatic, friction": lambda f, a, b: fm.Prismatic(
        "J", a, b, at=f.point(*AT), along=along(f), friction=ROUGH, length=0.1, preload=1.0
    ),
    "PinSlot": lambda f, a, b: fm.PinSlot("J", a, b, at=f.point(*AT), along=along(f)),
    "Bushing": lambda f, a, b: fm.Bushing(
        "J", a, b, at=f.point(*AT), stiffness=(1e4, 3e4), damping=(3.0, 1.0), torsion=20.0, torsion_damping=0.01,
        along=along(f),
    ),
    "RevoluteClearance": worn(),
    "JournalBearing": lambda f, a, b: fm.JournalBearing(
        "J", a, b, at=f.point(*AT), **ROUND, normal=NORMAL, friction=ROUGH, start=f.turn(2e-4, -3e-4), roughness=1e-5,
        film=fm.ShortBearing(viscosity=0.02, width=0.02),
    ),
    "wear.WornClearance": lambda f, a, b: worn()(f, a, b).worn_by(
        fm.Archard(bearing=1e-13, width=0.02)
    ).with_depths(DEPTHS),
    "RevoluteClearance, worn journal": lambda f, a, b: worn()(f, a, b).worn_by(
        fm.Archard(journal=1e-13, width=0.02)
    ).with_depths(DEPTHS),
    "PinSlotClearance": lambda f, a, b: fm.PinSlotClearance(
        "J", a, b, at=f.point(*AT), along=along(f), clearance=PLAY, pin_radius=0.02, length=2e-3, normal=NORMAL,
        friction=ROUGH,
    ),
    "PrismaticClearance": lambda f, a, b: fm.PrismaticClearance(
        "J", a, b, at=f.point(*AT), along=along(f), clearance=PLAY, **GUIDE, normal=NORMAL, friction=ROUGH
    ),
    "SliderBearing": lambda f, a, b: fm.SliderBearing(
        "J", a, b, at=f.point(*AT), along=along(f), clearance=PLAY, **GUIDE, normal=NORMAL, friction=ROUGH,
        film=fm.ShortBearing(viscosity=0.02, width=0.02), roughness=1e-5,
    ),
    "wear.WornBearing": lambda f, a, b: JOINTS["JournalBearing"](f, a, b).worn_by(
        fm.Archard(bearing=1e-13, width=0.02)
    ).with_depths(DEPTHS),
    "wear.WornGuide": lambda f, a, b: JOINTS["PrismaticClearance"](f, a, b).worn_by(
        fm.Archard(bearing=1e-13, width=0.02), length=0.3
    ).with_depths(np.tile(0.05 * DEPTHS, 2)),
    "wear.WornSlot": lambda f, a, b: replace(JOINTS["PinSlotClearance"](f, a, b), length=None).worn_by(
        fm.Archard(bearing=1e-13, width=0.02), length=0.3
    ).with_depths(np.tile(0.05 * DEPTHS, 2)),
    "SpringDamper": lambda f, a, b: fm.SpringDamper(
        "J", a, b, f.point(0.1, 0.0), f.point(0.4, 0.2), stiffness=1e4, damping=1.0, free_length=0.2
    ),
    "TorsionSpring": lambda f, a, b: fm.TorsionSpring("J", a, b, stiffness=10.0, damping=0.1, free_angle=0.1),
}  # fmt: skip
"""Every joint of the package, and the parts that hold two bodies elastically."""

ELASTIC = ("SpringDamper", "TorsionSpring")
ANY = (0.3, 0.5, -15.0)
TURNING = (-5.0 * (0.15 - AT[1]), 5.0 * (0.42 - AT[0]), 5.0)
SLIDING = (0.5, 0.2, 0.0)
RELATIVE = {
    "Fixed": (0.0, 0.0, 0.0),
    "Clamp": (0.0, 0.0, 0.0),
    "Revolute": TURNING,
    "Revolute, friction": TURNING,
    "Bushing": TURNING,
    "Prismatic": SLIDING,
    "Prismatic, friction": SLIDING,
    "PinSlot": (SLIDING[0] + TURNING[0], SLIDING[1] + TURNING[1], 5.0),
}
"""Velocity of the second body against the first, taken as one body, that the joint lets it have; others: `ANY`."""

LAWS = {name: record for name, record in SPECIMENS.items() if isinstance(record, (fm.NormalLaw, fm.FrictionLaw))}


def test_every_joint_is_here():
    joints = {name for name, thing in PUBLIC.items() if isinstance(thing, type) and issubclass(thing, Joint)}
    public = joints - {"couplings.OneWayClutch"}  # a revolute joint with a law of friction of its own
    assert public == {name for name in JOINTS if name in PUBLIC and name not in ELASTIC}


def motion(mech, frame, t_end, step):
    """(n, 12): positions and velocities of both bodies, turned and shifted back; and the solution."""
    sol = fm.simulate(mech, t_end=t_end, step=step, save=20, method=fm.RungeKutta4())
    assert sol.ok, sol.status
    back = Frame(-frame.angle)
    columns = []
    for body in ("first", "second"):
        x, y, theta, vx, vy, omega = (sol.array(f"{body}.{s}") for s in ("x", "y", "theta", "vx", "vy", "omega"))
        moved = [frame.shift[k] + frame.velocity[k] * sol.time for k in (0, 1)]
        columns += [*back.turn(x - moved[0], y - moved[1]), theta - frame.angle]
        columns += [*back.turn(vx - frame.velocity[0], vy - frame.velocity[1]), omega]
    return np.array(columns).T, sol


def compare(joint, relative, t_end=4e-3, step=1e-5):
    """Largest difference of both moved motions to the one here, each coordinate over its largest value."""
    here, sol = motion(pair(joint, HERE, relative=relative), HERE, t_end, step)
    scale = np.abs(here).max(axis=0)
    worst = 0.0
    for frame in (THERE, FLYING):
        there, _ = motion(pair(joint, frame, relative=relative), frame, t_end, step)
        worst = max(worst, float((np.abs(there - here) / scale).max()))
    return worst, sol


@pytest.mark.parametrize("name", JOINTS)
def test_a_turned_shifted_or_flying_pair_moves_alike(name):
    worst, sol = compare(JOINTS[name], RELATIVE.get(name, ANY))
    assert worst <= 1e-9
    if "Clearance" in name or name in ("wear.WornGuide", "wear.WornSlot"):
        depth = max(sol.peak(s.name).value for s in sol.signals if s.name.endswith("penetration"))
        assert depth > 1e-6  # they have met


@pytest.mark.parametrize("name", LAWS)
def test_with_every_law_a_turned_pair_moves_alike(name):
    law = LAWS[name]
    joint = worn(normal=law) if isinstance(law, fm.NormalLaw) else worn(friction=law)
    worst, sol = compare(joint, ANY, t_end=2.5e-3, step=2e-6)
    assert worst <= 1e-9
    assert sol.peak("J.penetration").value > 1e-7
    if isinstance(law, fm.FrictionLaw):
        assert sol.peak("J.friction_force").value > 1.0


@pytest.mark.parametrize("name", JOINTS)
@pytest.mark.parametrize("seed", range(4))
def test_action_is_reaction_moments_included(name, seed):
    """Sum of the forces on both bodies 0, sum of their moments about the origin 0.

    In any motion; in any pose in which an ideal joint is closed, and beyond the play of the others.
    """
    program = fm.compile(pair(JOINTS[name], THERE, relative=RELATIVE.get(name, ANY)))
    rng = np.random.default_rng(seed)
    q, v = np.array(program.reference.q), rng.standard_normal(program.n_q)
    if program.n_c == 0:
        direction = THERE.angle + rng.uniform(0.25, 0.45) * math.pi + math.pi * (seed % 2)
        q[3:5] += 8.0 * PLAY * np.array([math.cos(direction), math.sin(direction)])
        q[5] += 0.02 * rng.standard_normal()
    lam = 50.0 * rng.standard_normal(program.n_c)
    sizes = []
    for sign in (1.0, -1.0):  # a contact may let go of bodies that part
        system = StateEvaluation(program).at(q, sign * v, lam=lam)
        force = (system.force + system.constraint_force).reshape(2, 3)
        moments = [q[3 * k] * f[1] - q[3 * k + 1] * f[0] + f[2] for k, f in enumerate(force)]
        sizes.append(np.abs(force).max())
        assert np.abs(force[:, :2].sum(axis=0)).max() <= 1e-12 * sizes[-1]
        assert abs(sum(moments)) <= 1e-12 * max(sizes[-1], np.abs(moments).max())
    assert max(sizes) > 1e-2
