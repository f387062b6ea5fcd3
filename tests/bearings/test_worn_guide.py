"""Worn guides and slots: geometry, the dry limit, laws of wear, many turns, bad input."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import slow_where
from scipy.interpolate import BSpline

import flexmb as fm
from flexmb.kernels import GAP_SIZE
from flexmb.mechanisms import slider_crank
from flexmb.parts.joints.prismatic import corner_gap_kernel, slot_gap_kernel
from flexmb.parts.wear.worn_guide import worn_side_gap_kernel
from flexmb.places import GAP, NORMAL_X, NORMAL_Y

C, LENGTH, B, BINS = 5e-5, 0.3, 0.02, 360
LAWS = {"normal": fm.KelvinVoigt(3e8, 3e4), "friction": fm.ModifiedCoulomb(0.1, v0=1e-4, v1=1e-2)}
ARCHARD = fm.Archard(bearing=1e-13, width=B)
CRANK = slider_crank(speed=100.0)
GUIDE = fm.PrismaticClearance(
    "guide", fm.GROUND, CRANK["slider"], along=(1.0, 0.0), clearance=C, half_length=0.02, half_height=0.01, **LAWS
)
DRY = CRANK.with_part(GUIDE)
WORN = GUIDE.worn_by(ARCHARD, length=LENGTH)
PLACE = LENGTH * WORN.places
RANDOM = np.random.default_rng(7)
PROFILES = {
    "hollows": np.concatenate(
        [2e-5 * np.exp(-(((PLACE - 0.02) / 0.03) ** 2)), 3e-5 * np.exp(-(((PLACE + 0.02) / 0.03) ** 2))]
    ),
    "waves": 1e-5 * (1.0 + np.cos(np.tile(PLACE, 2) / 2e-3)),
    "ridges": 1e-5 * RANDOM.random(2 * BINS),
    "one place": 1e-4 * (np.arange(2 * BINS) == 200),
}


def yoke(joint=lambda one: one, **more):
    """A crank of 0.1 m whose pin runs in the upright slot of a slider."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.1, 0.0), 0.2, 1e-3)
    body = fm.RigidBody("yoke", (0.1, 0.0), 0.7, 1e-3)
    slot = fm.PinSlotClearance(
        "P", body, crank, at=(0.1, 0.0), along=(0.0, 1.0), clearance=C, pin_radius=8e-3, **{**LAWS, **more}
    )
    return fm.Mechanism(
        "scotch-yoke",
        [
            crank, body,
            fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
            fm.Prismatic("guide", fm.GROUND, body, along=(1.0, 0.0)),
            fm.Drive("motor", "O", fm.ConstantSpeed(50.0)),
            joint(slot),
        ],
    )  # fmt: skip


def in_slot(slot):
    return slot.worn_by(ARCHARD, length=LENGTH)


def rows(mechanism, **options):
    return fm.simulate(mechanism, save="steps", **options).require()


def contacts(mechanism, name):
    """Numbers of the gap kernels of a part."""
    return [one.p for one in mechanism[name].contributions(mechanism) if type(one).__name__ == "ContactContribution"]


def called(kernel, p, q, v):
    out = np.zeros(GAP_SIZE)
    kernel(np.array(p), np.asarray(q, dtype=float), v, out)
    return out


# Geometry


@pytest.mark.parametrize("kind", ["guide", "slot"])
def test_unworn_sides_give_the_numbers_of_the_dry_joint(kind):
    name, kernel = ("guide", corner_gap_kernel) if kind == "guide" else ("P", slot_gap_kernel)
    dry = DRY if kind == "guide" else yoke()
    worn = DRY.with_part(WORN) if kind == "guide" else yoke(in_slot)
    for p, w in zip(contacts(dry, name), contacts(worn, name), strict=True):
        for _ in range(100):
            q = np.array([0.1, 0.2, 0.7, 0.1, 0.2, 0.6]) + RANDOM.normal(size=6) * (0.01, 0.01, 0.1, 0.01, 0.01, 0.1)
            v = RANDOM.normal(size=6)
            before = called(kernel, p, q, v)
            assert called(worn_side_gap_kernel, w, q, v) == pytest.approx(before, rel=1e-11, abs=1e-13)


@pytest.mark.parametrize("kind", ["guide", "slot"])
def test_a_run_with_unworn_sides_is_that_of_the_dry_joint(kind):
    pair = (DRY, DRY.with_part(WORN)) if kind == "guide" else (yoke(), yoke(in_slot))
    names = ("slider.ax", "guide.upper_front.normal_force", "guide.mode") if kind == "guide" else ("yoke.ax", "P.ex")
    dry, worn = (rows(mech, periods=0.1) for mech in pair)
    for name in names:
        assert worn.array(name) == pytest.approx(dry.array(name), abs=1e-8 * abs(dry.array(name)).max())


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", ["hollows", "waves", "ridges"])
def test_depth_of_a_corner_is_its_distance_from_the_border_of_the_free_places(name):
    """Beside the nearest of many points of a B-spline of scipy."""
    mech = DRY.with_part(WORN.with_depths(PROFILES[name]))
    p, h = contacts(mech, "guide")[0], PROFILES[name][:BINS]
    step = LENGTH / BINS
    knots = step * (np.arange(BINS + 12) - 4.5 - BINS / 2)
    spline = BSpline(knots, np.concatenate([np.zeros(3), h, np.zeros(5)]), 3)
    for _ in range(20):
        x, y = RANDOM.uniform(-0.12, 0.12), RANDOM.uniform(-1e-5, 3e-5)
        q = [0.0, 0.0, 0.0, x - p[8] + p[6], y + C + 0.01 - p[9] + p[7], 0.0]
        out = called(worn_side_gap_kernel, p, q, np.zeros(6))
        near = x + np.linspace(-3e-5, 3e-5, 200001)
        distance = np.hypot(near - x, spline(near) - y)
        k = int(distance.argmin())
        assert abs(out[GAP]) == pytest.approx(distance[k], abs=1e-12)
        assert np.sign(-out[GAP]) == np.sign(y - spline(x))
        slope = spline(near[k], 1)
        assert out[NORMAL_X : NORMAL_Y + 1] == pytest.approx(np.array([-slope, 1.0]) / math.hypot(1.0, slope), abs=1e-6)


@pytest.mark.parametrize("name", PROFILES)
def test_a_pin_at_its_border_touches_the_side_and_never_cuts_it(name):
    joint = yoke(in_slot)["P"].with_depths(PROFILES[name])
    step, radius = LENGTH / BINS, joint.pin_radius
    for reached, h in zip(joint.sides, joint.depths.reshape(2, BINS), strict=True):
        padded = np.concatenate([np.zeros(20), h, np.zeros(20)])
        for i in range(BINS):
            away = step * (np.arange(len(padded)) - 20 - i)
            near = np.abs(away) < radius
            free = padded[near] + radius - np.sqrt(radius**2 - away[near] ** 2) - reached[i]
            assert free.min() == pytest.approx(0.0, abs=1e-17)


@pytest.mark.usefixtures("states")
@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.parametrize("kind", slow_where(lambda n: n != "ridges", ["guide", "slot"]))
def test_tangents_of_worn_sides(name, kind):
    mech = DRY.with_part(WORN.with_depths(PROFILES[name]))
    if kind == "slot":
        mech = yoke(lambda slot: in_slot(slot).with_depths(PROFILES[name]))
    fm.testing.check_part(mech, "guide" if kind == "guide" else "P")


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", PROFILES)
def test_runs_with_any_profile_reach_their_end(name):
    for mech in (
        DRY.with_part(WORN.with_depths(PROFILES[name])),
        yoke(lambda slot: in_slot(slot).with_depths(PROFILES[name])),
    ):
        sol = fm.simulate(mech, periods=1)
        assert sol.ok, sol.status
        assert abs(float(sol["energy.residual"][-1])) < 1e-3 * float(sol["energy.turned_over"][-1])


def test_a_slider_in_a_hollow_guide_goes_deeper():
    """Both lower sides are worn all along: the slider rests deeper by that depth."""
    body = fm.RigidBody("slider", (0.0, 0.0), 1.0, 1e-3)
    joint = replace(GUIDE, second=body).worn_by(ARCHARD, length=LENGTH)
    places = []
    for depth in (0.0, 2e-5):
        worn = joint.with_depths(np.concatenate([np.zeros(BINS), np.full(BINS, depth)]))
        sol = fm.simulate(fm.Mechanism("rest", [body, worn], gravity=(0.0, -9.81)), t_end=0.5, save=10)
        places.append(float(sol.array("guide.offset")[-1]))
        assert sol.array("guide.mode")[-1] == 3.0
    assert places[0] - places[1] == pytest.approx(2e-5, abs=1e-10)


# Laws of wear


def test_a_pressed_slider_wears_its_guide_by_force_over_width():
    """Every place loses k N/b altogether, when both corners have passed it, whatever the width of the contact."""
    body = fm.RigidBody("slider", (0.0, 0.0), 1.0, 1e-3, velocity=(1.0, 0.0, 0.0))
    joint = fm.PrismaticClearance(
        "guide", fm.GROUND, body, along=(1.0, 0.0), clearance=C, half_length=0.02, half_height=0.01,
        normal=LAWS["normal"],
    ).worn_by(ARCHARD, length=0.8)  # fmt: skip
    load = fm.Force("load", body, at=(0.0, 0.0), force=(0.0, -200.0))
    sol = rows(fm.Mechanism("slide", [body, joint, load]), t_end=0.3, save_from=0.1)
    wear = joint.worn_in(sol)
    upper, lower = wear.depths.reshape(2, -1)
    passed = (joint.places * 0.8 > 0.13) & (joint.places * 0.8 < 0.27)
    assert not upper.any()
    assert passed.sum() > 50
    assert lower[passed] == pytest.approx(1e-13 * 200.0 / B, rel=2e-3)
    assert wear.volume == pytest.approx(1e-13 * 200.0 * 0.2, rel=1e-4)
    assert wear.work == 0.0


@pytest.mark.parametrize("name", ["new", "hollows"])
@pytest.mark.parametrize("kind", ["guide", "slot"])
def test_worn_volume_goes_with_force_times_path_and_with_the_friction_work_of_the_balance(kind, name):
    depths = np.zeros(2 * BINS) if name == "new" else PROFILES[name]
    mech = DRY.with_part(WORN) if kind == "guide" else yoke(in_slot)
    joint = mech["guide" if kind == "guide" else "P"].with_depths(depths)
    sol = rows(mech.with_part(joint), periods=0.5, step=1e-5)
    wear, work = joint.worn_in(sol), float(sol["energy.dissipated_friction"][-1])
    path = sum(
        np.trapezoid(sol.array(f"{joint.name}.{c}normal_force") * abs(sol.array(f"{joint.name}.{c}slip")), sol.time)
        for c in joint.contacts
    )
    assert wear.volume == pytest.approx(1e-13 * path, rel=1e-12)
    assert wear.depths.sum() * LENGTH / BINS * B == pytest.approx(wear.volume, rel=1e-12)
    assert wear.work == pytest.approx(work, rel=2e-3)
    by_work = replace(joint, wear=fm.EnergyWear(bearing=1e-12, width=B)).worn_in(sol)
    assert by_work.volume == pytest.approx(1e-12 * work, rel=2e-3)


@pytest.mark.parametrize("kind", ["guide", "slot"])
def test_mirrored_motions_wear_the_other_side(kind):
    found = []
    for sign in (1.0, -1.0):
        mech = DRY if kind == "guide" else yoke()
        name = "guide" if kind == "guide" else "P"
        mech = mech.with_part(mech[name].worn_by(ARCHARD, length=LENGTH)).with_({"motor.motion.speed": 50.0 * sign})
        found.append(mech[name].worn_in(rows(mech, periods=0.2, step=2e-5)).depths.reshape(2, BINS))
    mirrored = found[1][::-1] if kind == "guide" else found[1][:, ::-1]
    assert mirrored == pytest.approx(found[0], abs=1e-4 * found[0].max())


# Many turns


@pytest.fixture(scope="module")
def life():
    return fm.wear_out(DRY.with_part(WORN), turns=2000.0, keep=2)


@pytest.mark.slow
def test_rows_and_picture_of_a_life(life, tmp_path):
    upper, lower = life["guide.upper_profile"], life["guide.lower_profile"]
    assert upper.dims == ("turns", "place")
    assert life["place"].values == pytest.approx((np.arange(BINS) + 0.5) / BINS - 0.5)
    volume = (upper.values.sum(axis=1) + lower.values.sum(axis=1)) * LENGTH / BINS * B
    assert life["guide.volume"].values == pytest.approx(volume, rel=1e-12)
    assert (np.diff(life["guide.clearance"].values) > 0.0).all()
    figure = fm.plot_wear(life, "guide")
    sides = figure.axes[0]
    assert len(sides.lines) == 6
    assert sides.lines[-1].get_ydata() == pytest.approx(-lower.values[-1])
    assert sides.lines[2].get_xdata() == pytest.approx(PLACE)
    figure.savefig(tmp_path / "wear.png")


@pytest.mark.slow
def test_a_narrow_pit_is_named_and_its_depth_goes_with_the_number_of_places(life, tmp_path):
    finer = fm.wear_out(DRY.with_part(WORN.worn_by(replace(ARCHARD, bins=720))), turns=2000.0, keep=2)
    (note,) = life.attrs["notes"]
    depths = [float(one["guide.lower_profile"][-1].max()) for one in (life, finer)]
    assert f"guide: the deepest pit of its lower, {depths[0]:.3g} m, is" in note
    assert "of 360 places wide" in note
    figure = fm.plot_wear(life, "guide")
    assert "Give more bins" in figure.get_supxlabel()
    figure.savefig(tmp_path / "wear.png")
    print(depths, float(finer["guide.volume"][-1]), float(life["guide.volume"][-1]))
    assert depths[1] > 1.2 * depths[0]
    assert float(finer["guide.volume"][-1]) == pytest.approx(float(life["guide.volume"][-1]), rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(("turns", "depth"), [(3e4, 0.15), pytest.param(1e5, 0.5, marks=pytest.mark.slow)])
def test_half_the_error_gives_the_same_life(turns, depth):
    """Up to a depth of a part of the clearance."""
    life, finer = (
        fm.wear_out(DRY.with_part(WORN), turns=turns, keep=1, tolerance=tolerance) for tolerance in (0.02, 0.01)
    )
    assert int(finer["runs"][-1]) > int(life["runs"][-1])
    assert float(life["guide.lower_profile"][-1].max()) > depth * C
    assert float(finer["guide.volume"][-1]) == pytest.approx(float(life["guide.volume"][-1]), rel=0.02)
    for side in ("upper", "lower"):
        apart = float(abs(finer[f"guide.{side}_profile"] - life[f"guide.{side}_profile"]).max())
        assert apart < float(life["guide.error"][-1] + finer["guide.error"][-1])


@pytest.mark.slow
def test_a_guide_and_a_bearing_wear_at_once_and_go_on_from_a_store(tmp_path):
    loose = slider_crank(speed=100.0, clearance=C)
    mech = loose.with_part(loose["B"].worn_by(ARCHARD)).with_part(replace(WORN, second=loose["slider"]))
    few = {"turns": 20.0, "keep": 2}
    whole = fm.wear_out(mech, **few, store=tmp_path / "life.zarr")
    assert fm.wear_out(mech, **few, store=tmp_path / "life.zarr", resume=True).identical(whole)
    assert whole["B.bearing_profile"].dims == ("turns", "angle")
    for name in ("B", "guide"):
        assert float(whole[f"{name}.volume"][-1]) > 0.0
        assert fm.plot_wear(whole, name)


def test_a_slot_wears_on_both_sides():
    life = fm.wear_out(yoke(in_slot), turns=200.0, keep=1)
    assert (life["P.upper_profile"].values[-1].max(), life["P.lower_profile"].values[-1].max()) > (1e-9, 1e-9)


# Bad input

SLOT = yoke()["P"]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: GUIDE.worn_by(fm.Archard(journal=1e-13, width=B), length=0.3), "coefficient of the journal"),
        (lambda: GUIDE.worn_by(fm.Archard(bearing=1e-13), length=0.3), "has no width"),
        (lambda: GUIDE.worn_by(ARCHARD, length=0.0), "worn_length is 0 m"),
        (lambda: GUIDE.worn_by(0.1, length=0.3), "law of wear"),
        (lambda: replace(SLOT, length=0.2).worn_by(ARCHARD, length=0.3), "round ends.*Stop"),
        (lambda: WORN.with_depths(np.zeros(BINS)), "profile has 360 depths.*Give 720"),
        (lambda: GUIDE.worn_by(replace(ARCHARD, foundation=1e13), length=0.3), "foundation.*at one place"),
        (lambda: WORN.worn_in(None), "sol is NoneType"),
        (lambda: WORN.with_depths(None), "depths is None"),
        (lambda: WORN.with_depths([0.0, "deep"]), r"depths\[1\] is 'deep'"),
        (lambda: WORN.with_depths(np.full(2 * BINS, np.nan)), r"depths\[0\] is nan"),
        (lambda: WORN.with_depths(np.full(2 * BINS, 0.02)), "below the half_height"),
        (lambda: WORN.with_depths(PROFILES["hollows"]).worn_by(ARCHARD, length=0.2), "depths are those of a length"),
        (lambda: WORN.worn_in(fm.simulate(DRY.with_part(WORN), periods=0.1, save=1e-4)), "save='steps'"),
        (
            lambda: replace(WORN, worn_length=0.05).worn_in(
                rows(DRY.with_part(replace(WORN, worn_length=0.05)), periods=0.5)
            ),
            "rubs from .* Give worn_by",
        ),
        (
            lambda: replace(GUIDE, friction=fm.friction.Frictionless()).worn_by(
                fm.EnergyWear(bearing=1e-13, width=B), length=0.3
            ),
            "the joint has none",
        ),
    ],
)  # fmt: skip
def test_bad_input_is_refused_with_what_to_do(make, words):
    with pytest.raises(fm.errors.InputError, match=words):
        make()


def test_a_worn_guide_takes_another_law_and_an_unworn_one_another_length():
    law = fm.EnergyWear(bearing=1e-12, width=B)
    worn = WORN.with_depths(PROFILES["hollows"])
    assert worn.worn_by(law).profile == worn.profile
    assert WORN.worn_by(law, length=0.4).worn_length == 0.4
