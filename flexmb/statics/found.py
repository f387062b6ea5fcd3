"""Record of a static equilibrium."""

from __future__ import annotations

import numpy as np

from flexmb import checks, display
from flexmb.display import counted, cut
from flexmb.fields import field, record
from flexmb.model.part import Part, name_of
from flexmb.program.program import resolve


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
