"""A user's file: a part whose kernel is a function of this module, and a mechanism with it."""

from dataclasses import dataclass

import flexmb as fm


@fm.element_kernel
def torsion_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    k, d = p
    r[0] = k * (q[0] - q[1]) + d * (v[0] - v[1])
    r[1] = -r[0]
    K[0, 0] = K[1, 1] = k
    K[0, 1] = K[1, 0] = -k
    C[0, 0] = C[1, 1] = d
    C[0, 1] = C[1, 0] = -d


@dataclass(frozen=True)
class Coil(fm.Element):
    """Linear spring and damper between the rotations of two bodies."""

    first: fm.Part
    second: fm.Part
    k: float
    d: float = 0.0
    kernel = torsion_kernel
    coords = ("first.theta", "second.theta")


def pendulum(coil=Coil):
    """A double pendulum with a coil in its elbow and play in its shoulder."""
    upper = fm.RigidLink("upper", (0.0, 0.0), (0.2, 0.0), mass=0.5, inertia=2e-3)
    lower = fm.RigidLink("lower", (0.2, 0.0), (0.5, 0.1), mass=0.4, inertia=3e-3)
    law = fm.LankaraniNikravesh(stiffness=1e8, restitution=0.8)
    shoulder = fm.RevoluteClearance(
        "shoulder", fm.GROUND, upper, at=(0.0, 0.0), clearance=2e-4, bearing_radius=8e-3, normal=law,
        friction=fm.ModifiedCoulomb(0.1),
    )  # fmt: skip
    elbow = fm.Revolute("elbow", upper, lower, at=(0.2, 0.0))
    parts = [upper, lower, shoulder, elbow, coil("coil", upper, lower, 0.5, 0.01)]
    return fm.Mechanism("pendulum", parts, gravity=(0.0, -9.81))


def motion(program):
    """Signals of a short run of a compiled mechanism, (n, n_y), started as `simulate` starts it."""
    import numpy as np

    from flexmb.engine.newmark.method import Newmark
    from flexmb.engine.step.step_size import FixedStep
    from flexmb.run.run import Run
    from flexmb.statics.start.consistent import Start, accelerations

    run = Run(program, Newmark.generalised_alpha(), FixedStep(2e-4), 0.02, None)
    q, v = program.reference.q, np.zeros(program.n_q)
    run.begin(Start(q, v, *accelerations(program, q, v, 0.0)))
    run.run_to(0.02, saving=0.0)
    return run.solution({}).values
