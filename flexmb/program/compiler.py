"""Compiler from a mechanism to a program: wiring of controls, check of kernels, period of the drives."""

import gc
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from flexmb.arguments import checked
from flexmb.engine.compiled.code_cache import ours
from flexmb.errors import USER_ERRORS, InputError, KernelError, ModelError
from flexmb.kernels import GAP_SIZE, JOINT_FRICTION_SIZE, Kernel, signal_kernel
from flexmb.model import contributions as model
from flexmb.model.contributions import Contributions, ControlContribution, Coordinate, MotionInput
from flexmb.model.law import Law, Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND
from flexmb.model.shape import LateShapes, Shapes
from flexmb.model.signal import Signals, hint, resolved
from flexmb.program import program as tables
from flexmb.program.numbering import COORDINATE_SIGNALS, Numbering, aliases, kernel_signals, layout, state_coordinates
from flexmb.program.program import Program, ReferenceConfiguration
from flexmb.program.structure import flat, numbers, structure_of


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


# Numbers that a kernel returns, by contract; others write to arrays.
RETURNED = dict.fromkeys(("energy", "account", "normal", "friction", "motion"), 3)
RETURNED |= {"damping": 2, "signal": 1, "extremum": 2}


def call_each_kernel(contributions: model.Contributions, number: Numbering) -> None:
    """Call every kernel once with the parameters of its part in the reference configuration."""
    # A call that was good is not repeated in this process: a kernel is a pure function, so it would be good again. A
    # `KernelError` on wrong unpacking or indexing, or results that are not finite, names part, kernel and remedy.
    pose = [*number.pose().tolist(), 0.0, 0.0, 0.0]
    seen: set[tuple[Any, ...]] = set()
    distinct: dict[tuple[Any, ...], model.ElementContribution] = {}  # by kernels and numbers of parameters
    for e in contributions.elements:
        kernels = e.kernel, e.energy, e.force, e.tangent, e.account, e.damping, e.factor and e.factor.kernel
        distinct.setdefault((*map(id, kernels), len(e.p), e.factor and len(e.factor.parameters())), e)
    pieces: tuple[Any, ...] = (
        *distinct.values(), *contributions.constraints, *contributions.contacts,
        *contributions.signals, *contributions.controls,
    )  # fmt: skip
    for contribution in pieces:
        for kernel, p, z, what in _kernels_of(contribution):
            control = kernel.contract.name == "control"
            sizes = tuple([len(getattr(contribution, x)) for x in ("inputs", "states", "outputs")]) if control else ()
            if (id(kernel), len(p), sizes) in seen:
                continue
            seen.add((id(kernel), len(p), sizes))
            law = kernel.contract.name in ("normal", "friction", "motion", "control")
            q = sizes if law else tuple([pose[k] for k in number.dofs(contribution.coordinates)])
            call = (id(kernel), tuple(p), tuple(z), q)
            if call in _GOOD:
                continue
            _call(contribution.part, kernel, np.array(p, dtype=float), _arguments(kernel, contribution, q, z), what)
            if len(_GOOD) >= REMEMBERED_CALLS:
                _GOOD.clear()
            _GOOD[call] = kernel


REMEMBERED_CALLS = 4096  # number of successful calls that are remembered
BEHIND = 64  # number of NaN behind each array of a compiled kernel that is called
KernelCall = tuple[Kernel, Sequence[float], Sequence[float], str]  # a kernel, p, its history, and the name of its class
# Good calls: id of the kernel, p, history, pose. The kernel stands beside them, so its id is given to no other.
_GOOD: dict[tuple[int, Sequence[float], Sequence[float], Sequence[float]], Kernel] = {}


def _kernels_of(contribution: Any) -> list[KernelCall]:
    """All kernels of a piece with their numbers."""
    found: list[KernelCall]
    if isinstance(contribution, model.ElementContribution):
        found = [(contribution.kernel, contribution.p, contribution.history, "element")]
        if contribution.energy is not None:
            found.append((contribution.energy, contribution.p, (), "element"))
        found += [(way, contribution.p, contribution.history, "element") for way in contribution.short_ways if way]
        return found if contribution.factor is None else [*found, _law(contribution.factor)]
    if isinstance(contribution, model.ConstraintContribution):
        motions = [_law(row.motion) for row in contribution.motions]
        found = [(contribution.kernel, contribution.p, (), "constraint"), *motions]
        if contribution.joint_friction is not None:
            rubbing = contribution.joint_friction
            found += [(rubbing.kernel, rubbing.p, (), "joint_friction"), _law(rubbing.friction)]
        return found
    if isinstance(contribution, model.ContactContribution):
        return [(contribution.gap, contribution.p, (), "gap"), _law(contribution.normal), _law(contribution.friction)]
    if isinstance(contribution, model.ControlContribution):
        motions = [_law(wanted.motion) for wanted in contribution.inputs if isinstance(wanted, model.MotionInput)]
        return [(contribution.kernel, contribution.p, contribution.start, "control"), *motions]
    return [(contribution.kernel, contribution.p, (), "signal")]


def _law(law: Law) -> KernelCall:
    return law.kernel, law.parameters(), () if isinstance(law, Motion) else law.history(), type(law).__name__


def _arguments(kernel: Kernel, contribution: Any, pose: Sequence[float], history: Sequence[float]) -> list[Any]:
    """Arguments of a kernel after p: at rest, in the reference configuration, at t = 0; laws at a small penetration."""
    name, n, m = kernel.contract.name, len(pose), getattr(contribution, "rows", 0)
    if name == "control":  # all inputs 0, states as at the start; the law can write to none of these
        read = np.zeros(len(contribution.inputs)), np.array(contribution.start, dtype=float)
        for array in read:
            array.flags.writeable = False
        return [0.0, *read, np.zeros(len(contribution.states)), np.zeros(len(contribution.outputs))]
    h = 1e-6 if name in ("normal", "friction") else 0.0
    numbers = {"t": 0.0, "h": h, "least": -1.0, "kq": 1.0, "kv": 1.0, "ka": 1.0}
    numbers |= {"gap": -1e-6, "gap_rate": -1e-3, "slip": -1e-6, "N": 1e-3}
    given = {"q": pose, "z": history, "z_new": history}
    sizes: dict[str, Any] = dict.fromkeys(("v", "w", "a", "y", "r", "Mv", "My"), n) | dict.fromkeys("KCMAH", (n, n))
    sizes |= dict.fromkeys(("lam", "g", "g_t", "gamma"), m)
    sizes |= {"G": (m, n), "out": GAP_SIZE if name == "gap" else JOINT_FRICTION_SIZE}
    return [
        numbers[x] if x in numbers else np.array(given[x], dtype=float) if x in given else np.zeros(sizes[x])
        for x in kernel.contract.parameters[1:]
    ]


def _call(part: str, kernel: Kernel, p: np.ndarray, arguments: list[Any], what: str) -> None:
    label = f"Part {part!r}: {what} kernel {kernel.name!r}" if what.islower() else f"Part {part!r}: {what}"
    own = ours(kernel.function)
    call, rooms = kernel.dispatcher if own else kernel.python, list[np.ndarray]()
    if own:  # compiled code sees no end of an array: what it reads there is not finite, what it writes there is seen
        p, *arguments = (_with_room(x, rooms) if isinstance(x, np.ndarray) else x for x in (p, *arguments))
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused below
            result = call(p, *arguments)
    except USER_ERRORS as error:
        reason = str(error) or "wrong number of values"  # compiled code says nothing when it cannot unpack
        if isinstance(error, (IndexError, TypeError)) or "unpack" in reason or reason != str(error):
            if kernel.contract.name == "control":
                sizes = [a.size for a in arguments[1:]]
                text = f"{label} failed with {len(p)} numbers p, {sizes[0]} inputs u, {sizes[1]} states x"
                text += f" with rates dx and {sizes[-1]} outputs y: {reason}. The law must fit the numbers,"
                raise KernelError(f"{text} inputs, states and loads of its controller.") from error
            text = f"{label} failed with {len(p)} parameters p = {_short(p)}: {reason}. The kernel must unpack"
            raise KernelError(f"{text} as many numbers as its class has numeric fields, in their order.") from error
        if kernel.contract.name == "control" and isinstance(error, (ArithmeticError, ValueError)):
            return  # inputs of 0 may be none that the mechanism has
        safe = "It must be safe there, also for t = h = 0." if isinstance(error, ArithmeticError) else "Correct it."
        places = {"normal": "at a penetration of 1e-6 m,", "friction": "at a slip of -1e-6 m/s and N = 1e-3 N,"}
        place = places.get(kernel.contract.name, "in the reference configuration, at rest,")
        text = f"{label} failed {place} with p = {_short(p)}: {type(error).__name__}: {error}."
        raise KernelError(f"{text} {safe}") from error
    if not all(np.isnan(room).all() for room in rooms):
        text = f"{label} writes beyond its arrays: it is made for more coordinates, rows or histories than the part has"
        raise KernelError(f"{text}. Give it all that it is made for.")
    size = RETURNED.get(kernel.contract.name, 0)
    if size:
        values = np.empty(0)
        with suppress(TypeError, ValueError):  # words, for example
            values = np.array(() if result is None else result, dtype=float)
        if values.size != size:
            plural = "s" if size > 1 else ""
            raise KernelError(f"{label} returned {result!r}; it must return {size} number{plural}.")
    else:
        arrays = [a.ravel() for a in arguments if isinstance(a, np.ndarray)]
        values = np.concatenate(arrays) if arrays else np.empty(0)
    if kernel.contract.name != "control" and not np.all(np.isfinite(values)):
        raise KernelError(f"{label} gives values that are not finite for p = {_short(p)}; check its numbers.")


def _with_room(array: np.ndarray, rooms: list[np.ndarray]) -> np.ndarray:
    """A copy of an array with NaN behind it, which are added to `rooms`."""
    longer = np.concatenate([array.ravel(), np.full(BEHIND, np.nan)])
    rooms.append(longer[array.size :])
    return longer[: array.size].reshape(array.shape)


def _short(p: np.ndarray) -> str:
    shown = ", ".join(f"{x:.6g}" for x in p[:8])
    return f"({shown}{', ...' if len(p) > 8 else ''})"


def common_period(program: Program) -> float:
    """The shortest time after which all drives are where they were [s]; refused where there is none."""
    known = [p for p in program.periods if p is not None]
    if not known:
        raise InputError(f"Mechanism {program.name!r} has no periodic drive; give t_end= instead of periods=.")
    apart = clash(program)
    if apart is not None:
        text = f"Mechanism {program.name!r}: the periods of its drives, {apart[0]:g} s and {apart[1]:g} s,"
        raise InputError(f"{text} have no small common multiple; give t_end= instead of periods=.")
    return known[0] * math.lcm(*(_ratio(known[0], period).denominator for period in known))


def clash(program: Program) -> tuple[float, float] | None:
    """Two periods of drives without a small common multiple [s], or None."""
    known = [p for p in program.periods if p is not None]
    for period in known[1:]:
        ratio, near = known[0] / period, _ratio(known[0], period)
        if near == 0 or abs(float(near) - ratio) > 1e-9 * ratio:
            return known[0], period
    return None


def _ratio(first: float, second: float) -> Fraction:
    """The fraction of small numbers nearest to the ratio of two periods."""
    return Fraction(first / second).limit_denominator(64)


def just_before(instant: float) -> float:
    """Instant before `instant` by a few units of round-off; `t + h` cannot round beyond it."""
    return float(instant - 4.0 * np.spacing(instant))


@checked
def compile(
    mechanism: Mechanism, *, closed: bool = False, start: bool = False, controlled: bool = False, touching: bool = False
) -> Program:
    """Flat arrays, kernels and names of a mechanism.

    Parameters
    ----------
    mechanism : the mechanism.
    closed : with the clearance joints replaced by ideal ones.
    start : with elastic joints replaced, too, for closed loops and start velocities.
    controlled : with controls in spite of `closed`; these must have no states.
    touching : with the contacts that no ideal joint replaces, such as cables and stops, in spite of `closed`.

    Raises
    ------
    ModelError : a mechanism without bodies.
    InputError : something that is no mechanism; parts whose points do not fit their bodies.
    KernelError : a user's kernel that unpacks a wrong number of parameters, cannot be compiled or returns NaN.
    """
    with _without_collector():
        contributions = chosen_contributions(
            _contributions(mechanism), closed=closed or start, start=start, controlled=controlled, touching=touching
        )
        number = Numbering(mechanism, controls=not (closed or start))
        return _compiled(mechanism, contributions, number, LateShapes(mechanism.shapes))


def compile_with_start(mechanism: Mechanism) -> tuple[Program, Program]:
    """Program of a mechanism, and the program of its start values, from one reading of the parts."""
    with _without_collector():
        contributions, number, shapes = _contributions(mechanism), Numbering(mechanism), LateShapes(mechanism.shapes)
        program = _compiled(mechanism, chosen_contributions(contributions, closed=False, start=False), number, shapes)
        always = all(c.holds == "always" for c in contributions.constraints)
        if always and not contributions.contacts and not contributions.controls:
            return program, program
        if contributions.controls:
            number = Numbering(mechanism, controls=False)
        ideal = chosen_contributions(contributions, closed=True, start=True)
        return program, _compiled(mechanism, ideal, number, shapes)


@contextmanager
def _without_collector() -> Iterator[None]:
    """Switch off Python's collector of cycles, which would inspect a hundred thousand new objects."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def _contributions(mechanism: Mechanism) -> model.Contributions:
    """All contributions to a mechanism with bodies, or an error."""
    if not isinstance(mechanism, Mechanism):
        raise InputError(f"compile: {mechanism!r} is not a Mechanism.")
    if not mechanism.bodies:
        raise ModelError(f"{mechanism.label} has no bodies; add at least one.")
    return mechanism.contributions()


def _compiled(mechanism: Mechanism, contributions: model.Contributions, number: Numbering, shapes: Shapes) -> Program:
    """Program of the contributions of a mechanism."""
    call_each_kernel(contributions, number)
    declared, others = contributions.controls, aliases(mechanism)
    contributions = wired(contributions, number, others)
    listed = numbers(contributions)
    structure = structure_of(contributions, number, listed)
    p, z = flat(listed)
    driven = [row for c in contributions.constraints for row in c.motions]
    inputs = [source.motion for control in contributions.controls for source in control.sources]
    motions = [*[row.motion for row in driven], *[e.factor for e in contributions.elements], *inputs]
    names = replace(structure.names, bodies=tuple(body.name for body in mechanism.bodies), aliases=others)
    return Program(
        mechanism.name, structure.tables.replaced(p=p), structure.kernels, structure.symbolic,
        reference_configuration(mechanism, number, z), names, shapes, tuple(period_of(row) for row in driven),
        structure.drives, number.extent, min((c.p[0] or math.inf for c in contributions.contacts), default=None),
        tuple([motion for motion in motions if motion is not None]), tuple(c.normal for c in contributions.contacts),
        samplers(declared, contributions.controls, structure.tables.controls.z, names),
        tuple(c.part for c in contributions.controls),
        tuple(number.dofs(state_coordinates(c))[k] for c in declared if c.sample is None for k in c.settled),
    )  # fmt: skip


def period_of(row: model.RowMotion) -> float | None:
    """The period of a driven row [s]; that of a motion which goes on counts for an angle, not for a travel."""
    motion, period = row.motion, row.motion.period
    if period is None or row.units[0] == "rad":
        return period
    p = np.array(motion.parameters(), dtype=float)
    first, half, last = (motion.kernel(p, part * period)[0] for part in (0.0, 0.37, 1.0))
    return period if abs(last - first) <= 1e-9 * max(abs(first), abs(half - first)) else None


def chosen_contributions(
    contributions: model.Contributions, *, closed: bool, start: bool, controlled: bool = False, touching: bool = False
) -> model.Contributions:
    """The contributions in motion: with ideal joints for contacts, no controls (`closed`); for start values."""
    # Controls and their loads have no part in closed loops and start velocities, nor have contacts and their friction;
    # `touching` keeps the ones that no ideal joint replaces, and the friction of the ideal joints.
    holding = {"always", *(["closed"] if closed else []), *(["start"] if start else [])}
    constraints = tuple([c for c in contributions.constraints if c.holds in holding])
    if not closed:
        return replace(contributions, constraints=constraints)
    if not touching:
        constraints = tuple(replace(c, joint_friction=None) if c.rubs_closed else c for c in constraints)
    replaced = {c.part for c in contributions.constraints if c.holds == "closed"}
    contacts = tuple(c for c in contributions.contacts if touching and c.part not in replaced)
    if controlled:
        return replace(contributions, constraints=constraints, contacts=contacts)
    own = {name for control in contributions.controls for name in control.loads}
    elements = tuple([e for e in contributions.elements if not own or e.part not in own])
    signals = tuple([s for s in contributions.signals if not own or s.part not in own])
    uncontrolled = replace(contributions, elements=elements, signals=signals, controls=())
    return replace(uncontrolled, constraints=constraints, contacts=contacts)


def reference_configuration(mechanism: Mechanism, number: Numbering, z: np.ndarray) -> ReferenceConfiguration:
    """Reference configuration with start displacements, declared velocities, and histories at the start."""
    # A rigid motion is declared at the main node alone, so that it holds wherever closing the loops moves the body.
    q = number.pose()
    v = np.full(number.n_q, np.nan)
    owner = np.zeros(number.n_q, dtype=np.int64)
    for k, body in enumerate(mechanism.bodies):
        first, last = number.of_body[body.name]
        owner[first:last] = k
        velocity, displacement = body.start_velocity(), body.start_displacement()
        if displacement is not None:
            q[first:last] += np.array(displacement).ravel()
        if velocity is not None and np.ndim(velocity) == 2:
            v[first:last] = np.array(velocity).ravel()
        elif velocity is not None:
            v[number.dofs(model.node_coordinates(body.name, body.main))] = velocity
    v[number.n_b :], owner[number.n_b :] = 0.0, len(mechanism.bodies) + np.arange(number.n_q - number.n_b) // 3
    for controller in mechanism.controllers if number.n_q > number.n_b else ():
        control = controller.control()
        states = number.dofs(state_coordinates(control))  # none of a sampled control
        v[states[: len(control.start)]] = control.start[: len(states)]
    return ReferenceConfiguration(q, v, z, owner, np.array([node.turns for _, node in number.nodes], dtype=float))
