"""Mechanisms of the literature that several folders of tests use."""

import math

import rod_of_plates as rod

import flexmb as fm

PUSHED = 2.5
"""Duration of the force and the moment that throw the free rod [s]."""

STRETCH, STRETCH_RATE = (0.103339863e-4, 0.169327969e-4), (-0.178591076e-5, -0.268938672e-5)
"""Axial displacements q3, q4 of the middle and the end of Simeon's rod at the start [m], and their rates [m/s]."""

WAVES = (0.444896105, 0.463434311e-2)
"""Rates of the amplitudes q1, q2 of its first and second lateral sine wave at the start [m/s]."""


def free_rod(elements=16):
    """A free rod, thrown from rest by a force and a moment on its lower end.

    J. C. Simo, L. Vu-Quoc, On the dynamics of flexible beams under large overall motions, part II, J. Applied Mechanics
    53 (1986) 855-863: E A = 1e4 N, E I = 500 N m^2, rho A = 1 kg/m, rho I = 10 kg m, and G A = 1e4 N, which a slender
    beam does not have.
    """
    lower, upper = (6.0, 0.0), (0.0, 8.0)
    section = fm.GeneralSection(area=1.0, second_moment=0.05, outer_fibre=0.5)  # the source gives products only
    beam = fm.FlexibleLink(
        "rod", lower, upper, section=section, material=fm.Material(1e4, 1.0), elements=elements, rotary_inertia=10.0
    )
    pulse = fm.drives.Pulse(end=PUSHED)
    push = fm.Force("push", beam, at=lower, force=(8.0, 0.0), history=pulse)
    return fm.Mechanism("free rod", [beam, push, fm.Torque("twist", beam, -80.0, at=lower, history=pulse)])


def n_four_bar(windows=2):
    """N + 1 upright rockers, N couplers between their upper ends: problem A02 of the IFToMM benchmark library.

    When the rockers lie on the ground, all links lie on one line: the constraint equations are dependent, and every
    parallelogram could continue as an antiparallelogram.  M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado, Multibody
    System Dynamics 16 (2006) 179-190.
    """
    feet, heads = ([(float(k), y) for k in range(windows + 1)] for y in (0.0, 1.0))
    bar = {"mass": 1.0, "inertia": 1.0 / 12.0}
    rockers = [
        fm.RigidLink(f"rocker{k}", feet[k], heads[k], **bar, velocity=(0.5, 0.0, -1.0) if k == 0 else None)
        for k in range(windows + 1)
    ]
    couplers = [fm.RigidLink(f"coupler{k}", heads[k - 1], heads[k], **bar) for k in range(1, windows + 1)]
    joints = [fm.Revolute(f"A{k}", fm.GROUND, rocker, at=feet[k]) for k, rocker in enumerate(rockers)]
    for k, coupler in enumerate(couplers, start=1):
        joints.append(fm.Revolute(f"P{k}", rockers[k - 1], coupler, at=heads[k - 1]))
        joints.append(fm.Revolute(f"S{k}", coupler, rockers[k], at=heads[k]))
    return fm.Mechanism(f"{windows}-four-bar", [*rockers, *couplers, *joints], gravity=(0.0, -9.81))


def simeon(elements=8, stretched=True, waving=True):
    """Simeon's slider-crank, whose rod starts with the published stretch and rates, or unstressed, or without waves.

    Start values: W. Lioen, J. de Swart, Test Set for Initial Value Problem Solvers.  J2 = 0.0045339259 kg m^2 of the
    source is m l^2/3 + m h^2/12 of the rod about its pin; the beam has m l^2/3, 0.02 % less.
    """
    start = {"displacement": lambda s: (parabola(STRETCH, s), 0.0, 0.0)} if stretched else {}
    start["velocity"] = start_velocity(stretched, waving)
    return rod.slider_crank(rod.rod_of_beams(elements, **start))


def start_velocity(stretched, waving):
    """Rigid motion of the chord, lateral waves, rates of the axial displacements."""
    tip = rod.SPEED * rod.CRANK
    turn = -tip / (rod.ROD + (STRETCH[1] if stretched else 0.0))
    a, b = WAVES if waving else (0.0, 0.0)
    rate = STRETCH_RATE if stretched else (0.0, 0.0)

    def velocity(s):
        x = rod.ROD * s + (parabola(STRETCH, s) if stretched else 0.0)
        wave = a * math.sin(math.pi * s) + b * math.sin(2.0 * math.pi * s)
        slope = math.pi / rod.ROD * (a * math.cos(math.pi * s) + 2.0 * b * math.cos(2.0 * math.pi * s))
        return parabola(rate, s), tip + turn * x + wave, turn + slope

    return velocity


def parabola(values, s):
    """Through 0 at s = 0, values[0] at 1/2, values[1] at 1."""
    return 4.0 * values[0] * s * (1.0 - s) + values[1] * s * (2.0 * s - 1.0)
