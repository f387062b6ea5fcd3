"""Balls thrown along X inside holes of the ground, one impact each; several impacts in one run."""

import flexmb as fm

PLAY, RADIUS = 2e-4, 1e-2


def thrown(laws, *, t_end, step, mass=1.0, speed=1.0, play=PLAY, radius=RADIUS, method=None, restart=None):
    """The solution, saved at every step, of one ball a law; ball k flies in the joint "J{k}"."""
    parts = []
    for k, law in enumerate(laws):
        ball = fm.RigidBody(f"ball{k}", (0.0, 0.0), mass, 1.0, velocity=(speed, 0.0, 0.0))
        joint = fm.RevoluteClearance(
            f"J{k}", fm.GROUND, ball, (0.0, 0.0), clearance=play, bearing_radius=radius, normal=law
        )
        parts += [ball, joint]
    method = method or fm.Newmark.trapezoidal()
    mech = fm.Mechanism("thrown", parts)
    return fm.simulate(mech, t_end=t_end, step=step, method=method, save="steps", restart=restart)


def returned(sol, number, speed=1.0):
    """Restitution of each ball, all of which have left the wall again."""
    assert sol.ok, sol.status
    for k in range(number):
        assert sol.array(f"J{k}.normal_force").max() > 0.0
        assert sol.array(f"J{k}.mode")[-1] == 0.0, f"ball {k} has not left"
    return [-sol.array(f"ball{k}.vx")[-1] / speed for k in range(number)]


def stiffness(exponent, depth=1e-5, mass=1.0, speed=1.0):
    """K for which (m v^2/K)^(1/(n+1)) is `depth`."""
    return mass * speed**2 / depth ** (exponent + 1.0)
