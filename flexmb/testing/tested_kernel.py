"""A kernel under test, with checks of every call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from flexmb.errors import KernelError
from flexmb.kernels import Kernel

RESULTS = {
    "energy": ("strain", "gravity", "damping"),
    "account": ("strain", "gravity", "damping"),
    "normal": ("N", "dN_dgap", "dN_drate"),
    "friction": ("T", "dT_dslip", "dT_dN"),
    "motion": ("s", "s_dot", "s_ddot"),
    "signal": ("value",),
    "extremum": ("value", "place"),
}
"""Names of returned numbers by contract; other kernels write to arrays."""

SAME = 1e-11
"""Largest difference of compiled and plain Python function, over the largest entry."""

State = dict[str, Any]
Values = dict[str, np.ndarray]


class TestedKernel:
    """A kernel with the parameters of a part.

    Parameters
    ----------
    owner : part and class, for messages.
    kernel, p : kernel and parameters.
    **shapes : shapes of the output arrays by name.
    """

    def __init__(self, owner: str, kernel: Kernel, p: Sequence[float] | np.ndarray, **shapes: tuple[int, ...]) -> None:
        self.kernel, self.shapes = kernel, shapes
        self.p = np.array(p, dtype=float)
        self.label = f"{owner}: {kernel.contract.name} kernel {kernel.name!r}"

    def __call__(self, state: State) -> Values:
        """Outputs of the compiled function by name, at a `state`."""
        return self._outputs(self.kernel.dispatcher, state)

    def checked_call(self, state: State, sizes: dict[str, float] | None = None) -> Values:
        """Outputs at a state, after the checks of a single call.

        Round-off is related to `sizes` of outputs by name; other outputs: their own size.  A `KernelError` tells a call
        that fails or changes its inputs, values that are not finite, a second call or a compiled function with another
        result.
        """
        first, second = self._python(state), self._python(state)
        for name, value in first.items():
            self._finite(name, value, state)
        for name, value in first.items():
            where = value != second[name]
            if np.any(where):
                both = f"{at(value, where):.17g} and then {at(second[name], where):.17g}"
                text = f"{entry(name, where)} is {both} for the same input"
                raise self.fault(f"{text}; a kernel may remember nothing but z", state)
        compiled = self(state)
        for name, value in first.items():
            self._finite(name, compiled[name], state)
            where = np.abs(compiled[name] - value) > SAME * self._size(name, first, state, sizes or {})
            if np.any(where):
                both = f"{at(compiled[name], where):.12g} compiled and {at(value, where):.12g} in plain Python"
                raise self.fault(f"{entry(name, where)} is {both}", state)
        return compiled

    def fault(self, text: str, state: State) -> KernelError:
        """The error to be raised, with the state."""
        with np.printoptions(precision=5, linewidth=10**6):
            listed = ", ".join(f"{name} = {np.asarray(x)}" for name, x in state.items())
        return KernelError(f"{self.label}: {text}. State: {listed}.")

    def _finite(self, name: str, value: np.ndarray, state: State) -> None:
        bad = ~np.isfinite(value)
        if np.any(bad):
            raise self.fault(f"{entry(name, bad)} is {at(value, bad)}; it must be finite at every state", state)

    def same(self, state: State, expected: Values, sizes: dict[str, float], other: str) -> None:
        """Check that the outputs agree with outputs of another kernel up to round-off, related to `sizes`."""
        values = self.checked_call(state, sizes)
        for name, value in expected.items():
            where = np.abs(values[name] - value) > SAME * self._size(name, expected, state, sizes)
            if np.any(where):
                both = f"{at(values[name], where):.12g}, where {other!r} gives {at(value, where):.12g}"
                raise self.fault(f"{entry(name, where)} is {both}; both must say the same", state)

    @staticmethod
    def _size(name: str, values: Values, state: State, sizes: dict[str, float]) -> float:
        """Magnitude to which round-off is related: a force is a difference of terms as large as K q."""
        size = float(np.abs(values[name]).max(initial=0.0)) + sizes.get(name, 0.0)
        if name in sizes:
            return size
        for output, matrix in (("r", "K"), ("g", "G")):
            if name == output:
                size += float(np.abs(values[matrix]).max(initial=0.0) * np.abs(state["q"]).max(initial=1.0))
        if name in ("strain", "gravity"):
            size += float(np.abs(values["strain"]) + np.abs(values["gravity"]))
        return size

    def _python(self, state: State) -> Values:
        """Outputs of the plain Python function, given copies of the inputs."""
        mine = {name: x.copy() if isinstance(x, np.ndarray) else x for name, x in state.items()}
        mine["p"] = self.p.copy()
        try:
            with np.errstate(all="ignore"):
                outputs = self._outputs(self.kernel.python, mine)
        except (ArithmeticError, ValueError, IndexError, TypeError) as error:
            raise self.fault(f"fails in plain Python with {type(error).__name__} ({error})", state) from error
        for name, x in {**state, "p": self.p}.items():
            if not np.array_equal(mine[name], x):
                raise self.fault(f"changes its input {name}; write to the outputs only", state)
        return outputs

    def _outputs(self, function: Callable[..., Any], state: State) -> Values:
        outputs = {name: np.zeros(shape) for name, shape in self.shapes.items()}
        given = {"p": self.p, "least": -1.0, **state, **outputs}  # an extremum is wanted, however small
        result = function(*(given[name] for name in self.kernel.contract.parameters))
        names = RESULTS.get(self.kernel.contract.name, ())
        numbers = np.atleast_1d(np.array(result, dtype=float)) if names else ()
        return {**outputs, **dict(zip(names, numbers, strict=True))}


def entry(name: str, where: Any) -> str:
    """Name of the first marked entry, such as 'K[0, 1]'."""
    if np.ndim(where) == 0 or np.size(where) == 1:
        return name
    index = ", ".join(str(k) for k in np.argwhere(where)[0])
    return f"{name}[{index}]"


def at(values: Any, where: Any) -> float:
    """Value of the first marked entry."""
    return float(np.atleast_1d(values)[np.atleast_1d(where)][0])
