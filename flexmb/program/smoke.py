"""One call of each kernel in plain Python while a program is packed, so that mistakes get a name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmb.errors import KernelError
from flexmb.kernels import GAP_SIZE, GRIP_SIZE, Kernel
from flexmb.model.law import Law, Motion
from flexmb.model.pieces import ConstraintPiece, ContactPiece, ElementPiece, Pieces
from flexmb.program.numbering import Numbering


def call_each_kernel(pieces: Pieces, number: Numbering) -> None:
    """Call every kernel once with the numbers of its part in the drawn pose.

    Raises
    ------
    KernelError : wrong unpacking or indexing, or results that are not finite; names part, kernel and remedy.
    """
    q = np.concatenate([number.pose(), np.zeros(3)])
    seen: set[tuple[Kernel, int]] = set()
    for piece in (*pieces.elements, *pieces.constraints, *pieces.contacts, *pieces.signals):
        for kernel, p, arguments, what in _calls(piece, q[number.dofs(piece.coordinates)]):
            if (kernel, len(p)) in seen:
                continue
            seen.add((kernel, len(p)))
            _call(piece.part, kernel, np.array(p, dtype=float), arguments, what)


def _calls(piece: Any, q: np.ndarray) -> list[tuple[Kernel, Sequence[float], list[Any], str]]:
    """(kernel, p, arguments after p, name of the class) of every kernel of a piece."""
    n = len(q)
    zero, square = np.zeros(n), np.zeros((n, n))
    if isinstance(piece, ElementPiece):
        z = np.array(piece.history, dtype=float)
        state = [0.0, 0.0, q, zero.copy(), zero.copy(), z]
        force = [zero.copy(), square, square.copy(), square.copy(), z.copy()]
        calls = [(piece.kernel, piece.p, [*state, *force], "element")]
        if piece.energy is not None:
            calls.append((piece.energy, piece.p, [0.0, q, zero.copy()], "element"))
        calls += _short_calls(piece, state)
        return [*calls, *_motion_calls(piece.factor)]
    if isinstance(piece, ConstraintPiece):
        rows = [np.zeros(piece.rows) for _ in range(4)]
        arguments = [0.0, q, zero, rows[0], rows[1], np.zeros((piece.rows, n)), rows[2], rows[3], square]
        driven = [call for row in piece.motions for call in _motion_calls(row.motion)]
        if piece.grip is not None:
            grip = (piece.grip.kernel, piece.grip.p, [q, rows[1], np.zeros(GRIP_SIZE), np.zeros((n, n))], "grip")
            driven += [grip, _law_call(piece.grip.friction)]
        return [(piece.kernel, piece.p, arguments, "constraint"), *driven]
    if isinstance(piece, ContactPiece):
        gap = (piece.gap, piece.p, [q, zero, np.zeros(GAP_SIZE)], "gap")
        return [gap, _law_call(piece.normal), _law_call(piece.friction)]
    return [(piece.kernel, piece.p, [0.0, q, zero, zero.copy()], "signal")]


def _short_calls(piece: ElementPiece, state: list[Any]) -> list[tuple[Kernel, Sequence[float], list[Any], str]]:
    """Calls of force, tangent and account of an element."""
    n, z = len(state[2]), state[-1]
    r, A = np.zeros((3, n)), np.zeros((n, n))
    given = (
        (piece.force, [*state, r[0], z.copy()]),
        (piece.tangent, [*state, 1.0, 1.0, 1.0, r[0], A, z.copy()]),
        (piece.account, [*state[:-1], np.zeros(n), z, *r, z.copy()]),
    )
    return [(kernel, piece.p, arguments, "element") for kernel, arguments in given if kernel is not None]


def _motion_calls(motion: Motion | None) -> list[tuple[Kernel, Sequence[float], list[Any], str]]:
    return [] if motion is None else [(motion.kernel, motion.parameters(), [0.0], type(motion).__name__)]


def _law_call(law: Law) -> tuple[Kernel, Sequence[float], list[Any], str]:
    z = np.array(law.history(), dtype=float)
    return law.kernel, law.parameters(), [1e-6, -1e-6, -1e-3, z, z.copy()], type(law).__name__


def _call(part: str, kernel: Kernel, p: np.ndarray, arguments: list[Any], what: str) -> None:
    label = f"Part {part!r}: {what} kernel {kernel.name!r}" if what.islower() else f"Part {part!r}: {what}"
    try:
        result = kernel.python(p, *arguments)
    except (ValueError, IndexError, TypeError) as error:
        reason = str(error) or "wrong number of values"
        raise KernelError(
            f"{label} failed with {len(p)} parameters p = {_short(p)}: {reason}. "
            "The kernel must unpack as many numbers as its class has numeric fields, in their order."
        ) from error
    except (ArithmeticError, NameError, AttributeError) as error:
        safe = "It must be safe there, also for t = h = 0." if isinstance(error, ArithmeticError) else "Correct it."
        text = f"{label} failed in the drawn pose, at rest, with p = {_short(p)}: {type(error).__name__}: {error}."
        raise KernelError(f"{text} {safe}") from error
    size = 1 if kernel.contract.name == "signal" else 3
    if kernel.contract.name in ("energy", "account", "normal", "friction", "motion", "signal"):
        values = np.atleast_1d(np.array(result, dtype=float)) if result is not None else np.empty(0)
        if values.size != size:
            plural = "s" if size > 1 else ""
            hint = _alone(kernel, values)
            raise KernelError(f"{label} returned {result!r}; it must return {size} number{plural}.{hint}")
    else:
        arrays = [a.ravel() for a in arguments if isinstance(a, np.ndarray)]
        values = np.concatenate(arrays) if arrays else np.empty(0)
    if not np.all(np.isfinite(values)):
        raise KernelError(f"{label} gives values that are not finite for p = {_short(p)}; check its numbers.")


def _alone(kernel: Kernel, values: np.ndarray) -> str:
    """What to say about a law that returned its force alone and has no derivatives all the same."""
    if not kernel.contract.active or values.size != 1:
        return ""
    if kernel.text is None:
        return (
            " The derivatives of a force alone are found from its source text, which is not there; put it into a file."
        )
    return " It was not seen to return one number; return an expression, not a name that holds different things."


def _short(p: np.ndarray) -> str:
    shown = ", ".join(f"{x:.6g}" for x in p[:8])
    return f"({shown}{', ...' if len(p) > 8 else ''})"
