"""Random states, comparisons and the record of what was compared."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from flexmb.model.contributions import Coordinate
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part
from flexmb.program.numbering import Numbering
from flexmb.testing.differences import gradient
from flexmb.testing.report import Check, Report
from flexmb.testing.subject import State, Subject, at, entry

TOLERANCE = 1e-6
"""Accepted error of a derivative, relative to the largest entry of its row."""

SMALL_ROW = 1e-4
"""A row this much smaller than the largest one is measured against the largest."""

HIDDEN = 1e-6
"""A change of a function over its scale that is smaller than this part of it is measured against the function."""

BALANCE = 1e-12
"""Accepted rest of forces and moments, relative to what is summed."""

TURNED = 1e-11
"""Accepted change of a result when everything is turned and shifted."""

MAGNITUDES = (1e-6, 1e-3, 0.05, 0.3)
"""How far states lie from the drawn pose: part of the size of the piece, and rad."""


class Bench:
    """Where the kernels of one part are tested.

    Parameters
    ----------
    mechanism : the mechanism.
    part : one of its parts.
    seed : seed of the random states.
    """

    def __init__(self, mechanism: Mechanism, part: Part, seed: int) -> None:
        self.owner = f"Part {part.name!r} ({type(part).__name__})"
        self.number = Numbering(mechanism)
        self.pose = np.concatenate([self.number.pose(), np.zeros(3)])
        self.random = np.random.default_rng(seed)
        self.errors: dict[str, list[float]] = {}
        self.skipped: dict[str, int] = {}

    def report(self) -> Report:
        """What was checked so far."""
        names = dict.fromkeys([*self.errors, *self.skipped])
        checks = [(n, self.errors.get(n, []), self.skipped.get(n, 0)) for n in names]
        return Report(self.owner, tuple(Check(n, len(e), max(e, default=0.0), s) for n, e, s in checks))

    def note(self, name: str, error: float = 0.0) -> None:
        """Record that a check was passed."""
        self.errors.setdefault(name, []).append(float(error))

    def scales(self, coordinates: Sequence[Coordinate]) -> np.ndarray:
        """Size of the piece for lengths, 1 for angles."""
        q = self.pose[self.number.dofs(coordinates)]
        extent = [np.ptp([x for x, c in zip(q, coordinates, strict=True) if c[2] == k] or [0.0]) for k in (0, 1)]
        size = math.hypot(*extent) or self.number.extent
        return np.array([1.0 if axis == 2 else size for _, _, axis in coordinates])

    def states(self, coordinates: Sequence[Coordinate], wanted: str) -> Iterator[State]:
        """States of each magnitude with the inputs named in `wanted`; every second one moves, some have h = 0."""
        q, scale = self.pose[self.number.dofs(coordinates)], self.scales(coordinates)
        for k in range(3 * len(MAGNITUDES)):
            free = {
                "t": float(self.random.uniform(0.0, 2.0)),
                "h": (0.0, 1e-4, 1e-2)[k % 3],
                "q": q + MAGNITUDES[k // 3] * scale * self.random.uniform(-1.0, 1.0, len(q)),
                "v": 10.0 * (k % 2) * scale * self.random.uniform(-1.0, 1.0, len(q)),
                "a": 100.0 * (k % 2) * scale * self.random.uniform(-1.0, 1.0, len(q)),
            }
            yield {name: free[name] for name in wanted.split()}

    def derivative(
        self, subject: Subject, what: str, state: State, got: Any, function: Any, x: Any, scale: Any, **sizes: Any
    ) -> None:
        """Hold `got` against differences of `function` at x; `what` is a formula that begins with the name of `got`.

        `rows` and `columns` in `sizes` bring entries of different units together, `floor` is the least size of a row,
        `noise` round-off of the values beyond that of their own size.
        """
        want, uncertain = gradient(function, x, scale, sizes.get("noise", 0.0))
        got = np.asarray(got, dtype=float)
        want, uncertain = want.reshape(got.shape), uncertain.reshape(got.shape)
        weight = np.asarray(sizes.get("rows", 1.0))
        if got.ndim == 2:
            weight = np.broadcast_to(weight, got.shape[:1])[:, None] * sizes.get("columns", 1.0)
        size = np.abs(want * weight)
        if got.ndim == 2:
            size = size.max(axis=1, keepdims=True, initial=0.0)
        # a derivative this small against the function itself is hidden by round-off
        hidden = HIDDEN * np.abs(function(x) * np.asarray(sizes.get("rows", 1.0))).max(initial=0.0)
        hidden *= np.max(np.asarray(sizes.get("columns", 1.0)) / scale)
        floor = max(SMALL_ROW * size.max(initial=0.0), sizes.get("floor", 0.0), float(hidden), 1e-300)
        size = np.maximum(size, floor)
        name = f"{subject.kernel.name}: {what}"
        doubtful = uncertain * weight > 0.1 * TOLERANCE * size
        if np.any(doubtful):
            self._skip(subject, name, what, state, doubtful)
            return
        error = np.abs(got - want) * weight / size
        wrong = error > TOLERANCE
        if np.any(wrong):
            place = entry(what.split(maxsplit=1)[0], wrong)
            both = f"the kernel says {at(got, wrong):.9g}, differences say {at(want, wrong):.9g}"
            text = f"{place}: {both} (relative error {at(error, wrong):.2g}); it must be {what}"
            raise subject.fault(text, state)
        self.note(name, error.max(initial=0.0))

    def _skip(self, subject: Subject, name: str, what: str, state: State, doubtful: np.ndarray) -> None:
        """Leave a state at a kink out, but not many of them."""
        self.skipped[name] = self.skipped.get(name, 0) + 1
        states = self.skipped[name] + len(self.errors.get(name, ()))
        if self.skipped[name] > max(4, states // 3):
            place = entry(what.split(maxsplit=1)[0], doubtful)
            count = f"{self.skipped[name]} of {states} states"
            text = f"{place}: no derivative is found at {count}; the values must change smoothly, without noise"
            raise subject.fault(text, state)

    def balanced(self, subject: Subject, what: str, state: State, terms: Sequence[float], rule: str) -> None:
        """Terms whose sum must vanish; `rule` is what a message says they must do."""
        rest, size = float(np.sum(terms)), float(np.abs(terms).sum())
        if abs(rest) > BALANCE * size:
            text = f"{what} are out of balance by {rest:.6g}, where their sizes add up to {size:.6g}"
            raise subject.fault(f"{text}; {rule}", state)
        self.note(f"{subject.kernel.name}: {what} in balance", abs(rest) / size if size else 0.0)

    def turned(self, subject: Subject, name: str, state: State, after: Any, before: Any, size: float) -> None:
        """Results after everything was turned and shifted, against the turned results of before."""
        error = np.abs(np.asarray(after) - before) / max(size, 1e-300)
        wrong = error > TURNED
        if np.any(wrong):
            both = f"{at(after, wrong):.12g}, not {at(before, wrong):.12g}"
            text = f"{entry(name, wrong)} depends on the frame: with everything turned and shifted it is {both}"
            raise subject.fault(text, state)
        self.note(f"{subject.kernel.name}: turned and shifted", np.max(error, initial=0.0))

    def rotation(self, scale: float) -> tuple[np.ndarray, np.ndarray]:
        """A random rotation of two nodes (6, 6), and what shifts and turns them after it (6,)."""
        angle = float(self.random.uniform(-3.0, 3.0))
        c, s = math.cos(angle), math.sin(angle)
        turn = np.kron(np.eye(2), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
        dx, dy = scale * self.random.uniform(-1.0, 1.0, 2)
        return turn, np.array([dx, dy, angle, dx, dy, angle])
