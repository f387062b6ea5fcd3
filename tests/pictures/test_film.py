"""Films: number and size of frames, times, what moves, files of GIF and MP4, bad input."""

import builtins
import runpy
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import flexmb as fm
from flexmb.errors import InputError, MissingPackageError
from flexmb.model.shape import PointShape
from flexmb.show.pictures.films import Film, instants, joints_with_forces, traced_points

ROOT = Path(__file__).parents[2]
handmade = runpy.run_path(str(ROOT / "tests" / "handmade.py"))
solution, SPEED, RADIUS = handmade["solution"], handmade["SPEED"], handmade["RADIUS"]


@pytest.fixture(scope="module")
def sol():
    return solution()


def frames_of(path):
    with Image.open(path) as film:
        found = []
        for k in range(film.n_frames):
            film.seek(k)
            found.append((np.asarray(film.convert("RGB")), film.info["duration"]))
        return found


@pytest.mark.quick(1)
@pytest.mark.parametrize(("seconds", "fps", "count"), [(0.5, 10.0, 5), (0.3, 30.0, 9), (0.01, 1.0, 1)])
def test_a_gif_has_seconds_times_fps_frames_of_one_size(sol, tmp_path, seconds, fps, count):
    path = fm.animate(sol, tmp_path / "new" / "x.gif", seconds=seconds, fps=fps, size=(241, 180))
    found = frames_of(path)
    assert len(found) == count
    assert {frame.shape for frame, _ in found} == {(180, 241, 3)}
    if count > 1:
        assert sum(pause for _, pause in found) == pytest.approx(1000.0 * seconds, abs=5.0)
        assert all(np.all(frame[-1, 0] == 255) for frame, _ in found)  # white paper
        with Image.open(path) as film:
            assert film.info["loop"] == 0


def test_an_html_file_is_the_report(sol, tmp_path):
    assert "handmade" in fm.animate(sol, tmp_path / "x.html").read_text()


def test_a_motionless_run_keeps_its_frames(tmp_path):
    still = solution(shapes=(PointShape("O", "revolute", "ground", "", (0.0, 0.0)),))
    assert len(frames_of(fm.animate(still, tmp_path / "x.gif", seconds=1.0, fps=12.0, size=(200, 160)))) == 12


@pytest.mark.slow
def test_an_mp4_has_seconds_times_fps_frames(sol, tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="films as .mp4 need the extra `film`")
    path = fm.animate(sol, tmp_path / "x.mp4", seconds=0.4, fps=20.0, size=(241, 181), colour=None)
    frames = ffmpeg.read_frames(str(path))
    about = next(frames)
    assert about["size"] == (242, 182)  # even, as H.264 asks
    assert about["fps"] == 20.0
    assert len(list(frames)) == 8


def film(sol, count=5, **changes):
    given = {"magnify": 1.0, "colour": "moment", "points": {}, "joints": (), "size": (320, 240), **changes}
    return Film(sol, instants(sol, None, count), *given.values())


def test_the_crank_moves_from_frame_to_frame(sol):
    """Each frame differs from the one before where the crank was and is; the frame of the axes does not."""
    images = list(film(sol, colour=None).frames())
    assert len(images) == 5
    for before, after in pairwise(images):
        assert np.any(before != after)
        np.testing.assert_array_equal(before[-20:], after[-20:])  # below the axes
    back, start = images[-1].astype(int), images[0].astype(int)
    assert np.abs(back - start)[40:].max() <= 2  # one turn: the pose of the start again, under another time


def test_images_do_not_depend_on_the_frames_before(sol):
    whole = film(sol)
    last = list(whole.frames())[3]
    (alone,) = film(sol).frames([3])
    np.testing.assert_array_equal(alone, last)


def test_frames_show_the_ends_of_the_chosen_time(sol):
    np.testing.assert_allclose(instants(sol, (0.25, 0.75), 3), [0.25, 0.5, 0.75])
    assert instants(sol, None, 2).tolist() == [0.0, 1.0]


def test_rods_bend_under_a_magnified_deformation(sol):
    """The arm is a circular arc; with three times the deformation its middle is three times as far from its chord."""
    true, large = film(sol), film(sol, magnify=3.0)
    away = []
    for scene in (true.scene, large.scene):
        first, second = (line.points[1] for line in scene.lines if line.is_beam)
        chord, middle = second[-1] - first[0], first[-1] - first[0]
        away.append((chord[0] * middle[1] - chord[1] * middle[0]) / np.hypot(*chord))
    assert abs(away[0]) > 0.05
    assert away[1] == pytest.approx(3.0 * away[0], rel=1e-9)
    moments = [f.scene.lines[-1].fields["bending_moment"] for f in (true, large)]
    np.testing.assert_allclose(moments[1], moments[0], rtol=1e-12)  # forces are the true ones


def test_no_deformation_draws_straight_rods(sol):
    scene = film(sol, magnify=0.0).scene
    first, second = (line.points for line in scene.lines if line.is_beam)
    points = np.concatenate([first, second], axis=1)
    away = points - points[:, :1]
    across = away[..., 0] * away[:, -1:, 1] - away[..., 1] * away[:, -1:, 0]
    assert np.abs(across).max() < 1e-12


def travelling():
    """Two discs that fly side by side, 40 m with 0.6 m between them."""
    bodies = [fm.RigidBody(f"disc{k}", (0.0, 0.6 * k), 1.0, 0.1, velocity=(40.0, 0.0, 0.0)) for k in (0, 1)]
    return fm.simulate(fm.Mechanism("flight", bodies), t_end=1.0, step=0.01)


@pytest.mark.slow
def test_axes_follow_a_body_that_travels():
    sol = travelling()
    still, moving = film(sol, colour=None), film(sol, colour=None, follow=("disc0", "", (0.0, 0.0)))
    assert np.ptp(still.scene.box[0]) > 40.0
    assert np.ptp(moving.scene.box[0]) < 3.0
    images = []
    for k in range(5):
        images += moving.frames([k])
        (x0, x1), (y0, y1) = moving._ax.get_xlim(), moving._ax.get_ylim()
        assert 0.5 * (x0 + x1) == pytest.approx(10.0 * k, abs=1e-9)
        assert y0 < 0.0 < 0.6 < y1
        assert {(0, 114, 178), (213, 94, 0)} <= {
            tuple(c) for c in np.unique(images[-1].reshape(-1, 3), axis=0).tolist()
        }
    np.testing.assert_array_equal(next(moving.frames([1])), images[1])


def test_paths_and_forces_are_those_that_were_asked_for(sol):
    assert list(traced_points(sol, None)) == []
    points = traced_points(sol, ["arm.end", "crank"])
    path, time = film(sol, points=points).scene.paths["arm.end"]
    np.testing.assert_allclose(path, np.stack([sol["arm.end.x"], sol["arm.end.y"]], axis=-1))
    np.testing.assert_array_equal(time, sol.time)
    assert joints_with_forces("animate", sol, True) == ()  # the record holds no fx
    with pytest.raises(InputError, match=r"traces is 'arm.ende'.*Did you mean 'arm.end'"):
        traced_points(sol, ["arm.ende"])
    with pytest.raises(InputError, match="animate: forces is 'Q'"):
        joints_with_forces("animate", sol, ["Q"])


@pytest.mark.parametrize(
    ("path", "keywords", "words"),
    [
        ("x.avi", {}, r"path is .*x.avi'; it must end in one of .mp4, .gif, .html"),
        ("x.gif", {"seconds": 0.0}, "seconds is 0"),
        ("x.gif", {"fps": -1.0}, "fps is -1"),
        ("x.gif", {"magnify": -1.0}, "magnify is -1"),
        ("x.gif", {"fps": 1e9}, r"seconds x fps are 4e\+09 frames; it must be at most 20000.*smaller fps="),
        ("x.gif", {"size": (10**6, 10**6)}, "size is 1000000 x 1000000 pixels; each must be 8192 at most"),
        ("x.gif", {"size": (4000, 4000), "fps": 500.0}, "2000 frames of 4000 x 4000 pixels .* Make an .mp4"),
        ("x.gif", {"size": (300, 300, 3)}, "size is .*; give width and height in pixels"),
        ("x.gif", {"follow": "crnk"}, "follow is 'crnk'. Did you mean 'crank'"),
        ("x.gif", {"colour": "momet"}, "colour is 'momet'.*Did you mean 'moment'"),
        ("x.gif", {"times": (0.5, 0.2)}, "the end must be later"),
        ("x.gif", {"times": (0.5, 2.0)}, r"times\[1\]"),
        ("x.gif", {"size": (20, 300)}, r"size\[0\]"),
    ],
)
def test_what_is_refused(sol, tmp_path, path, keywords, words):
    with pytest.raises(InputError, match=words):
        fm.animate(sol, tmp_path / path, **keywords)
    assert not list(tmp_path.iterdir())


def test_solutions_that_cannot_be_filmed(sol, tmp_path):
    with pytest.raises(InputError, match="no saved instants"):
        fm.animate(replace(sol, time=np.zeros(0), values=np.zeros((0, len(sol.names)))), tmp_path / "x.gif")
    with pytest.raises(InputError, match="no shapes"):
        fm.animate(solution(shapes=()), tmp_path / "x.gif")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="writable folder"):
        fm.animate(sol, tmp_path / "file" / "x.gif", seconds=0.1, size=(200, 150))


def test_a_missing_package_is_named_with_its_command(sol, tmp_path, monkeypatch):
    real = builtins.__import__

    def without(name, *rest, **more):
        if name == "imageio_ffmpeg":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingPackageError, match=r"pip install 'flexmb\[film\]'"):
        fm.animate(sol, tmp_path / "x.mp4", seconds=0.1)
