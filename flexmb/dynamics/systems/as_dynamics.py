"""Conversion of arguments: a mechanism or a `Dynamics` becomes a flow or a map."""

from __future__ import annotations

from typing import Any

from flexmb.dynamics.sections.section_map import SectionMap
from flexmb.dynamics.sections.stroboscopic import StroboscopicMap
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.run.simulate import Step
from flexmb.step.newmark.method import Newmark


def dynamics_of(
    caller: str, system: Any, *, period: float | None = None, step: Step | None = None, method: Newmark | None = None
) -> Dynamics:
    """`system` itself, or the flow of a mechanism; a `Dynamics` with a step or a method (it has its own) is refused."""
    if isinstance(system, Mechanism):
        return MechanismFlow(system, step=step, method=method, period=period)
    if not isinstance(system, Dynamics):
        text = f"{caller}: system is {system!r}"
        raise InputError(f"{text}; it must be a Mechanism, or a flow or map as ODE, Map, StroboscopicMap.")
    if step is not None or method is not None:
        text = f"{caller} {system.name!r}: step= and method= belong to a mechanism"
        raise InputError(f"{text}; this system has its own. Give them where the system is built.")
    return system


def strobe_of(caller: str, system: Dynamics, period: float | None) -> Dynamics:
    """Stroboscopic map of a flow, by default with the flow's own period [s]; a map is returned as it is."""
    if isinstance(system, ContinuousFlow):
        return StroboscopicMap(system, period)
    if period is not None:
        raise InputError(f"{caller} {system.name!r}: period= belongs to a flow; this is a map. Leave it out.")
    return system


def clock(system: Dynamics) -> float:
    """Time of a system, by which exponents count: seconds of a flow and of its sections, iterations of a map."""
    return system.flow.time if isinstance(system, (StroboscopicMap, SectionMap)) else system.time
