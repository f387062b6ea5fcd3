"""Pendulums of the records: fixed and published numbers, bounds of the fits, pieces that are fitted."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import flexmb as fm
from measured.chains import Bounds, Numbers


@dataclass(frozen=True)
class Case:
    """A pendulum: its record, fixed numbers, published friction, bounds of two fits, the pieces that are fitted."""

    name: str
    arms: int
    fixed: Numbers
    published: Numbers
    geometry: Bounds
    viscous: Bounds
    ours: Bounds
    pieces: Sequence[int]
    step: fm.Adaptive
    refit: Numbers = field(default_factory=dict)  # of an independent script, viscous, from recorded starts
    told: tuple[str, ...] = ()  # numbers of which all but some combinations are in doubt


REFIT_J = 0.147754901 * 0.147584572 * 9.8100131 / 63.9493
"""Moment of inertia about the bearing [kg m^2] that w0^2 = 63.9493 1/s^2 gives; there k/J is 0.05836 1/s."""

SINGLE = Case(
    "single",
    1,
    {"m1": 0.147754901, "a1": 0.147584572, "I1": 1.0911851e-4, "g": 9.8100131},
    {"k1": 2.2394013e-4},
    {"I1": (8e-5, 2e-4)},
    {"k1": (1e-5, 5e-4)},
    {"mu1": (1e-4, 3e-3), "b1": (1e-6, 5e-5)},
    (0, 2),
    fm.Adaptive(rtol=5e-4),
    {"I1": REFIT_J - 0.147754901 * 0.147584572**2, "k1": 0.05836 * REFIT_J},
    ("m1", "a1", "I1"),
)

DOUBLE = Case(
    "double",
    2,
    {
        **{"m1": 0.093843975, "a1": 0.108565215, "I1": 4.3752943e-4, "L1": 0.172719204},
        **{"m2": 0.137595970, "a2": 0.116779018, "I2": 1.26882939e-3, "g": 9.80858},
    },
    {"k1": 2.3714278e-4, "k2": 1e-5},
    {"L1": (0.170, 0.176), "a2": (0.112, 0.122), "I1": (3.5e-4, 5.5e-4), "I2": (1.1e-3, 1.4e-3)},
    {"k1": (1e-6, 5e-4), "k2": (1e-7, 5e-5)},
    {"mu1": (1e-4, 2e-3), "mu2": (1e-5, 1e-3), "b2": (1e-6, 3e-5)},
    (0, 8, 16, 24),
    fm.Adaptive(rtol=1e-3),
    told=("m1", "a1", "I1", "L1", "m2", "a2", "I2"),
)

TRIPLE = Case(
    "triple",
    3,
    {"m1": 0.0938, "a1": 0.1086, "m2": 0.13, "m3": 0.07, "g": 9.81},
    {},
    {
        **{"L1": (0.170, 0.180), "L2": (0.220, 0.240), "a2": (0.12, 0.15), "a3": (0.11, 0.14)},
        **{"I1": (2e-4, 1e-3), "I2": (5e-4, 2e-3), "I3": (3e-4, 9e-4)},
    },
    {"k1": (1e-6, 2e-3), "k2": (1e-7, 5e-4), "k3": (1e-7, 5e-4)},
    {"mu1": (1e-5, 3e-3), "mu2": (1e-5, 3e-3), "mu3": (1e-6, 1e-3), "b3": (1e-7, 5e-5)},
    (0, 7, 14, 21),
    fm.Adaptive(rtol=1e-3),
)

CASES = {case.name: case for case in (SINGLE, DOUBLE, TRIPLE)}
