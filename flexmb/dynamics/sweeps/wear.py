"""Wear over many turns: a few of them simulated, the depths carried on between them with control of the error."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from flexmb import checks
from flexmb.arguments import checked
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.dynamics.sweeps.parameter_sweep import dataset_of
from flexmb.dynamics.sweeps.store import STATUS, Column, Record, opened
from flexmb.engine.compiled.digest import digest
from flexmb.engine.step.method import Method
from flexmb.errors import InputError
from flexmb.late import xr
from flexmb.model.mechanism import Mechanism
from flexmb.parts.wear.worn_joint import WornJoint
from flexmb.program import compiler
from flexmb.run.simulate import Step, simulate
from flexmb.version import installed_version

KIND = "wear"  # kind of the dataset
# Largest depth that is carried on at once, over the clearance [1]; beyond it ridges grow between the angles.
LARGEST_INCREMENT = 0.05
SMALL_DEPTH = 0.05  # depth over the clearance [1] that counts beside the largest one in the error of an increment
# Factor of a new increment beside the one that would just do, and its least and largest change.
SAFETY, LEAST_FACTOR, MOST_FACTOR = 0.8, 0.3, 2.0
MOST_RUNS = 5000  # largest number of runs of a study, if no other one is given
NARROW = 3  # width of a pit, in places of the profile, up to which its depth is that of the places, not of the surface
FORCE = "normal_force"  # ending of the signals of normal forces
Depths = Mapping[str, np.ndarray]  # depths by joint [m]


class Rate(NamedTuple):
    """Wear of a turn by joint: depths [m], volume [m^3]; largest normal force of the turns [N]."""

    depths: Depths
    volume: dict[str, float]
    force: dict[str, float]


class StoppedError(Exception):
    """A run that did not reach its end; its status."""


@dataclass(frozen=True)
class Turns:
    """The runs of a wear study: mechanism, turns before and of each measurement, step and method."""

    mechanism: Mechanism  # with its worn joints
    joints: Mapping[str, WornJoint]  # the worn joints by name
    settle: int  # settle, sample: turns that are left out, and turns whose wear is taken
    sample: int
    options: Mapping[str, Any]  # step and method of `simulate`

    def worn(self, depths: Depths) -> Mechanism:
        """The mechanism with some depths."""
        mechanism = self.mechanism
        for name, joint in self.joints.items():
            mechanism = mechanism.with_part(joint.with_depths(depths[name]))
        return mechanism

    def rate(self, depths: Depths) -> Rate:
        """Wear of a turn with the present depths."""
        mechanism = self.worn(depths)
        worn = _wearing(mechanism)
        turns: Any = {"periods": self.settle + self.sample, "save_from_period": self.settle}
        signals = [f"{name}.{signal}" for name, joint in worn.items() for signal in joint.wear_signals]
        sol = simulate(mechanism, **turns, save="steps", signals=signals, **self.options)
        if not sol.ok:
            raise StoppedError(sol.status)
        found = {name: joint.worn_in(sol) for name, joint in worn.items()}
        period = float(sol.time[-1]) / (self.settle + self.sample)
        depths = {name: worn[name].smoothed(wear.depths) * period / wear.time for name, wear in found.items()}
        volumes = {name: wear.volume * period / wear.time for name, wear in found.items()}
        forces = {name: [f"{name}.{one}" for one in worn[name].wear_signals if one.endswith(FORCE)] for name in worn}
        peaks = {name: max(sol.peak(one).value for one in several) for name, several in forces.items()}
        return Rate(depths, volumes, peaks)


class Life:
    """Depths over turns."""

    # tolerance : of an increment, over the largest depth [1]; most : largest number of runs.
    def __init__(self, turns: Turns, tolerance: float, most: int) -> None:
        self.turns, self.tolerance, self.most = turns, tolerance, most
        self.depths: Depths = {name: joint.depths for name, joint in turns.joints.items()}
        self.error = dict.fromkeys(turns.joints, 0.0)  # sum of the errors of all increments by joint [m]
        self.stride, self.runs = np.inf, 0  # turns of the next increment, number of runs

    def rate(self, depths: Depths) -> Rate:
        """Wear of a turn, counted."""
        if self.runs >= self.most:
            text = f"The study took {self.runs} runs (most_runs)."
            raise StoppedError(f"{text} Resume its store with more, or wear less.")
        self.runs += 1
        return self.turns.rate(depths)

    def fastest(self, rate: Rate) -> tuple[float, str]:
        """Largest depth that a turn wears, over the clearance of its joint, and the joint."""
        joints = self.turns.joints.items()
        return max((float(rate.depths[name].max()) / joint.clearance, name) for name, joint in joints)

    def bound(self, rate: Rate) -> float:
        """Turns in which no depth grows by more than `LARGEST_INCREMENT`."""
        fastest, _ = self.fastest(rate)
        return LARGEST_INCREMENT / fastest if fastest > 0.0 else np.inf

    def foresee(self, label: str, turns: float, rate: Rate, seconds: float) -> None:
        """Refuse a study of more runs than it may take, of `seconds` each, or of turns that wear too much."""
        fastest, name = self.fastest(rate)
        least, text = 2.0 * turns / self.bound(rate), f"{label}: a turn wears {fastest:.2g} of the clearance of {name}"
        if fastest > LARGEST_INCREMENT:
            text += f"; within a run surfaces stay as they are, so it may be {LARGEST_INCREMENT:g} at most."
            raise InputError(f"{text} Give a smaller coefficient of wear; one without unit is divided by the hardness.")
        if self.runs + least > self.most:
            text += f", and no increment wears more than {LARGEST_INCREMENT:g} of it: {turns:g} turns take at least"
            text += f" {least:.0f} runs of {seconds:.2g} s, most_runs is {self.most}. Give fewer turns,"
            raise InputError(f"{text} a smaller coefficient of wear, or most_runs={2.0 * least:.0f}.")

    def advance(self, turns: float, rate: Rate) -> Rate:
        """Carry the depths on by `turns`; the wear of a turn before and after it."""
        left = turns
        while left > 0.0:
            stride = min(self.stride, self.bound(rate), left)
            if stride < left < 2.0 * stride:  # no small rest
                stride = 0.5 * left
            half = {name: h + 0.5 * stride * rate.depths[name] for name, h in self.depths.items()}
            middle = self.rate(half)
            ends = {name: h + 0.5 * stride * middle.depths[name] for name, h in half.items()}
            change = {name: float(np.abs(middle.depths[name] - rate.depths[name]).max()) for name in ends}
            errors = {name: 0.5 * stride * change[name] for name in ends}
            sizes = {name: float(h.max()) + SMALL_DEPTH * self.turns.joints[name].clearance for name, h in ends.items()}
            ratio = max(errors[name] / (self.tolerance * sizes[name]) for name in ends)
            factor = SAFETY / ratio**0.5 if ratio > 0.0 else MOST_FACTOR
            self.stride = stride * min(max(factor, LEAST_FACTOR), MOST_FACTOR)
            if ratio > 1.0 and stride > 1.0:
                continue
            self.depths, left = ends, left - stride
            self.error = {name: self.error[name] + errors[name] for name in ends}
            rate = self.rate(self.depths)
        return rate

    def results(self, rate: Rate) -> dict[str, Any]:
        """Results of the present turn by column."""
        found: dict[str, Any] = {"stride": self.stride, "runs": float(self.runs)}
        for name, now in _wearing(self.turns.worn(self.depths)).items():
            found |= {f"{name}.{face}_profile": h for face, h in _profiles(now).items()}
            numbers = {"volume": now.volume, "wear_rate": rate.volume[name], "clearance": now.half_play}
            numbers |= {"peak_force": rate.force[name], "error": self.error[name]}
            found |= {f"{name}.{one}": value for one, value in numbers.items()}
        return found

    def go_on(self, record: Record, k: int) -> None:
        """Take the state of a recorded turn."""
        for name, joint in self.turns.joints.items():
            known = [record.at((k,), f"{name}.{face}_profile") for face in joint.wearing_faces]
            self.depths = {**self.depths, name: np.concatenate(known)}
            self.error[name] = float(record.at((k,), f"{name}.error"))
        self.stride, self.runs = float(record.at((k,), "stride")), int(record.at((k,), "runs"))


def _columns(joints: Mapping[str, WornJoint]) -> Iterator[Column]:
    """Columns of the results."""
    yield Column("stride", units="1")
    yield Column("runs", units="1")
    for name, joint in joints.items():
        for face in joint.FACES:
            yield Column(f"{name}.{face}_profile", dims=(joint.PLACES,), shape=(joint.bins,), units="m")
        units = {"volume": "m3", "wear_rate": "m3", "clearance": "m", "peak_force": "N", "error": "m"}
        yield from (Column(f"{name}.{one}", units=unit) for one, unit in units.items())


def _wearing(mechanism: Mechanism) -> dict[str, WornJoint]:
    """Joints that wear."""
    return {part.name: part.wearing for part in mechanism.parts if part.wearing is not None}


def _profiles(joint: WornJoint) -> dict[str, np.ndarray]:
    """Profiles (bins,) of all surfaces of a joint, 0 of unworn ones [m]."""
    faces = joint.wearing_faces
    known = dict(zip(faces, np.split(joint.depths, len(faces)), strict=True))
    return {face: known.get(face, np.zeros(joint.bins)) for face in joint.FACES}


def _worn_joints(label: str, mechanism: Mechanism) -> dict[str, WornJoint]:
    """Joints that wear, all with the same number of places."""
    joints = _wearing(mechanism)
    if not joints:
        text = f"{label}: no joint of it wears. Give wear to one, e.g."
        raise InputError(f"{text} mech.with_part(mech['B'].worn_by(fm.Archard(bearing=1e-13))).")
    if len({joint.bins for joint in joints.values()}) > 1:
        listed = ", ".join(f"{name} {joint.bins}" for name, joint in joints.items())
        raise InputError(f"{label}: the joints have different numbers of bins ({listed}). Give all the same.")
    return joints


def _notes(joints: Mapping[str, WornJoint]) -> Iterator[str]:
    """Notes on pits that are no wider than a few places of their profile."""
    for name, joint in joints.items():
        middle = joint.bins // 2
        for face, h in _profiles(joint).items():
            apart = np.flatnonzero(np.roll(h, middle - int(h.argmax())) <= 0.5 * h.max())
            width = apart[apart > middle].min(initial=joint.bins) - apart[apart < middle].max(initial=-1) - 1
            if h.any() and width <= NARROW:
                text = f"{name}: the deepest pit of its {face}, {h.max():.3g} m, is {width} of {joint.bins} places wide"
                text += " at half of its depth. This depth is the mean of a place and goes with their number;"
                yield f"{text} volumes do not. Give more bins, until the pit is wider."


@checked
def wear_out(
    mechanism: Mechanism, *, turns: float, keep: int = 20, settle: int = 1, sample: int = 1, tolerance: float = 0.02,
    step: Step | None = None, method: Method | None = None, store: Any = None, resume: bool = False,
    progress: bool = False, most_runs: int = MOST_RUNS,
) -> xr.Dataset:  # fmt: skip
    """Wear of the joints of a mechanism over many turns.

    A turn is a common period of the drives.  A run gives the wear of a turn with the present surfaces; the depths are
    carried on with it by many turns, in an increment of two halves.  The difference of the whole increment from both
    halves is its error, which chooses the increment.  Depths of a turn are smoothed over three angles.

    Parameters
    ----------
    mechanism : mechanism with joints that wear, see `worn_by` of `RevoluteClearance`, `JournalBearing`,
        `PrismaticClearance` and `PinSlotClearance`.
    turns : number of turns.
    keep : number of equal parts of the turns after which the surfaces are kept.
    settle, sample : turns of each run that are left out, and those behind them whose wear is taken.
    tolerance : largest error of an increment over the largest depth, to which 0.05 of the clearance is added [1].
    step, method : of the runs, see `simulate`.
    store : folder that keeps every finished part (zarr); None: no store.
    resume : whether an existing store is continued, to the same bits; otherwise it is refused.
    progress : whether a progress bar with the remaining time is shown.
    most_runs : largest number of runs; a study that will need more is refused after its first run.

    Returns
    -------
    xarray.Dataset : over `turns`, for each joint `B`: `B.bearing_profile`, `B.journal_profile` (depth by "angle"), of
        guides and slots `B.upper_profile`, `B.lower_profile` (by "place", -1/2 to 1/2 of its `worn_length`) [m],
        `B.volume` (lost since new) [m3], `B.wear_rate` (volume of a turn) [m3], `B.clearance` (half of the widest way
        across) [m], `B.peak_force` (largest normal force of the run) [N], `B.error` (sum of the errors of all
        increments) [m]; `stride` (turns of the next increment), `runs`.  `status` says why a study ended early; its
        later rows are NaN.  The attribute `notes` names pits so narrow that their depth depends on `bins`.

    Raises
    ------
    InputError : no joint that wears, joints of different numbers of bins, numbers out of range; wear so strong that
        the turns take more than `most_runs`; an existing store without `resume`, or a store of another study.

    Notes
    -----
    Every run begins in the reference configuration.  Chaotic turns differ from one another: `sample` takes the mean of
    several, and the increments, which are many, average them as well.  No increment deepens a surface by more than 0.05
    of the clearance.

    Equation (16.6) of docs/theory/wear.md.
    """
    checks.instance("wear_out", "mechanism", mechanism, Mechanism, "Mechanism(name, parts)")
    label = f"wear of {mechanism.name!r}"
    number = checks.positive(label, "turns", turns)
    checks.count(label, "settle", settle, least=0)
    for name, value in (("keep", keep), ("sample", sample), ("most_runs", most_runs)):
        checks.count(label, name, value)
    bound = checks.between(label, "tolerance", checks.positive(label, "tolerance", tolerance), 0.0, 1.0)
    joints, program = _worn_joints(label, mechanism), compiler.compile(mechanism)
    turn, periods = compiler.common_period(program), (one.period for one in program.motions[len(program.periods) :])
    odd = [one for one in periods if one and not np.isclose(sample * turn / one, round(sample * turn / one))]
    if odd:
        raise InputError(f"{label}: a load repeats after {odd[0]:g} s; give as many turns of {turn:g} s in sample=.")
    runs = Turns(mechanism, joints, settle, sample, {"step": step, "method": method})
    marks = number * np.arange(keep + 1) / keep
    settings = {"turns": number, "keep": keep, "settle": settle, "sample": sample, "tolerance": bound}
    fingerprint = {"flexmb": installed_version(), "mechanism": digest(mechanism), "runs": digest([step, method])}
    fingerprint |= {name: repr(value) for name, value in settings.items()}
    if resume and store is None:
        raise InputError(f"{label}: resume is True without a store. Give store='out/wear.zarr', where all is kept.")
    store = None if store is None else opened(store, fingerprint, KIND, resume=resume)
    record = Record(("turns",), (keep + 1,), store)
    record.add(_columns(joints))
    record.coordinate("turns", ("turns",), marks, "1")
    for joint in joints.values():
        record.coordinate(joint.PLACES, (joint.PLACES,), joint.places, joint.PLACE_UNIT)
    radii = {f"{name}.{one}": size for name, joint in joints.items() for one, size in joint.sizes.items()}
    axes = [*sorted({joint.PLACES for joint in joints.values()}), "turns"]
    record.describe(name=mechanism.name, kind=KIND, flexmb=installed_version(), axes=axes, joints=list(joints), **radii)
    life = Life(runs, bound, most_runs)
    _study(label, life, record, marks, progress=progress)
    record.describe(notes=list(_notes(_wearing(runs.worn(life.depths)))))
    return dataset_of(record.tables, record.attributes)


def _study(label: str, life: Life, record: Record, marks: np.ndarray, *, progress: bool) -> None:
    """Compute the rows of a record that are not yet there, up to the first one that fails."""
    done = record.done & record.tables["ok"][1]
    first = int(np.argmin(done)) if not done.all() else len(marks)
    if first > 0:
        life.go_on(record, first - 1)
    rate: Rate | None = None
    with ProgressBar(label, len(marks), done=first, shown=progress, of="parts") as bar:
        for k in range(first, len(marks)):
            try:
                if rate is None:
                    begin = perf_counter()
                    rate = life.turns.rate(life.depths) if k > 0 else life.rate(life.depths)
                    life.foresee(label, marks[-1] - marks[max(k - 1, 0)], rate, perf_counter() - begin)
                if k > 0:
                    rate = life.advance(marks[k] - marks[k - 1], rate)
            except (StoppedError, InputError) as stopped:
                if isinstance(stopped, InputError) and k == first:
                    raise
                record.keep((k,), {"ok": False, STATUS: str(stopped)})
                return
            record.keep((k,), {**life.results(rate), "ok": True, STATUS: "done"})
            bar.one_more(ok=True)
