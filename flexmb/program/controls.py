"""Wiring of controls: inputs by their names, the coordinates they depend on, and the order of evaluation."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.kernels import Kernel, signal_kernel
from flexmb.model.contributions import Contributions, ControlContribution, Coordinate, MotionInput
from flexmb.model.law import Motion
from flexmb.model.part import GROUND
from flexmb.model.signal import Signals, hint, resolved
from flexmb.program import program as tables
from flexmb.program.numbering import COORDINATE_SIGNALS, Numbering, kernel_signals, layout, state_coordinates


@signal_kernel
def relative_angle(p, t, q, v, a):
    """Relative rotation of two nodes, 0 in the reference configuration."""
    (drawn,) = p
    return q[1] - q[0] - drawn


@signal_kernel
def relative_rate(p, t, q, v, a):
    """Rate of `relative_angle`."""
    return v[1] - v[0]


@dataclass(frozen=True)
class Source:
    """Source of an input of a control, of one of the kinds of `flexmb.program.program`."""

    kind: int
    coordinates: tuple[Coordinate, ...] = ()  # that the input depends on
    kernel: Kernel | None = None  # signal kernel of a measured input
    p: tuple[float, ...] = ()  # its numbers
    motion: Motion | None = None  # of a prescribed input
    control: str = ""  # whose output is the input
    output: int = 0  # number of that output


@dataclass(frozen=True)
class WiredControl(ControlContribution):
    """Control with the sources of its inputs; a sampled one has none, since a run reads its inputs between steps."""

    sources: tuple[Source, ...] = ()
    load_coordinates: tuple[tuple[Coordinate, ...], ...] = ()  # of the load of each output; none without load

    @property
    def history(self) -> tuple[float, ...]:
        """Start values of the states of a sampled control, and of its outputs."""
        return (*self.start, *(0.0,) * len(self.outputs)) if self.is_sampled else ()

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of the states, then coordinates of the inputs, without the ground."""
        found = dict.fromkeys(state_coordinates(self))
        for source in self.sources:
            found.update(dict.fromkeys(c for c in source.coordinates if c[0] != GROUND.name))
        return tuple(found)

    @property
    def touched(self) -> tuple[Coordinate, ...]:
        """Coordinates that the control couples: its own, and the coordinates of its loads."""
        return (*self.coordinates, *(c for load in self.load_coordinates for c in load))


def wired(contributions: Contributions, number: Numbering, aliases: Mapping[str, str]) -> Contributions:
    """Contributions whose controls are wired, in the order of evaluation; loops and unknown inputs are refused."""
    if not contributions.controls:
        return contributions
    finder = _Finder(contributions, number, aliases)
    found: dict[str, WiredControl] = {}
    # In the order of evaluation: sampled ones first, then each after the controls whose outputs it reads
    ordered = [control for control in contributions.controls if control.sample is not None]
    left = [control for control in contributions.controls if control.sample is None]
    while left:
        names = {control.part for control in left}
        ready = [c for c in left if not names & {other for other, _ in _read_outputs(c, finder)}]
        if not ready:
            outputs = ", ".join(sorted({repr(name) for c in left for _, name in _read_outputs(c, finder)}))
            text = f"{', '.join(c.label for c in left)}: the outputs {outputs} depend on one another at the same"
            text += " instant: an algebraic loop."
            raise ModelError(f"{text} Give one of the controllers sample=, or read a state in place of an output.")
        ordered += ready
        left = [control for control in left if control not in ready]
    for control in ordered:
        sources = () if control.is_sampled else tuple(finder.sources(control, found))
        loads = [finder.loads[name] for name in control.loads]
        none: list[tuple[Coordinate, ...]] = [()] * (len(control.outputs) - len(loads))
        found[control.part] = WiredControl(**vars(control), sources=sources, load_coordinates=(*loads, *none))
    return replace(contributions, controls=tuple(found.values()))


class _Finder:
    """Sources of inputs by their names."""

    def __init__(self, contributions: Contributions, number: Numbering, aliases: Mapping[str, str]) -> None:
        self.signals: Signals = layout(contributions, number.names(), number.n_b).signals
        self.aliases = aliases
        self.known: dict[str, Source] = {}
        for part, node in number.nodes[: number.n_b // 3]:
            stem = f"{part}.{node.name}" if node.name else part
            for kind, signals in zip((tables.COORDINATE, tables.VELOCITY), COORDINATE_SIGNALS[:2], strict=True):
                for axis, (name, _) in enumerate(signals):
                    self.known[f"{stem}.{name}"] = Source(kind, ((part, node.name, axis),))
        for joint in contributions.angles:
            self.known[f"{joint.part}.angle"] = Source(tables.MEASURED, joint.coordinates, relative_angle, joint.p)
            self.known[f"{joint.part}.omega"] = Source(tables.MEASURED, joint.coordinates, relative_rate, joint.p)
        for signal in contributions.signals:
            if not signal.is_mode and not signal.use_of_factor and not signal.place:
                name = f"{signal.part}.{signal.name}"
                self.known[name] = Source(tables.MEASURED, signal.coordinates, signal.kernel, signal.p)
        placed = [one for one in contributions.signals if one.place]
        self.extrema = {f"{one.part}.{name}" for one in placed for name, _ in kernel_signals(one)}
        controls = contributions.controls
        self.outputs = {f"{c.part}.{name}": (c, k) for c in controls for k, name in enumerate(c.outputs)}
        pairs = ((c.part, zip(c.states, state_coordinates(c), strict=False)) for c in controls)
        self.states = {f"{part}.{name}": Source(tables.VELOCITY, (x,)) for part, own in pairs for name, x in own}
        self.loads = {element.part: element.coordinates for element in contributions.elements}
        self.pose, self.number = number.pose(), number

    def name(self, wanted: str) -> str:
        """The name of a signal, by itself or by an alias."""
        return resolved(wanted, self.signals, self.aliases)

    def sources(self, control: ControlContribution, wired: Mapping[str, WiredControl]) -> Iterator[Source]:
        """Sources of the inputs of a control; `wired`: controls that are evaluated before it."""
        for wanted in control.inputs:
            if isinstance(wanted, MotionInput):
                yield Source(tables.MOTION_SPEED if wanted.rate else tables.MOTION_VALUE, motion=wanted.motion)
                continue
            name = self.name(wanted)
            if name in self.outputs:
                other, k = self.outputs[name]
                yield Source(tables.OUTPUT, wired[other.part].coordinates, control=other.part, output=k)
                continue
            source = self.known.get(name) or self.states.get(name)
            if source is None:
                raise self.refusal(control, wanted, name)
            if source.kind == tables.MEASURED and self._needs_acceleration(source):
                text = f"{control.label}: input {wanted!r} depends on accelerations,"
                text += " which depend on the outputs at the same instant: an algebraic loop. Give sample=, so that"
                raise ModelError(f"{text} the controller reads it at instants, or measure a position or a velocity.")
            yield source

    def refusal(self, control: ControlContribution, wanted: str, name: str) -> ModelError:
        """The error of an input that is no signal, or none that a control can read at all times."""
        if name not in self.signals.places:
            text = f"{control.label}: input {wanted!r} is no signal of the mechanism"
            return ModelError(f"{text}. {hint(wanted, self.signals, self.aliases)}")
        if name in self.extrema:
            text = f"{control.label}: input {wanted!r} is the largest of many values, whose place jumps"
            return ModelError(f"{text}. Give sample=, so that the controller reads it at instants.")
        text = f"{control.label}: input {wanted!r} is no function of positions and velocities alone"
        text += " (accelerations, forces and energies depend on the outputs at the same instant). Give sample=, so that"
        return ModelError(f"{text} the controller reads it at instants, or measure a position or a velocity.")

    def _needs_acceleration(self, source: Source) -> bool:
        """Whether a signal kernel gives other values for other accelerations, at a few states."""
        random, kernel = np.random.default_rng(0), source.kernel
        place = [self.pose[k] if k < len(self.pose) else 0.0 for k in self.number.dofs(source.coordinates)]
        p, n = np.array(source.p, dtype=float), len(place)
        for _ in range(3):
            q = np.array(place) + 0.1 * random.uniform(-1.0, 1.0, n)
            v, a = random.uniform(-1.0, 1.0, (2, n))
            with np.errstate(all="ignore"):
                values: Any = [kernel(p, 0.1, q, v, x) for x in (np.zeros(n), a)]  # type: ignore[misc]
            if values[0] != values[1]:
                return True
        return False


def _read_outputs(control: ControlContribution, finder: _Finder) -> Iterator[tuple[str, str]]:
    """Control and name of each output that a control reads."""
    for wanted in control.inputs:
        name = finder.name(wanted) if isinstance(wanted, str) else ""
        if name in finder.outputs:
            yield finder.outputs[name][0].part, name


def samplers(
    controls: Sequence[ControlContribution], wired_controls: Sequence[Any], z: np.ndarray, names: tables.Names
) -> tuple[tables.Sampler, ...]:
    """Controls that act at instants."""
    place = {control.part: int(z[k, tables.BEGIN]) for k, control in enumerate(wired_controls)}
    found = []
    for control in controls:
        if control.sample is None:
            continue
        inputs: list[int | MotionInput] = []
        for wanted in control.inputs:
            read = isinstance(wanted, str) and names.signals.places.get(resolved(wanted, names.signals, names.aliases))
            if read is None:
                text = f"{control.label}: input {wanted!r} is no signal of the mechanism"
                raise ModelError(f"{text}. {hint(str(wanted), names.signals, names.aliases)}")
            inputs.append(wanted if isinstance(wanted, MotionInput) else read)
        own, sizes = (control.part, control.kernel, control.p), (len(control.states), len(control.outputs))
        found.append(tables.Sampler(*own, tuple(inputs), control.sample, *sizes, place[control.part], control.settled))
    return tuple(found)
