"""Rotor that rubs all the way round in its clearance."""

import cmath
import math
from pathlib import Path
from typing import Any

import numpy as np

import flexmb as fm
from measured import compared, table

RECORDS = False
"""Whether the section needs measured records."""

MASS, SHAFT, DAMPING, CLEARANCE, UNBALANCE = 1.0, 1.0, 0.1, 1.0, 0.3
STATOR, FRICTION = 10.0, 0.1
RADIUS, TINY = 10.0, 1e-12
"""Radius of the stator; mass and moment of inertia of the sliders by which the rotor keeps its speed."""

CASES = ((1.0, 1.03), (1.2, 1.09), (1.2, 1.003))
"""Speeds, and first guesses of the amplitude."""

STEPS = (2000, 4000)
"""Numbers of steps in a turn; the errors of both, of the second order, are extrapolated."""


def rotor(speed: float) -> fm.Mechanism:
    """A disc on an elastic shaft, kept at its speed by an Oldham coupling, in a stator with friction."""
    centre = (0.0, 0.0)
    across = fm.RigidBody("across", centre, TINY, TINY)
    along = fm.RigidBody("along", centre, TINY, TINY)
    disc = fm.RigidBody("disc", (UNBALANCE, 0.0), MASS, MASS)
    laws = {"normal": fm.KelvinVoigt(STATOR, 0.0), "friction": fm.ModifiedCoulomb(FRICTION)}
    return fm.Mechanism(
        "rotor",
        [
            *(across, along, disc),
            fm.Prismatic("slot1", fm.GROUND, across, at=centre, along=(1.0, 0.0)),
            fm.Prismatic("slot2", across, along, at=centre, along=(0.0, 1.0)),
            fm.Revolute("hub", along, disc, at=centre),
            fm.Drive("motor", "hub", fm.ConstantSpeed(speed)),
            fm.Bushing("shaft", fm.GROUND, disc, at=centre, stiffness=SHAFT, damping=DAMPING),
            fm.RevoluteClearance("rub", fm.GROUND, disc, at=centre, clearance=CLEARANCE, bearing_radius=RADIUS, **laws),
        ],
        gravity=(0.0, 0.0),
    )


def pulled(speed: float, amplitude: float) -> complex:
    """Stiffness of shaft, inertia and stator to the whirl with an amplitude."""
    wall = STATOR * (1.0 - CLEARANCE / amplitude)
    return SHAFT - MASS * speed**2 + wall + 1j * (DAMPING * speed + FRICTION * wall)


def closed(speed: float, guess: float) -> float:
    """Amplitude of the closed form, by Newton's method from a guess."""
    from scipy.optimize import newton  # noqa: PLC0415 - takes long to import

    load = MASS * UNBALANCE * speed**2
    return float(newton(lambda A: abs(pulled(speed, A)) * A - load, guess, tol=1e-15, rtol=1e-15))


def orbit(speed: float, guess: float, steps: int) -> tuple[float, float, float]:
    """Amplitude, normal force, and size of the largest multiplier of the periodic orbit near a guess."""
    turn = 2.0 * math.pi / speed
    flow = fm.chaos.MechanismFlow(rotor(speed), step=turn / steps, period=turn)
    whirl = guess * cmath.exp(-1j * cmath.phase(pulled(speed, guess)))
    state, places = flow.state(), flow.state_names
    for body, reach in (("across", whirl.real), ("along", whirl), ("disc", whirl + UNBALANCE)):
        rate = 1j * speed * whirl if body != "disc" else 1j * speed * reach
        for axis, part in (("x", "real"), ("y", "imag")):
            if (body, axis) != ("across", "y"):
                state[places[f"{body}.{axis}"]] = getattr(complex(reach), part)
                state[places[f"{body}.v{axis}"]] = getattr(rate, part)
    found = fm.chaos.periodic_orbit(flow, period=turn, guess=state)
    if not found.ok:
        raise SystemExit(found.status)
    round_it = found.samples(8)
    amplitude = np.hypot(round_it["rub.ex"], round_it["rub.ey"])
    return float(amplitude.mean()), float(round_it["rub.normal_force"].mean()), float(abs(found.multipliers[0]))


def numbers(_: Path | None) -> dict[str, Any]:
    """Computed and closed values of each case."""
    rows = []
    for speed, guess in CASES:
        (one, first, _), (two, second, growth) = (orbit(speed, guess, steps) for steps in STEPS)
        known, factor = closed(speed, guess), (STEPS[1] / STEPS[0]) ** 2
        ours = [last + (last - before) / (factor - 1.0) for before, last in ((one, two), (first, second))]
        rows.append(
            {
                "speed": speed,
                "known": [known, STATOR * (known - CLEARANCE)],
                "ours": ours,
                "plain": [two, second],
                "growth": growth,
            }
        )
    return {"rows": rows}


def passage(found: dict[str, Any]) -> str:
    """A table of amplitudes and forces."""
    rows = [
        [
            f"{one['speed']:g}",
            *compared(name, one["known"][k], one["ours"][k], 11),
            f"{one['plain'][k]:.11g}",
            f"{one['growth']:.3f}",
        ]
        for one in found["rows"]
        for k, name in enumerate(("amplitude", "normal force"))
    ]
    head = [
        "speed",
        "quantity",
        "closed form",
        "ours, extrapolated",
        "error",
        f"ours, {STEPS[1]} steps a turn",
        "largest multiplier",
    ]
    return table(head, rows, left=2)
