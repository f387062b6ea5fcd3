"""The nine-bar mechanism as declared: pose, mass properties, names, refusals."""

import pickle
import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import NineBarData, nine_bar
from flexmb.mechanisms.nine_bar import NineBarPose

by_hand = runpy.run_path(str(Path(__file__).with_name("closed_form.py")))

# docs/nine_bar.md, "Reconstruction": the pose at theta1 = theta4 = 0, to 0.1 mm.
POSE = {
    "P1": (0.0450, 0.0), "P4": (0.0950, 0.4300), "B": (-0.2681, 0.0907),
    "A": (-0.3746, 0.2934), "C": (-0.5826, 0.0717), "S": (-0.9181, 0.0900),
}  # fmt: skip
MASSES = {
    "crank1": 0.148, "link2": 0.805, "link3": 0.603, "crank4": 0.265, "rocker6": 0.581,
    "panel7": 4.334, "link8": 0.827, "slider": 0.801,
}  # fmt: skip
PIVOT_INERTIAS = {"crank1": (2.382e-4, 0.045), "crank4": (1.210e-3, 0.095), "rocker6": (1.212e-2, 0.230)}
CENTRAL_INERTIAS = {"link2": 8.001e-3, "link3": 1.337e-2, "panel7": 3.802e-2, "link8": 8.663e-3}


@pytest.mark.parametrize("joint", POSE)
def test_drawn_pose_is_the_documented_one(joint):
    found = getattr(NineBarPose.at(NineBarData(), 0.0, 0.0), joint)
    assert np.abs(np.subtract(found, POSE[joint])).max() <= 0.6e-4  # both rounded to 0.1 mm


@pytest.mark.parametrize("flexible", [False, True])
def test_joints_stand_at_the_pose(flexible):
    mech = nine_bar(flexible=flexible)
    for name, point in {**POSE, "B2": POSE["B"], "B3": POSE["B"], "O6": (-0.58, 0.19)}.items():
        if name != "B":
            assert mech.find(name).at == pytest.approx(point, abs=0.6e-4)


@pytest.mark.parametrize("start", [(0.0, 0.0), (1.0, -2.0), (-2.5, 0.7), (3.1, 3.1)])
def test_pose_agrees_with_the_law_of_cosines(start):
    pose = NineBarPose.at(NineBarData(), *start)
    q = by_hand["positions"](*map(np.array, start))
    B = 0.045 * np.exp(1j * q.t1) + 0.326 * np.exp(1j * q.t2)
    assert complex(*pose.B) == pytest.approx(B, abs=1e-14)
    assert np.subtract(pose.S, (q.s9, 0.090)) == pytest.approx(0.0, abs=1e-14)


def test_all_pairs_of_crank_angles_close():
    turn = np.linspace(0.0, 2.0 * np.pi, 25)
    found = [NineBarPose.at(NineBarData(), a, b).S[0] for a in turn for b in turn]
    assert np.ptp(found) < 0.2  # one branch: no jump of the slider to the other side of its rod


def rigid_properties(body):
    """Mass, centre and central inertia of a rigid body as declared."""
    node = body.nodes()[0]
    return body.mass, (node.x, node.y), body.inertia


@pytest.mark.parametrize("start", [(0.0, 0.0), (1.0, -2.0)])
def test_rigid_and_flexible_bodies_have_the_same_mass_centre_and_inertia(start):
    rigid, flexible = nine_bar(start=start), nine_bar(start=start, flexible=True)
    for body in flexible.bodies:
        if body.name == "slider":
            continue
        own, (mass, centre, inertia) = body.properties(), rigid_properties(rigid.find(body.name))
        assert own.mass == pytest.approx(mass, rel=1e-12)
        assert own.centre == pytest.approx(centre, abs=1e-12)
        assert own.inertia == pytest.approx(inertia, rel=1e-10)


def test_mass_properties_are_the_table_s():
    for body in nine_bar().bodies:
        mass, centre, inertia = rigid_properties(body)
        assert mass == MASSES[body.name]
        if body.name in PIVOT_INERTIAS:
            about_pivot, length = PIVOT_INERTIAS[body.name]
            assert np.hypot(*np.subtract(centre, body.start)) == pytest.approx(length / 2, rel=1e-12)
            assert inertia + mass * (length / 2) ** 2 == pytest.approx(about_pivot, rel=1e-12)
        elif body.name in CENTRAL_INERTIAS:
            assert inertia == CENTRAL_INERTIAS[body.name]


def test_panel_s_centre_lies_147_mm_from_a_towards_the_centroid():
    mech = nine_bar()
    A, B, C = (np.array(mech.find(n).at) for n in ("A", "B2", "C"))
    arm = np.array(mech.find("panel7").at) - A
    assert np.hypot(*arm) == pytest.approx(0.147, abs=1e-12)
    middle = (A + B + C) / 3 - A
    assert arm @ middle == pytest.approx(0.147 * np.hypot(*middle), rel=1e-12)


def test_two_degrees_of_freedom_and_no_redundant_joint():
    mech = nine_bar()
    free = mech.without_part("motor1").without_part("motor4")
    program = fm.compile(mech)
    assert (program.n_q, program.n_c) == (24, 24)  # eight bodies; ten pins, the guide with two rows, two drives
    assert fm.compile(free).n_c == 22  # 24 - 22 = 2 degrees of freedom


def test_directions_of_the_cranks_and_gravity():
    mech = nine_bar(speed=3.0)
    assert (mech.find("motor1").motion.speed, mech.find("motor4").motion.speed) == (-3.0, 3.0)
    assert mech.gravity == (-9.81, 0.0)


def test_contact_stiffness_is_eq_4_with_a_concave_bearing():
    joint = nine_bar(clearance=0.5e-3).find("P1")
    s = (1 - 0.29**2) / 207e9
    # the paper's R1 + R2 with a negative R of the bearing: sqrt(R1 R2 / (R1 - R2))
    expected = 4.0 / (3.0 * (s + s)) * np.sqrt(0.010 * 0.0095 / 0.0005)
    normal = joint.normal.for_radii(joint.bearing_radius, joint.journal_radius)
    assert normal.stiffness == pytest.approx(expected, rel=1e-12)
    assert (joint.first.name, joint.second.name) == ("crank1", "link2")


def test_friction_words_and_laws():
    assert nine_bar(clearance=1e-4).find("P1").friction == fm.ModifiedCoulomb(0.01, 1e-4, 1e-3)
    assert nine_bar(clearance=1e-4, friction=None).find("P1").friction == fm.friction.Frictionless()
    law = fm.ModifiedCoulomb(0.2)
    assert nine_bar(clearance=1e-4, friction=law).find("P1").friction == law


def test_ramp_starts_from_rest():
    assert nine_bar(speed=2.0, ramp=0.5).find("motor1").motion == fm.drives.Ramp(-2.0, 0.5)


def test_mechanism_can_be_pickled():
    mech = nine_bar(clearance=0.5e-3, flexible=True)
    assert pickle.loads(pickle.dumps(mech)) == mech  # noqa: S301 - its own bytes


@pytest.mark.parametrize(
    ("keywords", "words"),
    [
        ({"friction": "colomb"}, ["nine_bar", "colomb", "coulomb"]),
        ({"flexible": 4}, ["flexible", "4", "True or False"]),
        ({"start": 0.0}, ["start", "two angles"]),
        ({"elements": 0}, ["elements", "0"]),
        ({"ramp": 0.0}, ["ramp", "> 0"]),
        ({"data": {"mass1": 1.0}}, ["data", "NineBarData"]),
        ({"clearance": 0.0}, ["P1", "clearance", "Revolute"]),
        ({"clearance": 0.5}, ["P1", "0.5", "bearing radius"]),
    ],
)
def test_refusals(keywords, words):
    with pytest.raises(fm.errors.InputError) as error:
        nine_bar(**keywords)
    assert all(word in str(error.value) for word in words)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mass7": -1.0}, ["mass7", "-1"]),
        ({"side_ab": 0.7}, ["0.7", "no triangle"]),
        ({"damping": -1e-6}, ["damping"]),
        ({"pivot6": 1.0}, ["pivot6"]),
    ],
)
def test_data_out_of_range(changes, words):
    with pytest.raises(fm.errors.InputError) as error:
        replace(NineBarData(), **changes)
    assert all(word in str(error.value) for word in words)


def test_inertia_meant_about_the_centre_of_mass_is_explained():
    with pytest.raises(fm.errors.InputError, match=r"inertia6 is 0\.004436.*about the centre of mass"):
        nine_bar(data=NineBarData(inertia6=4.436e-3))


@pytest.mark.parametrize(
    ("changes", "loop", "missing"),
    [
        # |P1 P4| = sqrt(0.05^2 + 0.43^2) = 0.43290 at the start: 0.1 + 0.3 misses it by 0.0329
        ({"length2": 0.1, "length3": 0.3}, "O1-P1-B-P4-O4", "0.0329 m too little"),
        # O6 to B = hypot(0.31186, 0.09932) = 0.32730: 0.1 + 0.2 misses it by 0.0273
        ({"length6": 0.1, "side_ab": 0.2, "side_ac": 0.25, "side_bc": 0.25}, "O6-A-B", "0.0273 m too little"),
        # C lies at Y = 0.0717
        ({"slider_line": 0.5}, "C-S-guide", "0.09227 m too far"),
    ],
)
def test_a_loop_that_cannot_close_is_named_with_its_gap(changes, loop, missing):
    with pytest.raises(fm.errors.AssemblyError) as error:
        nine_bar(data=NineBarData(**changes))
    assert loop in str(error.value)
    assert missing in str(error.value)


def test_links_that_keep_their_ends_apart():
    with pytest.raises(fm.errors.AssemblyError, match=r"at least 0\.6 m apart"):
        nine_bar(data=NineBarData(length2=0.1, length3=0.7))


MESHES = Path(__file__).parents[2] / "meshes"


def test_all_seven_stored_meshes_fit_and_give_the_same_mechanism():
    built, read = nine_bar(flexible=True), nine_bar(mesh=str(MESHES))
    for name in (*PIVOT_INERTIAS, *CENTRAL_INERTIAS):
        one, other = built.find(name), read.find(name)
        assert [n.name for n in other.nodes()] == [n.name for n in one.nodes()]
        poses = [np.array([(n.x, n.y, n.theta) for n in part.nodes()]) for part in (one, other)]
        np.testing.assert_allclose(poses[1], poses[0], atol=1e-14)
        assert other.properties().mass == pytest.approx(one.properties().mass, rel=1e-12)
        assert other.properties().inertia == pytest.approx(one.properties().inertia, rel=1e-12)
    runs = [fm.simulate(mech, t_end=2e-3, step=1e-4) for mech in (built, read)]
    assert runs[1].array("slider.ax")[-1] == pytest.approx(runs[0].array("slider.ax")[-1], rel=1e-7)


def test_a_mesh_of_a_panel_the_other_way_round_is_refused(tmp_path):
    for file in MESHES.glob("*[0-9].msh"):
        text = file.read_text()
        if file.stem == "panel7":
            begin, end = text.index("$Nodes"), text.index("$EndNodes")
            rows = [line.split() for line in text[begin:end].splitlines()]
            flipped = [" ".join((r[0], r[1], str(-float(r[2])), r[3])) if len(r) == 4 else r[0] for r in rows]
            text = text[:begin] + "\n".join(flipped) + "\n" + text[end:]
        (tmp_path / file.name).write_text(text)
    with pytest.raises(fm.errors.InputError, match=r"panel7.msh has no corner at hinge C of the panel"):
        nine_bar(mesh=str(tmp_path))
