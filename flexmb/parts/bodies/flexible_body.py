"""Base of flexible bodies: beams, bosses that correct their mass, damping, fields at the start."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY
from functools import cached_property
from typing import ClassVar

import numpy as np

from flexmb import checks, planar
from flexmb.elastic.beams.corotational import chord_share
from flexmb.elastic.beams.section import Section, checked_factor
from flexmb.errors import InputError
from flexmb.fields import field, instance, not_negative, positive, record
from flexmb.findings.finding import Finding, found
from flexmb.model.contributions import Attachment, Contribution
from flexmb.model.elastic_body import ElasticBody
from flexmb.model.law import Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Pose, WatchedMotion
from flexmb.model.shape import Shapes
from flexmb.parts.bodies import flexible

Point = tuple[float, float]
THICK_ARC = 0.1  # height of a section over the radius of an arc, above which the stress is not that of a straight beam
LEAST_SLENDERNESS = 5.0  # length of a beam over its height, below which shear cannot be left out


@record
class FlexibleBody(ElasticBody):
    """Base of bodies made of beams; a subclass lays them out and fits bosses to the nodes at its corners."""

    # - elements: a number of equal elements, or increasing fractions of the length where inner nodes stand.
    # - mass, inertia: bosses at the corners add to the beams what is missing.
    # - rotary_inertia (Rayleigh beam): False for none, True for rho I, or a number >= 0; None: rho I with shear, none
    #   without.
    # - shear (Timoshenko beam): False for none, True for the shear factor of the section (Cowper's, for Poisson's ratio
    #   of the material), or the shear factor, such as 5/6.
    # - stress: the largest normal stress in the outer fibres, signals `von_mises` [Pa] and `von_mises_node`, the number
    #   of its node, or of the middle of an element behind all nodes.  None: where the material has a yield stress and
    #   all sections know their outer fibres.
    # - velocity: of a rigid motion, or one (vx, vy, omega) per node; displacement: per node [m, rad], added to the
    #   reference configuration.
    stress_name: ClassVar[str] = "normal stress in the outer fibres"
    theory: ClassVar[str] = "beams"
    _: KW_ONLY
    section: Section | tuple[Section, ...] = field("cross section of all beams, or one a beam")
    material: Material = field("material", rule=instance(Material, "a Material(...)"))
    elements: flexible.Elements | tuple[flexible.Elements, ...] = field(
        "elements a beam, or fractions of its length, or such a beam", default=4
    )
    mass: float | None = field("total mass; None: the beams' own", "kg", positive, default=None)
    inertia: float | None = field("about the centre of mass; None: the beams' own", "kg m^2", positive, default=None)
    centre: float | Point | None = field("of mass, when mass or inertia is given; None: the beams' own", default=None)
    damping: float = field("stiffness-proportional damping time zeta2 (Rayleigh)", "s", not_negative, default=0.0)
    mass_damping: float = field("mass-proportional damping rate zeta1 (Rayleigh)", "1/s", not_negative, default=0.0)
    rotary_inertia: bool | float | None = field("of the sections, see above", "kg m", default=None)
    shear: bool | float = field("whether beams have shear, see above", default=False)
    stress: bool | None = field(
        "whether every accepted step looks for the largest stress, see above",
        rule=instance(bool, "True, False or None"), default=None,
    )  # fmt: skip
    velocity: flexible.Triple | flexible.FieldLike | None = field(
        "(vx, vy, omega) at the start; None: as driven", default=None
    )
    displacement: flexible.FieldLike | None = field("(dx, dy, dtheta) at the start, as above; None: none", default=None)

    @property
    @abstractmethod
    def corners(self) -> tuple[str, ...]:
        """Names of the nodes at the corners."""

    @property
    @abstractmethod
    def corner_points(self) -> tuple[Point, ...]:
        """Points of the corners in the reference configuration [m]."""

    @property
    @abstractmethod
    def beams(self) -> tuple[flexible.Beam, ...]:
        """The beams; the frame of mass-proportional damping lies on the first one."""

    @abstractmethod
    def _fit(self, own: flexible.RigidProperties, mass: float) -> flexible.Bosses:
        """Bosses that turn the beams' `own` properties into the declared ones, with the total `mass` [kg]."""

    @abstractmethod
    def _further_mass(self) -> tuple[float, Point, float]:
        """Mass [kg], point [m] and moment of inertia [kg m^2] beside beams and bosses at corners."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.section, list):
            object.__setattr__(self, "section", tuple(self.section))
        for section in self._sections:
            checks.instance(self.label, "section", section, Section, "a cross section such as Rectangle(...)")
        if self.stress and not self.knows_stress:
            text = f"{self.label}: stress is True, and a section does not know its outer fibre"
            raise InputError(f"{text}. Give outer_fibre=... [m] to the section.")
        _ = self._options

    def _check_fields(self, count: int, places: Sequence[float] | None) -> None:
        """Check the start fields of `count` nodes; functions are evaluated at `places`, or refused without them."""
        for name, checked in (("velocity", flexible.start_velocity), ("displacement", flexible.start_displacement)):
            object.__setattr__(self, name, checked(self.label, getattr(self, name), count, places))

    @cached_property
    def _bosses(self) -> flexible.Bosses:
        """Masses and moments of inertia at the corners, which give the body its declared mass properties."""
        if self.mass is None and self.inertia is None:
            return flexible.Bosses((0.0,) * len(self.corners), 0.0, 0.0)
        own = flexible.RigidProperties.of(self._mass_parts())
        return self._fit(own, own.mass if self.mass is None else self.mass)

    def properties(self) -> flexible.RigidProperties:
        """Mass, centre of mass and moment of inertia as a rigid body in the reference configuration."""
        bosses = self._bosses
        corners = [(mass, point, bosses.inertia) for mass, point in zip(bosses.masses, self.corner_points, strict=True)]
        return flexible.RigidProperties.of([*self._mass_parts(), *corners, self._further_mass()])

    @property
    def seeks_stress(self) -> bool:
        return (self.material.yield_stress is not None and self.knows_stress) if self.stress is None else self.stress

    @property
    def knows_stress(self) -> bool:
        return all(map(flexible.knows_stress, self._sections))

    def reference_points(self) -> np.ndarray:
        """Places (n, 2) of the nodes, then of the middles of the elements, in the reference configuration [m]."""
        return np.array([(node.x, node.y) for node in self.nodes()] + [p for beam in self.beams for p in beam.middles])

    def place_name(self, number: int) -> str:
        count = len(self.nodes())
        return super().place_name(number) if number < count else f"the middle of element {number - count}"

    def strain_at_rest(self, mechanism: Mechanism, pose: Pose) -> tuple[float, float]:
        strain = float(self._strains(lambda names: np.array([[pose[name] for name in names]])).max())
        return strain, max(strain * self.material.young, super().strain_at_rest(mechanism, pose)[1])

    def strain_in(self, motion: WatchedMotion) -> tuple[float, float, float]:
        strains = self._strains(lambda names: motion.rows(*names))
        k = int(np.argmax(strains))
        return float(strains[k]), float(strains[k]) * self.material.young, float(motion.times[k])

    def _strains(self, rows: Callable[[list[str]], np.ndarray]) -> np.ndarray:
        """Largest strains (n,) of n poses, by a function that gives `rows` (n, k) of coordinates by full names."""
        nodes, found_here = {node.name: node for node in self.nodes()}, []
        for beam in self.beams:
            names = [f"{self.name}.{node}.{axis}" for axis in ("x", "y", "theta") for node in beam.nodes]
            found_here.append(flexible.beam_strains(beam, nodes, np.split(rows(names), 3, axis=1)).max(axis=1))
        return np.asarray(np.max(found_here, axis=0))

    def odd_sizes(self) -> Iterator[Finding]:
        """Findings on thick arcs of unknown outlines, and on beams without shear that are short for their height."""
        arcs = [beam for beam in self.beams if beam.turn and self.seeks_stress]
        heights = [2.0 * _outer_fibre(beam.section) * abs(beam.turn) / beam.length for beam in arcs]
        unknown = [h for h, beam in zip(heights, arcs, strict=True) if np.isnan(flexible.arc_factors(beam)).any()]
        if unknown and max(unknown) > THICK_ARC:
            text = f"{self.label}: the radius of an arc is {1.0 / max(unknown):.3g} times the height of its section,"
            text += " whose outline is unknown: its stress is that of a straight beam, too small at the inner fibre."
            remedy = "Take a Rectangle, Circle or Tube, or a section of your own with over_radius_at."
            yield found("thick-arc", (self.name,), text, remedy, radius_over_height=1.0 / max(unknown))
        if self.shear is not False:
            return
        height = max(2.0 * _outer_fibre(beam.section) for beam in self.beams)
        length = float(np.hypot(*np.ptp(self.reference_points(), axis=0)))
        if length < LEAST_SLENDERNESS * height:
            text = f"{self.label} is {length:.4g} m long and {height:.4g} m high: no slender beam."
            remedy = "Take a rigid body, or shear=True; the bending of this one would lack its shear."
            yield found("stubby-beam", (self.name,), text, remedy, length=length, height=height)

    def total_mass(self) -> float:
        return self.properties().mass

    def attach(self, owner: str, point: Point) -> Attachment:
        points = self.corner_points
        size = max([planar.distance(points[0], corner) for corner in points[1:]])
        node = flexible.nearest_node(self.label, owner, self.nodes(), point, size)
        return Attachment(self.name, node.name, (0.0, 0.0))

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        nodes, gravity = {n.name: n for n in self.nodes()}, mechanism.gravity
        return [
            *flexible.beam_pieces(self.name, self.beams, nodes, self.damping, gravity),
            *self._boss_pieces(gravity),
            *flexible.mass_damping_pieces(self.name, self.beams, self.beams[0], self.mass_damping, self._lumps()),
            *([flexible.beam_stress_signal(self.name, self.beams, nodes, gravity)] if self.seeks_stress else []),
        ]

    def shapes(self, mechanism: Mechanism) -> Shapes:
        return flexible.beam_shapes(self.name, self.beams, {n.name: n for n in self.nodes()}, mechanism.gravity)

    @classmethod
    def prepare(cls, parts: Sequence[FlexibleBody]) -> None:
        flexible.assemble(beam for part in parts for beam in part.beams)

    def _boss_pieces(self, gravity: Point) -> list[Contribution]:
        """Contributions of the masses at the corners and at their mean."""
        return flexible.boss_pieces(self.name, self.corners, self._bosses, gravity)

    def _lumps(self) -> dict[str, tuple[float, float]]:
        """Mass [kg] and moment of inertia [kg m^2] at the corners, by node."""
        return {name: (m, self._bosses.inertia) for name, m in zip(self.corners, self._bosses.masses, strict=True)}

    def _mass_parts(self) -> list[tuple[float, Point, float]]:
        """Mass, centre of mass and moment of inertia of every element."""
        return [part for beam in self.beams for part in flexible.mass_parts(beam)]

    @property
    def _sections(self) -> tuple[Section, ...]:
        """The sections, one of all beams or one of each."""
        return self.section if isinstance(self.section, tuple) else (self.section,)

    @cached_property
    def _options(self) -> tuple[float | None, float | None]:
        """Rotary inertia [kg m] (None: rho I) and shear of a `Beam` (None: that of its sections, if they know it)."""
        shear: float | None = None if self.shear is True else 0.0
        if not isinstance(self.shear, bool):
            shear = checked_factor(self.label, "shear", self.shear)
        for section in self._sections if shear is None else ():
            try:
                section.shear_factor_at(0.5, self.material.poisson)
            except InputError as error:
                raise InputError(f"{self.label}: shear is True, and {error}") from None
        rotary = shear != 0.0 if self.rotary_inertia is None else self.rotary_inertia
        if isinstance(rotary, bool):
            return None if rotary else 0.0, shear
        return checks.not_negative(self.label, "rotary_inertia", rotary, "kg m"), shear

    def _beam(
        self, names: Sequence[str], ends: tuple[Point, Point], places: Sequence[float], section: Section, turn: float
    ) -> flexible.Beam:
        """A beam between two points with nodes of these names at fractions of its length."""
        length = planar.distance(*ends) / chord_share(turn)
        stations = tuple([s * length for s in places])
        return flexible.Beam(tuple(names), *ends, stations, section, self.material, *self._options, turn)


def _outer_fibre(section: Section) -> float:
    """Largest distance of the outer fibre [m]; where it is unknown that of a rectangle of the same A and I."""
    places = np.array([0.0, 0.5, 1.0])
    if flexible.knows_stress(section):
        return float(np.max(section.outer_fibre_at(places)))
    return float(np.max(np.sqrt(3.0 * section.second_moment_at(places) / section.area_at(places))))


def beam_of_mesh(
    label: str, path: str, tags: set[int], stations: np.ndarray, sections: Mapping[int, Section]
) -> tuple[flexible.Elements, Section]:
    """Inner nodes as fractions of the length, and the one section of a straight beam, by stations (n,) and `tags`."""
    missing = sorted(tags - set(sections))
    if missing:
        raise InputError(f"{label}: {path} has cells with tag {missing[0]}, for which sections has no entry. Add one.")
    if len({sections[t] for t in tags}) != 1:
        raise InputError(f"{label}: {path} has cells of several sections {sorted(tags)}; use FlexibleFrame.from_mesh.")
    return tuple(float(s) for s in stations[1:-1] / stations[-1]) or 1, sections[min(tags)]
