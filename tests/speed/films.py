"""Cost of oil films in a step: the slider-crank with a dry joint, and with each film in its place.

Run alone on a quiet machine: python tests/speed/films.py
"""

import math
import statistics
import time

import flexmb as fm
from flexmb.mechanisms import slider_crank

STEP, PERIODS, PAIRS = 1e-5, 2, 7
DRY = slider_crank(speed=2.0 * math.pi * 1000 / 60, clearance=5e-5)
SHAPE = {"viscosity": 0.02, "width": 0.012}
FILMS = {
    "short": fm.ShortBearing(**SHAPE),
    "long": fm.LongBearing(**SHAPE),
    "finite": fm.FiniteBearing(**SHAPE),
    "grooves": fm.FiniteBearing(**SHAPE, grooves=(0.5 * math.pi, 1.5 * math.pi)),
}


def wet(film):
    """The slider-crank with a film in the joint of its slider."""
    rod, piston, dry = DRY["rod"], DRY["slider"], DRY["B"]
    laws = {"normal": dry.normal, "friction": dry.friction, "roughness": 1e-6}
    place = {"at": (0.17, 0.0), "clearance": 5e-5, "bearing_radius": 0.010}
    return DRY.with_part(fm.JournalBearing("B", rod, piston, **place, film=film, **laws))


def seconds(mechanism):
    """Processor time of a step [s]."""
    begin = time.process_time()
    sol = fm.simulate(mechanism, periods=PERIODS, step=STEP, save=100)
    return (time.process_time() - begin) / sol.stats.steps


if __name__ == "__main__":
    for name, film in FILMS.items():
        mechanism = wet(film)
        pairs = [(seconds(mechanism), seconds(DRY)) for _ in range(PAIRS + 1)][1:]  # the first pair compiles
        ratio = statistics.median(own / dry for own, dry in pairs)
        steps = 1e6 * statistics.median(dry for _, dry in pairs)
        print(f"{name:8s} {ratio:.2f} times a step with the dry joint, {steps:.2f} us")
