"""Andrews' squeezing mechanism: seven bodies in three loops, whirled by a motor of constant torque.

The angles after 0.03 s, when the motor has turned two and a half times, beside those of the Test Set for Initial Value
Problem Solvers (F. Mazzia, C. Magherini, University of Bari, release 2.4), which are good to 1e-9.
"""

import math

import numpy as np

import flexmb as fm

# Data: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, Springer 1996, section VII.7.
ANGLES = ("beta", "Theta", "gamma", "Phi", "delta", "Omega", "epsilon")
START = (
    -0.0617138900142764496, 0.0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550,
    -0.222668390165885885, 1.23054744454982119,
)  # fmt: skip
PUBLISHED = (
    15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948, 0.5244099658805304,
    0.5347301163226948, 1.048080741042263,
)  # fmt: skip
O, A, B, C = (0.0, 0.0), (-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)
MASSES = (0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498)
INERTIAS = (2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5)
TORQUE, STIFFNESS, FREE_LENGTH = 0.033, 4530.0, 0.07785
d, da, e, ea, rr, ra = 0.028, 0.0115, 0.02, 0.01421, 0.007, 0.00092
ss, sa, sb, sc, sd = 0.035, 0.01874, 0.01043, 0.018, 0.02
ta, tb, u, ua, ub, zf, zt, fa = 0.02308, 0.00916, 0.04, 0.01228, 0.00449, 0.02, 0.04, 0.01421


def from_frame(origin, angle, point):
    """A point of a frame, from its origin and the angle of its x-axis."""
    (x, y), c, s = point, math.cos(angle), math.sin(angle)
    return origin[0] + c * x - s * y, origin[1] + s * x + c * y


def andrews() -> fm.Mechanism:
    """The seven bodies K1 ... K7, whose theta are their angles in the source; no gravity.

    A motor turns K1 against the spring on K3.  K32, K34 and K36 are joints at the common pin of K2, K3, K4 and K6.
    """
    beta, Theta, gamma, Phi, delta, Omega, epsilon = START
    crank, link = from_frame(O, beta, (rr, 0.0)), beta + Theta
    left, right = from_frame(A, delta, (zt, 0.0)), from_frame(A, epsilon, (0.0, -u))
    pin = from_frame(B, gamma, (0.0, -ss))
    frames = [  # of each body: origin of its frame, angle, centre of mass in that frame
        (O, beta, (ra, 0.0)),
        (crank, link, (-da, 0.0)),
        (B, gamma, (sb, -sa)),
        (left, Phi + delta, (0.0, ea - e)),
        (A, delta, (ta, tb)),
        (right, Omega + epsilon, (zf - fa, 0.0)),
        (A, epsilon, (-ub, -ua)),
    ]
    bodies = [
        fm.RigidBody(f"K{k}", from_frame(at, angle, centre), mass, inertia, theta=angle)
        for k, ((at, angle, centre), mass, inertia) in enumerate(zip(frames, MASSES, INERTIAS, strict=True), start=1)
    ]
    K1, K2, K3, K4, K5, K6, K7 = bodies
    joints = [
        fm.Revolute("O", fm.GROUND, K1, at=O),
        fm.Revolute("B", fm.GROUND, K3, at=B),
        fm.Revolute("A5", fm.GROUND, K5, at=A),
        fm.Revolute("A7", fm.GROUND, K7, at=A),
        fm.Revolute("K12", K1, K2, at=crank),
        fm.Revolute("K45", K5, K4, at=left),
        fm.Revolute("K67", K7, K6, at=right),
        *(fm.Revolute(name, K3, body, at=pin) for name, body in (("K32", K2), ("K34", K4), ("K36", K6))),
    ]
    hook = from_frame(B, gamma, (sd, -sc))
    spring = fm.SpringDamper("spring", fm.GROUND, K3, at=C, to=hook, stiffness=STIFFNESS, free_length=FREE_LENGTH)
    return fm.Mechanism("andrews", [*bodies, *joints, spring, fm.Torque("motor", K1, TORQUE)])


def andrews_angles(sol, rates=False):
    """The seven angles [rad] in the order of `ANGLES`, or their rates [rad/s]: (7, n)."""
    signal = "omega" if rates else "theta"
    K1, K2, K3, K4, K5, K6, K7 = (sol.array(f"K{k}.{signal}") for k in range(1, 8))
    return np.array([K1, K2 - K1, K3, K4 - K5, K5, K6 - K7, K7])


def main():
    sol = fm.simulate(andrews(), t_end=0.03, step=1e-5, save=300, method=fm.RungeKutta4())
    if not sol.ok:
        raise SystemExit(sol.status)
    for name, published, angle in zip(ANGLES, PUBLISHED, andrews_angles(sol)[:, -1], strict=True):
        print(f"{name:8s}{angle:14.9f} rad (published {published:.9f})")
    fm.render(sol, path="out/andrews.png")


if __name__ == "__main__":
    main()
