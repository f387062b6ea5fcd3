"""Mechanisms with known answers."""

import systems

import flexmb as fm


def rod(push=2.5, damping=0.1):
    """A rod on a pin, damped and pushed by a torque: x'' + damping x' + sin x = push sin t, first at rest."""
    inertia = 1.0 / 3.0
    bar = fm.RigidLink("rod", (0.0, 0.0), (0.0, -2.0), mass=1.0, inertia=inertia)
    J = inertia + 1.0
    parts = [
        bar,
        fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0)),
        fm.TorsionSpring("damper", fm.GROUND, bar, stiffness=0.0, damping=damping * J, at=(0.0, 0.0)),
        fm.Torque("push", bar, torque=push * J, history=fm.drives.Harmonic(1.0, frequency=1.0 / systems.TURN)),
    ]
    return fm.Mechanism("rod", parts, gravity=(0.0, -J))


def rod_flow(steps=400, **options):
    return fm.chaos.MechanismFlow(rod(**options), period=systems.TURN, step=systems.TURN / steps)


def swinging(rtol=1e-6):
    """A bar of 1 m let go at 90 degrees."""
    bar = fm.RigidLink("bar", (0.0, 0.0), (1.0, 0.0), mass=2.0, inertia=1.0 / 6.0)
    mechanism = fm.Mechanism("pendulum", [bar, fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0))], gravity=(0.0, -9.81))
    return fm.chaos.MechanismFlow(mechanism, period=1.6, step=fm.Adaptive(rtol=rtol))


def cranks(*periods):
    """Cranks side by side, each driven with its own period."""
    parts = []
    for k, period in enumerate(periods):
        at = (float(k), 0.0)
        crank = fm.RigidLink(f"crank{k}", at, (k + 0.1, 0.0), mass=1.0, inertia=1e-3)
        pin = fm.Revolute(f"O{k}", fm.GROUND, crank, at=at)
        parts += [crank, pin, fm.Drive(f"motor{k}", pin, fm.ConstantSpeed(systems.TURN / period))]
    return fm.Mechanism("cranks", parts)
