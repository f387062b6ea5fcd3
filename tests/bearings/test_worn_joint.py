"""Worn joints: geometry, the dry limit, laws of wear, many turns, robustness, bad input."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import slow_where
from scipy.optimize import brentq

import flexmb as fm
from flexmb.dynamics.sweeps import wear as study
from flexmb.kernels import GAP_SIZE
from flexmb.mechanisms import slider_crank
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.joints.revolute import journal_gap_kernel
from flexmb.parts.wear.worn_clearance import settled, shares, surface, worn_gap_kernel
from flexmb.places import ARM1_X, ARM2_X, ARM2_Y, GAP, NORMAL_X

C, R, B, W = 5e-5, 0.01, 0.02, 100.0  # clearance, radius, width, load
DRY = slider_crank(speed=2.0 * math.pi * 1000 / 60, clearance=C, friction="coulomb")
ARCHARD = fm.Archard(bearing=1e-13, width=B)
WORN = DRY["B"].worn_by(ARCHARD)
ANGLE = 2.0 * math.pi * np.arange(360) / 360
GROOVE = np.maximum(9e-5 * np.cos(ANGLE - 1.0) - C, 0.0)  # as a journal leaves it that went 40 um into the bearing
RANDOM = np.random.default_rng(4)
PROFILES = {
    "groove": GROOVE,
    "deep": 10.0 * GROOVE,
    "all round": np.full(360, 3e-5),
    "three waves": 1e-5 * (1.0 + np.cos(3.0 * ANGLE)),
    "ridges": 1e-5 * RANDOM.random(360),
    "one bin": 1e-4 * (np.arange(360) == 20),
}


def rows(mechanism, **options):
    return fm.simulate(mechanism, save="steps", **options).require()


def states(n):
    for _ in range(n):
        size = RANDOM.uniform(0.1, 1.4) * C
        angle = RANDOM.uniform(-3.2, 3.2)
        q = np.array([0.1, 0.2, 0.7, 0.1, 0.2, -0.4]) + size * np.array([0, 0, 0, math.cos(angle), math.sin(angle), 0])
        yield q, RANDOM.normal(size=6)


# Geometry


@pytest.mark.parametrize("law", [ARCHARD, fm.Archard(journal=1e-13, width=B)], ids=["bearing", "journal"])
def test_unworn_surfaces_give_the_numbers_of_the_dry_joint(law):
    numbers = np.array(DRY["B"].worn_by(law).numbers((0.0, 0.0), (0.0, 0.0)))
    for q, v in states(200):
        dry, worn = np.zeros(GAP_SIZE), np.zeros(GAP_SIZE)
        journal_gap_kernel(np.array([C, R, 0.0, 0.0, 0.0, 0.0]), q, v, dry)
        worn_gap_kernel(numbers, q, v, worn)
        assert worn == pytest.approx(dry, rel=1e-11, abs=1e-14 * max(1.0, abs(dry).max()))


def test_a_run_with_unworn_surfaces_is_that_of_the_dry_joint():
    dry, worn = (rows(mech, periods=0.3) for mech in (DRY, DRY.with_part(WORN)))
    for name in ("slider.ax", "B.normal_force", "B.ex", "crank.theta"):
        assert worn.array(name) == pytest.approx(dry.array(name), abs=1e-8 * abs(dry.array(name)).max())


@pytest.mark.parametrize("name", PROFILES)
def test_depth_is_the_distance_from_all_places_that_the_surface_leaves_free(name):
    """Beside a quadratic program in two unknowns, whose constraints are the surface at each angle."""
    from scipy.optimize import minimize

    h, numbers = PROFILES[name], np.array(WORN.with_depths(PROFILES[name]).numbers((0.0, 0.0), (0.0, 0.0)))
    u = np.stack([np.cos(ANGLE), np.sin(ANGLE)], axis=1)
    blur = (ANGLE[1] ** 2 / 6.0) * surface(C, h).radius.max()  # an edge is rounded over two angles
    for angle in np.linspace(0.1, 6.2, 12):
        size = max(h.max(), C)
        e = (C + h.max() + 0.3 * size) * np.array([math.cos(angle), math.sin(angle)]) / size
        wall = {"type": "ineq", "fun": lambda x, size=size: (C + h) / size - u @ x, "jac": lambda _: -u}
        near = minimize(
            lambda x, e=e: ((x - e) @ (x - e), 2.0 * (x - e)), 0.0 * e, jac=True, constraints=wall, tol=1e-14
        )
        out = np.zeros(GAP_SIZE)
        worn_gap_kernel(numbers, np.array([0.0, 0.0, 0.0, *(size * e), 0.0]), np.zeros(6), out)
        distance = size * math.sqrt(near.fun)
        assert -out[GAP] == pytest.approx(distance, abs=1.01 * blur + 1e-7 * size)
        assert out[NORMAL_X : NORMAL_X + 2] == pytest.approx(size * (e - near.x) / distance, abs=0.02)


def test_free_places_are_convex_and_inside_the_surface():
    for h in PROFILES.values():
        found = surface(C, h)
        assert (found.radius >= 0.0).all()
        assert (found.wall >= found.support - 1e-18).all() or (found.wall <= C + h + 1e-18).all()
        assert (found.wall <= C + h + 1e-18).all()


def test_an_error_of_a_smooth_profile_falls_with_the_square_of_the_bins():
    errors = []
    for bins in (90, 180, 360):
        angle = 2.0 * math.pi * np.arange(bins) / bins
        smooth = surface(C, 1e-5 * (1.0 + np.cos(2.0 * angle)))
        errors.append(abs(smooth.support - C - 1e-5 * (1.0 + np.cos(2.0 * angle))).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.02)


def test_friction_of_a_half_bearing_that_fits_has_four_over_pi_of_the_arm():
    """The friction circle of a pressure that goes with the cosine."""
    fits = np.where(np.cos(ANGLE) > 0.0, 1e-4 * np.cos(ANGLE), 0.0)
    sharp = surface(C, fits)
    assert sharp.support[0] > C
    numbers = np.array(WORN.with_depths(np.maximum(1e-2 * np.cos(ANGLE) - C, 0.0)).numbers((0.0, 0.0), (0.0, 0.0)))
    out = np.zeros(GAP_SIZE)
    seat = 1e-2 * math.sin(math.radians(1.0)) / math.radians(1.0)  # of the smoothed corner
    worn_gap_kernel(numbers, np.array([0.0, 0.0, 0.0, seat + 1e-6, 0.0, 0.0]), np.zeros(6), out)
    arm = math.hypot(out[ARM2_X], out[ARM2_Y]) / (R - C)
    assert arm == pytest.approx(4.0 / math.pi, rel=5e-3)


@pytest.mark.quick(1)
@pytest.mark.usefixtures("states")
@pytest.mark.parametrize("name", slow_where(lambda n: n not in ("ridges", "one bin"), PROFILES))
@pytest.mark.parametrize("surface_that_wears", ["bearing", "journal"])
def test_tangents_of_worn_contacts(name, surface_that_wears):
    joint = DRY["B"].worn_by(fm.Archard(**{surface_that_wears: 1e-13})).with_depths(PROFILES[name])
    fm.testing.check_part(DRY.with_part(joint), "B")


# Laws of wear


def steady(bins, depth, share=0.5, path=100.0, k=1e-12):
    """Depths of a bearing under a constant load along X while a shaft turns; `depth` [m] of the contact."""
    h, s = np.zeros(bins), 0.0
    while s < path:
        now = surface(C, h)
        seat = np.array([now.support[0], now.slope[0]])
        place = seat + np.array([depth, 0.0])
        spread = shares(now, place[:1], place[1:], np.zeros(1))[0]
        rate = k * W * spread / (spread @ now.cos) / (B * R * 2.0 * math.pi / bins)
        step = min(share * depth / rate.max(), path - s)
        h, s = h + rate * step, s + step
    return h, surface(C, h).support[0]


def test_wear_of_stiff_surfaces_follows_the_rigid_law():
    """de/ds = k W/(b R (a + sin a cos a)), cos a = c/e, in closed form."""
    errors = {}
    for bins in (360, 720):
        h, e = steady(bins, 1e-7)
        errors[bins] = e / (C + 4.22194e-5) - 1.0
        assert math.degrees(math.acos(C / e)) == pytest.approx(57.16749, abs=6e-3 * 360 / bins)
        assert R * 2.0 * math.pi / bins * h.sum() == pytest.approx(5.52004e-7, rel=1e-5)
    assert abs(errors[720]) < 5e-5
    assert abs(errors[720]) < 0.5 * abs(errors[360])
    soft = [abs(steady(720, depth)[1] - C - 4.22194e-5) for depth in (4e-6, 1e-6)]
    assert soft[1] < soft[0]


@pytest.mark.parametrize("depths", [np.zeros(360), GROOVE], ids=["new", "worn"])
def test_worn_volume_is_the_coefficient_times_force_times_path(depths):
    joint = WORN.with_depths(depths)
    sol = rows(DRY.with_part(joint), periods=1)
    wear = joint.worn_in(sol)
    path = np.trapezoid(sol.array("B.normal_force") * abs(sol.array("B.slip")), sol.time)
    assert wear.volume == pytest.approx(1e-13 * path, rel=1e-12)
    assert wear.depths.sum() * 2.0 * math.pi / 360 * R * B == pytest.approx(wear.volume, rel=1e-12)


@pytest.mark.parametrize("depths", [np.zeros(360), GROOVE], ids=["new", "worn"])
def test_worn_volume_goes_with_the_friction_work_of_the_balance(depths):
    law = fm.EnergyWear(bearing=1e-12, width=B)
    joint = replace(WORN.with_depths(depths), wear=law)
    errors = []
    for step in (5e-6, 1.25e-6):
        sol = rows(DRY.with_part(joint), periods=0.05, step=step)
        work = float(sol["energy.dissipated_friction"][-1])
        errors.append(joint.worn_in(sol).volume / (1e-12 * work) - 1.0)
    assert abs(errors[1]) < 2e-3
    assert abs(errors[1]) < abs(errors[0])


def test_steps_of_order_eight_wear_as_many_small_ones_do():
    """Six steps of an impact: by the trapezoidal rule 1.4 % of the volume were missing."""
    mechanism, step = DRY.with_part(WORN), fm.Adaptive(rtol=1e-5)
    many, few = (rows(mechanism, t_end=0.004, method=m, step=step) for m in (fm.RadauIIA(), fm.DormandPrince()))
    assert WORN.worn_in(few).volume == pytest.approx(WORN.worn_in(many).volume, rel=1e-3)


def test_friction_wears_as_pressure_does_beyond_its_slow_slips():
    sol = rows(DRY.with_part(WORN), periods=1)
    by_work = replace(WORN, wear=fm.EnergyWear(bearing=1e-13, width=B)).worn_in(sol)
    assert by_work.volume / 0.03 == pytest.approx(WORN.worn_in(sol).volume, rel=1e-3)


def test_mirrored_motions_wear_mirrored_surfaces():
    found = []
    for sign in (1.0, -1.0):
        mech = slider_crank(speed=sign * 100.0, clearance=C, friction="coulomb")
        sol = rows(
            mech.with_part(WORN.with_depths(GROOVE if sign > 0 else np.roll(GROOVE[::-1], 1))), periods=0.2, step=1e-5
        )
        found.append(WORN.with_depths(GROOVE if sign > 0 else np.roll(GROOVE[::-1], 1)).worn_in(sol))
    assert found[1].volume == pytest.approx(found[0].volume, rel=1e-7)
    assert np.roll(found[1].depths[::-1], 1) == pytest.approx(found[0].depths, abs=1e-6 * found[0].depths.max())


def test_narrow_contacts_wear_the_two_angles_beside_them():
    flat = surface(C, np.zeros(360))
    place = C + 1e-12
    spread = shares(flat, np.array([place * math.cos(0.3)]), np.array([place * math.sin(0.3)]), np.array([0.3]))[0]
    assert np.flatnonzero(spread).tolist() == [17, 18]
    assert spread.sum() == pytest.approx(1.0)
    assert spread @ ANGLE == pytest.approx(0.3)


@pytest.mark.parametrize("depth", [1e-8, 1e-6, 2e-5])
def test_a_foundation_carries_the_force_as_a_layer_on_a_round_ground_does(depth):
    """Unworn: N = K b R (e (a + sin a cos a) - 2 c sin a), cos a = c/e, with the pressure K (e cos phi - c)."""
    fine = surface(C, np.zeros(7200))
    e, angle = C + depth, 0.3
    a = math.acos(C / e)
    force = (e * (a + math.sin(a) * math.cos(a)) - 2.0 * C * math.sin(a)) * 7200 / (2.0 * math.pi)
    x, y = settled(fine, *(np.array([part]) for part in (0.9 * C * math.cos(angle), 0.9 * C * math.sin(angle), angle,
                                                         -0.1 * C, force)))  # fmt: skip
    assert math.hypot(x[0], y[0]) - C == pytest.approx(depth, rel=1e-3)
    assert math.atan2(y[0], x[0]) == pytest.approx(angle, abs=1e-12)
    spread = shares(fine, x, y, np.array([angle]))[0]
    expected = np.maximum(e * np.cos(2.0 * math.pi * np.arange(7200) / 7200 - angle) - C, 0.0)
    assert spread == pytest.approx(expected / expected.sum(), abs=2e-3 * spread.max())


@pytest.mark.slow
def test_a_stiffer_foundation_comes_nearer_to_the_rigid_law():
    """Shape of a groove beside that of the same volume, max(0, e cos phi - c), on a contact that is far softer."""
    mech = shaft(fm.KelvinVoigt(1e7, 3e3))
    joint, apart = mech["J"], []
    for foundation in (None, 1e10, 1e11, 1e12):
        law = replace(joint.wear, foundation=foundation)
        life = fm.wear_out(mech.with_part(joint.worn_by(law)), turns=200.0, keep=1)
        profile = life["J.bearing_profile"].values[-1]
        middle = math.atan2(profile @ np.sin(ANGLE), profile @ np.cos(ANGLE))
        rigid = lambda e: np.maximum(e * np.cos(ANGLE - middle) - C, 0.0)  # noqa: B023, E731 - called at once
        e = brentq(lambda e: rigid(e).sum() - profile.sum(), C, 3.0 * C)  # noqa: B023
        apart.append(abs(profile - rigid(e)).max() / profile.max())
    soft, *own = apart
    assert own == sorted(own, reverse=True)
    assert own[-1] < 0.02
    assert soft > 0.2


# Many turns


def shaft(law=fm.KelvinVoigt(3e8, 1e4)):
    """A shaft in a bearing that hangs on it with a constant load; the shaft turns, the bearing does not."""
    rotor = fm.RigidBody("shaft", at=(0.0, 0.0), mass=1.0, inertia=1e-3)
    shell = fm.RigidBody("shell", at=(0.0, 0.0), mass=0.1, inertia=1e-4)
    joint = fm.RevoluteClearance(
        "J", shell, rotor, at=(0.0, 0.0), clearance=C, bearing_radius=R,
        normal=law, start=(0.999 * C, 0.0),
    ).worn_by(fm.Archard(bearing=1e-12, width=B))  # fmt: skip
    return fm.Mechanism(
        "shaft",
        [
            rotor, shell, joint,
            fm.Revolute("O", fm.GROUND, rotor, at=(0.0, 0.0)),
            fm.Drive("motor", "O", fm.ConstantSpeed(200.0)),
            fm.Force("load", shell, at=(0.0, 0.0), force=(-W, 0.0)),
        ],
    )  # fmt: skip


@pytest.mark.slow
def test_a_shaft_under_load_wears_its_bearing_by_the_rigid_law():
    turn = 2.0 * math.pi * (R - C)  # path of the shaft's surface
    life = fm.wear_out(shaft(), turns=100.0 / turn, keep=2)
    assert life.attrs["joints"] == ["J"]
    assert float(life["J.volume"][-1]) == pytest.approx(5.52004e-7 * B, rel=2e-3)
    assert float(life["J.bearing_profile"][-1].max()) == pytest.approx(4.22194e-5, rel=1e-2)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A life and its store."""
    store = tmp_path_factory.mktemp("life") / "whole.zarr"
    return fm.wear_out(DRY.with_part(WORN), turns=2000.0, keep=4, store=store), store


@pytest.fixture(scope="module")
def life(stored):
    return stored[0]


@pytest.mark.slow
def test_rows_of_a_life(life):
    profile, volume = life["B.bearing_profile"].values, life["B.volume"].values
    assert profile.shape == (5, 360)
    assert life["turns"].values.tolist() == [0.0, 500.0, 1000.0, 1500.0, 2000.0]
    assert (np.diff(profile, axis=0) >= 0.0).all()
    assert not life["B.journal_profile"].values.any()
    assert volume == pytest.approx(profile.sum(axis=1) * 2.0 * math.pi / 360 * R * B, rel=1e-12)
    assert (np.diff(life["B.clearance"].values) > 0.0).all()
    assert (life["B.peak_force"].values > 0.0).all()


@pytest.mark.slow
def test_half_the_error_gives_the_same_life(life):
    finer = fm.wear_out(DRY.with_part(WORN), turns=2000.0, keep=4, tolerance=0.01)
    assert int(finer["runs"][-1]) > int(life["runs"][-1])
    assert float(finer["B.volume"][-1]) == pytest.approx(float(life["B.volume"][-1]), rel=0.02)
    apart = abs(finer["B.bearing_profile"] - life["B.bearing_profile"]).max()
    assert float(apart) < float(life["B.error"][-1] + finer["B.error"][-1])


def files(folder):
    return {path.relative_to(folder): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


@pytest.mark.slow
def test_a_life_that_was_interrupted_goes_on_to_the_same_bits(stored, tmp_path, monkeypatch):
    life, whole = stored
    mech, rate, left = DRY.with_part(WORN), study.Turns.rate, [14]

    def stops(self, depths):
        left[0] -= 1
        if left[0] < 0:
            raise KeyboardInterrupt
        return rate(self, depths)

    store = tmp_path / "life.zarr"
    monkeypatch.setattr(study.Turns, "rate", stops)
    with pytest.raises(KeyboardInterrupt):
        fm.wear_out(mech, turns=2000.0, keep=4, store=store)
    monkeypatch.undo()
    assert 0 < int((fm.sweeps.load_sweep(store)["status"] == "done").sum()) < 5
    again = fm.wear_out(mech, turns=2000.0, keep=4, store=store, resume=True)
    assert again.identical(life)
    assert files(store) == files(whole)
    assert fm.sweeps.load_sweep(store).identical(life)


@pytest.mark.slow
def test_a_store_of_another_study_is_refused(tmp_path):
    few = {"turns": 10.0, "keep": 1, "store": tmp_path / "a.zarr"}
    fm.wear_out(DRY.with_part(WORN), **few)
    with pytest.raises(fm.errors.InputError, match="another sweep"):
        fm.wear_out(DRY.with_part(WORN.with_depths(GROOVE)), resume=True, **few)
    alone = fm.wear_out(DRY.with_part(WORN), turns=10.0, keep=1)
    assert alone.identical(fm.sweeps.load_sweep(few["store"]))


@pytest.mark.slow
def test_a_study_of_too_many_runs_is_refused_and_one_that_takes_more_stops():
    strong = DRY.with_part(WORN.worn_by(fm.Archard(bearing=1e-10, width=B)))
    with pytest.raises(
        fm.errors.InputError, match=r"of the clearance of B, .*: 1e\+06 turns take at least \d+ runs of"
    ):
        fm.wear_out(strong, turns=1e6)
    with pytest.raises(fm.errors.InputError, match=r"within a run surfaces stay as they are.*coefficient"):
        fm.wear_out(DRY.with_part(WORN.worn_by(fm.Archard(bearing=1e-9, width=1e-5))), turns=10.0)
    life = fm.wear_out(DRY.with_part(WORN), turns=2000.0, keep=2, most_runs=6)
    assert "took 6 runs (most_runs)" in " ".join(life["status"].values.tolist())
    assert life["ok"].values.tolist() == [True, False, False]


def test_a_run_that_fails_ends_the_study_with_its_status():
    life = fm.wear_out(DRY.with_part(WORN), turns=1e4, keep=3, step=2e-3)
    assert life["ok"].values.tolist() == [False] * 4
    assert "t =" in str(life["status"][0].values)
    assert np.isnan(life["B.volume"].values).all()


def test_what_is_refused_in_the_middle_of_a_study_is_a_status(monkeypatch):
    """A depth or a contact that is no longer admissible after some turns; at the first one it is an error."""
    rate, calls = study.Turns.rate, []

    def limited(turns, depths):
        calls.append(depths)
        if len(calls) in limit:
            raise fm.errors.InputError("B: the contact lies outside of the known places.")
        return rate(turns, depths)

    monkeypatch.setattr(study.Turns, "rate", limited)
    limit = range(4, 99)
    life = fm.wear_out(DRY.with_part(WORN), turns=2000.0, keep=4)
    assert life["ok"].values[0]
    assert not life["ok"].values[-1]
    assert "outside of the known places" in " ".join(life["status"].values.tolist())
    limit = range(len(calls) + 1, 99)
    with pytest.raises(fm.errors.InputError, match="outside of the known places"):
        fm.wear_out(DRY.with_part(WORN), turns=2000.0, keep=4)


def test_the_journal_wears_as_well():
    joint = DRY["B"].worn_by(fm.Archard(journal=1e-13, width=B))
    life = fm.wear_out(DRY.with_part(joint), turns=500.0, keep=1)
    depths = life["B.journal_profile"].values[-1]
    assert float(life["B.volume"][-1]) == pytest.approx(depths.sum() * 2.0 * math.pi / 360 * (R - C) * B, rel=1e-12)
    assert not life["B.bearing_profile"].values.any()


@pytest.mark.slow
def test_two_joints_wear_at_once_and_one_that_does_not_wear_stays():
    crank_pin = fm.RevoluteClearance(
        "A", DRY["crank"], DRY["rod"], at=DRY["A"].at, clearance=C, bearing_radius=R, normal=DRY["B"].normal
    )
    both = DRY.with_part(crank_pin.worn_by(fm.Archard(bearing=1e-13, width=B))).with_part(WORN)
    life = fm.wear_out(both, turns=200.0, keep=1)
    assert list(life.attrs["joints"]) == ["A", "B"]
    for name in "AB":
        assert float(life[f"{name}.volume"][-1]) > 0.0
    assert not np.array_equal(life["A.bearing_profile"], life["B.bearing_profile"])
    alone = fm.wear_out(DRY.with_part(crank_pin).with_part(WORN), turns=200.0, keep=1)
    assert alone.attrs["joints"] == ["B"]
    coarse = both.with_part(DRY["B"].worn_by(fm.Archard(bearing=1e-13, bins=180)))
    with pytest.raises(fm.errors.InputError, match=r"different numbers of bins \(A 360, B 180\)"):
        fm.wear_out(coarse, turns=1.0)


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", PROFILES)
def test_runs_with_any_profile_reach_their_end(name):
    sol = fm.simulate(DRY.with_part(WORN.with_depths(PROFILES[name])), periods=2)
    assert sol.ok, sol.status
    turned = float(sol["energy.turned_over"][-1])
    assert abs(float(sol["energy.residual"][-1])) < 1e-3 * turned


# Pictures and bad input


@pytest.mark.slow
def test_the_picture_shows_surface_depth_and_volume(life, tmp_path):
    figure = fm.plot_wear(life, WORN)
    polar, _, deepest, volume = figure.axes
    assert len(polar.lines) == 6  # five turns and the unworn circle
    radius = polar.lines[-2].get_ydata()
    assert np.argmax(radius[:-1]) == np.argmax(life["B.bearing_profile"].values[-1])
    assert deepest.lines[0].get_ydata()[-1] == pytest.approx(float(life["B.bearing_profile"][-1].max()))
    assert volume.lines[0].get_ydata()[-1] == pytest.approx(float(life["B.volume"][-1]))
    figure.savefig(tmp_path / "wear.png")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: fm.Archard(bearing=1e-3), "0.001 1/Pa.*Divide a coefficient without unit by the hardness"),
        (fm.Archard, "bearing and journal are both 0"),
        (lambda: fm.Archard(bearing=1e-13, journal=1e-13), "both above 0"),
        (lambda: fm.Archard(bearing=-1e-13), "bearing is -1e-13"),
        (lambda: fm.Archard(bearing=1e-13, bins=12), "bins is 12; it must be at least 60"),
        (lambda: fm.Archard(bearing=1e-13, width=0.0), "width is 0 m"),
        (lambda: replace(WORN, profile=(0.0,) * 10), "profile has 10 depths.*Give 360"),
        (lambda: DRY["B"].worn_by(0.1), "law of wear"),
        (lambda: WORN.worn_by(0.1), "law of wear"),
        (lambda: WORN.with_depths([1e-6] * 360).worn_by(fm.Archard(journal=1e-13)), "bearing is worn"),
        (lambda: replace(WORN, friction=Frictionless()).worn_by(fm.EnergyWear(bearing=1e-13)), "the joint has none"),
        (lambda: fm.wear_out(DRY, turns=10.0), "no joint of it wears"),
        (lambda: fm.wear_out(DRY.with_part(WORN), turns=-1.0), "turns is -1"),
        (lambda: fm.wear_out(DRY.with_part(WORN), turns=10.0, keep=0), "keep is 0"),
        (lambda: fm.wear_out("B", turns=10.0), "mechanism is 'B'; it must be Mechanism"),
        (lambda: WORN.worn_in(None), "sol is NoneType; it must be the result of fm.simulate"),
        (lambda: fm.wear_out(DRY.with_part(WORN), turns=10.0, most_runs=0), "most_runs is 0"),
        (lambda: fm.Archard(bearing=1e-13, foundation=-1.0), "foundation is -1"),
        (lambda: WORN.worn_in(fm.simulate(DRY.with_part(WORN), periods=0.01, save=[1e-4])), "save='steps'"),
        (lambda: fm.wear_out(DRY.with_part(WORN), turns=10.0, resume=True), "resume is True without a store"),
        (lambda: WORN.with_depths(np.full(360, 1.0)), "below the bearing radius"),
        (lambda: fm.Archard(bearing=1e-13, bins=10**7), "at most 7200"),
    ],
)
def test_bad_input_is_refused_with_what_to_do(make, words):
    with pytest.raises(fm.errors.InputError, match=words):
        make()


def test_pictures_of_other_things_are_refused():
    life = fm.wear_out(DRY.with_part(WORN), turns=10.0, keep=1)
    with pytest.raises(fm.errors.InputError, match=r"fm\.wear_out"):
        fm.plot_wear(life.assign_attrs(kind="sweep"), "B")
    with pytest.raises(fm.errors.InputError, match="'C'"):
        fm.plot_wear(life, "C")


def test_a_bearing_with_another_film_than_the_short_one_does_not_wear():
    oil = fm.FiniteBearing(viscosity=0.02, width=0.01)
    wet = fm.JournalBearing(
        "B", DRY["rod"], DRY["slider"], at=(0.17, 0.0), clearance=C, bearing_radius=R, normal=DRY["B"].normal, film=oil
    )
    with pytest.raises(fm.errors.InputError, match="with a worn surface it must be ShortBearing"):
        wet.worn_by(ARCHARD)


@pytest.mark.parametrize(
    "save", [1e-5, pytest.param(1000, marks=pytest.mark.slow), pytest.param([0.0, 1e-4, 2e-4], marks=pytest.mark.slow)]
)
def test_wear_of_a_run_that_saved_less_than_all_steps_is_refused(save, tmp_path):
    sol = fm.simulate(DRY.with_part(WORN), periods=0.02, save=save)
    assert not sol.has_every_step
    with pytest.raises(fm.errors.InputError, match=r"needs every step.*save='steps'"):
        WORN.worn_in(sol)
    every = rows(DRY.with_part(WORN), periods=0.02)
    again = fm.load(every.to_netcdf(tmp_path / "run.nc"))
    assert WORN.worn_in(again).volume == WORN.worn_in(every).volume


def test_a_width_that_is_not_given_is_told():
    told = fm.check(DRY.with_part(DRY["B"].worn_by(fm.Archard(bearing=1e-13))))
    assert [one.numbers["width"] for one in told.findings if one.code == "width-of-wear"] == [0.02]
    assert not [one for one in fm.check(DRY.with_part(WORN)).findings if one.code == "width-of-wear"]


def test_arms_of_both_bodies_meet_at_one_point():
    out = np.zeros(GAP_SIZE)
    q = np.array([0.1, 0.2, 0.3, 0.1 + 1.2 * C, 0.2, 0.4])
    worn_gap_kernel(np.array(WORN.with_depths(GROOVE).numbers((0.01, 0.0), (0.01, 0.0))), q, np.zeros(6), out)
    assert q[:2] + out[ARM1_X : ARM1_X + 2] == pytest.approx(q[3:5] + out[ARM2_X : ARM2_X + 2], abs=1e-16)


@pytest.mark.quick(1)
@pytest.mark.parametrize(("frequency", "sample"), [(1.0, 2), (2.0, 1), (1.0, 1)])
def test_a_load_that_takes_several_turns(frequency, sample):
    """The mean of a load that swings counts: k F times the way of a journal, of two turns a second, in 100 turns."""
    crank = fm.RigidBody("crank", at=(0.0, 0.0), mass=1.0, inertia=1e-3)
    block = fm.RigidBody("block", at=(0.0, 0.0), mass=1.0, inertia=1e-3)
    rubs = {"normal": fm.KelvinVoigt(5e8, 1e4), "friction": fm.friction.SmoothCoulomb(0.1)}
    pin = fm.RevoluteClearance("B", crank, block, at=(0.0, 0.0), clearance=1e-4, bearing_radius=0.02, **rubs)
    swing = fm.drives.Harmonic(0.6, frequency=frequency, mean=1.0)
    hinge = fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0))
    parts = [crank, block, hinge, fm.Drive("D", hinge, fm.drives.ConstantSpeed(4.0 * np.pi)), pin.worn_by(ARCHARD)]
    parts += [fm.couplings.SameRotation("S", fm.GROUND, block), fm.Force("F", block, (0, 0), (0, -500), history=swing)]
    mech = fm.Mechanism("shaft", parts)
    if frequency * sample < 2.0:
        with pytest.raises(fm.errors.InputError, match=r"a load repeats after 1 s; give as many turns of 0\.5 s"):
            fm.wear_out(mech, turns=100.0, keep=1, sample=sample)
        return
    life = fm.wear_out(mech, turns=100.0, keep=1, sample=sample)
    assert float(life["B.volume"][-1]) == pytest.approx(1e-13 * 500.0 * 100.0 * 2.0 * np.pi * 0.02, rel=0.02)
