"""Andrews' squeezing mechanism: seven bodies in three loops, a spring and a motor."""

from __future__ import annotations

import numpy as np

from flexmb.arguments import checked
from flexmb.bodies.rigid_body import RigidBody
from flexmb.joints.revolute import Revolute
from flexmb.loads.spring_damper import SpringDamper
from flexmb.loads.torque import Torque
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND
from flexmb.planar import from_frame
from flexmb.results.solution import Solution

NAME = "andrews"
ANGLES = ("beta", "Theta", "gamma", "Phi", "delta", "Omega", "epsilon")
START = (
    -0.0617138900142764496,
    0.0,
    0.455279819163070380,
    0.222668390165885885,
    0.487364979543842550,
    -0.222668390165885885,
    1.23054744454982119,
)
"""Start values of the seven angles [rad], in the order of `ANGLES`."""

O, A, B, C = (0.0, 0.0), (-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)
MASSES = (0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498)
INERTIAS = (2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5)
TORQUE, STIFFNESS, FREE_LENGTH = 0.033, 4530.0, 0.07785

d, da, e, ea, rr, ra = 0.028, 0.0115, 0.02, 0.01421, 0.007, 0.00092
ss, sa, sb, sc, sd = 0.035, 0.01874, 0.01043, 0.018, 0.02
ta, tb, u, ua, ub, zf, zt, fa = 0.02308, 0.00916, 0.04, 0.01228, 0.00449, 0.02, 0.04, 0.01421

Point = tuple[float, float]


@checked
def andrews(torque: float = TORQUE) -> Mechanism:
    """Andrews' squeezing mechanism: a motor of constant torque turns K1 against the spring on K3; no gravity.

    Bodies: K1 ... K7, each a `RigidBody` whose theta is its angle in the source.  Joints: O (frame and K1), A5, A7
    (frame and K5, K7), B (frame and K3), K12, K45, K67 (between the bodies of these numbers), and K32, K34, K36 at the
    common pin of K2, K3, K4 and K6.  Loads: motor, spring.  `andrews_angles` returns the seven angles.

    Parameters
    ----------
    torque : torque of the motor on K1 [N m].

    Raises
    ------
    InputError : a torque that is no finite number.

    Notes
    -----
    Sources: W. Schiehlen (ed.), Multibody Systems Handbook, Springer 1990; E. Hairer, G. Wanner, Solving Ordinary
    Differential Equations II, Springer 1996, section VII.7 (data and start values); problem A03 of the IFToMM library.
    """
    beta, Theta, gamma, Phi, delta, Omega, epsilon = START
    crank, link = from_frame(O, beta, (rr, 0.0)), beta + Theta
    left, right = from_frame(A, delta, (zt, 0.0)), from_frame(A, epsilon, (0.0, -u))
    pin = from_frame(B, gamma, (0.0, -ss))
    # one row a body: origin of its frame, angle, centre of mass in that frame
    frames: list[tuple[Point, float, Point]] = [
        (O, beta, (ra, 0.0)),
        (crank, link, (-da, 0.0)),
        (B, gamma, (sb, -sa)),
        (left, Phi + delta, (0.0, ea - e)),
        (A, delta, (ta, tb)),
        (right, Omega + epsilon, (zf - fa, 0.0)),
        (A, epsilon, (-ub, -ua)),
    ]
    bodies = [
        RigidBody(f"K{k}", from_frame(at, angle, centre), mass, inertia, theta=angle)
        for k, ((at, angle, centre), mass, inertia) in enumerate(zip(frames, MASSES, INERTIAS, strict=True), start=1)
    ]
    K1, K2, K3, K4, K5, K6, K7 = bodies
    joints = [
        Revolute("O", GROUND, K1, at=O),
        Revolute("B", GROUND, K3, at=B),
        Revolute("A5", GROUND, K5, at=A),
        Revolute("A7", GROUND, K7, at=A),
        Revolute("K12", K1, K2, at=crank),
        Revolute("K45", K5, K4, at=left),
        Revolute("K67", K7, K6, at=right),
        *(Revolute(name, K3, body, at=pin) for name, body in (("K32", K2), ("K34", K4), ("K36", K6))),
    ]
    spring = SpringDamper(
        "spring", GROUND, K3, at=C, to=from_frame(B, gamma, (sd, -sc)), stiffness=STIFFNESS, free_length=FREE_LENGTH
    )
    return Mechanism(NAME, (*bodies, *joints, spring, Torque("motor", K1, torque)))


def andrews_angles(solution: Solution, rates: bool = False) -> np.ndarray:
    """The seven angles beta, Theta, gamma, Phi, delta, Omega, epsilon of `andrews`, (7, n) [rad].

    Parameters
    ----------
    solution : a solution of the mechanism `andrews()`.
    rates : whether the rates of the angles [rad/s] are returned instead.

    Raises
    ------
    InputError : a solution of another mechanism.
    """
    signal = "omega" if rates else "theta"
    K1, K2, K3, K4, K5, K6, K7 = (solution.array(f"K{k}.{signal}") for k in range(1, 8))
    return np.array([K1, K2 - K1, K3, K4 - K5, K5, K6 - K7, K7])
