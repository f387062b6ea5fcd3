"""Files on full disks and at paths that cannot be written: the old file or the new one, and one error with a name."""

import errno
import gc
import io
import os
import random
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from cases import slow_where
from damage import crank, damaged, servo

import flexmb as fm
from flexmb.cli.command_line import main
from flexmb.dynamics.jobs.files import whole_file
from flexmb.engine.compiled import ahead
from flexmb.errors import FileFormatError, FlexmbError, InputError
from flexmb.results.solution import Solution
from flexmb.run import saving
from flexmb.run.checkpoint import Checkpoints


@pytest.fixture(scope="module")
def sol():
    return fm.simulate(fm.mechanisms.slider_crank(clearance=5e-4), t_end=2e-3, save=20)


WRITERS = {
    "a.nc": lambda sol, path: sol.to_netcdf(path),
    "a.png": lambda sol, path: fm.render(sol, path=path),
    "b.png": lambda sol, path: fm.plot(sol, ["slider.x"]).savefig(path),
    "a.pdf": lambda sol, path: fm.render(sol, path=path),
    "b.pdf": lambda sol, path: fm.plot(sol, ["slider.x"]).savefig(path),
    "a.svg": lambda sol, path: fm.render(sol, path=path),
    "a.gif": lambda sol, path: fm.animate(sol, path, seconds=0.2, fps=10),
    "a.mp4": lambda sol, path: fm.animate(sol, path, seconds=0.2, fps=10),
    "a.glb": fm.plots.export_gltf,
    "a.html": fm.report,
    "a.pvd": fm.write_vtk,
}


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 16 kB with an old file of each name, nearly full."""
    place = tmp_path / "disk"
    place.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", place], check=False, capture_output=True
    )
    if mounted.returncode:
        pytest.skip("no file systems may be mounted here")
    yield place
    if subprocess.run(["umount", place], check=False, capture_output=True).returncode:
        gc.collect()  # matplotlib leaves files of pages open; a collection takes a second
        subprocess.run(["umount", place], check=True)


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", slow_where(lambda n: n in ("a.pdf", "a.png", "a.svg"), WRITERS))
def test_a_full_disk_leaves_the_old_file_whole(sol, small_disk, name):
    if name.endswith("mp4"):
        pytest.importorskip("imageio_ffmpeg")
    old = small_disk / name
    old.write_bytes(b"old")
    (small_disk / "filling").write_bytes(bytes(8192))
    with pytest.raises(InputError, match=r"cannot be written"):
        WRITERS[name](sol, old)
    assert old.read_bytes() == b"old"
    assert not list(small_disk.glob(".*part*"))


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", ["a.nc", "a.png", "a.gif", "a.glb", "a.html", "a.pvd"])
def test_nul_in_a_path_is_an_error_with_a_name(sol, tmp_path, name):
    with pytest.raises(InputError, match=r"NUL|cannot be written"):
        WRITERS[name](sol, tmp_path / f"a\0{name}")


@pytest.mark.parametrize("given", [None, 1.0, b"a.nc", ["a.nc"]])
def test_what_is_no_path_is_refused_by_name(sol, given):
    for use in (fm.load, fm.meshes.read, sol.to_netcdf, lambda path: fm.write_vtk(sol, path)):
        with pytest.raises(InputError, match=r"the path is .*; it must be a text or a Path"):
            use(given)


def test_an_array_in_place_of_a_name_or_an_equilibrium_is_refused_by_name(sol):
    for use in (lambda: sol[np.zeros(2)], lambda: sol.peak(np.zeros(2))):
        with pytest.raises(FlexmbError, match="has no signal array"):
            use()
    with pytest.raises(InputError, match=r"start is array\("):
        fm.simulate(fm.mechanisms.slider_crank(), t_end=1e-3, start=np.zeros(2))


def test_nul_in_a_name_is_refused_where_it_is_given():
    with pytest.raises(InputError, match=r"NUL|it must be a non-empty string"):
        fm.Mechanism("a\0b", [])


@pytest.mark.slow
def test_letters_that_the_system_has_not_are_refused_by_name(tmp_path):
    code = "import flexmb as fm; fm.simulate(fm.mechanisms.slider_crank(), t_end=1e-4).to_netcdf('\\xfc.nc')"
    plain = {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C", "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **plain}, cwd=tmp_path, capture_output=True, check=False
    )
    assert done.returncode == 0 or b"InputError" in done.stderr.splitlines()[-1]


def test_links_are_followed_and_devices_stay(tmp_path):
    real, link = tmp_path / "real.txt", tmp_path / "link.txt"
    real.write_text("old")
    link.symlink_to(real)
    with whole_file(link) as part:
        part.write_text("new")
    assert (link.is_symlink(), real.read_text()) == (True, "new")
    with whole_file(Path("/dev/null")) as part:
        assert str(part) == "/dev/null"


def test_more_instants_than_the_memory_holds_are_refused_before_the_run():
    with pytest.raises(InputError, match=r"save asks for 1e\+09 instants of .* GB\. Save fewer"):
        fm.simulate(fm.mechanisms.slider_crank(), t_end=1e-3, save=10**9)


@pytest.mark.parametrize("save", ["steps", 10**5])
@pytest.mark.parametrize("sampled", [False, True])
def test_a_run_whose_rows_fill_the_memory_ends_with_a_status(save, sampled, monkeypatch):
    """With 20 kB beside the rows, the run stops where these are full, before the system ends the process."""
    model = servo().mechanism if sampled else fm.mechanisms.slider_crank()
    monkeypatch.setattr(saving, "free_memory", lambda: 2e4, raising=False)
    monkeypatch.setattr(saving, "SURE_SIZE", 0.0)
    sol = fm.simulate(model, t_end=2.0, step=1e-4, save=save, signals=["energy.kinetic"], max_steps=30_000)
    assert not sol.ok
    assert f"{len(sol.time):,} saved instants fill the memory; save fewer instants or signals, at t = " in sol.status
    assert 3e4 < sol.values.nbytes + sol.time.nbytes <= 8e4  # 0.8 of the rows and what is free beside them
    assert np.isfinite(sol.values).all()


@pytest.mark.slow
def test_free_memory_is_that_of_the_system():
    """Touched pages are taken from it."""
    before = saving.free_memory()
    taken = np.ones(1 << 25)
    after = saving.free_memory()
    assert before == after == np.inf or (0.0 < after < before and 0.5 < (before - after) / taken.nbytes < 2.0)


def test_a_run_with_a_sampled_controller_writes_checkpoints(tmp_path, monkeypatch):
    written = []
    monkeypatch.setattr(Checkpoints, "write", lambda self, run: written.append(float(run.flow.clock.t)))
    servo(checkpoint=tmp_path / "run.nc", checkpoint_every=0.0)
    assert len(written) > 100  # one a sample; before only where two blocks lay between two samples


def test_slow_writes_do_not_take_all_the_time_of_a_run(tmp_path, monkeypatch):
    """Before, each of 200 samples wrote a checkpoint as soon as one write took longer than the time between two."""
    written = []
    monkeypatch.setattr(Solution, "to_netcdf", lambda self, path: written.append(time.sleep(0.11)))
    began = time.monotonic()
    servo(checkpoint=tmp_path / "run.nc", checkpoint_every=0.1)
    took = time.monotonic() - began
    assert len(written) <= took / 0.21 + 1.0  # a write and a tenth of a second between two
    assert len(written) < 100


def test_a_checkpoint_that_cannot_be_removed_is_noted(tmp_path, monkeypatch):
    path = tmp_path / "run.nc"
    refused = OSError(errno.EROFS, "Read-only file system")

    def unlink(self, missing_ok=False):
        if self == path:
            raise refused

    monkeypatch.setattr("pathlib.Path.unlink", unlink)
    path.write_text("of a run before")
    sol = crank(checkpoint=path)
    assert sol.ok
    assert any("run.nc' cannot be removed (Read-only file system)" in note for note in sol.notes)
    monkeypatch.undo()
    (tmp_path / "file").write_text("")
    assert crank(checkpoint=tmp_path / "file" / "run.nc").ok


@pytest.mark.slow
def test_the_checkpoint_stays_until_the_results_are_on_disk(tmp_path, monkeypatch, capsys):
    """The disk is full when the command writes its results: a call with --resume has them all."""
    real, full = os.fsync, OSError(errno.ENOSPC, "No space left on device")

    def fsync(file):
        if "checkpoint" not in Path(f"/proc/self/fd/{file}").readlink().name:
            raise full
        real(file)

    words = ["run", "slider-crank", "--clearance", "0.5mm", "--t-end", "5ms", "--no-plots", "--no-vtk", "--no-report"]
    words += ["--out", str(tmp_path), "--quiet", "--checkpoint", "0s"]
    monkeypatch.setattr("flexmb.run.run.FIRST_BLOCK_UPDATES", 200)
    monkeypatch.setattr("os.fsync", fsync)
    assert main(words) == 2
    assert "No space left on device" in (said := capsys.readouterr().err)
    assert "is kept: go on from it, --resume" in said
    checkpoint = tmp_path / "slider-crank.checkpoint.nc"
    assert checkpoint.is_file()
    monkeypatch.undo()
    assert main([*words, "--resume"]) == 0
    assert not checkpoint.exists()
    again = fm.simulate(fm.mechanisms.slider_crank(clearance=5e-4), t_end=0.005)
    assert np.array_equal(fm.load(tmp_path / "slider-crank.nc").values, again.values)


def test_the_second_process_imports_nothing_from_the_working_folder(tmp_path):
    (tmp_path / "numpy.py").write_text("open('executed', 'w')\nraise SystemExit")
    command = ahead.command(["flexmb.kernels.copy"])
    command[command.index("-c") + 1] = "import numpy; print(numpy.__file__)"
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert not (tmp_path / "executed").exists()
    assert str(tmp_path) not in done.stdout


@pytest.mark.parametrize("copies", [10, pytest.param(200, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", ["gmsh", "gmsh22"])
def test_damaged_meshes_are_refused_by_name(tmp_path, kind, copies):
    """Binary files of gmsh have no checksum: a hit in a coordinate is another mesh, all else is refused."""
    meshio = pytest.importorskip("meshio")
    points = np.array([(x, y, 0.0) for y in range(4) for x in range(4)], dtype=float)
    cells = [[k, k + 1, k + 5, k + 4] for k in (0, 1, 2, 4, 5, 6, 8, 9, 10)]
    path, rng = tmp_path / "plate.msh", random.Random(copies)
    meshio.write(path, meshio.Mesh(points, [("quad", np.array(cells))]), file_format=kind, binary=True)
    content, refused = path.read_bytes(), 0
    for _ in range(copies):
        path.write_bytes(damaged(content, rng))
        try:
            fm.meshes.read(path)
        except FlexmbError:
            refused += 1
    assert refused > 0.5 * copies
    print(f"{refused} of {copies} damaged meshes refused")


def test_a_mesh_of_abaqus_without_the_kind_of_its_cells_is_refused_by_name(tmp_path):
    path = tmp_path / "plate.inp"
    path.write_text("*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n*ELEMENT, YPE=B31\n1, 1, 2\n")
    with pytest.raises(FileFormatError, match=r"plate\.inp: not a mesh that meshio can read .*TYPE not found"):
        fm.meshes.read(path)


def test_a_result_without_its_checksum_is_refused_where_bytes_stand_behind_its_data(sol, tmp_path):
    """A zeroed last page takes the checksum along, and the last numbers."""
    path = sol.to_netcdf(tmp_path / "run.nc")
    content = path.read_bytes()
    path.write_bytes(content[:-4096] + bytes(4096))
    with pytest.raises(FileFormatError, match="does not agree with its checksum"):
        fm.load(path)
    path.write_bytes(content[:-31])  # as other programs write it
    assert np.array_equal(fm.load(path).values, sol.values)
    assert io.BytesIO(content).getvalue()[-31:-16] == b"flexmb-blake2b:"
