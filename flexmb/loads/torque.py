"""A torque on a body, constant or changing in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

from flexmb import checks
from flexmb.kernels import element_kernel, signal_kernel
from flexmb.loads.force import check_history, check_loaded
from flexmb.model.contributions import MULTIPLIES, Contribution, ElementContribution, signal_contributions
from flexmb.model.law import Motion
from flexmb.model.part import Part

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


SIGNALS = (("torque", "N m"), ("power", "W"))
"""Signals with their units, in the order of `torque_signal`."""


@element_kernel
def torque_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Torque on one theta."""
    (torque,) = p
    r[0] = -torque


@signal_kernel
def torque_signal(p, t, q, v, a):
    """By its number: 0 torque, 1 power."""
    torque, number = p
    return torque if number == 0.0 else torque * v[0]


@dataclass(frozen=True)
class Torque(Part):
    """A torque on a body, or on one node of a flexible one (an end moment of a beam).

    Signals: torque (times the value of `history`) [N m], power [W].

    Parameters
    ----------
    name : the load's name.
    body : the loaded body.
    torque : counter-clockwise [N m].
    at : point of the reference configuration [m] whose node takes the torque; None: the body's main node, of a flexible
        link the middle one.
    history : a motion whose value at the time t multiplies the torque, e.g. `Pulse(end=0.1)`; None: constant.

    Raises
    ------
    ModelError : a torque on the ground.
    InputError : a history that is no motion.

    Notes
    -----
    Static equilibrium takes the history at t = 0.
    """

    body: Part
    torque: float
    at: tuple[float, float] | None = None
    _: KW_ONLY
    history: Motion | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check_loaded(self, self.body)
        check_history(self, self.history)
        if self.at is not None:
            object.__setattr__(self, "at", checks.point(self.label, "at", self.at))

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One element on theta of the node, and two signals."""
        body = mechanism.body(self.body.name, self.label)
        node = body.main if self.at is None else body.attach(self.label, self.at).node
        theta = ((body.name, node, 2),)
        return [
            ElementContribution(self.name, torque_kernel, theta, (self.torque,), factor=self.history),
            *signal_contributions(self.name, torque_signal, SIGNALS, theta, (self.torque,), use_of_factor=MULTIPLIES),
        ]
