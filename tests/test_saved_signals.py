"""`simulate(..., signals=...)`: only what was asked for is saved, with the same bits."""

import numpy as np
import pytest
from nine_bar_study.nine_bar.staggered.method import Staggered

import flexmb as fm
from flexmb.run.saving import SavedRows

STEEL = fm.Material(young=2.1e11, density=7800.0)


def crank():
    """A slider-crank with a flexible rod."""
    ends = (0.0, 0.0), (0.05, 0.0), (0.17, 0.0)
    wheel = fm.RigidLink("crank", ends[0], ends[1], mass=0.3, inertia=1e-4)
    square = fm.Rectangle(width=0.01, height=0.01)
    rod = fm.FlexibleLink("rod", ends[1], ends[2], section=square, material=STEEL, elements=2)
    slider = fm.RigidBody("slider", ends[2], mass=0.2, inertia=1e-4)
    joints = (
        fm.Revolute("A", fm.GROUND, wheel, ends[0]),
        fm.Revolute("B", wheel, rod, ends[1]),
        fm.Revolute("C", rod, slider, ends[2]),
        fm.Prismatic("D", fm.GROUND, slider, along=(1.0, 0.0)),
    )
    motor = fm.Drive("motor", joints[0], fm.ConstantSpeed(200.0))
    return fm.Mechanism("slider-crank", (wheel, rod, slider, *joints, motor), gravity=(0.0, -9.81))


RUN = {"t_end": 2e-3, "step": 1e-5}
WANTED = ["slider.x", "rod.end.*", "*.force", "energy.residual", "slider.x"]


@pytest.fixture(scope="module")
def full():
    return fm.simulate(crank(), save=37, **RUN)


@pytest.fixture(scope="module")
def few():
    return fm.simulate(crank(), save=37, signals=WANTED, **RUN)


def same(few, full):
    """Each signal of `few` has the bits and the peak that it has in `full`."""
    assert np.array_equal(few.time, full.time)
    for name in few.names:
        assert np.array_equal(few.array(name), full.array(name)), name
        assert few.peak(name) == full.peak(name)
        assert few.units(name) == full.units(name)


def test_the_signals_asked_for_have_the_same_bits(full, few):
    axes = ("x", "y", "theta", "vx", "vy", "omega", "ax", "ay", "alpha")
    forces = tuple(name for name in full.names if name.endswith(".force"))
    assert set(few.names) == {"slider.x", *(f"rod.node2.{axis}" for axis in axes), *forces, "energy.residual"}
    assert few.names == tuple(name for name in full.names if name in few.names)
    assert few.values.shape == (len(full.time), len(few.names))
    same(few, full)
    assert few["rod.end.x"].values[-1] == full["rod.end.x"].values[-1]
    assert few.status == full.status
    assert few.stats.steps == full.stats.steps


@pytest.mark.parametrize("options", [{"save": "steps"}, {"save": 3000}, {"save": 10, "method": fm.RungeKutta4()}])
def test_every_way_of_saving(options):
    mechanism = fm.mechanisms.slider_crank()
    run = {**RUN, **options}
    same(fm.simulate(mechanism, signals=["slider.*", "energy.*"], **run), fm.simulate(mechanism, **run))


def test_modes_of_contacts_with_play():
    run = {"t_end": 4e-3, "step": fm.Adaptive(rtol=1e-5), "save": 300}
    mechanism = fm.mechanisms.slider_crank(clearance=2e-4)
    contact = fm.simulate(mechanism, **run)
    same(fm.simulate(mechanism, signals=["*.mode", "*.penetration", "*.ex"], **run), contact)


@pytest.mark.slow
def test_a_rigid_model_with_elastic_shadow():
    run = {**RUN, "save": 7, "method": Staggered()}
    few = fm.simulate(crank(), signals=["rod.*"], **run)
    same(few, fm.simulate(crank(), **run))
    assert "rod.deflection" in few


def test_nothing_is_saved_but_the_final_state(full):
    none = fm.simulate(crank(), save=37, signals=[], **RUN)
    assert none.values.shape == (len(full.time), 0)
    assert none.ok
    assert "0 signals of 0 parts" in repr(none)


def test_a_restart_holds_the_whole_state(full, few):
    later = {"t_end": 3e-3, "step": 1e-5, "save": 11}
    one = fm.simulate(crank(), restart=few.restart, **later)
    other = fm.simulate(crank(), restart=full.restart, **later)
    assert np.array_equal(one.values, other.values)
    again = fm.simulate(crank(), restart=full.restart, signals=["crank.theta"], **later)
    same(again, other)


def test_a_file_keeps_them(tmp_path, few):
    read = fm.load(few.to_netcdf(tmp_path / "few.nc"))
    assert read.names == few.names
    assert np.array_equal(read.values, few.values)
    assert read.model["signals"] == WANTED
    assert set(few.dataset.data_vars) == set(few.names)


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        (["slidr.x"], "simulate 'slider-crank': no signal is called 'slidr.x'. Did you mean 'slider.x'?"),
        (["rod.end.z"], "no signal is called 'rod.end.z'. Did you mean 'rod.end"),
        (["slidr.*"], "no signal fits 'slidr.*'. Did you mean 'slider."),
        ("slider.x", "it must be a list of names"),
        ([3], "signals holds 3"),
        (7, "signals is 7"),
    ],
)
def test_unknown_names_are_refused(wanted, message):
    with pytest.raises(fm.errors.InputError) as caught:
        fm.simulate(crank(), signals=wanted, **RUN)
    assert message in str(caught.value)


def test_a_signal_that_was_not_saved_is_told_from_one_that_is_not_there(few):
    with pytest.raises(KeyError, match=r"has no signal 'crank.x'.*Saved were only those of simulate"):
        few["crank.x"]


def test_drawing_says_which_signals_are_missing(tmp_path, few):
    with pytest.raises(fm.errors.InputError, match=r"missing that were not saved: .*'crank\.\*'.*signals="):
        fm.write_vtk(few, tmp_path / "few.pvd")
    nodes = ["*.x", "*.y", "*.theta"]
    drawn = fm.simulate(crank(), save=3, signals=nodes, **RUN)
    assert fm.write_vtk(drawn, tmp_path / "drawn.pvd").is_file()


def test_momentum_needs_positions_and_velocities(few, full):
    with pytest.raises(fm.errors.InputError, match="positions and velocities were not saved"):
        fm.momentum(crank(), few)
    states = fm.simulate(crank(), save=37, signals=["*.x", "*.y", "*.theta", "*.vx", "*.vy", "*.omega"], **RUN)
    assert np.array_equal(fm.momentum(crank(), states).linear, fm.momentum(crank(), full).linear)


def test_rows_are_copied_once_and_grow():
    rows = SavedRows(3, np.array([0, 2, 4]))
    rows.add_one(0.0, np.arange(5.0))
    for k in range(1, 50):
        rows.add(np.array([float(k)]), np.full((1, 3), k))
    rows.replace_last(np.arange(5.0) + 9.0)
    assert rows.is_at(49.0, 1e-9)
    times, values = rows.finished()
    assert times.tolist() == [float(k) for k in range(50)]
    assert values[0].tolist() == [0.0, 2.0, 4.0]
    assert values[-1].tolist() == [9.0, 11.0, 13.0]
    assert not values.flags.writeable
    assert values.flags.owndata  # a solution takes it as it is
    rows.add_one(50.0, np.zeros(5))
    assert len(values) == 50


def test_brackets_are_no_patterns():
    with pytest.raises(fm.errors.InputError, match=r"no signal fits 'slider.\[xy\]\*'"):
        fm.simulate(crank(), signals=["slider.[xy]*"], **RUN)
