"""Rainflow count against the example of ASTM E1049-85; damage against closed forms."""

from collections import Counter

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError
from flexmb.results import WoehlerLine
from flexmb.results.stress import cycles_of

pytest.importorskip("rainflow")

AREA, LENGTH, PULL, FREQUENCY, TIMES = 1e-4, 0.1, 8000.0, 50.0, 5


def test_example_of_the_standard():
    """ASTM E1049-85 (2017), section 5.4.4, figure 6: 0.5 of 3, 1.5 of 4, 0.5 of 6, 1 of 8, 0.5 of 9."""
    ranges, means, counts = cycles_of(np.array([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0]))
    found = Counter()
    for size, count in zip(ranges, counts, strict=True):
        found[float(size)] += float(count)
    assert found == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
    assert means[list(ranges).index(9.0)] == 0.5  # from -4 to 5


def test_constant_amplitude():
    line = WoehlerLine(amplitude=100e6, slope=5.0, cycles=1e6)
    ranges, _, counts = cycles_of(np.tile([200e6, -200e6], 1000))
    assert counts.sum() == pytest.approx(999.5)
    assert line.damage(0.5 * ranges, counts) == pytest.approx(999.5 * 2.0**5 / 1e6)
    assert WoehlerLine(100e6, limit=201e6).damage(0.5 * ranges, counts) == 0.0
    assert WoehlerLine(100e6).life(0.0) == np.inf


def pulsing(body, **more):
    """A rod that a slow harmonic force pulls and presses along its axis."""
    wall = fm.Fixed("wall", fm.GROUND, body, (0, 0))
    load = fm.Force("F", body, (LENGTH, 0), (PULL, 0.0), history=fm.drives.Harmonic(1.0, frequency=FREQUENCY))
    mechanism = fm.Mechanism("pulsing", [body, wall, load])
    return fm.simulate(mechanism, **{"t_end": TIMES / FREQUENCY, "save": 500, "step": 1e-4, **more})


def rod(**more):
    square = fm.Rectangle(width=0.01, height=0.01)
    material = fm.Material(2.1e11, 7850.0, 0.3)
    return fm.FlexibleLink("rod", (0, 0), (LENGTH, 0), section=square, material=material, damping=1e-5, **more)


def test_damage_of_a_rod():
    line, amplitude = WoehlerLine(amplitude=60e6, slope=4.0), PULL / AREA
    sol = pulsing(rod(stress=True))
    found = sol.fatigue("rod", line)
    # from 0, up and down, to 0: 2 n - 1 half cycles of the whole range, two halves of half the range
    damage = (TIMES - 0.5) / line.life(amplitude) + 1.0 / line.life(0.5 * amplitude)
    assert found.counts.sum() == TIMES + 0.5
    assert found.damage == pytest.approx(damage, rel=5e-3)
    assert found.life == pytest.approx(line.life(amplitude) / FREQUENCY, rel=5e-3)  # repeated, each period is a cycle
    assert found.captured == pytest.approx(1.0, abs=2e-3)
    assert "save more" not in repr(found)


@pytest.mark.parametrize("part", [1.0, 1.25])
def test_life_of_a_short_run(part):
    """Repeated, a harmonic stress has a cycle a period, and one more of 0 to the peak where a run ends at the peak."""
    line, amplitude, period = WoehlerLine(amplitude=60e6, slope=4.0), PULL / AREA, 1.0 / FREQUENCY
    found = pulsing(rod(stress=True), t_end=part * period).fatigue("rod", line)
    damage = 1.0 / line.life(amplitude) + (part > 1.0) / line.life(0.5 * amplitude)
    assert found.life == pytest.approx(part * period / damage, rel=5e-3)


def test_coarse_instants_are_told():
    found = pulsing(rod(stress=True), save=15).fatigue("rod")
    assert found.captured < 0.95
    assert "of the largest stress: save more" in repr(found)
    assert np.isnan(found.damage)


def test_point_without_the_signal():
    sol = pulsing(rod())
    with pytest.raises(InputError, match=r"no signal 'rod.von_mises'.*Give point=..., or stress=True"):
        sol.fatigue("rod")
    with pytest.raises(InputError, match=r"woehler is .1e6.; it must be a WoehlerLine"):
        sol.fatigue("rod", "1e6", point="start")
    assert sol.fatigue("rod", WoehlerLine(60e6), point="start").damage > 0.0


def sheared(history):
    """Stresses and fatigue at the neutral axis of a short block whose end is pushed across."""
    mesh = fm.meshes.rectangle(0.06, 0.04, 6, 4)
    steel = fm.Material(2e11, 7800.0, 0.3)
    block = fm.PlaneBody("block", mesh, thickness=0.01, material=steel, pins=("left", "right"), damping=1e-5)
    wall = fm.Fixed("wall", fm.GROUND, block, at=(0.0, 0.02))
    push = fm.Force("push", block, at=(0.06, 0.02), force=(0.0, -20e3), history=history)
    pull = fm.Force("pull", block, at=(0.06, 0.02), force=(300.0, 0.0), history=fm.drives.Harmonic(1.0, FREQUENCY))
    how = {"t_end": TIMES / FREQUENCY, "save": 500, "step": 2e-4, "start": "equilibrium"}
    sol = fm.simulate(fm.Mechanism("sheared", [block, wall, push, pull]), **how).require()
    middle = (0.03, 0.02)
    return sol.stress("block", [middle]), sol.fatigue("block", WoehlerLine(50e6), point=middle)


def test_reversed_shear_has_the_damage_of_its_planes():
    """Under +-tau each plane at 45 degrees sees +-tau; the largest principal stress sees +tau twice."""
    stresses, found = sheared(fm.drives.Harmonic(1.0, frequency=FREQUENCY))
    tau = float(np.abs(stresses.txy).max())
    assert float(np.abs(stresses.sx).max()) < 0.05 * tau
    damage = (TIMES - 0.5) / found.woehler.life(tau) + 1.0 / found.woehler.life(0.5 * tau)
    assert found.damage == pytest.approx(damage, rel=0.05)  # (1 + s/2 tau)^5 with the normal stress s


@pytest.mark.slow
def test_steady_shear_with_a_ripple_does_no_damage():
    stresses, found = sheared(fm.drives.Harmonic(0.01, frequency=FREQUENCY, mean=1.0))
    tau = np.abs(stresses.txy.values)
    assert np.ptp(stresses.signed.values) > 1.9 * tau.max()  # it jumps between the principal stresses
    assert found.ranges.max() < 1.1 * (np.ptp(tau) + 0.5 * np.ptp(stresses.sx.values))
    assert found.ranges.max() < 0.05 * tau.max()


def test_bad_woehler_lines():
    for values in ({"amplitude": 0.0}, {"amplitude": 1e8, "slope": -1.0}, {"amplitude": 1e8, "limit": -1.0}):
        with pytest.raises(InputError, match="WoehlerLine"):
            WoehlerLine(**values)
