"""Short runs, and damaged copies of files, for tests of kills, full disks and broken files."""

import flexmb as fm

PAGE = 4096
"""Bytes that a file system writes, or loses, as one."""


def crank(**more):
    """Half a turn of a slider-crank with clearance, some ten impacts."""
    return fm.simulate(fm.mechanisms.slider_crank(clearance=5e-4), periods=0.5, save=200, **more)


def servo(**more):
    """A rotor under a sampled PID law: blocks of the run end at its samples."""
    body = fm.RigidBody("rotor", at=(0.0, 0.0), mass=1.0, inertia=2e-3)
    axis = fm.Revolute("axis", fm.GROUND, body, at=(0.0, 0.0))
    pid = fm.PID("pid", "rotor.omega", target=20.0, kp=0.3, ki=2.0, limit=10.0, sample=1e-3)
    motor = fm.controllers.DCMotor(
        "motor", "rotor.omega", "shaft", voltage="pid.output", resistance=2.0, inductance=5e-3, torque_constant=0.05
    )
    rotor = fm.Mechanism("rotor", [body, axis, fm.Torque("shaft", body, 1.0), motor, pid])
    return fm.simulate(rotor, t_end=0.2, save=100, **more)


def damaged(content, rng):
    """A copy of the bytes with flipped bits, cut, with zeroed or repeated pages, or emptied; never the same."""
    found = bytearray(content)
    kind = rng.randrange(6)
    place = rng.randrange(len(found))
    if kind == 0:
        for _ in range(rng.choice((1, 1, 8, 100))):
            found[rng.randrange(len(found))] ^= 1 << rng.randrange(8)
    elif kind == 1:
        del found[place:]
    elif kind == 2:
        place -= place % PAGE
        found[place : place + PAGE] = bytes(len(found[place : place + PAGE]))
    elif kind == 3:
        found[max(len(found) - rng.choice((1, 30, 31, 500)), 0) :] = b""
    elif kind == 4:
        found = found[:place] + found[place + rng.randrange(1, PAGE) :] + bytes(rng.choice((0, PAGE)))
    else:
        found = bytearray(rng.choice((0, PAGE, len(found))))
    return bytes(found) if bytes(found) != content else damaged(content, rng)
