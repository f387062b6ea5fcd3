"""What a flow or a map is to the tools of this folder: a state that can be advanced, alone or with its neighbours."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.errors import InputError


class Dynamics(ABC):
    """A dynamical system with a present state.

    A flow counts time in seconds, a map in iterations; a section of a flow is a map.  Tools know nothing else of
    a system than what stands here, so that they serve mechanisms, ordinary differential equations and maps alike.

    Attributes
    ----------
    name : what messages and files call it.
    unit : "s" for a flow, "iterations" for a map, "periods" or "crossings" for a section.
    names : names of what `observe` returns.
    units : their units.
    status : how it stands, in a sentence.
    ok : False once it could not be advanced; `reset` makes it True again.
    """

    name: str
    unit: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    status: str
    ok: bool

    @property
    @abstractmethod
    def time(self) -> float:
        """Time of the present state [unit]."""

    @property
    @abstractmethod
    def size(self) -> int:
        """Numbers of a state, and rows of tangent vectors."""

    @property
    def dimension(self) -> int:
        """Directions in which a state can differ from another one: how many exponents there are."""
        return self.size

    @property
    def weights(self) -> np.ndarray:
        """Weights (size,) >= 0 of the squares of its numbers in the length of a tangent vector.

        They make lengths and speeds comparable; no exponent depends on them.  0: a number that others determine.
        """
        return np.ones(self.size)

    @property
    def records(self) -> np.ndarray:
        """Places (m,) in a state of what is only noted: nothing depends on it, so its differences may be left out."""
        return np.zeros(0, dtype=np.int64)

    @property
    def telling(self) -> tuple[int, ...]:
        """Places in `names` of the signals that say where the motion is, so that a verdict may rest on them."""
        return tuple(range(len(self.names)))

    @property
    def resolution(self) -> np.ndarray | None:
        """Differences (len(names),) of the signals that may be errors of the integration; None: 1e-6 of their sizes."""
        return None

    @property
    @abstractmethod
    def parameters(self) -> Mapping[str, Any]:
        """Names and present values of what `reset` may change."""

    @abstractmethod
    def state(self) -> np.ndarray:
        """A copy of the present state (size,)."""

    @abstractmethod
    def observe(self) -> np.ndarray:
        """Present values (len(names),) of the signals."""

    @abstractmethod
    def reset(
        self, state: np.ndarray | None = None, *, time: float = 0.0, parameters: Mapping[str, Any] | None = None
    ) -> None:
        """Go to `state` at `time`, or (None) to its own start; from now on with other `parameters`.

        Raises
        ------
        InputError : a state of another size, an unknown parameter, a value that is refused.
        """

    @abstractmethod
    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        """Go on for `duration` [unit]; whether it got there.  If not, `status` says why.

        Parameters
        ----------
        duration : > 0; for maps and sections a whole number.
        tangents : (size, k) float64 in C order, small differences of states; they are carried along, in place.
        """

    def velocity(self) -> np.ndarray:
        """Rate (size,) of the present state, for flows; a tangent vector whose exponent is 0 in bounded motion.

        Raises
        ------
        InputError : a map, which has none.
        """
        raise InputError(f"{self.name!r} is a map: it has no velocity. Take an exponent of its iterations.")

    def tangent_basis(self, count: int, seed: int = 0) -> np.ndarray:
        """`count` tangent vectors (size, count), orthonormal in the weights, random by `seed`.

        Raises
        ------
        InputError : more of them than the system has dimensions; a number or a seed that is not whole.
        """
        count, seed = checks.count(f"{self.name!r}", "count", count), checks.count(f"{self.name!r}", "seed", seed, 0)
        if count > self.dimension:
            text = f"{self.name!r}: {count} tangent vectors are asked for"
            raise InputError(f"{text}; it has 1 to {self.dimension} independent ones.")
        W = self.on_manifold(np.random.default_rng(seed).standard_normal((self.size, count)))
        orthonormalise(W, self.weights)
        return W

    def on_manifold(self, tangents: np.ndarray) -> np.ndarray:
        """The part of arbitrary differences `tangents` (size, k) that the constraints of the system allow here."""
        return np.ascontiguousarray(tangents, dtype=np.float64)

    @abstractmethod
    def copy(self) -> Self:
        """Another system in the same state, which goes its own way."""

    @property
    def fineness(self) -> str:
        """How fine its steps are, in words; "" for a map, which has none."""
        return ""

    def finer(self) -> Self:
        """A copy that takes finer steps from here on: a tenth of a tolerance, half of a fixed step; of a map a copy."""
        return self.copy()

    def another_start(self, part: float, seed: int) -> np.ndarray:
        """A state (size,) beside the present one, in a random direction.

        Parameters
        ----------
        part : distance, as a part of the length of the state.
        seed : of the direction.
        """
        x, way = self.state(), self.tangent_basis(1, seed)[:, 0]
        return x + part * (float(np.sqrt(self.weights @ x**2)) or 1.0) * way


def orthonormalise(tangents: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Make the columns of `tangents` (size, k) orthonormal in the weights (size,), in place; their lengths (k,) before.

    Each length is that of what is left of a column when the directions of those before it are taken away, so that
    its logarithms add up to exponents (G. Benettin et al., Meccanica 15 (1980)).  Modified Gram-Schmidt, done twice.
    Numbers without weight follow the others.  Columns may be of any length whose square is no number any more.
    """
    k = tangents.shape[1]
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is told by the lengths
        lengths = np.array([_made_near_one(tangents[:, j], weights) for j in range(k)])
        for _ in range(2):
            for j in range(k):
                column = tangents[:, j]
                for i in range(j):
                    column -= (weights * tangents[:, i] @ column) * tangents[:, i]
                size = float(np.sqrt(weights * column @ column))
                lengths[j] *= size
                if size > 0.0:
                    column /= size
    return lengths


def _made_near_one(column: np.ndarray, weights: np.ndarray) -> float:
    """Divide a vector by its largest number that has a weight, and return that number; 1 if all are 0."""
    largest = float(np.abs(np.where(weights > 0.0, column, 0.0)).max(initial=0.0))
    if largest == 0.0 or not np.isfinite(largest):
        return 1.0 if largest == 0.0 else largest
    np.divide(column, largest, out=column)
    return largest
