"""Bases of parts, the named items of a mechanism; of bodies that bend, with findings on their strains and stresses."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

import numpy as np

from flexmb import checks, kernels
from flexmb.display import Shown, number_text
from flexmb.errors import USER_ERRORS, FlexmbError, InputError, ModelError
from flexmb.fields import Input, field, fields_of, point, record
from flexmb.findings.finding import Finding, found
from flexmb.model import contributions as pieces
from flexmb.model.contributions import AXES, Attachment, Contribution, Ends, Node, SignalContribution
from flexmb.model.law import Law, Material, number_fields, require_kernel
from flexmb.model.shape import PointShape, Shapes
from flexmb.model.signal import Signals
from flexmb.namespace import warn_of_former

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


Triple = tuple[float, float, float]


class Pose(Protocol):
    """Coordinates by their full names."""

    def __getitem__(self, name: str) -> float: ...


def name_of(part: Part | str) -> str:
    """Name of a part, given by itself or by its name; another object as it is."""
    return part.name if isinstance(part, Part) else part


def declared_state(value: Any) -> dict[str, Any]:
    """State for pickling: the declared fields alone."""
    kind = type(value)
    return {k: v for k, v in vars(value).items() if not isinstance(getattr(kind, k, None), cached_property)}


@record
class Part(Input, Shown, ABC):
    """Base of all parts of a mechanism."""

    name: str = field("its name, unique in the mechanism")
    by_name: ClassVar[tuple[str, ...]] = ()
    """Fields that hold names of parts, and take the parts themselves as well."""
    deep_from: ClassVar[float] = 0.2
    """Penetration over `contact_size` above which there is a finding."""
    lost_beyond: ClassVar[float] = 1.0
    """The same above which the run is not ok: a journal has passed its own centre."""
    lost_when: ClassVar[str] = "the parts pass through each other"
    """Words for a penetration beyond `lost_beyond`."""

    def __post_init__(self) -> None:
        checks.identifier(type(self).__name__, self.name)
        for name in self.by_name:
            given = getattr(self, name)
            names = tuple(map(name_of, given)) if isinstance(given, list | tuple) else name_of(given)
            if not isinstance(names, str | tuple) and getattr(type(self), name, "") is not None:
                raise InputError(f"{self.label}: {name} is {given!r}; it must be a {name} or its name.")
            object.__setattr__(self, name, names)
        super().__post_init__()
        for name in [one.name for one in fields_of(type(self)) if one.type == "Part"]:
            if not is_kind((value := getattr(self, name)).__class__, Part):
                hint = " Give the part itself, not its name." if isinstance(value, str) else ""
                raise InputError(f"{self.label}: {name} is {value!r}; it must be a body or GROUND.{hint}")

    @property
    def label(self) -> str:
        """Class and name, as messages show it."""
        return f"{type(self).__name__} {self.name!r}"

    def __getstate__(self) -> dict[str, Any]:
        return declared_state(self)

    def text_inside(self, *, nested: bool) -> str:  # noqa: ARG002 - a name has no fields
        """Name of the part, by which other parts show it; `nested` has no effect."""
        return repr(self.name)

    @classmethod
    def prepare(cls, parts: Sequence[Any]) -> None:
        """Prepare all `parts` of this class at once, before their contributions are collected."""
        return

    @abstractmethod
    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """Contributions of the part to the equations of motion of `mechanism`."""

    def shapes(self, mechanism: Mechanism) -> Shapes:  # noqa: ARG002 - most parts are not drawn
        """Shapes of the part in `mechanism`, for drawings."""
        return ()

    def share(self, part: float) -> Part:  # noqa: ARG002 - most parts are no loads
        """The part with the fraction `part` (0 to 1) of a follower load, in which its parameters are linear.

        Static equilibrium increases follower loads by it, other loads as forces of the reference configuration.
        """
        return self

    def references(self) -> tuple[str, ...]:
        """Names of the parts to which this part is connected."""
        values = [getattr(self, field.name) for field in fields_of(type(self))]
        return tuple([v.name for v in values if is_kind(v.__class__, Part)])

    @property
    def pushes(self) -> tuple[str, ...]:
        """Names of own forces that only push: below 0 a real part, such as a cam, would lift off."""
        return ()

    @cached_property
    def all_materials(self) -> tuple[Material, ...]:
        """Materials among the fields of the part and of its laws."""
        return tuple(dict.fromkeys(_materials([getattr(self, field.name) for field in fields_of(type(self))])))

    @property
    def declared_load(self) -> float | None:
        """Force that the part declares [N], 0 for a torque; None for a part that is neither."""
        return None

    @property
    def wearing(self) -> Any:
        """The part, if its surfaces wear: a `WornJoint` of `flexmb/parts/wear`; None for a part whose surfaces stay."""
        return None

    @property
    def oiled(self) -> Any:
        """The part, if it has a film whose pressure is known by direction: a `JournalBearing`; else None."""
        return None

    def idealised(self) -> Part:
        """The part with an ideal joint in place of its clearance, if it has one."""
        return self

    def contact_size(self, mechanism: Mechanism) -> float | None:  # noqa: ARG002 - asked by some
        """Length beside which penetrations of the part in `mechanism` are judged [m]; None for a part without one."""
        sizes = (getattr(self, name, None) for name in ("bearing_radius", "pin_radius", "half_height"))
        return next((size for size in sizes if isinstance(size, float)), None)

    def findings_before(self, mechanism: Mechanism) -> Iterable[Finding]:  # noqa: ARG002 - most have none
        """Findings on the part as declared in `mechanism`, before it moves."""
        return ()

    def findings_at_rest(self, mechanism: Mechanism, load: float, pose: Pose | None) -> Iterable[Finding]:  # noqa: ARG002
        """Findings on the part of `mechanism` under a `load` [N], and at rest in a `pose` where that is known."""
        return ()

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterable[Finding]:  # noqa: ARG002
        """Findings on a `motion` of `mechanism` that a real part could not follow, or the theory does not cover."""
        return ()

    def answers(self, question: str, *arguments: Any) -> list[Finding]:
        """Findings of a method `question`, such as `findings_after`, called with `arguments`; its failure is one."""
        former = getattr(self, "remarks", None) if question == "findings_after" else None
        try:
            given: list[Any] = list(getattr(self, question)(*arguments))
            if callable(former):
                warn_of_former(type(self).__name__, "remarks", "findings_after", "0.3")
                given += [found("unreal-motion", (self.name,), str(one)) for one in former(*arguments)]
            if not given:
                return []
            wrong = [f"it gives {one!r}, which is no Finding" for one in given if not isinstance(one, Finding)][:1]
        except FlexmbError:
            raise
        except USER_ERRORS as error:
            given, wrong = [], [f"{type(error).__name__}: {error}"]
        told = [found("broken-question", (self.name,), f"{self.label}: {question} failed: {one}.") for one in wrong]
        return [*(one for one in given if isinstance(one, Finding)), *told]

    def validate(self, mechanism: Mechanism) -> None:
        """Check the part against the other parts of `mechanism`."""


@cache
def is_kind(kind: type, of: type) -> bool:
    """Whether a class is one of another; remembered, since abstract base classes are slow."""
    return issubclass(kind, of)


def _materials(values: Iterable[Any]) -> Iterator[Material]:
    """Materials among values, in tuples of them, and among the fields of laws."""
    for value in values:
        if is_kind(value.__class__, Material):
            yield value
        elif isinstance(value, tuple):
            yield from _materials(value)
        elif is_kind(value.__class__, Law):
            yield from _materials(vars(value).values())


@record
class Body(Part):
    """Base of bodies: parts with nodes, to which other parts are attached."""

    is_elastic: ClassVar[bool] = False
    """Whether the body bends."""

    @abstractmethod
    def nodes(self) -> tuple[Node, ...]:
        """Nodes in the reference configuration."""

    @property
    def main(self) -> str:
        """Main node of the body; its coordinates represent the body."""
        return self.nodes()[0].name

    @property
    def aliases(self) -> dict[str, str]:
        """Other names of nodes."""
        return {}

    @abstractmethod
    def attach(self, owner: str, point: tuple[float, float]) -> Attachment:
        """Node and offset of a `point` of the reference configuration; `owner`: caller, for messages."""

    @property
    def bar_ends(self) -> tuple[tuple[float, float], ...]:
        """Both ends of a bar in the reference configuration [m]; () for a body of another form."""
        return ()

    @property
    def whole_body(self) -> Body:
        """The body with all its nodes, of which this one is made."""
        return self

    @property
    def is_massless(self) -> bool:
        """Whether the body has neither mass nor moment of inertia."""
        return False

    def total_mass(self) -> float:
        """Mass of the body [kg]: its field `mass`; 1 kg for a body without an own answer."""
        mass: float = getattr(self, "mass", 1.0)
        return mass

    def start_velocity(self) -> Triple | tuple[Triple, ...] | None:
        """Velocity (vx, vy, omega) at the start: of the main node of a rigid motion, of every node, or None: as driven.

        Fields are absolute and in world axes; the value of a field `velocity` without an own answer.
        """
        velocity: Triple | tuple[Triple, ...] | None = getattr(self, "velocity", None)
        return velocity

    def start_displacement(self) -> tuple[Triple, ...] | None:
        """Displacement (x, y, theta) of every node at the start from the reference configuration, or None."""
        displacement: tuple[Triple, ...] | None = getattr(self, "displacement", None)
        return displacement

    def node(self, name: str) -> Node:
        """The node of that name or alias, or `InputError`."""
        name = self.aliases.get(name, name)
        for node in self.nodes():
            if node.name == name:
                return node
        names = [*self.aliases, *(n.name for n in self.nodes())]
        raise InputError(f"{self.label} has no node {name!r}. {checks.did_you_mean(name, names)}")


@record
class Ground(Body):
    """The fixed frame; use the constant `GROUND`."""

    name: str = "ground"

    def nodes(self) -> tuple[Node, ...]:
        return (Node("", 0.0, 0.0, 0.0),)

    def attach(self, owner: str, point: tuple[float, float]) -> Attachment:  # noqa: ARG002 - any point will do
        return Attachment(self.name, "", point)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:  # noqa: ARG002 - nothing moves
        return ()


GROUND = Ground()


@record
class Element(Part):
    """Base of elements written by users: one kernel on named coordinates.

    A subclass has the class attributes `kernel` (an element kernel) and `coords`, a tuple of "FIELD.AXIS" or
    "FIELD.NODE.AXIS" where FIELD names a field that holds a body and AXIS is x, y or theta.  The kernel's p holds
    the numeric fields in the order of declaration; `history` gives the start values of z.  An element that stores or
    damps energy may have an energy kernel, `energy`; without one its work is counted as that of a load.  The signals of
    an element stand in `signals`: (name, unit, signal kernel) each, with its p and its coordinates.
    `force_kernel` and `tangent_kernel` may give the same forces and tangents at less cost.
    """

    kernel: ClassVar[kernels.Kernel]
    energy: ClassVar[kernels.Kernel | None] = None
    coords: ClassVar[tuple[str, ...]]
    force_kernel: ClassVar[kernels.Kernel | None] = None
    tangent_kernel: ClassVar[kernels.Kernel | None] = None
    signals: ClassVar[tuple[tuple[str, str, kernels.Kernel], ...]] = ()

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        require_kernel(cls, kernels.ELEMENT)
        require_kernel(cls, kernels.ENERGY, "energy")
        require_kernel(cls, kernels.FORCE, "force_kernel")
        require_kernel(cls, kernels.TANGENT, "tangent_kernel")
        for signal in cls.signals:
            fits = isinstance(signal, tuple) and len(signal) == 3 and isinstance(signal[2], kernels.Kernel)
            if not fits or signal[2].contract is not kernels.SIGNAL or not all(isinstance(x, str) for x in signal[:2]):
                text = f"{cls.__name__}: signals has {signal!r}; each must be (name, unit, kernel) with a kernel"
                raise InputError(f"{text} made by @fm.kernels.signal_kernel, e.g. ('moment', 'N m', moment_kernel).")

    def parameters(self) -> tuple[float, ...]:
        """Parameters p of the kernel."""
        return number_fields(self)

    def history(self) -> tuple[float, ...]:
        """Start values of the history z."""
        return ()

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        names, named = [f.name for f in fields(self) if isinstance(getattr(self, f.name), Part)], []
        for text in self.coords:
            words = text.split(".")
            if len(words) not in (2, 3) or words[0] not in names or words[-1] not in AXES:
                told = f"{self.label}: coords entry {text!r} must read FIELD.AXIS or FIELD.NODE.AXIS"
                raise InputError(f"{told} with FIELD in {names} and AXIS in {list(AXES)}.")
            body = mechanism.body(getattr(self, words[0]).name, self.label)
            node = body.main if len(words) == 2 else body.node(words[1]).name
            named.append((body.name, node, AXES.index(words[-1])))
        coordinates, p = tuple(named), self.parameters()
        others: dict[str, Any] = {"energy": self.energy, "force": self.force_kernel, "tangent": self.tangent_kernel}
        element = pieces.ElementContribution(self.name, self.kernel, coordinates, p, self.history(), **others)
        own = [SignalContribution(self.name, name, unit, kernel, coordinates, p) for name, unit, kernel in self.signals]
        return [element, *own]


@record
class Joint(Part):
    """Base of joints between two bodies at a point of the reference configuration."""

    # A new joint answers, besides `contributions`: `kind` (its mark in pictures: `MARKERS` of `show/pictures/pose.py`
    # and `assets/drawing.js` of reports), `is_guide`, `holds_point`, `shapes`; with a drive `drive_contribution`; with
    # clearance `idealised` and `contact_size`.
    first: Part = field("first body; `GROUND` is the frame")
    second: Part = field("second body, on which reported forces act")
    at: tuple[float, float] = field("the joint's point", "m", point)

    kind: ClassVar[str] = "joint"
    is_guide: ClassVar[bool] = False
    """Whether the second body slides along the first one without clearance."""
    holds_point: ClassVar[bool] = True
    """Whether the bodies turn about the joint's point, which moves with both, but for clearance."""

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_one_body(self)

    def ends(self, mechanism: Mechanism) -> Ends:
        """Attachments of the joint on the first and the second body of `mechanism`."""
        first = mechanism.body(self.first.name, self.label)
        second = mechanism.body(self.second.name, self.label)
        at = self.at
        if at is None:
            node = second.node(second.main)
            at = (node.x, node.y)
        return Ends(first.attach(self.label, at), second.attach(self.label, at))

    def drive_contribution(self, mechanism: Mechanism) -> pieces.ConstraintContribution | None:  # noqa: ARG002 - not every joint
        """The coordinate in `mechanism` that a drive can prescribe, or None for a joint that cannot be driven."""
        return None

    def can_be_turned(self, mechanism: Mechanism) -> bool:
        """Whether the joint has an angle in `mechanism` that can be driven."""
        try:
            row = self.drive_contribution(mechanism)
        except FlexmbError:
            return False
        return row is not None and row.drive_units[0] == "rad"

    def shapes(self, mechanism: Mechanism) -> Shapes:
        first, second = self.ends(mechanism)
        return (PointShape(self.name, self.kind, *first.place, other=second.place),)


@record
class PointToPoint(Part):
    """Base of parts between a point of one body and a point of another."""

    formerly: ClassVar[tuple[tuple[str, str, str], ...]] = (("start", "at", "0.3"), ("end", "to", "0.3"))
    first: Part = field("first body; `GROUND` is the frame")
    second: Part = field("second body")
    at: tuple[float, float] = field("point of the first body, or centre of its drum", "m", point)
    to: tuple[float, float] = field("the same of the second body", "m", point)

    def ends(self, mechanism: Mechanism) -> Ends:
        """Both points on the bodies of `mechanism`."""
        first = mechanism.body(self.first.name, self.label).attach(self.label, self.at)
        return Ends(first, mechanism.body(self.second.name, self.label).attach(self.label, self.to))


def refuse_one_body(part: Any, how: str = "joins {} to") -> None:
    """Refuse a part with one body at both of its ends; `how` is the verb of the message."""
    if part.first.name == part.second.name:
        raise ModelError(f"{part.label} {how.format(repr(part.first.name))} itself; give two different bodies.")


class WatchedMotion(NamedTuple):
    """Motion of a run, whatever of it was saved."""

    signals: Signals  # names of all signals
    times: np.ndarray  # (n,) instants of some accepted steps, the first and the most strained one among them [s]
    values: np.ndarray  # (n, n_y) all signals there
    z: np.ndarray  # (n, n_z) histories there
    sizes: np.ndarray  # (n,) sizes of the steps that led there [s]
    even: np.ndarray  # (n,) whether they are those that are evenly distributed over the steps
    # (n_y,) largest absolute values of all signals over all steps, and (n_y,) when [s]
    peaks: tuple[np.ndarray, np.ndarray]
    reported: tuple[np.ndarray, np.ndarray]  # the same of the time that is saved
    lows: Mapping[str, tuple[float, float]]  # least value and its instant [s] of the signals of `Part.pushes`, by name
    fixed_step: float | None  # size of the steps [s]; None: chosen by their errors
    failed: bool  # whether a step failed

    def rows(self, *names: str) -> np.ndarray:
        """Values (n, k) of signals by their full names at the instants."""
        return self.values[:, [self.signals.places[name] for name in names]]

    def pose(self, body: str, node: str) -> np.ndarray:
        """x, y, theta (n, 3) of a node [m, rad]; zeros for the ground."""
        if body == GROUND.name:
            return np.zeros((len(self.times), 3))
        stem = f"{body}.{node}" if node else body
        return self.rows(*(f"{stem}.{axis}" for axis in ("x", "y", "theta")))

    def point(self, place: tuple[str, str, tuple[float, float]]) -> np.ndarray:
        """Positions (n, 2) of a point of a body [m]: body, node, offset in the frame of the node."""
        body, node, (a, b) = place
        x, y, theta = self.pose(body, node).T
        c, s = np.cos(theta), np.sin(theta)
        return np.column_stack([x + a * c - b * s, y + a * s + b * c])

    def peak(self, name: str) -> tuple[float, float]:
        """Largest absolute value of a signal over all steps, and when [s]."""
        place = self.signals.places[name]
        return float(self.peaks[0][place]), float(self.peaks[1][place])


@record
class Controller(Part):
    """Base of parts that compute the factors of loads from signals."""

    @abstractmethod
    def control(self) -> pieces.ControlContribution:
        """Law, inputs, states and outputs."""

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:  # noqa: ARG002 - the same in all
        return [self.control()]

    def followed(self, end: float) -> tuple[str, float, float] | None:  # noqa: ARG002 - of controllers with a target
        """Signal that the controller holds near a target, and the range of the target until `end` [s]; None: none."""
        return None

    def references(self) -> tuple[str, ...]:
        """Names of the controlled loads."""
        return self.control().loads

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse loads that cannot be controlled, or that have another controller in `mechanism`."""
        for name in self.control().loads:
            load = mechanism.find(name)
            found = [] if isinstance(load, Controller) else list(load.contributions(mechanism))
            forces = [one for one in found if not isinstance(one, SignalContribution)]
            element = forces[0] if len(forces) == 1 and isinstance(forces[0], pieces.ElementContribution) else None
            if element is None or element.energy is not None:
                text = f"{self.label}: {load.label} cannot be controlled"
                remedy = "give a Force or a Torque, whose value per unit of the output it holds"
                raise ModelError(f"{text}; {remedy}, or a load on the mesh of a Reduced body.")
            if element.factor is not None:
                text = f"{self.label}: {load.label} has a history, and would be multiplied twice"
                raise ModelError(f"{text}. Leave the history out, and let the control law depend on time.")
            for other in mechanism.controllers_of[name]:
                if other.name < self.name:  # told once
                    text = f"{self.label} and {other.label} both control {name!r}"
                    raise ModelError(f"{text}. Give each a load of its own; forces on one body add up.")


def refuse_controllers(mechanism: Mechanism, analysis: str, reason: str, *, with_memory: bool = False) -> None:
    """Refuse an analysis of a mechanism with controllers."""
    # With `with_memory` only controllers with states of their own and sampled ones are refused: the outputs of others
    # are functions of the motion. The message begins with `analysis`.
    controllers = getattr(mechanism, "controllers", ())  # the compiler refuses what is no mechanism
    if with_memory:
        controllers = [part for part in controllers if part.control().states or part.control().is_sampled]
    if controllers:
        listed = ", ".join(part.label for part in controllers)
        loads = ", ".join(repr(name) for part in controllers for name in part.control().loads)
        text = f"{analysis}: {reason}; {mechanism.label} has {listed}"
        full = f"the loads {loads or '-'} have their full values"
        raise ModelError(f"{text}. Remove it with without_part(...), then {full}.")


# Strain at rest under the loads, and in a run, above which linear elasticity is not meant; above the last no run is ok.
STRAIN_AT_REST, LARGE_STRAIN, IMPOSSIBLE_STRAIN = 0.02, 0.05, 0.2
LEAST = 1e-6  # stress over yield stress up to which nothing is said: round-off of a body without loads


class ElasticBody(Body):
    """Base of bodies that bend, by beams or by meshes."""

    # A new one: its class, a stub, `elastic/reduced/models.py` if it can be reduced, `results/stress.py` and, by its
    # `theory`, `results/positions.py` (docs/decisions/067-deformable-bodies.md).
    is_elastic: ClassVar[bool] = True
    stress_name: ClassVar[str] = "von Mises stress"
    """The stress that the signal `von_mises` holds."""
    theory: ClassVar[str] = "plane bodies"
    """The bodies that are linear elastic."""

    @property
    def whole_body(self) -> ElasticBody:
        return self

    @property
    @abstractmethod
    def seeks_stress(self) -> bool:
        """Whether every accepted step looks for the largest stress."""

    @property
    def knows_stress(self) -> bool:
        """Whether the stresses follow from strains: all sections know their outer fibres."""
        return True

    @abstractmethod
    def reference_points(self) -> np.ndarray:
        """Places (n, 2) of stresses by number [m]: nodes, of beams also middles, of reduced beams points of a mesh."""

    def place_name(self, number: int) -> str:
        """Words for a place of stresses by its number."""
        return f"node {number}"

    def strain_at_rest(self, mechanism: Mechanism, pose: Pose) -> tuple[float, float]:
        """Largest strain and stress [Pa] of the body of `mechanism` at rest in a `pose`."""
        seeking: Any = self
        try:
            seeking = replace(seeking, stress=True)
        except FlexmbError:  # a general section, whose outer fibres are unknown
            return 0.0, 0.0
        stress = 0.0
        for signal in seeking.contributions(mechanism):
            if isinstance(signal, SignalContribution) and signal.place:
                q = np.array([pose[f"{part}.{node}.{AXES[axis]}"] for part, node, axis in signal.coordinates])
                still, p = np.zeros(len(q)), np.array(signal.p, dtype=float)
                stress = float(signal.kernel.dispatcher(p, 0.0, q, still, still, -np.inf)[0])
                break
        return stress / min(material.young for material in self.all_materials), stress

    def strain_in(self, motion: WatchedMotion) -> tuple[float, float, float]:
        """Largest strain and stress [Pa] in a `motion`, and when [s]."""
        name = f"{self.name}.von_mises"
        known = name in motion.signals.places and self.whole_body.theory == self.theory
        stress, when = motion.peak(name) if known else (0.0, 0.0)
        return stress / max(material.young for material in self.all_materials), stress, when

    def odd_sizes(self) -> Iterable[Finding]:
        """Findings on the sizes of a body with all its nodes."""
        return ()

    def coarse_cells(self, owner: ElasticBody) -> Iterable[Finding]:  # noqa: ARG002 - of meshes
        """Finding on the cells of a body with all its nodes, in the name of its `owner`."""
        return ()

    def findings_before(self, mechanism: Mechanism) -> Iterator[Finding]:  # noqa: ARG002 - the body alone
        """Findings on sizes and cells of the whole body."""
        yield from self.whole_body.coarse_cells(self)
        yield from (replace(finding, parts=(self.name,)) for finding in self.whole_body.odd_sizes())

    def findings_at_rest(self, mechanism: Mechanism, load: float, pose: Pose | None) -> Iterator[Finding]:  # noqa: ARG002
        """Finding on a body that yields or strains by much under the loads at rest."""
        if pose is None:
            return
        strain, stress = self.strain_at_rest(mechanism, pose)
        limit = _yield_stress(self)
        text = f"Under the loads at rest {self.label} strains by {strain:.3g} ({stress:.3g} Pa)"
        remedy = "Reduce the loads, or give a stronger section; flexible bodies are linear elastic."
        if limit is not None and stress > limit:
            text += f"; it yields at {limit:.3g} Pa."
        elif strain > STRAIN_AT_REST:
            text += "; no small strain."
        else:
            return
        yield found("overload", (self.name,), text, remedy, strain=strain, stress=stress)

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:  # noqa: ARG002
        """Findings on cells, strains beyond linear elasticity, and the safety against yield."""
        yield from self.whole_body.coarse_cells(self)
        strain, stress, when = self.strain_in(motion)
        limit = None if self.seeks_stress else _yield_stress(self)
        by = "by some" if self.theory == ElasticBody.theory else "by"
        text = f"At t = {when:.6g} s {self.label} strains {by} {strain:.3g} ({stress:.3g} Pa)"
        if limit is not None and stress > limit:
            text += f"; it yields at {limit:.3g} Pa, and {self.theory} are linear elastic."
        else:
            limit = LARGE_STRAIN * max(material.young for material in self.all_materials)
            text += f"; {self.theory} are linear elastic, for small strains."
        if stress > limit:
            wrong = strain > IMPOSSIBLE_STRAIN
            yield found("large-strain", (self.name,), text, wrong=wrong, time=when, strain=strain, limit=limit)
        # The largest stress of the time that is saved.
        place, limit = motion.signals.places.get(f"{self.name}.von_mises"), _yield_stress(self)
        stress = 0.0 if place is None else float(motion.reported[0][place])
        if place is None or limit is None or not stress > LEAST * limit:
            return
        node = round(float(motion.reported[0][motion.signals.places[f"{self.name}.von_mises_node"]]))
        (x, y), when = self.reference_points()[node].tolist(), float(motion.reported[1][place])
        several = len({material.yield_stress for material in self.all_materials}) > 1
        weakest = " of the weakest material, at least" * several
        text = f"{self.label}: largest {self.whole_body.stress_name} {number_text(stress)} Pa at t ="
        text += f" {when:.6g} s at {self.place_name(node)}, ({x:.4g}, {y:.4g}) m in the reference configuration:"
        text += f" safety against yield{weakest} {limit / stress:.3g}"
        if stress > limit:
            text += f"; it yields at {limit:.3g} Pa, and stresses are those of a linear elastic material"
        yield found("strength", (self.name,), f"{text}.", time=when, stress=stress, limit=limit)


def _yield_stress(body: Body) -> float | None:
    """Yield stress of the weakest material of a body [Pa]; None where one is unknown."""
    known = [material.yield_stress for material in body.all_materials if material.yield_stress is not None]
    return min(known) if known and len(known) == len(body.all_materials) else None
