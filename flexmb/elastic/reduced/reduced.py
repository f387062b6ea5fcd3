"""Flexible bodies by their pins and a few modes, and the matrices that equal bodies share."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, replace
from functools import cached_property
from threading import Lock
from typing import Any, Generic, TypeVar

import numpy as np

from flexmb import arguments, checks, planar
from flexmb.elastic.planes.loads import NodalLoad
from flexmb.elastic.planes.plane_body import MeshBody, PlaneBody
from flexmb.elastic.reduced.accuracy import Accuracy, Load, accuracy, deformation_findings
from flexmb.elastic.reduced.bases import Basis, ElasticModel, basis
from flexmb.elastic.reduced.kernel import REDUCED
from flexmb.elastic.reduced.models import Reducible, key_of, model_of, place_of
from flexmb.elastic.reduced.peak_stress import group_parameters, peak_stress_signal
from flexmb.elastic.reduced.superelement import Superelement, checked_loads, left_out, load_contributions, superelement
from flexmb.errors import InputError
from flexmb.fields import Rule, count, field, flag, not_negative, one_of, positive, variant
from flexmb.findings.finding import Finding
from flexmb.model.contributions import Attachment, Contribution, Node
from flexmb.model.law import Material, Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, WatchedMotion
from flexmb.model.shape import MeshShape, Shapes
from flexmb.parts.bodies.flexible import nearest_node
from flexmb.parts.loads.mesh_loads import MeshLoad

Value = TypeVar("Value")
REMEMBERED = 8  # number of models, of bases and of matrices of reduced bodies that are kept


class Kept(Generic[Value]):
    """Values by key, of which the oldest give way; `made` is the number of computed ones."""

    def __init__(self) -> None:
        self.made = 0
        self._values: OrderedDict[Hashable, Value] = OrderedDict()
        self._lock = Lock()  # sweeps may run in threads

    def of(self, key: Hashable, make: Callable[[], Value]) -> Value:
        """Value of a key, which is all that the value depends on; computed by `make` when it is not kept."""
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
                return self._values[key]
        value = make()
        with self._lock:
            self.made += 1
            self._values[key] = value
            while len(self._values) > REMEMBERED:
                self._values.popitem(last=False)
        return value


MODELS: Kept[ElasticModel] = Kept()
BASES: Kept[Basis] = Kept()
ELEMENTS: Kept[Superelement] = Kept()
GROUPS: Kept[tuple[float, ...]] = Kept()
FRAMES = ("chord", "pin")
PIN_NAMES = Rule(lambda label, name, value, *_: checks.sequence(label, name, value, "names of pins"))
ROUND_OFF = 1e-12  # distance of two pins over that from the origin [1] up to which they stand at one place


def ratios(label: str, name: str, value: Any, *_: str) -> float | tuple[float, ...]:
    """One damping ratio, or several, each >= 0."""
    if np.ndim(value) == 0:
        return checks.not_negative(label, name, value)
    return tuple(checks.not_negative(label, name, ratio) for ratio in value)


@variant
class Reduced(MeshBody):
    """A flexible body by the static shapes of its pins and a few vibrations with held pins (Craig and Bampton).

    The body keeps its name, so joints find it: `mechanism.with_part(fm.Reduced(rod, modes=4))` replaces `rod`.
    Its nodes are its pins, and "modes1", "modes2", ... for every three vibrations.  Signals of the stress: `von_mises`
    [Pa] and `von_mises_node`.  What is left out of name, damping, mass_damping and stress is that of the body.

    - modes: vibrations come in threes, together with the shapes of rotation and of loads, so 4 keeps 6, and 5 beside
      one of these; 0 keeps static shapes.  `up_to` is in place of it.
    - pins: left out, the corners of beams, the holes of a plane body.
    - frame: of "chord" it follows the positions of all pins; of "pin", or where all pins stand at one place, the first.
    - inertia_shapes: a node "inertia" for unit accelerations along x, along y and about the first pin, and a shape for
      a steady rotation beside the modes, less those that modes or loads hold.  Weight and rotation then bend and stress
      exactly, and all stress inside counts in the stiffening.
    - load_shapes: such a load on edges or in the body bends the body exactly, beside the modes, with its exact stress,
      which counts in the stiffening.
    - mass_damping acts against the frame; damping_ratios are those of the vibrations of the free body.
    - stress: of a fine mesh it takes longer than the rest of a step.

    Raises
    ------
    InputError : a body that cannot be reduced, pins that it has not, more modes than it has, a free piece, loads on
        other bodies.

    Notes
    -----
    Deformations are small in the frame; motions of the frame are not, and all terms of inertia are kept.  Stiffening is
    right to the first order of the forces of the pins, and for a rotation about the first pin; with `inertia_shapes`
    also for gravity, an accelerated first pin and curved bodies.  The static shapes are exact for forces at the pins.
    Frequencies of the body are too high, by less the more modes are kept: `frequencies()` shows them, `accuracy()`
    compares them and statics with those of all displacements, and `dropped_frequency` is the lowest one with held pins
    that is left out.
    The frame "chord" has the smaller errors: with deflections of a tenth of the length 4e-4, "pin" 1e-2.
    Equal bodies share their shapes and matrices.
    Source: R. R. Craig, M. C. C. Bampton, AIAA J. 6 (1968) 1313; O. Wallrapp, R. Schwertassek, Int. J. Numer. Meth.
    Engng 32 (1991) 1833 (stiffening).  Equations (12.1) to (12.21) of docs/theory/reduced.md.

    Examples
    --------
    >>> import flexmb as fm
    >>> steel = fm.Material(young=2.1e11, density=7850.0)
    >>> rod = fm.FlexibleLink("rod", (0, 0), (0.3, 0), section=fm.Rectangle(width=0.01, height=0.02), material=steel)
    >>> fm.Reduced(rod, modes=3).frequencies(1).round(1).tolist()
    [1182.9]
    """

    body: Reducible = field("a `FlexibleLink`, `FlexibleFrame` or `PlaneBody`")
    modes: int = field("least number of vibrations with all pins held", rule=count(0), default=0)
    _: KW_ONLY
    name: str = field("its name; None: that of the body", default=None, kw_only=True)
    up_to: float | None = field("frequency up to which all of them are kept", "Hz", positive, default=None)
    pins: Sequence[str] | None = field("nodes where parts may be attached", rule=PIN_NAMES, default=None)
    frame: str = field('"chord" or "pin", see above', rule=one_of(*FRAMES), default="chord")
    stiffening: bool = field("whether rotation, and forces of the pins, stiffen or soften bending", default=True)
    inertia_shapes: bool = field("whether the static shapes of the own inertia are kept", default=False)
    load_shapes: Sequence[MeshLoad] = field("loads whose static shapes are kept", default=())
    damping: float | None = field("stiffness-proportional damping time", "s", not_negative, default=None)
    mass_damping: float | None = field("mass-proportional damping rate", "1/s", not_negative, default=None)
    damping_ratios: float | Sequence[float] = field(
        "of all vibrations, or one for each of the lowest", rule=Rule(ratios), default=0.0
    )
    stress: bool | None = field("whether every step looks for the largest stress", rule=flag, default=None)

    def __post_init__(self) -> None:
        checks.instance("Reduced", "body", self.body, Body, "a flexible body such as a PlaneBody")
        if self.name is None:
            object.__setattr__(self, "name", self.body.name)
        super().__post_init__()
        if not isinstance(self.body, Reducible):
            text = f"{self.label}: a {type(self.body).__name__} does not bend."
            raise InputError(f"{text} Reduce a FlexibleLink, FlexibleFrame or PlaneBody; leave others as they are.")
        object.__setattr__(self, "load_shapes", checked_loads(self, self.load_shapes))
        if self.stress and not self.body.knows_stress:
            _ = replace(self.body, stress=True)  # refuses sections without outer fibres
        names = [pin.name for pin in self._pins]
        checks.no_name_of_nodes(self.label, names, "modes", "nodes of its vibrations")
        if self.inertia_shapes and "inertia" in names:
            raise InputError(f"{self.label}: pin 'inertia' has the name of the node of shapes of inertia. Rename it.")

    @cached_property
    def _pins(self) -> tuple[Node, ...]:
        """Nodes of the body where parts may be attached."""
        body = self.body
        if self.pins is None:
            return body.pin_nodes if isinstance(body, PlaneBody) else tuple(map(body.node, body.corners))
        if not self.pins:
            raise InputError(f"{self.label}: pins is empty; name at least one node of the body.")
        nodes = body.pin_nodes if isinstance(body, PlaneBody) else body.nodes()
        known = [*body.aliases, *(node.name for node in nodes)]
        found = tuple(body.node(checks.one_of(self.label, "pin", name, known)) for name in self.pins)
        if len({pin.name for pin in found}) < len(found):
            raise InputError(f"{self.label}: pins are {self.pins!r}; name each one once.")
        return found

    @cached_property
    def _extent(self) -> float:
        """Largest distance of two pins [m]; 0 where they stand at one place."""
        points = [(pin.x, pin.y) for pin in self._pins]
        found = max(planar.distance(a, b) for a in points for b in points)
        return found if found > ROUND_OFF * max(abs(x) for point in points for x in point) else 0.0

    @cached_property
    def _key(self) -> Hashable:
        """All that the model of the body depends on."""
        return key_of(self.body, [pin.name for pin in self._pins])

    @cached_property
    def _options(self) -> tuple[int, float | None, bool, bool, tuple[bytes, ...]]:
        """Modes, highest frequency, whether the frame is that of the first pin, shapes of inertia, forces of loads."""
        by_pin = self.frame == "pin" or self._extent == 0.0
        forces = tuple(load.on(self.plane).forces.tobytes() for load in self.load_shapes) if self.plane else ()
        return self.modes, self.up_to, by_pin, self.inertia_shapes, forces

    @cached_property
    def model(self) -> ElasticModel:
        """Stiffness and mass of the body over all its displacements."""
        body, pins = self.body, [pin.name for pin in self._pins]
        found, (origin, direction) = MODELS.of(self._key, lambda: model_of(body, pins)), place_of(body, pins)
        found = replace(found, label=body.label, damping=body.damping, mass_damping=body.mass_damping)
        return replace(found, origin=origin, direction=direction)

    @cached_property
    def basis(self) -> Basis:
        """The shapes that are kept."""
        modes, up_to, by_pin, inertia, forces = self._options

        def make() -> Basis:
            loads = [self.model.shape.T @ np.frombuffer(force) for force in forces]
            columns = np.stack(loads, axis=1) if loads else np.zeros((self.model.shape.shape[1], 0))
            return basis(self.model, modes, up_to, by_pin=by_pin, own=np.arange(4 * inertia), loads=columns)

        return replace(BASES.of((self._key, self._options), make), model=self.model)

    @cached_property
    def element(self) -> Superelement:
        """The constant matrices of the equations of motion."""
        damping = self.model.damping if self.damping is None else self.damping
        drag = self.model.mass_damping if self.mass_damping is None else self.mass_damping
        numbers: dict[str, Any] = {"stiffening": self.stiffening, "ratios": self.damping_ratios, "mass_damping": drag}
        key = (self._key, self._options), (damping, *numbers.values())
        return ELEMENTS.of(key, lambda: superelement(self.basis, damping, **numbers))

    @arguments.checked
    def frequencies(self, count: int = 6) -> np.ndarray:
        """Lowest frequencies of the free reduced body, without rigid motions (at most `count`) [Hz]."""
        return self.element.frequencies(count)

    @property
    def dropped_frequency(self) -> float:
        """Lowest frequency with held pins that the basis leaves out [Hz]; infinite where none is left."""
        kept = self.basis.vibrations
        return float(self.basis.held[kept]) if len(self.basis.held) > kept else math.inf

    def accuracy(
        self, count: int = 3, *, held: Sequence[str] | None = None, loads: Mapping[str, Load | MeshLoad] | None = None
    ) -> Accuracy:
        """The reduced body beside the body with all its displacements and the same pins.

        Parameters
        ----------
        count : number of frequencies, at most.
        held : names of the pins that neither move nor turn; None: all pins keep their places and may turn, a single
            one may not.
        loads : further loads by name: loads on edges or in the body such as `loads.EdgePressure`; or functions of
            points (S, 2) [m] that return accelerations of gravity (S, 2) [m/s^2], or forces (S, 2) [N] at the points
            `model.points`, in the axes of the body: those of the mesh, or of the first pin of beams.

        Returns
        -------
        Accuracy : frequencies, deflections and stresses of both, and their errors; `print` shows a table.

        Raises
        ------
        InputError : pins that the body has not, loads of another shape.
        """
        if held is not None:
            held = [self.aliases.get(name, name) for name in checks.sequence(self.label, "held", held, "names of pins")]
        forces: dict[str, Load] = {}
        for name, load in (loads or {}).items():
            forces[name] = load.on(load.plane_of(self)).forces if isinstance(load, MeshLoad) else load
        return accuracy(self.basis, self.element, count, held, forces)

    def nodes(self) -> tuple[Node, ...]:
        return self.model.placed(self.basis.nodes)

    @property
    def main(self) -> str:
        return self._pins[0].name

    @property
    def aliases(self) -> dict[str, str]:
        names = {pin.name for pin in self._pins}
        return {alias: node for alias, node in self.body.aliases.items() if node in names}

    def attach(self, owner: str, point: tuple[float, float]) -> Attachment:
        remedy = "or make it a pin of the body, which a reduced one keeps"
        node = nearest_node(self.label, owner, self._pins, point, self._extent or 1.0, remedy)
        return Attachment(self.name, node.name, (0.0, 0.0))

    def references(self) -> tuple[str, ...]:
        return ()

    def total_mass(self) -> float:
        return self.element.mass

    def start_velocity(self) -> tuple[float, float, float] | None:
        """The declared velocity of the body as a rigid one, of the first pin.

        Raises
        ------
        InputError : a body with a field of velocities or displacements.
        """
        given = self.body.start_velocity()
        if self.body.start_displacement() is not None or np.ndim(given) > 1:  # type: ignore[arg-type]
            text = f"{self.label}: start fields of a body with all its nodes cannot be kept by a reduced one."
            raise InputError(f"{text} Give the body one velocity (vx, vy, omega), or start from a static equilibrium.")
        if given is None:
            return None
        vx, vy, omega = np.asarray(given, dtype=float).tolist()
        main, first = self.body.node(self.body.main), self._pins[0]
        return vx - omega * (first.y - main.y), vy + omega * (first.x - main.x), omega

    def shapes(self, mechanism: Mechanism) -> Shapes:  # noqa: ARG002 - the body alone
        model, moved = self.model, self.moved_by
        if model.drawn is None or model.drawn_by is None:
            return ()
        shapes, fibres = self.basis.shapes, np.zeros((0, 0))
        if not model.drawn.materials and model.stresses is not None:
            fibres = model.stresses(shapes)[:, 0]
        own: dict[str, Any] = {"nodes": moved.nodes, "poses": moved.poses, "weights": moved.weights}
        own |= {"shortening": _nested(self.element.directions), "fibres": _nested(fibres)}
        return (replace(model.drawn, part=self.name, basis=_nested(np.asarray(model.drawn_by @ shapes)), **own),)

    @property
    def moved_by(self) -> MeshShape:
        """Drawing record without a mesh: the nodes of the body, their poses in its axes, weights of its frame."""
        nodes, (poses, weights) = self.basis.nodes, self.element.frame_parameters()
        own: dict[str, Any] = {"nodes": tuple(node.name for node in nodes), "poses": _nested(poses)}
        own["weights"] = () if self.basis.by_pin else _nested(weights[:, :2])
        return MeshShape(self.name, "", points=(), cells=(), loops=(), **own)

    @property
    def seeks_stress(self) -> bool:
        return self.body.seeks_stress if self.stress is None else self.stress

    @property
    def whole_body(self) -> Reducible:
        return self.body

    @property
    def all_materials(self) -> tuple[Material, ...]:
        return self.body.all_materials

    def reference_points(self) -> np.ndarray:
        model, (c, s) = self.model, (np.cos(self.model.direction), np.sin(self.model.direction))
        own = np.zeros((0, 2)) if model.drawn is None else np.array(model.drawn.points)
        return np.asarray(model.origin + own @ np.array([[c, s], [-s, c]]))

    def left_out(self, load: NodalLoad) -> float:
        whole, left = left_out(self, self.model.shape.T @ load.forces.ravel())
        return left / whole if whole > 0.0 else 0.0

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:
        """Findings on strains and stresses, and on deformations that the kept shapes cannot show."""
        yield from super().findings_after(mechanism, motion)
        yield from deformation_findings(self, motion)

    @property
    def plane(self) -> PlaneBody | None:
        return self.body.plane if isinstance(self.body, MeshBody) else None

    def loaded(self, name: str, load: NodalLoad, history: Motion | None) -> Sequence[Contribution]:
        return load_contributions(self, name, load, history)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        coordinates, p = self.coordinates, self.element.parameters(mechanism.gravity)
        element, stresses = REDUCED.contribution(self.name, coordinates, p), self.model.stresses
        if stresses is None or not self.seeks_stress:
            return [element]
        groups = GROUPS.of((self._key, self._options), lambda: group_parameters(stresses(self.basis.shapes)))
        return [element, peak_stress_signal(self.name, coordinates, p, groups)]


def _nested(array: np.ndarray) -> Any:
    """Nested tuples of the numbers of an array."""
    return tuple(map(_nested, array)) if array.ndim > 1 else tuple(array.tolist())
