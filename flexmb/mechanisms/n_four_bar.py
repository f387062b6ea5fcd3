"""Row of parallel four-bar linkages, which passes a singular position."""

from __future__ import annotations

from flexmb import arguments, checks
from flexmb.bodies.rigid_link import RigidLink
from flexmb.joints.revolute import Revolute
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND

STANDARD_GRAVITY = 9.81
"""Acceleration of gravity [m/s^2]."""


@arguments.checked
def n_four_bar(
    windows: int = 2, *, length: float = 1.0, mass: float = 1.0, speed: float = 1.0, gravity: float = STANDARD_GRAVITY
) -> Mechanism:
    """N parallelograms side by side: N + 1 upright rockers on the ground, N couplers between their upper ends.

    All 2 N + 1 links are uniform, equal bars, and the rockers stand one length apart.  When the rockers lie on the
    ground, all links lie on one line: in this singular position the constraint equations are dependent, and every
    parallelogram could continue as an antiparallelogram.

    Bodies: rocker0 ... rockerN, coupler1 ... couplerN.  Joints: A0 ... AN (frame), P1 S1 ... PN SN; Pk connects coupler
    k with rocker k - 1, Sk with rocker k.  Gravity acts along -Y.

    Parameters
    ----------
    windows : number N of parallelograms, >= 1.
    length : length of every link, and distance of the rockers [m], > 0.
    mass : mass of every link [kg], > 0.
    speed : start speed of the rockers' upper ends along +X [m/s].
    gravity : acceleration of gravity along -Y [m/s^2].

    Raises
    ------
    InputError : values out of range or of the wrong kind.

    Notes
    -----
    Source: problem A02 of the library of benchmark problems of the IFToMM technical committee for multibody dynamics,
    whose numbers are the defaults; M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado, A benchmarking system for MBS
    simulation software, Multibody System Dynamics 16 (2006) 179-190.

    Examples
    --------
    >>> n_four_bar(1).names
    ('rocker0', 'rocker1', 'coupler1', 'A0', 'A1', 'P1', 'S1')
    """
    owner = "n_four_bar"
    count = checks.count(owner, "windows", windows)
    side = checks.positive(owner, "length", length, "m")
    checks.positive(owner, "mass", mass, "kg")
    spin = -checks.number(owner, "speed", speed, "m/s") / side
    down = checks.number(owner, "gravity", gravity, "m/s^2")
    inertia = mass * side * side / 12.0
    feet = [(k * side, 0.0) for k in range(count + 1)]
    heads = [(k * side, side) for k in range(count + 1)]
    start = (-0.5 * spin * side, 0.0, spin)
    rockers = [
        RigidLink(f"rocker{k}", feet[k], heads[k], mass, inertia, velocity=start if k == 0 else None)
        for k in range(count + 1)
    ]
    couplers = [RigidLink(f"coupler{k}", heads[k - 1], heads[k], mass, inertia) for k in range(1, count + 1)]
    joints = [Revolute(f"A{k}", GROUND, rocker, at=feet[k]) for k, rocker in enumerate(rockers)]
    for k, coupler in enumerate(couplers, start=1):
        joints.append(Revolute(f"P{k}", rockers[k - 1], coupler, at=heads[k - 1]))
        joints.append(Revolute(f"S{k}", coupler, rockers[k], at=heads[k]))
    return Mechanism(f"{count}-four-bar", (*rockers, *couplers, *joints), gravity=(0.0, -down))
