"""Base of controllers: parts with inputs, states of their own, and outputs that are factors of loads."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexmb.errors import ModelError
from flexmb.model.contributions import ControlContribution, ElementContribution, SignalContribution
from flexmb.model.part import Part

if TYPE_CHECKING:
    from flexmb.model.contributions import Contribution
    from flexmb.model.mechanism import Mechanism


@dataclass(frozen=True)
class Controller(Part):
    """Base of parts that compute the factors of loads from signals.

    Parameters
    ----------
    name : name of the controller.
    """

    @abstractmethod
    def control(self) -> ControlContribution:
        """Law, inputs, states and outputs."""

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:  # noqa: ARG002 - the same in all
        """One control law."""
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
            element = forces[0] if len(forces) == 1 and isinstance(forces[0], ElementContribution) else None
            if element is None or element.energy is not None:
                text = f"{self.label}: {load.label} cannot be controlled"
                remedy = "give a Force or a Torque, whose value per unit of the output it holds"
                raise ModelError(f"{text}; {remedy}, or a load on the mesh of a Reduced body.")
            if element.factor is not None:
                text = f"{self.label}: {load.label} has a history, and would be multiplied twice"
                raise ModelError(f"{text}. Leave the history out, and let the control law depend on time.")
        for other in mechanism.controllers:
            twice = set(self.control().loads) & set(other.control().loads)
            if other.name < self.name and twice:  # told once
                text = f"{self.label} and {other.label} both control {sorted(twice)[0]!r}"
                raise ModelError(f"{text}. Give each a load of its own; forces on one body add up.")


def refuse_controllers(mechanism: Mechanism, analysis: str, reason: str, *, with_memory: bool = False) -> None:
    """Refuse an analysis of a mechanism with controllers.

    With `with_memory` only controllers with states of their own and sampled ones are refused: the outputs of others are
    functions of the motion.  The message begins with `analysis`.
    """
    controllers = getattr(mechanism, "controllers", ())  # the compiler refuses what is no mechanism
    if with_memory:
        controllers = [part for part in controllers if part.control().states or part.control().is_sampled]
    if controllers:
        listed = ", ".join(part.label for part in controllers)
        loads = ", ".join(repr(name) for part in controllers for name in part.control().loads)
        text = f"{analysis}: {reason}; {mechanism.label} has {listed}"
        raise ModelError(
            f"{text}. Remove it with without_part(...), then the loads {loads or '-'} have their full values."
        )
