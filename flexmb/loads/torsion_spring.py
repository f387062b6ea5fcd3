"""Linear spring and damper between the rotations of two bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import TYPE_CHECKING

from flexmb import checks
from flexmb.kernels import account_kernel, compiled, element_kernel, energy_kernel, force_kernel, signal_kernel
from flexmb.loads.moving_rest import check_rest, couple_kernel, moving_end, rest_at_start
from flexmb.model.contributions import SUBTRACTS, Contribution, ElementContribution, signal_contributions
from flexmb.model.law import Motion
from flexmb.model.part import Part

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


SIGNALS = (("angle", "rad"), ("rate", "rad/s"), ("torque", "N m"), ("energy", "J"))
"""Signals with their units, in the order of `torsion_spring_signal`."""


@compiled
def put_moment(p, q, v, r):
    """r (2,); energy of the spring, no weight, power of the damper."""
    k, d, angle = p
    turn, rate = q[1] - q[0] - angle, v[1] - v[0]
    moment = k * turn + d * rate
    r[0] = -moment
    r[1] = moment
    return 0.5 * k * turn * turn, 0.0, d * rate * rate


@element_kernel
def torsion_spring_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """M = k (theta2 - theta1 - angle0) + d (omega2 - omega1); q = (theta1, theta2)."""
    k, d, _ = p
    put_moment(p, q, v, r)
    for i in range(2):
        for j in range(2):
            sign = 1.0 if i == j else -1.0
            K[i, j] = sign * k
            C[i, j] = sign * d


@force_kernel
def torsion_spring_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (2,) alone."""
    put_moment(p, q, v, r)


@account_kernel
def torsion_spring_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """Residual r (2,); no mass; energies as `torsion_spring_energy` gives them."""
    return put_moment(p, q, v, r)


@energy_kernel
def torsion_spring_energy(p, t, q, v):
    """Energy of the spring, power of the damper."""
    k, d, angle = p
    return 0.5 * k * (q[1] - q[0] - angle) ** 2, 0.0, d * (v[1] - v[0]) ** 2


@signal_kernel
def torsion_spring_signal(p, t, q, v, a):
    """By its number: 0 relative rotation, 1 its rate, 2 torque on the second body, 3 energy of the spring."""
    k, d, angle, drawn, number = p
    which, turn, rate = int(number), q[1] - q[0] - angle, v[1] - v[0]
    if which < 2:
        return q[1] - q[0] - drawn if which == 0 else rate
    return -k * turn - d * rate if which == 2 else 0.5 * k * turn * turn


@dataclass(frozen=True)
class TorsionSpring(Part):
    """Linear torsion spring and damper between two bodies.

    Signals: angle (of the second body against the first, 0 in the reference configuration) [rad], rate [rad/s], torque
    (of spring and damper, on the second body) [N m], energy (of the spring) [J].

    Parameters
    ----------
    name : the part's name.
    first, second : the bodies; `GROUND` is the frame.
    stiffness : k [N m/rad], >= 0.
    damping : d [N m s/rad], >= 0.
    free_angle : relative rotation without moment [rad], counted from the reference configuration; a motion: its value
        at each time, as of a spring whose far end an actuator turns.
    at : point of the reference configuration [m] whose nodes are connected; None: the main nodes.

    Raises
    ------
    InputError : negative stiffness or damping, a rest angle that is neither a number nor a motion.

    Notes
    -----
    With a rest angle that moves, the energy of the spring is counted with the rest angle at t = 0, and the rest of its
    moment as a load: the work of the load is the actuator's, less what the spring holds more than is counted.
    """

    formerly = (("rest_angle", "free_angle"),)
    first: Part
    second: Part
    _: KW_ONLY
    stiffness: float
    damping: float = 0.0
    free_angle: float | Motion = 0.0
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.not_negative(self.label, "stiffness", self.stiffness, "N m/rad")
        checks.not_negative(self.label, "damping", self.damping, "N m s/rad")
        check_rest(self.label, "free_angle", self.free_angle, "rad")
        rest_at_start(self.label, "free_angle", self.free_angle)
        if self.at is not None:
            object.__setattr__(self, "at", checks.point(self.label, "at", self.at))

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One element on two angles and four signals; with a rest angle that moves two loads more, and no energy."""
        rest = rest_at_start(self.label, "free_angle", self.free_angle)
        coordinates, drawn = [], 0.0
        for part, sign in ((self.first, -1.0), (self.second, 1.0)):
            body = mechanism.body(part.name, self.label)
            node = body.main if self.at is None else body.attach(self.label, self.at).node
            coordinates.append((body.name, node, 2))
            drawn += sign * body.node(node).theta
        p = (self.stiffness, self.damping, rest + drawn)
        pair = tuple(coordinates)
        element = ElementContribution(
            self.name,
            torsion_spring_kernel,
            pair,
            p,
            energy=torsion_spring_energy,
            force=torsion_spring_force,
            account=torsion_spring_account,
        )
        moving = moving_end(self.name, couple_kernel, pair, self.stiffness, self.free_angle, rest, ())
        signals = signal_contributions(self.name, torsion_spring_signal, SIGNALS, pair, (*p, drawn))
        if moving:
            angle, rate, torque, _ = signals
            counted = (self.stiffness, self.damping, drawn, *torque.p[3:])
            signals = [angle, rate, replace(torque, p=counted, use_of_factor=SUBTRACTS)]
        return [element, *moving, *signals]
