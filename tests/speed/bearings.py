"""Cost of oil films and of worn contacts in a step, and of many turns: `python tests/speed/bearings.py [--steps]`.

The slider-crank with a dry joint or guide, and a crank with a slot, beside the same with each film and each worn
surface in its place, in pairs.  The rows are kept in out/speed for `python docs/performance.py --collect`; with
`--steps` the many turns are left out.  It wants a quiet machine.
"""

import argparse
import math
import statistics
import time

import numpy as np
from duel import keep

import flexmb as fm
from flexmb.mechanisms import slider_crank

STEP, PERIODS, PAIRS, TURNS = 1e-5, 2, 7, 1e6
SPEED, CLEARANCE = 2.0 * math.pi * 1000 / 60, 5e-5
DRY = slider_crank(speed=SPEED, clearance=CLEARANCE)
ARCHARD = fm.Archard(bearing=1e-13, bins=360, width=0.02)
NEW = DRY["B"].worn_by(ARCHARD)
SHAPE, ANGLE = {"viscosity": 0.02, "width": 0.012}, 2.0 * math.pi * np.arange(360) / 360
GROOVE = np.maximum(9e-5 * np.cos(ANGLE) - CLEARANCE, 0.0)
SIDES = {
    "clearance": CLEARANCE, "normal": fm.KelvinVoigt(3e8, 3e4),
    "friction": fm.ModifiedCoulomb(0.1, v0=1e-3, v1=1e-2),
}  # fmt: skip
LENGTH = 0.3
HOLLOW = 2e-5 * np.exp(-((np.linspace(-0.5, 0.5, 360) * LENGTH / 0.03) ** 2))


def wet(film):
    """The joint of the slider in a film."""
    dry = DRY["B"]
    laws = {"normal": dry.normal, "friction": dry.friction, "roughness": 1e-6}
    place = {"at": (0.17, 0.0), "clearance": CLEARANCE, "bearing_radius": 0.010}
    return fm.JournalBearing("B", DRY["rod"], DRY["slider"], **place, film=film, **laws)


def sliding():
    """The slider-crank whose guide has the play."""
    ideal = slider_crank(speed=SPEED)
    guide = fm.PrismaticClearance("guide", fm.GROUND, ideal["slider"], half_length=0.02, half_height=0.01, **SIDES)
    return ideal.with_part(guide)


def yoke():
    """A crank whose pin runs in the upright slot of a slider."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.1, 0.0), 0.2, 1e-3)
    body = fm.RigidBody("yoke", (0.1, 0.0), 0.7, 1e-3)
    slot = fm.PinSlotClearance("P", body, crank, at=(0.1, 0.0), along=(0.0, 1.0), pin_radius=8e-3, **SIDES)
    joints = [fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)), fm.Prismatic("guide", fm.GROUND, body, (1.0, 0.0))]
    return fm.Mechanism("yoke", [crank, body, *joints, fm.Drive("motor", "O", fm.ConstantSpeed(SPEED)), slot])


def worn(joint, depths, **more):
    """A joint with a worn surface."""
    return joint.worn_by(ARCHARD, **more).with_depths(depths)


GUIDED, SLOTTED = sliding(), yoke()
SHORT, THIN = wet(fm.ShortBearing(**SHAPE)), wet(fm.ShortBearing(viscosity=3e-4, width=0.012))
ROWS = {  # joint, and the mechanism with the dry one
    "short film": (SHORT, DRY),
    "long film": (wet(fm.LongBearing(**SHAPE)), DRY),
    "finite film": (wet(fm.FiniteBearing(**SHAPE)), DRY),
    "finite film, two grooves": (wet(fm.FiniteBearing(**SHAPE, grooves=(0.5 * math.pi, 1.5 * math.pi))), DRY),
    "360 angles, unworn": (NEW, DRY),
    "360 angles, worn": (NEW.with_depths(GROOVE), DRY),
    "short film, 360 angles, unworn": (worn(SHORT, np.zeros(360)), DRY),
    "short film, 360 angles, worn": (worn(SHORT, GROOVE), DRY),
    "thin oil and contact, 360 angles, worn": (worn(THIN, GROOVE), DRY),
    "guide, 360 places, worn": (worn(GUIDED["guide"], np.tile(HOLLOW, 2), length=LENGTH), GUIDED),
    "slot, 360 places, worn": (worn(SLOTTED["P"], np.tile(HOLLOW, 2), length=LENGTH), SLOTTED),
}


def seconds(mechanism):
    """Processor time of a step [s]."""
    begin = time.process_time()
    sol = fm.simulate(mechanism, periods=PERIODS, step=STEP, save=100).require()
    return (time.process_time() - begin) / sol.stats.steps


def steps():
    """Rows: name, time of a step [us], and its ratio to that with the dry joint."""
    for name, (joint, dry) in ROWS.items():
        mechanism = dry.with_part(joint)
        pairs = [(seconds(mechanism), seconds(dry)) for _ in range(PAIRS + 1)][1:]  # the first pair compiles
        ratio = statistics.median(own / of_dry for own, of_dry in pairs)
        print(f"{name:40s} {ratio:.2f} times a step with the dry joint", flush=True)
        yield [name, 1e6 * statistics.median(own for own, _ in pairs), ratio]


def lives():
    """Rows of a million turns: tolerance, time [s], runs, deepest place [um], volume [mm^3]."""
    for tolerance in (0.02, 0.01):
        begin = time.process_time()
        life = fm.wear_out(DRY.with_part(NEW), turns=TURNS, tolerance=tolerance)
        spent, deepest = time.process_time() - begin, 1e6 * float(life["B.bearing_profile"][-1].max())
        found = [tolerance, spent, int(life["runs"][-1]), deepest, 1e9 * float(life["B.volume"][-1])]
        print("tolerance {:g}: {:.0f} s, {} runs, {:.2f} um deep, {:.4g} mm^3".format(*found), flush=True)
        yield found


def main():
    """Measure and keep."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", action="store_true", help="leave the many turns out")
    chosen = parser.parse_args()
    keep("bearings", {"rows": list(steps())})
    if not chosen.steps:
        keep("lives", {"rows": list(lives())})


if __name__ == "__main__":
    main()
