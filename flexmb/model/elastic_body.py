"""Base of bodies that bend, with findings on their strains and stresses."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexmb.display import number_text
from flexmb.errors import FlexmbError
from flexmb.findings.finding import Finding, found
from flexmb.model.contributions import AXES, SignalContribution
from flexmb.model.part import Body, Pose, WatchedMotion

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

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
