"""Check of kernels: one call of each in plain Python, with errors that name part and kernel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmb.errors import USER_ERRORS, KernelError
from flexmb.kernels import GAP_SIZE, JOINT_FRICTION_SIZE, Kernel
from flexmb.model.contributions import (
    ConstraintContribution,
    ContactContribution,
    Contributions,
    ControlContribution,
    ElementContribution,
    MotionInput,
)
from flexmb.model.law import Law, Motion
from flexmb.program.numbering import Numbering

RETURNED = {"energy": 3, "account": 3, "normal": 3, "friction": 3, "motion": 3, "signal": 1, "extremum": 2}
"""Numbers that a kernel returns, by contract; others write to arrays."""


def call_each_kernel(contributions: Contributions, number: Numbering) -> None:
    """Call every kernel once with the parameters of its part in the reference configuration.

    A call that was good is not repeated in this process: a kernel is a pure function, so it would be good again.  A
    `KernelError` on wrong unpacking or indexing, or results that are not finite, names part, kernel and remedy.
    """
    pose = [*number.pose().tolist(), 0.0, 0.0, 0.0]
    seen: set[tuple[Any, ...]] = set()
    pieces: tuple[Any, ...] = (
        *_distinct_elements(contributions.elements),
        *contributions.constraints,
        *contributions.contacts,
        *contributions.signals,
        *contributions.controls,
    )
    for contribution in pieces:
        for kernel, p, z, what in _kernels_of(contribution):
            sizes = _sizes_of(contribution) if kernel.contract.name == "control" else ()
            if (id(kernel), len(p), sizes) in seen:
                continue
            seen.add((id(kernel), len(p), sizes))
            law = kernel.contract.name in ("normal", "friction", "motion", "control")
            q = sizes if law else tuple([pose[k] for k in number.dofs(contribution.coordinates)])
            call = (id(kernel), tuple(p), tuple(z), q)
            if call in _GOOD:
                continue
            _call(contribution.part, kernel, np.array(p, dtype=float), _arguments(kernel, contribution, q, z), what)
            if len(_GOOD) >= REMEMBERED_CALLS:
                _GOOD.clear()
            _GOOD[call] = kernel


def _distinct_elements(elements: Sequence[ElementContribution]) -> list[ElementContribution]:
    """The first elements of each set of kernels and number of parameters."""
    found: dict[tuple[Any, ...], ElementContribution] = {}
    for e in elements:
        kernels = e.kernel, e.energy, e.force, e.tangent, e.account, e.factor and e.factor.kernel
        lengths = len(e.p), e.factor and len(e.factor.parameters())
        found.setdefault((*map(id, kernels), *lengths), e)
    return list(found.values())


REMEMBERED_CALLS = 4096
"""Number of successful calls that are remembered."""

KernelCall = tuple[Kernel, Sequence[float], Sequence[float], str]
"""A kernel, p, its history, and the name of its class."""

_GOOD: dict[tuple[int, Sequence[float], Sequence[float], Sequence[float]], Kernel] = {}
"""Good calls: id of the kernel, p, history, pose.  The kernel stands beside them, so its id is given to no other."""


def _kernels_of(contribution: Any) -> list[KernelCall]:
    """All kernels of a piece with their numbers."""
    found: list[KernelCall]
    if isinstance(contribution, ElementContribution):
        found = [(contribution.kernel, contribution.p, contribution.history, "element")]
        if contribution.energy is not None:
            found.append((contribution.energy, contribution.p, (), "element"))
        short = (contribution.force, contribution.tangent, contribution.account)
        found += [(kernel, contribution.p, contribution.history, "element") for kernel in short if kernel is not None]
        return found if contribution.factor is None else [*found, _law(contribution.factor)]
    if isinstance(contribution, ConstraintContribution):
        found = [
            (contribution.kernel, contribution.p, (), "constraint"),
            *(_law(row.motion) for row in contribution.motions),
        ]
        if contribution.joint_friction is not None:
            found += [
                (contribution.joint_friction.kernel, contribution.joint_friction.p, (), "joint_friction"),
                _law(contribution.joint_friction.friction),
            ]
        return found
    if isinstance(contribution, ContactContribution):
        return [(contribution.gap, contribution.p, (), "gap"), _law(contribution.normal), _law(contribution.friction)]
    if isinstance(contribution, ControlContribution):
        motions = [_law(wanted.motion) for wanted in contribution.inputs if isinstance(wanted, MotionInput)]
        return [(contribution.kernel, contribution.p, contribution.start, "control"), *motions]
    return [(contribution.kernel, contribution.p, (), "signal")]


def _law(law: Law) -> KernelCall:
    return law.kernel, law.parameters(), () if isinstance(law, Motion) else law.history(), type(law).__name__


def _arguments(kernel: Kernel, contribution: Any, pose: Sequence[float], history: Sequence[float]) -> list[Any]:
    """Arguments of a kernel after p: at rest, in the reference configuration, at t = 0."""
    name, n = kernel.contract.name, len(pose)
    if name == "control":
        return _arguments_of_control(contribution)
    q, z = np.array(pose, dtype=float), np.array(history, dtype=float)
    zero, rows = np.zeros(n), [np.zeros(getattr(contribution, "rows", 0)) for _ in range(4)]
    state = [0.0, 0.0, q, zero.copy(), zero.copy(), z]
    plain: dict[str, list[Any]] = {
        "force": [*state, zero.copy(), z.copy()],
        "account": [*state[:-1], np.zeros(n), z, *np.zeros((3, n)), z.copy()],
        "energy": [0.0, q, zero],
        "gap": [q, zero, np.zeros(GAP_SIZE)],
        "normal": [1e-6, -1e-6, -1e-3, z, z.copy()],
        "friction": [1e-6, -1e-6, 1e-3, z, z.copy()],
        "motion": [0.0],
        "signal": [0.0, q, zero, zero.copy()],
        "extremum": [0.0, q, zero, zero.copy(), -1.0],
    }
    if name in plain:  # a signal may read all coordinates of a large body, so it must not cost a matrix of them
        return plain[name]
    square = np.zeros((n, n))
    with_matrices: dict[str, list[Any]] = {
        "element": [*state, zero.copy(), square, square.copy(), square.copy(), z.copy()],
        "tangent": [*state, 1.0, 1.0, 1.0, zero.copy(), square, z.copy()],
        "constraint": [0.0, q, zero, rows[0], rows[1], np.zeros((len(rows[0]), n)), rows[2], rows[3], square],
        "joint_friction": [q, rows[1], np.zeros(JOINT_FRICTION_SIZE), square],
    }
    return with_matrices[name]


def _sizes_of(control: ControlContribution) -> tuple[int, int, int]:
    """Numbers of inputs, states and outputs."""
    return len(control.inputs), len(control.states), len(control.outputs)


def _arguments_of_control(control: ControlContribution) -> list[Any]:
    """Arguments of a control law after p: all inputs 0, states as at the start; the law can write to none of these."""
    given = np.zeros(len(control.inputs)), np.array(control.start, dtype=float)
    for array in given:
        array.flags.writeable = False
    return [0.0, *given, np.zeros(len(control.states)), np.zeros(len(control.outputs))]


def _call(part: str, kernel: Kernel, p: np.ndarray, arguments: list[Any], what: str) -> None:
    label = f"Part {part!r}: {what} kernel {kernel.name!r}" if what.islower() else f"Part {part!r}: {what}"
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused below
            result = kernel.python(p, *arguments)
    except USER_ERRORS as error:
        if isinstance(error, (IndexError, TypeError)) or "unpack" in str(error):
            reason = str(error) or "wrong number of values"
            if kernel.contract.name == "control":
                sizes = [a.size for a in arguments[1:]]
                raise KernelError(
                    f"{label} failed with {len(p)} numbers p, {sizes[0]} inputs u, {sizes[1]} states x with rates dx "
                    f"and {sizes[-1]} outputs y: {reason}. The law must fit the numbers, inputs, states and loads of "
                    "its controller."
                ) from error
            raise KernelError(
                f"{label} failed with {len(p)} parameters p = {_short(p)}: {reason}. "
                "The kernel must unpack as many numbers as its class has numeric fields, in their order."
            ) from error
        if kernel.contract.name == "control" and isinstance(error, (ArithmeticError, ValueError)):
            return  # inputs of 0 may be none that the mechanism has
        safe = "It must be safe there, also for t = h = 0." if isinstance(error, ArithmeticError) else "Correct it."
        text = f"{label} failed {_place(kernel)} with p = {_short(p)}: "
        text += f"{type(error).__name__}: {error}."
        raise KernelError(f"{text} {safe}") from error
    size = RETURNED.get(kernel.contract.name, 0)
    if size:
        values = np.atleast_1d(np.array(result, dtype=float)) if result is not None else np.empty(0)
        if values.size != size:
            plural = "s" if size > 1 else ""
            hint = _underivable_law(kernel, values)
            raise KernelError(f"{label} returned {result!r}; it must return {size} number{plural}.{hint}")
    else:
        arrays = [a.ravel() for a in arguments if isinstance(a, np.ndarray)]
        values = np.concatenate(arrays) if arrays else np.empty(0)
    if kernel.contract.name != "control" and not np.all(np.isfinite(values)):
        raise KernelError(f"{label} gives values that are not finite for p = {_short(p)}; check its numbers.")


def _place(kernel: Kernel) -> str:
    """State of a call in words."""
    places = {"normal": "at a penetration of 1e-6 m,", "friction": "at a slip of -1e-6 m/s and N = 1e-3 N,"}
    return places.get(kernel.contract.name, "in the reference configuration, at rest,")


def _underivable_law(kernel: Kernel, values: np.ndarray) -> str:
    """Message about a law that returns its force alone and cannot be differentiated."""
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
