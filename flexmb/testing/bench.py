"""Test bench for the kernels of a part: random states, comparisons, and the report of the comparisons."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from flexmb.model.contributions import Coordinate
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part
from flexmb.program.numbering import Numbering
from flexmb.testing.differences import gradient
from flexmb.testing.tested_kernel import State, TestedKernel, at, entry

TOLERANCE = 1e-6
"""Largest relative error of a derivative, over the largest entry of its row."""

SMALL_ROW = 1e-4
"""Size of a row, over the largest row, below which its errors are related to the largest row."""

HIDDEN = 1e-6
"""Change of a function over its scale, relative to the function, below which errors are related to the function."""

BALANCE = 1e-12
"""Largest imbalance of forces and moments, over the sum of their magnitudes."""

TURNED = 1e-11
"""Largest relative change of a result by a rotation and shift of the frame."""

MAGNITUDES = (1e-6, 1e-3, 0.05, 0.3)
"""Distances of the states from the reference configuration: over the size of the piece, and in rad."""


Round = TypeVar("Round")


@dataclass(frozen=True)
class Check:
    """One line of a report.

    Parameters
    ----------
    name : kernel and checked property.
    states : number of states.
    error : largest relative error.
    skipped : number of further states at a kink, which were left out.
    """

    name: str
    states: int
    error: float = 0.0
    skipped: int = 0


@dataclass(frozen=True)
class Report:
    """Result of `check_part`; `str(report)` is a readable table.

    Parameters
    ----------
    part : name and class of the part.
    checks : lines of the report.
    """

    part: str
    checks: tuple[Check, ...]

    def __str__(self) -> str:
        width = max((len(c.name) for c in self.checks), default=0)
        lines = [f"{self.part}: keeps its contracts"]
        for c in self.checks:
            left_out = f", {c.skipped} at kinks left out" if c.skipped else ""
            lines.append(f"  {c.name:{width}s}  {c.states:4d} states, largest error {c.error:.1e}{left_out}")
        return "\n".join(lines)


class Bench:
    """Test bench for the kernels of one part; `seed` is that of the random states."""

    def __init__(self, mechanism: Mechanism, part: Part, seed: int) -> None:
        self.owner = f"Part {part.name!r} ({type(part).__name__})"
        self.number = Numbering(mechanism)
        self.pose = np.concatenate([self.number.pose(), np.zeros(3)])
        self.random = np.random.default_rng(seed)
        self.errors: dict[str, list[float]] = {}
        self.skipped: dict[str, int] = {}

    def report(self) -> Report:
        """Report of all checks so far."""
        names = dict.fromkeys([*self.errors, *self.skipped])
        checks = [(n, self.errors.get(n, []), self.skipped.get(n, 0)) for n in names]
        return Report(self.owner, tuple(Check(n, len(e), max(e, default=0.0), s) for n, e, s in checks))

    def note(self, name: str, error: float = 0.0) -> None:
        """Record a passed check: kernel and checked property, and its relative error."""
        self.errors.setdefault(name, []).append(float(error))

    def scales(self, coordinates: Sequence[Coordinate]) -> np.ndarray:
        """Scales of `coordinates`: the size of the piece for lengths, 1 for angles."""
        q = self.pose[self.number.dofs(coordinates)]
        extent = [np.ptp([x for x, c in zip(q, coordinates, strict=True) if c[2] == k] or [0.0]) for k in (0, 1)]
        size = math.hypot(*extent) or self.number.extent
        return np.array([1.0 if axis == 2 else size for _, _, axis in coordinates])

    def states(self, coordinates: Sequence[Coordinate], wanted: str) -> Iterator[State]:
        """Random states of each magnitude; every second one is in motion, and some have h = 0.

        `wanted` are names of the inputs, separated by blanks.
        """
        q, scale = self.pose[self.number.dofs(coordinates)], self.scales(coordinates)
        for k in range(3 * len(MAGNITUDES)):
            inputs = {
                "t": float(self.random.uniform(0.0, 2.0)),
                "h": (0.0, 1e-4, 1e-2)[k % 3],
                "q": q + MAGNITUDES[k // 3] * scale * self.random.uniform(-1.0, 1.0, len(q)),
                "v": 10.0 * (k % 2) * scale * self.random.uniform(-1.0, 1.0, len(q)),
                "a": 100.0 * (k % 2) * scale * self.random.uniform(-1.0, 1.0, len(q)),
            }
            yield {name: inputs[name] for name in wanted.split()}

    def derivative(
        self,
        tested: TestedKernel,
        formula: str,
        state: State,
        value: Any,
        function: Any,
        x: Any,
        scale: Any,
        **sizes: Any,
    ) -> None:
        """Compare a derivative of the kernel with differences of a function at x.

        The formula begins with the name of the derivative; `scale` is that of the differences.  `sizes` are `rows`,
        `columns`: weights that give all entries one unit; `floor`: smallest size of a row; `noise`: round-off of the
        function beyond that of its own size.
        """
        expected, uncertain = gradient(function, x, scale, sizes.get("noise", 0.0))
        value = np.asarray(value, dtype=float)
        expected, uncertain = expected.reshape(value.shape), uncertain.reshape(value.shape)
        weight = np.asarray(sizes.get("rows", 1.0))
        if value.ndim == 2:
            weight = np.broadcast_to(weight, value.shape[:1])[:, None] * sizes.get("columns", 1.0)
        size = np.abs(expected * weight)
        if value.ndim == 2:
            size = size.max(axis=1, keepdims=True, initial=0.0)
        # a derivative this small against the function itself is hidden by round-off
        hidden = HIDDEN * np.abs(function(x) * np.asarray(sizes.get("rows", 1.0))).max(initial=0.0)
        hidden *= np.max(np.asarray(sizes.get("columns", 1.0)) / scale)
        floor = max(SMALL_ROW * size.max(initial=0.0), sizes.get("floor", 0.0), float(hidden), 1e-300)
        size = np.maximum(size, floor)
        name = f"{tested.kernel.name}: {formula}"
        doubtful = uncertain * weight > 0.1 * TOLERANCE * size
        if np.any(doubtful):
            self._skip(tested, name, formula, state, doubtful)
            return
        error = np.abs(value - expected) * weight / size
        wrong = error > TOLERANCE
        if np.any(wrong):
            place = entry(formula.split(maxsplit=1)[0], wrong)
            both = f"the kernel says {at(value, wrong):.9g}, differences say {at(expected, wrong):.9g}"
            text = f"{place}: {both} (relative error {at(error, wrong):.2g}); it must be {formula}"
            raise tested.fault(text, state)
        self.note(name, error.max(initial=0.0))

    def _skip(self, tested: TestedKernel, name: str, formula: str, state: State, doubtful: np.ndarray) -> None:
        """Leave out a state at a kink; too many such states are an error."""
        self.skipped[name] = self.skipped.get(name, 0) + 1
        states = self.skipped[name] + len(self.errors.get(name, ()))
        if self.skipped[name] > max(4, states // 3):
            place = entry(formula.split(maxsplit=1)[0], doubtful)
            count = f"{self.skipped[name]} of {states} states"
            text = f"{place}: no derivative is found at {count}; the values must change smoothly, without noise"
            raise tested.fault(text, state)

    def balanced(self, tested: TestedKernel, quantity: str, state: State, terms: Sequence[float], rule: str) -> None:
        """Check that the sum of terms vanishes."""
        imbalance, size = float(np.sum(terms)), float(np.abs(terms).sum())
        if abs(imbalance) > BALANCE * size:
            text = f"{quantity} are out of balance by {imbalance:.6g}, where their sizes add up to {size:.6g}"
            raise tested.fault(f"{text}; {rule}", state)
        self.note(f"{tested.kernel.name}: {quantity} in balance", abs(imbalance) / size if size else 0.0)

    def turned(self, tested: TestedKernel, name: str, state: State, after: Any, before: Any, size: float) -> None:
        """Compare results `after` in a rotated and shifted frame with the rotated results `before` of the old one.

        The error is related to the magnitude `size`.
        """
        error = np.abs(np.asarray(after) - before) / max(size, 1e-300)
        wrong = error > TURNED
        if np.any(wrong):
            both = f"{at(after, wrong):.12g}, not {at(before, wrong):.12g}"
            text = f"{entry(name, wrong)} depends on the frame: with everything turned and shifted it is {both}"
            raise tested.fault(text, state)
        self.note(f"{tested.kernel.name}: turned and shifted", np.max(error, initial=0.0))

    def rotation(self, scale: float) -> tuple[np.ndarray, np.ndarray]:
        """A random rotation of two nodes (6, 6), and the shift of at most `scale` [m] and turn (6,) after it."""
        angle = float(self.random.uniform(-3.0, 3.0))
        c, s = math.cos(angle), math.sin(angle)
        turn = np.kron(np.eye(2), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
        dx, dy = scale * self.random.uniform(-1.0, 1.0, 2)
        return turn, np.array([dx, dy, angle, dx, dy, angle])
