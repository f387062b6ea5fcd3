"""Remarks of a run on the safety of flexible bodies against yield, by the largest stress of all accepted steps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.display.text import number_text
from flexmb.model.material import Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.signal import Signals
from flexmb.results.peaks import Peaks

if TYPE_CHECKING:
    from flexmb.planes.plane_body import PlaneBody
    from flexmb.results.reference_points import STRESSED

LEAST = 1e-6
"""Stress over yield stress up to which nothing is said: round-off of a body without loads."""


def strength_remarks(mechanism: Mechanism, signals: Signals, peaks: Peaks) -> Iterator[str]:
    """A sentence on each body that looks for its largest stress and whose yield stress is known."""
    for body in mechanism.bodies:
        place = signals.places.get(f"{body.name}.von_mises")
        if place is not None:
            yield from _remark(body, signals, peaks, place)


def _remark(body: Any, signals: Signals, peaks: Peaks, place: int) -> Iterator[str]:
    """The sentence on one body."""
    from flexmb.results.reference_points import STRESSED, reference_points

    if not isinstance(body, STRESSED):
        return
    stress, limits = float(peaks.values[place]), yield_stresses(body)
    if not limits or not stress > LEAST * min(limits):
        return
    node = round(float(peaks.values[signals.places[f"{body.name}.von_mises_node"]]))
    x, y = reference_points(body)[node].tolist()
    kind = "normal stress in the outer fibres" if isinstance(source_of(body), FlexibleBody) else "von Mises stress"
    when = f"at t = {peaks.times[place]:.6g} s at node {node}, ({x:.4g}, {y:.4g}) m in the reference configuration"
    safety, weakest = min(limits) / stress, " of the weakest material, at least" * (len(limits) > 1)
    text = f"{body.label}: largest {kind} {number_text(stress)} Pa {when}"
    text += f": safety against yield{weakest} {safety:.3g}"
    if safety < 1.0:
        text += f"; it yields at {min(limits):.3g} Pa, and stresses are those of a linear elastic material"
    yield f"{text}."


def source_of(body: STRESSED) -> FlexibleBody | PlaneBody:
    """Body with all its nodes, of which a reduced body is made."""
    source: Any = getattr(body, "body", body)
    return source  # type: ignore[no-any-return]


def materials_of(source: FlexibleBody | PlaneBody) -> list[Material]:
    """Materials of a body with all its nodes."""
    if isinstance(source, FlexibleBody):
        return [source.material]
    from flexmb.planes.regions import by_region

    return [material for _, material in by_region(source.label, "material", source.material)]


def yield_stresses(body: STRESSED) -> set[float]:
    """Different yield stresses of the materials of a body [Pa]; empty where one is unknown."""
    known = {material.yield_stress for material in materials_of(source_of(body))}
    return {limit for limit in known if limit is not None} if None not in known else set()
