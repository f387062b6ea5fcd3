"""Runs that are ended from outside go on from their checkpoint as if nothing had happened."""

import errno
import os
import random
import resource
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from cases import slow_where

import flexmb as fm
from flexmb.dynamics.jobs import files
from flexmb.errors import FileFormatError, InputError
from flexmb.run import run as run_module
from flexmb.run.checkpoint import Checkpoints
from flexmb.run.run import Interruption

WORN = {"clearance": 5e-4}
LONG = {"periods": 1, "save": 200}


def worn():
    """A slider-crank with clearance."""
    return fm.mechanisms.slider_crank(**WORN)


def same(one, other):
    """Whether two solutions are equal to the last bit: signals, peaks, contact intervals, statistics."""
    rows = one.contacts.rows, other.contacts.rows
    assert np.array_equal(one.time, other.time)
    assert np.array_equal(one.values, other.values)
    assert np.array_equal(one.peaks.values, other.peaks.values)
    assert np.array_equal(one.peaks.times, other.peaks.times)
    assert np.array_equal(*rows, equal_nan=True)
    assert one.status == other.status
    assert one.notes == other.notes
    counts = ("steps", "rejected", "newton_iterations", "evaluations", "smallest_step", "largest_step")
    assert [getattr(one.stats, name) for name in counts] == [getattr(other.stats, name) for name in counts]


class Killed(BaseException):
    """Stands for the end of the process."""


@pytest.fixture
def small_blocks(monkeypatch):
    """Blocks of some steps, so that there are many moments at which a run can be cut."""
    monkeypatch.setattr(run_module, "BLOCK_SECONDS", 1e-4)
    monkeypatch.setattr(run_module, "FIRST_BLOCK_UPDATES", 200)


@pytest.mark.quick(1)
@pytest.mark.parametrize("blocks", [pytest.param(1, marks=pytest.mark.slow), 40])
@pytest.mark.parametrize(
    "options",
    [{}, {"save_from_period": 0.5}, {"signals": ["slider.*"], "save": "steps"}, {"method": fm.Newmark.hht(0.05)}],
    ids=["whole", "second half", "some signals", "HHT"],
)
def test_a_run_that_was_killed_goes_on(tmp_path, monkeypatch, small_blocks, blocks, options):
    whole = fm.simulate(worn(), **{**LONG, **options})
    path = tmp_path / "run.nc"
    after_blocks(monkeypatch, blocks, Killed)
    with pytest.raises(Killed):
        fm.simulate(worn(), **{**LONG, **options}, checkpoint=path)
    monkeypatch.undo()
    same(fm.simulate(worn(), **{**LONG, **options}, checkpoint=path, resume=True), whole)
    assert not path.exists()  # the run has reached its end


def servo(sample):
    """A motor on a rotor under a PID law with integral, filter and limit; the motor's current is a state, too."""
    body = fm.RigidBody("rotor", at=(0.0, 0.0), mass=1.0, inertia=2e-3)
    pid = fm.PID("pid", "rotor.omega", target=20.0, kp=0.3, ki=2.0, limit=10.0, sample=sample)
    given = {"resistance": 2.0, "inductance": 5e-3, "torque_constant": 0.05, "gear_ratio": 3.0}
    motor = fm.controllers.DCMotor("motor", "rotor.omega", "shaft", voltage="pid.output", **given)
    axis = fm.Revolute("axis", fm.GROUND, body, at=(0.0, 0.0))
    return fm.Mechanism("rotor", [body, axis, fm.Torque("shaft", body, 1.0), motor, pid])


def valve(**pair):
    """An eccentric disc and a follower under a spring that is too weak for it."""
    turn, e, R = np.linspace(0.0, 2.0 * np.pi, 61)[:-1], 0.01, 0.03
    disc = fm.ClosedCurve(np.column_stack([e + R * np.cos(turn), R * np.sin(turn)]))
    cam = fm.RigidBody("cam", at=(0.0, 0.0), mass=0.5, inertia=1e-3)
    follower = fm.RigidBody("follower", at=(0.0, R), mass=0.3, inertia=1e-4)
    return fm.Mechanism("valve", [
        cam, follower, fm.Revolute("axis", fm.GROUND, cam, at=(0.0, 0.0)),
        fm.Prismatic("guide", fm.GROUND, follower, along=(0.0, 1.0)),
        fm.CurveOnCurve("tappet", cam, disc, follower, fm.Line((-0.05, R), (0.05, R)), **pair),
        fm.SpringDamper("spring", fm.GROUND, follower, at=(0.0, 0.2), to=(0.0, R), stiffness=2000.0, free_length=0.2),
        fm.Drive("motor", "axis", fm.ConstantSpeed(200.0)),
    ])  # fmt: skip


def block():
    """A block of two outlines that falls onto an edge and tumbles on the ground."""
    ground = fm.cams.Outline(((-1.0, -0.2), (1.0, -0.2), (1.0, 0.0), (-1.0, 0.0)))
    own = fm.cams.Outline(((-0.05, 0.01), (0.05, 0.02), (0.04, 0.07), (-0.06, 0.06)), (0.0, 0.0, 0.3, 0.0))
    body = fm.RigidBody("block", at=(0.0, 0.04), mass=2.0, inertia=2e-3, velocity=(0.3, 0.0, 0.0))
    law, rubbing = fm.HuntCrossley(1e7, restitution=0.8), fm.ModifiedCoulomb(0.3, 1e-4, 1e-3)
    pair = fm.cams.OutlineOnOutline("floor", fm.GROUND, ground, body, own, normal=law, friction=rubbing)
    return fm.Mechanism("block", [body, pair], gravity=(0.0, -9.81))


PARTS = {
    "controllers": (lambda: servo(None), 0.2),
    "sampled controllers": (lambda: servo(0.02), 0.2),
    "cam that lifts off": (
        lambda: valve(normal=fm.LankaraniNikravesh(1e8, restitution=0.8), friction=fm.ModifiedCoulomb(0.1, 1e-4, 1e-2)),
        0.06,
    ),
    "ideal cam": (lambda: valve(friction=fm.friction.SmoothCoulomb(0.1, v0=1e-2)), 0.06),
    "outlines": (block, 0.3),
}


@pytest.mark.quick(1)
@pytest.mark.filterwarnings("ignore::flexmb.errors.RestitutionWarning")
@pytest.mark.parametrize("kind", slow_where(lambda n: n in ("controllers", "ideal cam"), PARTS))
def test_runs_with_controllers_and_cams_that_were_killed_go_on(tmp_path, monkeypatch, small_blocks, kind):
    make, t_end = PARTS[kind]
    whole = fm.simulate(make(), t_end=t_end, save=100)
    assert whole.ok, whole.status
    path = tmp_path / "run.nc"
    after_blocks(monkeypatch, 2, Killed)
    with pytest.raises(Killed):
        fm.simulate(make(), t_end=t_end, save=100, checkpoint=path)
    monkeypatch.undo()
    same(fm.simulate(make(), t_end=t_end, save=100, checkpoint=path, resume=True), whole)


def test_a_run_from_a_restart_goes_on_from_its_own_restart_alone(tmp_path, monkeypatch, small_blocks):
    half, other = (fm.simulate(worn(), periods=part, save=50) for part in (0.5, 0.25))
    path, end = tmp_path / "run.nc", {"periods": 1.5, "save": 200}
    whole = fm.simulate(worn(), **end, restart=half.restart)
    after_blocks(monkeypatch, 20, Killed)
    with pytest.raises(Killed):
        fm.simulate(worn(), **end, restart=half.restart, checkpoint=path)
    monkeypatch.undo()
    with pytest.raises(InputError, match="belongs to a run with restart = "):
        fm.simulate(worn(), **end, restart=other.restart, checkpoint=path, resume=True)
    same(fm.simulate(worn(), **end, restart=half.restart, checkpoint=path, resume=True), whole)


def test_default_steps_are_the_same_steps_when_they_are_written_out(tmp_path, monkeypatch, small_blocks):
    path = tmp_path / "run.nc"
    after_blocks(monkeypatch, 5, Killed)
    with pytest.raises(Killed):
        fm.simulate(worn(), **LONG, checkpoint=path)
    monkeypatch.undo()
    same(fm.simulate(worn(), **LONG, step=fm.Adaptive(), checkpoint=path, resume=True), fm.simulate(worn(), **LONG))


def test_a_damaged_checkpoint_says_what_to_do(tmp_path):
    path = tmp_path / "run.nc"
    path.write_bytes(b"no checkpoint")
    with pytest.raises(FileFormatError, match="Remove this checkpoint; the run then starts anew") as seen:
        fm.simulate(worn(), **LONG, checkpoint=path, resume=True)
    assert "again" not in str(seen.value)  # advice of `load`, which does not hold here
    with pytest.raises(FileFormatError, match="a folder"):
        fm.load(tmp_path)


def after_blocks(monkeypatch, blocks, error):
    """Write a checkpoint after some blocks of steps, and raise an error then."""
    count = []

    def stop(checkpoints, run):
        count.append(1)
        if len(count) == blocks:
            checkpoints.write(run)
            raise error

    monkeypatch.setattr(Checkpoints, "after_block", stop)


def test_a_checkpoint_of_another_run_is_refused(tmp_path, monkeypatch, small_blocks):
    path = tmp_path / "run.nc"
    _interrupted(path, monkeypatch)
    with pytest.raises(InputError, match=r"belongs to a run with end = .*Resume with the same arguments"):
        fm.simulate(worn(), periods=3, save=200, checkpoint=path, resume=True)
    other = fm.mechanisms.slider_crank(clearance=4e-4)
    with pytest.raises(InputError, match="restart is of another mechanism"):
        fm.simulate(other, **LONG, checkpoint=path, resume=True)
    fm.simulate(worn(), t_end=1e-3).to_netcdf(path)
    with pytest.raises(FileFormatError, match="is no checkpoint; it is a finished result"):
        fm.simulate(worn(), **LONG, checkpoint=path, resume=True)


def test_a_checkpoint_of_other_start_velocities_is_refused(tmp_path, monkeypatch, small_blocks):
    """The fingerprint of a mechanism leaves them out, since a restart replaces them: rows of two runs were mixed."""

    def thrown(speed):
        body = fm.RigidBody("ball", at=(0.0, 0.0), mass=1.0, inertia=1.0, velocity=(speed, 0.0, 0.0))
        return fm.Mechanism("thrown", [body], gravity=(0.0, -9.81))

    path, options = tmp_path / "run.nc", {"t_end": 1.0, "step": 1e-4, "save": 100}
    after_blocks(monkeypatch, 3, Killed)
    with pytest.raises(Killed):
        fm.simulate(thrown(1.0), **options, checkpoint=path)
    monkeypatch.undo()
    with pytest.raises(InputError, match="belongs to a run with start velocities = "):
        fm.simulate(thrown(2.0), **options, checkpoint=path, resume=True)
    same(fm.simulate(thrown(1.0), **options, checkpoint=path, resume=True), fm.simulate(thrown(1.0), **options))


def test_a_checkpoint_of_another_equilibrium_is_refused(tmp_path, monkeypatch, small_blocks):
    """Texts of equilibria show numbers of coordinates and reactions alone, which may be equal."""
    body = fm.RigidBody("arm", at=(0.5, 0.0), mass=1.0, inertia=1.0)
    arm = fm.Mechanism("arm", [body, fm.Revolute("J", fm.GROUND, body, at=(0.0, 0.0))], gravity=(0.0, -9.81))
    down = fm.static_equilibrium(arm)
    turned = replace(down, q=down.q + np.array([0.0, 0.0, 2.0 * np.pi]))
    path, options = tmp_path / "run.nc", {"t_end": 1.0, "step": 1e-4, "save": 100}
    after_blocks(monkeypatch, 3, Killed)
    with pytest.raises(Killed):
        fm.simulate(arm, **options, start=down, checkpoint=path)
    monkeypatch.undo()
    assert repr(turned) == repr(down)
    with pytest.raises(InputError, match="belongs to a run with start = "):
        fm.simulate(arm, **options, start=turned, checkpoint=path, resume=True)


def _interrupted(path, monkeypatch):
    """Write a checkpoint of a run that is ended from the keyboard."""
    after_blocks(monkeypatch, 5, KeyboardInterrupt)
    sol = fm.simulate(worn(), **LONG, checkpoint=path)
    assert "Interrupted from the keyboard" in sol.status
    assert not sol.ok
    assert path.is_file()


def test_a_run_that_is_interrupted_leaves_its_checkpoint(tmp_path, monkeypatch, small_blocks):
    path = tmp_path / "run.nc"
    _interrupted(path, monkeypatch)
    same(fm.simulate(worn(), **LONG, checkpoint=path, resume=True), fm.simulate(worn(), **LONG))


@pytest.mark.parametrize(("given", "words"), [("", "'', empty"), (".", "'.', a folder"), ("there", "there', a folder")])
def test_a_folder_or_no_name_is_refused_before_the_run(tmp_path, monkeypatch, given, words):
    """They were noted at the first checkpoint, so after 30 s, or when the run was killed."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there").mkdir()
    checkpoint = tmp_path / given if given == "there" else given
    for resume in (False, True):
        with pytest.raises(InputError, match=f"checkpoint: the path is .*{words}. Give a file"):
            fm.simulate(fm.mechanisms.slider_crank(), t_end=1e9, checkpoint=checkpoint, resume=resume)


def test_a_checkpoint_that_cannot_be_written_is_noted(tmp_path, monkeypatch, small_blocks):
    def full(file):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    sol = fm.simulate(worn(), **LONG, checkpoint=tmp_path / "run.nc", checkpoint_every=0.0)
    assert sol.ok
    assert any("No checkpoint since t = " in note and "No space left on device" in note for note in sol.notes)


def command(folder, *more):
    """A run of some seconds on the command line."""
    words = ["run", "slider-crank", "--clearance", "0.5mm", "--periods", "600", "--save", "20", "--out", str(folder)]
    return [sys.executable, "-m", "flexmb", *words, "--no-plots", "--no-vtk", "--quiet", *more]


@pytest.mark.slow
@pytest.mark.parametrize("kill", [signal.SIGTERM, signal.SIGKILL])
def test_a_command_that_is_killed_goes_on(tmp_path, kill):
    path = tmp_path / "slider-crank.checkpoint.nc"
    process = subprocess.Popen(command(tmp_path, "--checkpoint", "0.2s"))
    for _ in range(600):
        time.sleep(0.1)
        if path.exists() or process.poll() is not None:
            break
    assert process.poll() is None
    process.send_signal(kill)
    code = process.wait(timeout=60)
    assert code == (1 if kill == signal.SIGTERM else -signal.SIGKILL)
    if kill == signal.SIGTERM:
        assert "Ended by SIGTERM" in fm.load(tmp_path / "slider-crank.nc").status
    assert path.is_file()
    assert subprocess.run(command(tmp_path, "--resume"), check=True).returncode == 0
    other = tmp_path / "whole"
    subprocess.run(command(other), check=True)
    same(fm.load(tmp_path / "slider-crank.nc"), fm.load(other / "slider-crank.nc"))


@pytest.mark.slow
def test_fifty_kills(tmp_path):
    """SIGKILL at 50 random moments of one run: nothing is lost beyond the last checkpoint, and no bit changes."""
    rng, moments = random.Random(5), 0
    while moments < 50:
        process = subprocess.Popen(command(tmp_path, "--checkpoint", "0.05s", "--resume"))
        try:
            assert process.wait(timeout=rng.uniform(0.6, 2.0)) == 0
            break
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            moments += 1
    else:
        subprocess.run(command(tmp_path, "--resume"), check=True)
    other = tmp_path / "whole"
    subprocess.run(command(other), check=True)
    same(fm.load(tmp_path / "slider-crank.nc"), fm.load(other / "slider-crank.nc"))


@pytest.mark.slow
def test_a_full_disk_loses_nothing(tmp_path):
    """A process that may not write files above 4 kB gets an error, and the old result stays."""
    path = tmp_path / "slider-crank.nc"
    fm.simulate(worn(), t_end=1e-4).to_netcdf(path)
    before = path.read_bytes()
    short = [sys.executable, "-m", "flexmb", "run", "slider-crank", "--t-end", "1ms", "--out", str(tmp_path)]

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [*short, "--no-plots", "--no-vtk"],
        preexec_fn=limit,
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert done.returncode == 2, done
    assert "cannot be written (File too large)" in done.stderr
    assert "Traceback" not in done.stderr
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_every_flipped_bit_is_seen(tmp_path):
    path = fm.simulate(worn(), t_end=1e-3, save=5).to_netcdf(tmp_path / "run.nc")
    content = path.read_bytes()
    assert files.read_sealed(path) == content
    end = len(content) - len(files.SEAL) - files.DIGEST  # a hit in the mark of the checksum leaves the content whole
    for place in random.Random(3).sample(range(end), 60):
        damaged = bytearray(content)
        damaged[place] ^= 1 << (place % 8)
        path.write_bytes(damaged)
        with pytest.raises(FileFormatError, match=r"run\.nc.*damaged"):
            fm.load(path)


def test_truncated_files_are_refused(tmp_path):
    path = fm.simulate(worn(), t_end=1e-3, save=5).to_netcdf(tmp_path / "run.nc")
    content = path.read_bytes()
    for length in (0, 1, 100, len(content) // 2, len(content) - files.DIGEST - len(files.SEAL) - 1):
        path.write_bytes(content[:length])
        with pytest.raises(FileFormatError, match=r"run\.nc"):
            fm.load(path)


def test_a_file_that_declares_a_terabyte_is_refused(tmp_path):
    import h5py

    path = fm.simulate(worn(), t_end=1e-3, save=5).to_netcdf(tmp_path / "bomb.nc")
    with h5py.File(path, "r+") as file:
        del file["restart/q"]
        file.create_dataset("restart/q", shape=(10**11,), dtype="f8", chunks=(10**6,))
    began = time.perf_counter()
    with pytest.raises(FileFormatError, match="more than 50 times its own size"):
        fm.load(path)
    assert time.perf_counter() - began < 5.0


def runs_until_one_is_interrupted():
    """Short runs, of one block each; the last status, or "" when all went through."""
    for _ in range(10_000):
        sol = fm.simulate(worn(), t_end=1e-3)
        if not sol.ok:
            return sol.status
    return ""


def test_ctrl_c_in_the_last_block_is_not_lost():
    """A loop of runs of one block each notices Ctrl-C at once, wherever it comes."""
    fm.simulate(worn(), t_end=1e-3)
    ours = signal.signal(signal.SIGINT, signal.default_int_handler)  # a worker of pytest may ignore SIGINT
    before = signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        assert "Interrupted from the keyboard" in runs_until_one_is_interrupted()
    except KeyboardInterrupt:
        pass  # it came between two runs, or while one was made ready
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
        signal.signal(signal.SIGINT, ours)


def test_a_signal_after_the_last_block_is_not_lost():
    with pytest.raises(KeyboardInterrupt), Interruption([signal.SIGINT]):
        signal.raise_signal(signal.SIGINT)
    with Interruption([signal.SIGINT]) as nothing:
        pass
    assert nothing.asked is None
