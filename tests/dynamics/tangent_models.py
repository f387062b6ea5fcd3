"""Small mechanisms whose steps are differentiated, and differences of steps."""

import math

import numpy as np

import flexmb as fm
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.run import run as run_module

LOSS = fm.friction.SmoothCoulomb(0.3, v0=0.2)


def pendulum(*, extras=(), lower=None, friction=None, gravity=9.81):
    """Two rods, hinged at the origin and to each other; `extras` are made of both."""
    knee = (math.cos(0.3), math.sin(0.3))
    tip = (knee[0] + 0.7 * math.cos(-0.7), knee[1] + 0.7 * math.sin(-0.7))
    upper = fm.RigidLink("upper", (0.0, 0.0), knee, 0.8, 0.12)
    lower = lower(knee, tip) if lower else fm.RigidLink("lower", knee, tip, 0.5, 0.03)
    rubbing = {"friction": friction, "radius": 0.05, "preload": 3.0} if friction else {}
    joints = (fm.Revolute("O", fm.GROUND, upper, (0.0, 0.0)), fm.Revolute("P", upper, lower, knee, **rubbing))
    more = [make(upper, lower, knee, tip) for make in extras]
    return fm.Mechanism("pendulum", (upper, lower, *joints, *more), gravity=(0.0, -gravity))


def beam(knee, tip):
    """A flexible lower rod."""
    material = fm.Material(young=2e9, density=1200.0)
    return fm.FlexibleLink("lower", knee, tip, material=material, section=fm.Rectangle(0.02, 0.03), elements=3)


def spring(upper, lower, knee, tip):
    """A spring and damper from the tip to the ground."""
    return fm.SpringDamper("S", fm.GROUND, lower, (1.5, 0.4), tip, stiffness=80.0, damping=2.0)


def bushed():
    """Two rods with a bushing between them, and a spring that turns one of them back."""
    upper = fm.RigidLink("upper", (0.0, 0.0), (1.0, 0.0), 0.8, 0.12, velocity=(0.0, 1.0, 2.0))
    lower = fm.RigidLink("lower", (1.0, 0.0), (1.7, 0.1), 0.5, 0.03)
    parts = (
        fm.Revolute("O", fm.GROUND, upper, (0.0, 0.0)),
        fm.Bushing("P", upper, lower, (1.0, 0.0), stiffness=(300.0, 200.0), damping=2.0, torsion=1.0),
        fm.TorsionSpring("T", fm.GROUND, upper, stiffness=5.0, damping=0.1),
    )
    return fm.Mechanism("bushed", (upper, lower, *parts), gravity=(0.0, -9.81))


def clutched():
    """Two rods with an engaged clutch between them, wound up by a millionth of its angle."""
    upper = fm.RigidLink("upper", (0.0, 0.0), (1.0, 0.0), 0.8, 0.12)
    lower = fm.RigidLink("lower", (1.0, 0.0), (1.0, -0.7), 0.5, 0.03)
    stiff = {"stiffness": 2e5, "damping": 50.0, "free": "clockwise"}
    parts = (
        fm.Revolute("O", fm.GROUND, upper, (0.0, 0.0)),
        fm.couplings.OneWayClutch("P", upper, lower, (1.0, 0.0), **stiff),
    )
    return fm.Mechanism("clutched", (upper, lower, *parts), gravity=(0.0, -9.81))


def thrown(normal, friction=LOSS, *, speed=1.0, spin=4.0, clearance=0.02):
    """A disc thrown against the wall of a wide hole in the ground, a little beside its middle; it spins."""
    ball = fm.RigidBody("ball", (0.0, 0.0), 1.0, 2e-3, velocity=(speed, 0.2 * speed, spin))
    laws = {"clearance": clearance, "bearing_radius": 0.08, "normal": normal, "friction": friction}
    joint = fm.RevoluteClearance("J", fm.GROUND, ball, (0.0, 0.0), start=(0.0, 0.25 * clearance), **laws)
    return fm.Mechanism("thrown", (ball, joint))


def tight(monkeypatch, tolerance=1e-12):
    """Newton's iterations converge to round-off."""
    monkeypatch.setattr(run_module, "NEWTON_TOLERANCE", tolerance)


def displaced(flow, change):
    """A copy of the flow whose state is off by `change`, as it is: not projected, not made consistent."""
    other = flow.copy()
    n, n_z, target = flow.program.n_q, flow.program.tables.sizes.n_z, other.run.flow
    q, v, z, a, x = np.split(change, np.cumsum([n, n, n_z, n]))
    target.q[:n] += q
    target.v[:n] += v
    target.z[:] += z
    target.a[:n] += a
    target.x[:n] += x
    target.reuse.age = 0.0  # a step shifts positions by its own matrix, not by that of a step before
    return other


def difference(flow, duration, change, eps):
    """Central difference of fourth order of the state after `duration`, along `change`."""
    ends = []
    for part in (1.0, -1.0, 2.0, -2.0):
        other = displaced(flow, part * eps * change)
        assert other.advance(duration), other.status
        ends.append(other.state())
    return (8.0 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12.0 * eps)


def blocks(flow, state):
    """Parts of a state by name; histories one by one, as they have units of their own."""
    n, n_z = flow.program.n_q, flow.program.tables.sizes.n_z
    parts = dict(zip(("q", "v", "z", "a", "x"), np.split(state, np.cumsum([n, n, n_z, n])), strict=True))
    for i, value in enumerate(parts.pop("z")):
        parts[f"z{i}"] = np.array([value])
    return parts


def missed(flow, carried, wanted):
    """Largest difference of two changes of state in each part, relative to the largest number of the part."""
    found = {}
    ours, theirs = blocks(flow, carried), blocks(flow, wanted)
    for name, part in theirs.items():
        size = np.abs(part).max(initial=0.0)
        found[name] = float(np.abs(ours[name] - part).max(initial=0.0) / size) if size > 1e-12 else 0.0
    return found


def started(flow, seed=0):
    """One smooth change of state at the present state, without the arbitrary parts of histories."""
    n, n_z = flow.program.n_q, flow.program.tables.sizes.n_z
    W = np.random.default_rng(seed).standard_normal((flow.size, 1))
    W[2 * n : 2 * n + n_z] = 0.0
    return flow.on_manifold(W)


def fixed(mechanism, step, **settings):
    """The flow of a mechanism with steps of one size."""
    return MechanismFlow(mechanism, step=step, **settings)
