"""Static equilibrium as it is found, and steady rotation: a mechanism at rest in a frame that turns at constant speed.

In the turning frame, with the tangents K, C, M of r(q, v, a) at the instant at which it lies on the fixed one, a motion
y(t) obeys Equation (8.6) of docs/theory/equilibrium.md; S turns translations by a quarter and leaves angles alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb import checks, display
from flexmb.display import counted, cut
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.engine.system.work import MOTION_RATE
from flexmb.errors import InputError
from flexmb.fields import field, record
from flexmb.late import sp
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Part, name_of
from flexmb.program.program import Program, resolve

SPEED_TOLERANCE = 1e-9  # drives may turn at the speed of the frame or stand still, to this part of it


@dataclass(frozen=True)
class Spin:
    """Rotation of the frame: speed [rad/s] and centre [m]."""

    speed: float
    about: tuple[float, float]

    def motion(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Velocities and accelerations (n_q + 3,) of coordinates q and of the ground, all turning with the frame."""
        pose = np.append(q, np.zeros(3)).reshape(-1, 3)
        arm = pose[:, :2] - self.about
        v, a = np.zeros_like(pose), np.zeros_like(pose)
        v[:, 0], v[:, 1], v[:, 2] = -self.speed * arm[:, 1], self.speed * arm[:, 0], self.speed
        a[:, :2] = -(self.speed**2) * arm
        return v.ravel(), a.ravel()

    def at(
        self, system: StateEvaluation, q: np.ndarray, lam: np.ndarray | None = None,
        weights: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> StateEvaluation:  # fmt: skip
        """Evaluate a program that turns with the frame."""
        return system.at(q, *self.motion(q), lam, weights=weights)

    def matrices(self, system: StateEvaluation, q: np.ndarray, lam: np.ndarray) -> tuple[sp.csc_matrix, ...]:
        """Stiffness, damping and mass (n_q, n_q) of motions in the frame; the system is left evaluated there."""
        M = self.at(system, q, lam, (0.0, 0.0, 1.0)).block()
        C = self.at(system, q, lam, (0.0, 1.0, 0.0)).block()
        K = self.at(system, q, lam, (1.0, 0.0, 0.0)).block()
        if not self.speed:
            return K, C, M
        quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # (x, y, theta) to (-y, x, 0)
        S = sp.csr_matrix(sp.block_diag([quarter] * (len(q) // 3)))
        W = self.speed
        return (K + W * (C @ S) + W**2 * (M @ S @ S)).tocsc(), (C + 2.0 * W * (M @ S)).tocsc(), M


def check_spin(owner: str, mechanism: Mechanism, program: Program, system: StateEvaluation, spin: Spin) -> None:
    """Refuse loads that are not steady in the rotating frame: gravity, and drives of another speed."""
    if not spin.speed:
        return
    if any(mechanism.gravity):
        text = f"{owner}: gravity is {mechanism.gravity} and spin is {spin.speed:g} rad/s; seen from the turning frame"
        raise InputError(f"{text} gravity turns, and nothing is steady. Set gravity to (0, 0), or simulate the motion.")
    driven = program.tables.constraints.motion >= 0
    # Sense of a driven coordinate: 1 body against ground, -1 ground against body, else 0. The ground as it is drawn
    # stands still, so only such a row may have the speed of the frame.
    sense = {}
    for contribution in mechanism.contributions().constraints:
        ends = (contribution.coordinates[0][0], contribution.coordinates[-1][0])
        way = 1 if ends[0] == GROUND.name else -1 if ends[1] == GROUND.name else 0
        for row in contribution.motions:
            name = f"{contribution.part}.{row.name}" if row.name else contribution.part
            sense[name] = way if row.units[0] == "rad" else 0
    for name, speed in zip(program.drives, system.work.drive[driven, MOTION_RATE], strict=True):
        if not speed or (sense[name] and abs(speed - sense[name] * spin.speed) <= SPEED_TOLERANCE * abs(spin.speed)):
            continue
        still = "It moves a body along, or against another body: stop it, or simulate the motion."
        remedy = "Give both the same speed." if sense[name] else still
        text = f"{owner}: drive {name!r} moves at {speed:g} and the frame turns at {spin.speed:g} rad/s;"
        raise InputError(f"{text} a steady rotation needs drives that stand still in it. {remedy}")


@record
class Equilibrium:
    """A static equilibrium.

    `equilibrium["rod.end.y"]` is a coordinate [m, rad]; `force("O")` the reaction of a joint.
    """

    q: np.ndarray = field("(n_q,) coordinates")
    lam: np.ndarray = field("(n_c,) multipliers")
    names: tuple[str, ...] = field("(n_q,) names of the coordinates")
    aliases: dict[str, str] = field("other names of nodes")
    reactions: dict[str, tuple[float, float, float]] = field(
        "(fx, fy, moment) on the second body of every joint [N, N m]; moment 0 where the joint carries none. What a "
        "body keeps within itself, such as the rotation of a particle, is no reaction"
    )
    iterations: int = field("Newton iterations of all load steps")
    spin: float = field("speed of the frame in which the mechanism is at rest, counter-clockwise", "rad/s", default=0.0)
    about: tuple[float, float] = field("centre of that rotation", "m", default=(0.0, 0.0))
    stable: bool | None = field("whether all stiffness is positive; None of follower forces", default=None)

    def __getitem__(self, name: str) -> float:
        place = resolve(name, self.aliases)
        return float(self.q[self.names.index(checks.one_of("Equilibrium", "coordinate", place, self.names))])

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)

    def __repr__(self) -> str:
        reactions = [cut(f"  reactions: {', '.join(self._reactions())}")] if self.reactions else []
        return "\n".join([self._title(), *reactions])

    def _title(self) -> str:
        kind = {True: "stable", False: "unstable", None: "stability unknown"}[self.stable]
        spin = f", turning at {self.spin:.6g} rad/s" if self.spin else ""
        text = f"{counted(len(self.q), 'coordinate')}, {counted(self.iterations, 'Newton iteration')}"
        return f"Equilibrium ({kind}{spin}): {text}"

    def _reactions(self) -> list[str]:
        found = []
        for joint, (fx, fy, moment) in self.reactions.items():
            force = float(np.hypot(fx, fy))
            texts = [f"{force:.4g} N"] if force or not moment else []
            texts += [f"{moment:.4g} N m"] if moment else []
            found.append(f"{joint} {' and '.join(texts)}")
        return found

    def _repr_html_(self) -> str:
        rows = [(joint, *(f"{value:.6g}" for value in values)) for joint, values in self.reactions.items()]
        coordinates = [(name, f"{value:.6g}") for name, value in zip(self.names, self.q, strict=True)]
        reactions = display.table(rows, ("reaction of", "fx [N]", "fy [N]", "moment [N m]"))
        return display.page(self._title(), "", reactions, display.folded("coordinates", display.table(coordinates)))

    def force(self, joint: Part | str) -> tuple[float, float, float]:
        """(fx, fy, moment) that a `joint`, or that of this name, exerts on its second body [N, N m]."""
        return self.reactions[checks.one_of("Equilibrium", "joint", name_of(joint), self.reactions)]
