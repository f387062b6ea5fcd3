"""A page of a run holds the numbers of the solution and all of its parts, and nothing on it acts by itself."""

import base64
import hashlib
import re
import time
import tracemalloc
from dataclasses import replace

import handmade
import numpy as np
import pytest
from pages import Page, unpacked

import flexmb as fm
from flexmb.errors import InputError
from flexmb.results import drawing

PLACES = ("x", "y", "theta")
EMPTY = replace(handmade.solution(), time=np.zeros(0), values=np.zeros((0, len(handmade.solution().names))))


def node_poses(scene):
    """Poses (n, m, 3) of all nodes of a scene."""
    frames, moved = unpacked(scene["frames"]), unpacked(scene["displacements"])
    found = []
    for frame, x, y, angle, own in scene["nodes"]:
        if frame < 0:
            found.append(np.zeros((len(frames), 3)))
            continue
        fx, fy, turn = frames[:, 3 * frame : 3 * frame + 3].T
        dx, dy, da = moved[:, 3 * own : 3 * own + 3].T if own >= 0 else np.zeros((3, len(frames)))
        c, s = np.cos(turn), np.sin(turn)
        px, py = x + dx, y + dy
        found.append(np.stack([fx + c * px - s * py, fy + s * px + c * py, turn + angle + da], axis=-1))
    return np.stack(found, axis=1)


def test_curves_are_the_signals_in_single_precision(slider_crank, run_page):
    _, sol = slider_crank
    signals = run_page.data["signals"]
    assert {"slider.ax", "motor.torque", "B.normal_force", "rod.deflection"} <= set(signals["names"])
    assert np.array_equal(unpacked(signals["abscissae"]), sol.time)
    for name, unit, column in zip(signals["names"], signals["units"], unpacked(signals["curves"]).T, strict=True):
        assert np.array_equal(column, sol.array(name).astype(np.float32))
        assert unit == sol.units(name)
    assert np.array_equal(unpacked(signals["time"]), sol.time[signals["rows"]])


def test_nodes_stand_where_the_solution_says(slider_crank, run_page):
    _, sol = slider_crank
    scene, rows = run_page.data["scene"], run_page.data["signals"]["rows"]
    poses = node_poses(scene)
    beams = {(part, a): node for (part, a, *_), node in zip(scene["beams"], ("node0", "node1"), strict=True)}
    beams[scene["beams"][-1][0], scene["beams"][-1][2]] = "node2"
    for (part, place), node in beams.items():
        wanted = np.stack([sol.array(f"{part}.{node}.{axis}")[rows] for axis in PLACES], axis=-1)
        turns = np.round((poses[:, place, 2] - wanted[:, 2]) / (2 * np.pi)) * 2 * np.pi
        apart = poses[:, place] - wanted - np.stack([0 * turns, 0 * turns, turns], axis=-1)
        assert np.all(np.abs(apart).max(axis=0) < (5e-8, 5e-8, 1e-6))
    (crank,) = (shape for shape in scene["rigid"] if shape["part"] == "crank")
    wanted = np.stack([sol.array(f"crank.{axis}")[rows] for axis in PLACES], axis=-1)
    assert np.allclose(poses[:, crank["node"]], wanted, rtol=0, atol=1e-6)


def test_displacements_are_those_from_the_chord(slider_crank, run_page):
    """The middle of the rod leaves the chord of the page's rigid motion by the signal `deflection`."""
    _, sol = slider_crank
    scene, rows = run_page.data["scene"], run_page.data["signals"]["rows"]
    middle = next(node for node in scene["nodes"] if node[4] == 1)
    across = unpacked(scene["displacements"])[:, 3 * middle[4] + 1]
    wanted = sol.array("rod.deflection")[rows]
    assert np.abs(across - wanted).max() < 2e-3 * np.abs(wanted).max()


def test_section_forces_and_joint_forces(slider_crank, run_page):
    _, sol = slider_crank
    scene, rows = run_page.data["scene"], np.array(run_page.data["signals"]["rows"])
    beams = [line for line in drawing.lines(sol, rows, 2) if line.is_beam]
    for key, field in (("moment", "bending_moment"), ("axial", "axial_force")):
        wanted = np.concatenate([beam.fields[field] for beam in beams], axis=1)
        assert np.abs(unpacked(scene[key]) - wanted).max() <= 0.51 * np.ptp(wanted) / 1023
    forces = unpacked(scene["forces"])
    for k, name in enumerate(scene["forced"]):
        for c, axis in enumerate(("fx", "fy")):
            wanted = sol.array(f"{name}.{axis}")[rows]
            assert np.abs(forces[:, 2 * k + c] - wanted).max() <= 0.51 * np.ptp(wanted) / 4095
    assert {"O", "A", "B"} <= set(scene["forced"])


def test_stresses_are_those_of_axial_force_and_bending_moment(slider_crank, run_page):
    """E (|N|/EA + |M| c/EI) of the section, the largest one at the ends and in the middle of an element."""
    mech, sol = slider_crank
    rod, rows = mech.find("rod"), np.array(run_page.data["signals"]["rows"])
    beams = [line for line in drawing.lines(sol, rows, 3) if line.is_beam]
    section = rod.section
    area, second, fibre = (float(f(0.0)) for f in (section.area_at, section.second_moment_at, section.outer_fibre_at))
    stress = unpacked(run_page.data["scene"]["stress"])
    for k, beam in enumerate(beams):
        bending = np.abs(beam.fields["bending_moment"]) * fibre / second
        wanted = (np.abs(beam.fields["axial_force"]) / area + bending).max(axis=1)
        assert stress[:, k] == pytest.approx(wanted, abs=0.51 * np.ptp(stress) / 1023 + 1e-6 * wanted.max())


def test_tables_hold_the_numbers(slider_crank, run_page):
    mech, sol = slider_crank
    text = run_page.text
    for name in ("slider.ax", "B.normal_force", "motor.torque"):
        assert f"{sol.peak(name).value:.6g}" in text
    for value in (sol.stats.steps, sol.stats.rejected, sol.stats.newton_iterations, sol.stats.evaluations):
        assert str(value) in text
    assert sol.status in text
    assert all(note in text for note in sol.notes)
    for key in ("kinetic", "drive_work", "residual"):
        assert f"{sol.array(f'energy.{key}')[-1]:.6g}" in text
    episodes = sol.episodes("B")
    assert len(episodes) > 3
    buttons = [float(b["data-time"]) for b in run_page.all("button") if b.get("class") == "go"]
    assert set(np.round(episodes.start[np.isfinite(episodes.start)], 9)) <= set(np.round(buttons, 9))
    for part in mech.parts:
        assert part.name in text
        assert type(part).__name__ in text
    assert "LankaraniNikravesh" in text
    assert "clearance 0.0005 m" in text
    assert f"{sum(body.total_mass() for body in mech.bodies):.6g} kg" in text
    assert f"{fm.check(mech).frequencies[0]:.4g}" in text
    assert repr(fm.Newmark.generalised_alpha()) in text
    captions = [attributes for name, attributes in run_page.elements if name == "caption"]
    assert len(captions) == len(run_page.all("table")) >= 5


def test_words_have_no_unit_and_motions_that_of_what_they_drive(slider_crank, run_page, tmp_path):
    assert re.search(r"start centred$", run_page.text, re.MULTILINE)
    assert "motion ConstantSpeed (speed 300 rad/s)" in run_page.text
    body = fm.RigidBody("body", at=(0.0, 0.0), mass=1.0, inertia=0.1)
    guide = fm.Prismatic("guide", fm.GROUND, body, along=(1.0, 0.0))
    pushed = fm.Drive("motor", "guide", fm.drives.Harmonic(0.1, frequency=2.0))
    page = Page(fm.report(fm.simulate(fm.Mechanism("pushed", [body, guide, pushed]), t_end=0.1), tmp_path / "run.html"))
    assert "amplitude 0.1 m, frequency 2 Hz" in page.text
    for text in (run_page.text, page.text):
        assert "rad/s or m/s" not in text
        assert "rad or m" not in text
        assert "centred m" not in text


def test_names_that_read_like_units_stay(tmp_path):
    """Once the joint of the drive was called "way in m"."""
    body = fm.RigidBody("body", at=(0.0, 0.0), mass=1.0, inertia=0.1)
    guide = fm.Prismatic("way in rad or m", fm.GROUND, body, along=(1.0, 0.0))
    pushed = fm.Drive("motor", guide.name, fm.drives.Harmonic(0.1, frequency=2.0, mean=0.2))
    page = Page(fm.report(fm.simulate(fm.Mechanism("pushed", [body, guide, pushed]), t_end=0.1), tmp_path / "run.html"))
    assert "joint way in rad or m; motion Harmonic (amplitude 0.1 m, frequency 2 Hz, mean 0.2 m)" in page.text


def test_journal_and_its_clearance(slider_crank, run_page):
    _, sol = slider_crank
    (journal,) = run_page.data["journals"]
    rows = run_page.data["signals"]["rows"]
    assert journal["joint"] == "B"
    assert journal["clearance"] == pytest.approx(5e-4, rel=1e-9)
    now = unpacked(journal["now"])
    for column, name in zip(now.T, ("ex", "ey", "penetration", "normal_force"), strict=True):
        assert np.array_equal(column, sol.array(f"B.{name}")[rows].astype(np.float32))
    touching = np.array(list(journal["touching"])) == "1"
    assert touching.any()
    assert not touching.all()


def test_a_loaded_solution_gives_the_same_page(slider_crank, run_page, tmp_path):
    mech, sol = slider_crank
    loaded = fm.load(sol.to_netcdf(tmp_path / "run.nc"))
    page = Page(fm.report(loaded, tmp_path / "run.html"))
    known = {key: value for key, value in run_page.data["scene"].items() if key != "stress"}  # needs the mechanism
    assert page.data == {**run_page.data, "scene": known}
    assert "Not examined" in page.text
    examined = Page(fm.report(loaded, tmp_path / "again.html", mechanism=mech))
    assert examined.source == run_page.source
    assert "Not examined" not in run_page.text


def test_a_solution_without_mechanism_says_so(tmp_path):
    page = Page(fm.report(handmade.solution(), tmp_path / "page.html"))
    assert "knows no mechanism" in page.text
    assert "mechanism=mech" in page.text
    assert len(page.data["scene"]["beams"]) == 2


def test_poses_that_were_not_saved_are_named(slider_crank, tmp_path):
    mech, _ = slider_crank
    sol = fm.simulate(mech, t_end=1e-3, save=10, step=1e-5, signals=["B.*"])
    page = Page(fm.report(sol, tmp_path / "page.html"))
    assert page.data["scene"] is None
    assert "were not saved" in page.text
    assert not page.all("canvas") or all(c.get("class") == "journal" for c in page.all("canvas"))


def test_peaks_survive_in_long_runs(tmp_path):
    """A spike of one row in 100,000 is on the page, which is made in seconds and little memory."""
    sol = handmade.solution(n=100_001)
    values = np.array(sol.values)
    column, row = sol.names.index("crank.ax"), 31_416
    values[row, column] = 1e4
    sol = replace(sol, values=values)
    tracemalloc.start()
    began = time.perf_counter()
    page = Page(fm.report(sol, tmp_path / "long.html", signals=["crank.ax"]))
    taken, (_, most) = time.perf_counter() - began, tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert taken < 20.0
    assert most < 1e9
    curves, times = unpacked(page.data["signals"]["curves"])[:, 0], unpacked(page.data["signals"]["abscissae"])
    assert len(curves) == 2000
    assert curves.max() == 1e4
    assert curves.min() == np.float32(values[:, column].min())
    assert abs(times[np.argmax(curves)] - sol.time[row]) < 1.01e-3
    assert np.all(np.diff(times) > 0.0)
    frames = unpacked(page.data["signals"]["time"])
    assert (len(frames), frames[0], frames[-1]) == (1000, 0.0, 1.0)
    assert len(page.source) < 1_000_000


def test_fewer_frames(slider_crank, tmp_path):
    _, sol = slider_crank
    page = Page(fm.report(sol, tmp_path / "page.html", frames=50, signals=["slider.*", "B.mode"], title="Short"))
    assert page.data["scene"]["frames"]["n"] == 50
    names = page.data["signals"]["names"]
    assert names == [*(name for name in sol.names if name.startswith("slider.")), "B.mode"]
    at_frames, times = unpacked(page.data["signals"]["at_frames"]), unpacked(page.data["signals"]["time"])
    assert np.array_equal(at_frames[:, -1], sol.array("B.mode")[np.isin(sol.time, times)])
    assert "<h1>Short</h1>" in page.source


def test_size_of_a_usual_page(slider_crank, tmp_path):
    """2,000 saved instants, 1,000 frames; a run of two periods as the command line makes it."""
    mech, _ = slider_crank
    sol = fm.simulate(mech, periods=1, save=2000, step=1e-5)
    assert fm.report(sol, tmp_path / "page.html").stat().st_size < 600_000


def test_names_are_escaped(tmp_path):
    """A part named as a script, and a title that ends its element."""
    evil = '<img src=x onerror="hacked=1">'
    arm = fm.RigidLink(evil, (0.0, 0.0), (0.5, 0.0), mass=1.0, inertia=0.02)
    parts = [arm, fm.Revolute("<script>window", fm.GROUND, arm, at=(0.0, 0.0))]
    sol = fm.simulate(fm.Mechanism("<b>arm", parts, gravity=(0.0, -9.81)), t_end=0.1, save=20)
    page = Page(fm.report(sol, tmp_path / "page.html", title="</title><script>hacked=1</script>"))
    assert not page.all("img")
    assert len(page.all("script")) == 3
    assert len(page.all("b")) == 0
    assert evil in page.text
    assert "<script>window" in page.text
    assert page.data["scene"]["rigid"][0]["part"] == evil


def test_policy_allows_the_scripts_of_the_page_and_no_network(run_page):
    (policy,) = (m["content"] for m in run_page.all("meta") if m.get("http-equiv") == "Content-Security-Policy")
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["default-src"] == "'none'"
    assert rules["img-src"] == "data:"
    assert rules["base-uri"] == rules["form-action"] == "'none'"
    assert set(rules) == {"default-src", "style-src", "script-src", "img-src", "base-uri", "form-action"}

    def hashes(texts):
        digests = [hashlib.sha256(text.encode()).digest() for text in texts]
        return " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)

    assert rules["style-src"] == hashes(re.findall(r"<style>(.*?)</style>", run_page.source, re.DOTALL))
    assert rules["script-src"] == hashes(re.findall(r"<script>(.*?)</script>", run_page.source, re.DOTALL))
    assert not any(name in attributes for _, attributes in run_page.elements for name in ("src", "style", "onclick"))
    assert not run_page.all("link")
    assert all(a["href"].startswith("#") for a in run_page.all("a"))


def test_uplot_is_the_released_file(root):
    """Version 1.6.32 as published, with its licence; the page carries its notice."""
    known = {
        "uPlot.iife.min.js": "19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f",
        "uPlot.min.css": "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04",
        "uPlot.LICENSE.txt": "8f989229699b4fe2f1a0432d0e9edc338a8a911e250e2d1b01ecd770a5f5b1bd",
    }
    folder = root / "flexmb" / "show" / "reports" / "assets"
    found = {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in known}
    assert found == known


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"result": 3}, "report: result is int; it must be a Solution"),
        ({"path": "page.pdf"}, "must end in .html"),
        ({"path": 3}, "the path is 3"),
        ({"frames": 1}, "frames is 1; it must be"),
        ({"frames": 2.5}, "frames is 2.5"),
        ({"signals": "crank.ax"}, r"must be a list of names, e.g. \['crank.ax'\]"),
        ({"signals": ["crank.az"]}, "Did you mean"),
        ({"mechanism": "crank"}, "must be a Mechanism"),
        ({"result": EMPTY}, "no saved instants"),
    ],
)
def test_bad_input(tmp_path, change, words):
    arguments = {"result": handmade.solution(), "path": tmp_path / "page.html", **change}
    with pytest.raises(InputError, match=words):
        fm.report(**arguments)


def test_a_path_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        fm.report(handmade.solution(), tmp_path / "file" / "page.html")
    (tmp_path / "page.html").mkdir()
    with pytest.raises(InputError, match="cannot be written"):
        fm.report(handmade.solution(), tmp_path / "page.html")


@pytest.mark.parametrize(
    ("ok", "status", "kind"),
    [
        (False, "Stopped at t = 0.5 s: Newton did not converge.", "error"),
        (True, "Finished at t = 1 s. But the energies miss 3 J.", "warning"),
        (True, "Finished at t = 1 s.", None),
    ],
)
def test_the_head_tells_how_a_run_ended(tmp_path, ok, status, kind):
    page = Page(fm.report(replace(handmade.solution(), ok=ok, status=status), tmp_path / "page.html"))
    head = page.source[: page.source.index("<main")]
    assert f'<span class="badge {"good" if ok else "error"}">' in head
    assert (status in head) == (kind is not None)
    assert [x["class"] for x in page.all("p") if "told" in x.get("class", "")] == ([f"told {kind}"] if kind else [])


def test_one_saved_instant_is_enough(tmp_path):
    page = Page(fm.report(handmade.solution(n=1), tmp_path / "page.html"))
    assert ", 1 saved instant, " in page.text
    assert page.data["scene"]["frames"]["n"] == 1
