"""Evaluation of a program at one state, for solvers in Python: forces, residuals, matrices; kernels that fail there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.engine.linalg.dense import DENSE_UNKNOWNS, PivotingSolver, solve_dense
from flexmb.engine.linalg.large import KeptFactors
from flexmb.engine.system.evaluate import evaluate
from flexmb.engine.system.work import Work, workspace
from flexmb.errors import USER_ERRORS, KernelError, SolveError
from flexmb.findings.finding import Finding, found
from flexmb.kernels import GAP_SIZE, JOINT_FRICTION_SIZE, Kernel
from flexmb.places import GAP, GAP_RATE, LOAD, SLIDING, SLIP
from flexmb.program import program as at
from flexmb.program.program import KINDS, Program

if TYPE_CHECKING:
    import scipy.sparse as sp

Vector = Sequence[float] | np.ndarray
LARGE_UNKNOWNS = 1000  # number of unknowns above which the factors of a matrix are kept for the next ones


class StateEvaluation:
    """Evaluation of a program at one state, in a workspace that is overwritten; returned arrays are copies."""

    def __init__(self, program: Program, work: Work | None = None) -> None:
        self.program = program
        self.work: Work = work or workspace(program)
        self._pattern = program.symbolic
        self.small = self._pattern.n <= DENSE_UNKNOWNS
        self._instant: Instant | None = None

    @cached_property
    def _solver(self) -> PivotingSolver:
        return (KeptFactors if self._pattern.n > LARGE_UNKNOWNS else PivotingSolver)(self._pattern)

    def at(
        self, q: Vector, v: Vector | None = None, a: Vector | None = None, lam: Vector | None = None, *, t: float = 0.0,
        z: Vector | None = None, weights: Vector = (0.0, 0.0, 0.0),
    ) -> StateEvaluation:  # fmt: skip
        """Evaluate at a state (n_q,); `weights`: factors of stiffness, damping and mass in the matrix."""
        # The last three entries of arrays with n_q + 3 entries are the motion of the ground, else at rest.
        n, m = self.program.n_q, self.program.n_c
        state = _padded(q, n), _padded(v, n), _padded(a, n)
        lam = np.zeros(m) if lam is None else np.ascontiguousarray(lam, dtype=float)
        z = np.array(self.program.reference.z if z is None else z)
        tables, address = self.program.tables, self.program.addresses
        self._instant = Instant(float(t), 0.0, *state, lam, z)
        try:
            evaluate(tables, address, float(t), 0.0, *state, lam, z, *map(float, weights), True, self.work)
        except USER_ERRORS as error:
            self.refuse_failed_kernel(error)
            raise
        return self

    def refuse_failed_kernel(self, error: Exception | None = None) -> None:
        """Raise `KernelError` if a kernel raises or is not finite at the state that was evaluated last."""
        failed = None if self._instant is None else failed_kernel(self.program, [self._instant])
        if failed is not None:
            raise KernelError(failed.text) from error

    @property
    def force(self) -> np.ndarray:
        """Residual r (n_q,): inertia less applied forces, without constraint forces."""
        return self.work.r[: self.program.n_q].copy()

    @property
    def constraint_force(self) -> np.ndarray:
        """G^T lam (n_q,)."""
        return self.work.Gl[: self.program.n_q].copy()

    @property
    def residual(self) -> np.ndarray:
        """g (n_c,)."""
        return self.work.g.copy()

    @property
    def velocity_residual(self) -> np.ndarray:
        """G v + g_t (n_c,)."""
        return self.work.gv.copy()

    @property
    def gamma(self) -> np.ndarray:
        """Right side of G a = gamma (n_c,)."""
        return self.work.gamma.copy()

    @property
    def matrix(self) -> sp.csc_matrix:
        """[[weighted K, C, M, G^T], [G, 0]] (n, n)."""
        import scipy.sparse as sp  # noqa: PLC0415 - large models alone need it, and it takes long to import

        pattern = self._pattern
        values = self.work.lu[pattern.places]
        return sp.csc_matrix((values, (pattern.a_rows, pattern.a_cols)), shape=(pattern.n, pattern.n))

    @property
    def dense(self) -> np.ndarray:
        """`matrix` as a plain array."""
        pattern = self._pattern
        A = np.zeros((pattern.n, pattern.n))
        A[pattern.a_rows, pattern.a_cols] = self.work.lu[pattern.places]
        return A

    def block(self) -> sp.csc_matrix:
        """The upper left block (n_q, n_q) of the matrix."""
        n = self.program.n_q
        return self.matrix[:n, :n].tocsc()

    @property
    def jacobian(self) -> sp.csr_matrix:
        """G (n_c, n_q)."""
        n = self.program.n_q
        return self.matrix.tocsr()[n:, :n]

    @property
    def blocks(self) -> tuple[np.ndarray, np.ndarray] | tuple[sp.csc_matrix, sp.csr_matrix]:
        """`block()` and `jacobian`; plain arrays for at most DENSE_UNKNOWNS unknowns (see `engine/linalg/dense.py`)."""
        n = self.program.n_q
        if self.small:
            A = self.dense
            return A[:n, :n], A[n:, :n]
        A = self.matrix.tocsr()
        return A[:n, :n].tocsc(), A[n:, :n]

    def solve(self, b: np.ndarray, purpose: str, accuracy: float = 0.0) -> np.ndarray:
        """Solve with the present matrix, with pivoting, for a right-hand side (n,), or several, (n, k)."""
        # `accuracy` is the error of the solution that suffices, relative to its largest entry; 0: round-off.
        try:
            if self.small:
                return solve_dense(self.dense, b)
            solver = self._solver.factor(self.work.lu)
            more = (accuracy,) if isinstance(solver, KeptFactors) else ()
            return np.apply_along_axis(solver.solve, 0, b, *more)
        except SolveError as error:
            self.refuse_failed_kernel(error)
            raise SolveError(f"{purpose}: {error}") from error

    def is_regular(self) -> bool:
        """Whether the present matrix maps no vector to round-off beyond doubt; False for a small one without a look."""
        if self._pattern.n <= LARGE_UNKNOWNS:
            return False
        solver = self._solver.factor(self.work.lu)
        return isinstance(solver, KeptFactors) and solver.is_regular()

    def mass(self, q: np.ndarray) -> sp.csc_matrix:
        """M (n_q, n_q) at positions q."""
        return self.at(q, weights=(0.0, 0.0, 1.0)).block()


def _padded(x: Vector | None, n: int) -> np.ndarray:
    full = np.zeros(n + 3)
    if x is not None:
        full[: len(x)] = x
    return full


# Kernels of a program that raise or are not finite at one state: each is called in plain Python, part by part

MOST_CALLS, BLOWN_UP = 20_000, 1e100  # most calls of kernels at a state, half a second; size of a state that blew up
SHOWN_NUMBERS = 6  # number of entries of an array in a message at most
# Names of the parameters that kernels write.
OUTPUTS = frozenset("r K C M z_new g G g_t gamma H out A Mv My dx y".split())


@dataclass(frozen=True)
class Instant:
    """State at which kernels are called; `q`, `v` and `a` end with the three coordinates of the ground."""

    t: float  # time, and time since the last accepted state [s]
    h: float
    q: np.ndarray  # coordinates, velocities, accelerations (n_q + 3,)
    v: np.ndarray
    a: np.ndarray
    lam: np.ndarray  # multipliers (n_c,)
    z: np.ndarray  # histories at the last accepted state (n_z,)


@dataclass(frozen=True)
class _Call:
    """Call of one kernel."""

    part: str
    kernel: Kernel
    arguments: tuple[Any, ...]

    def run(self) -> tuple[np.ndarray, str]:
        """All numbers that the kernel returns or writes, and the exception in words; "" without an exception."""
        try:
            result = self.kernel.python(*self.arguments)
        except USER_ERRORS as error:
            return np.empty(0), f"raised {type(error).__name__}: {str(error).rstrip('.')}"
        written = [np.ravel(value) for value in self.named(OUTPUTS).values()]
        returned = [] if result is None else [np.ravel(np.asarray(result, dtype=float))]
        return np.concatenate([*returned, *written, np.empty(0)]), ""

    def named(self, names: frozenset[str]) -> dict[str, Any]:
        """Arguments by the name of the parameter, chosen by `names`."""
        pairs = zip(self.kernel.contract.parameters, self.arguments, strict=True)
        return {name: value for name, value in pairs if name in names}

    def failure(self) -> Finding | None:
        """Finding on a failed call; None for a good call, and for a state that blew up."""
        given = self.named(frozenset(self.kernel.contract.parameters) - OUTPUTS)
        if not all((np.abs(x) < (np.inf if name == "p" else BLOWN_UP)).all() for name, x in given.items()):
            return None
        values, raised = self.run()
        if not raised and np.isfinite(values).all():
            return None
        shown = ", ".join(f"{name} = {_shown(value)}" for name, value in given.items())
        reason = raised or "gave numbers that are not finite"
        text = f"The kernel {self.kernel.name!r} of part {self.part!r} {reason}, called with {shown}."
        return found("broken-kernel", (self.part,), text, "It must return finite numbers for these arguments.")


def failed_kernel(program: Program, instants: Sequence[Instant]) -> Finding | None:
    """Finding on the first kernel that fails at one of several states, the likeliest first."""
    # None: all are good, or the model is too large.
    for instant in instants:
        with np.errstate(all="ignore"):
            for number, call in enumerate(_calls(program, instant)):
                failure = call.failure()
                if failure is not None:
                    return failure
                if number > MOST_CALLS:
                    return None
    return None


def _calls(program: Program, s: Instant) -> Iterator[_Call]:
    """Calls of all kernels at a state, in the order of evaluation."""
    yield from _control_calls(program, s)
    yield from _element_calls(program, s)
    yield from _constraint_calls(program, s)
    yield from _contact_calls(program, s)
    M = program.tables.measured
    for k, (number, extremum) in enumerate(zip(M.kernel, M.extremum, strict=True)):
        dofs = M.dofs[M.dof[k] : M.dof[k + 1]]
        state = s.q[dofs], s.v[dofs], s.a[dofs]
        name, p = program.names.signals.names[int(M.out[k])].rpartition(".")[0], _numbers(program, M.p[k])
        if number >= 0:
            yield _Call(name, _kernel(program, "signal", number), (p, s.t, *state))
        else:
            yield _Call(name, _kernel(program, "extremum", extremum), (p, s.t, *state, -1.0))


def _control_calls(program: Program, s: Instant) -> Iterator[_Call]:
    """Laws of the controls that act at all times, and the motions and signals that they read."""
    C, outputs = program.tables.controls, np.zeros(int(program.tables.controls.output[-1]))
    for c in range(len(C.kernel)):
        begin, end = int(C.output[c]), int(C.output[c + 1])
        if C.z[c, at.END] > C.z[c, at.BEGIN]:
            outputs[begin:end] = s.z[C.z[c, at.END] - (end - begin) : C.z[c, at.END]]
            continue
        u = np.zeros(int(C.input[c + 1] - C.input[c]))
        for j in range(len(u)):
            kind, what, *bounds = (int(k) for k in C.source[C.input[c] + j])
            if kind in (at.COORDINATE, at.VELOCITY):
                u[j] = (s.q if kind == at.COORDINATE else s.v)[what]
            elif kind == at.OUTPUT:
                u[j] = outputs[what]
            else:
                name, given = "motion", tuple[Any, ...]((_numbers(program, np.array(bounds)), s.t))
                if kind == at.MEASURED:
                    place = int(C.input[c]) + j
                    dofs = C.source_dofs[C.source_dof[place] : C.source_dof[place + 1]]
                    name, given = "signal", (*given, s.q[dofs], s.v[dofs], np.zeros(len(dofs)))
                read = _Call(program.controls[c], _kernel(program, name, what), given)
                yield read
                values, raised = read.run()
                u[j] = np.nan if raised else values[1 if kind == at.MOTION_SPEED else 0]
        x, y = s.v[C.dofs[C.dof[c] : C.dof[c] + C.states[c]]], np.zeros(end - begin)
        arguments = _numbers(program, C.p[c]), s.t, u, x, np.zeros(len(x)), y
        law = _Call(program.controls[c], _kernel(program, "control", C.kernel[c]), arguments)
        yield law
        law.run()
        outputs[begin:end] = y


def _element_calls(program: Program, s: Instant) -> Iterator[_Call]:
    E, part = program.tables.elements, program.names.elements
    for e in range(len(E.kernel)):
        dofs = E.dofs[E.dof[e] : E.dof[e + 1]]
        n, p, z = len(dofs), _numbers(program, E.p[e]), s.z[E.z[e, at.BEGIN] : E.z[e, at.END]]
        state = s.q[dofs], s.v[dofs], s.a[dofs]
        if E.kernel[e] >= 0:
            outputs = np.zeros(n), np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)), z.copy()
            yield _Call(part[e], _kernel(program, "element", E.kernel[e]), (p, s.t, s.h, *state, z, *outputs))
        if E.force[e] >= 0:
            yield _Call(part[e], _kernel(program, "force", E.force[e]), (p, s.t, s.h, *state, z, np.zeros(n), z.copy()))
        if E.energy[e] >= 0:
            yield _Call(part[e], _kernel(program, "energy", E.energy[e]), (p, s.t, *state[:2]))
        if E.factor[e] >= 0:
            yield _Call(part[e], _kernel(program, "motion", E.factor[e]), (_numbers(program, E.factor_p[e]), s.t))


def _constraint_calls(program: Program, s: Instant) -> Iterator[_Call]:
    C, rows = program.tables.constraints, program.names.rows
    for c in range(len(C.kernel)):
        dofs = C.dofs[C.dof[c] : C.dof[c + 1]]
        begin, end = int(C.row[c]), int(C.row[c + 1])
        n, m, q, v = len(dofs), end - begin, s.q[dofs], s.v[dofs]
        part, lam = rows[begin].rpartition("[")[0], s.lam[begin:end]
        outputs = np.zeros(m), np.zeros((m, n)), np.zeros(m), np.zeros(m), np.zeros((n, n))
        p = _numbers(program, C.p[c])
        yield _Call(part, _kernel(program, "constraint", C.kernel[c]), (p, s.t, q, v, lam, *outputs))
        for k in range(begin, end):
            if C.motion[k] >= 0:
                yield _Call(part, _kernel(program, "motion", C.motion[k]), (_numbers(program, C.motion_p[k]), s.t))
        if C.joint_friction[c, at.LOAD_KERNEL] >= 0:
            out, places = np.zeros(JOINT_FRICTION_SIZE), C.joint_friction_p[c]
            p, law_p = (_numbers(program, places[first:]) for first in (at.LOAD_P, at.SLIDING_P))
            load = _kernel(program, "joint_friction", C.joint_friction[c, at.LOAD_KERNEL])
            yield _Call(part, load, (p, q, lam, out, np.zeros((n, n))))
            z = s.z[C.joint_friction_z[c, at.BEGIN] : C.joint_friction_z[c, at.END]]
            slip, law = float(out[SLIDING : SLIDING + 6] @ v[:6]), C.joint_friction[c, at.SLIDING_LAW]
            yield _Call(part, _kernel(program, "friction", law), (law_p, s.h, slip, float(out[LOAD]), z, z.copy()))


def _contact_calls(program: Program, s: Instant) -> Iterator[_Call]:
    K, names = program.tables.contacts, program.names.contacts
    for k in range(len(K.kernel)):
        dofs, places, z, out = K.dofs[6 * k : 6 * k + 6], K.p[k], K.z[k], np.zeros(GAP_SIZE)
        gap, normal, friction = (
            _kernel(program, kind, K.kernel[k, column])
            for kind, column in (("gap", at.GAP_KERNEL), ("normal", at.NORMAL_LAW), ("friction", at.FRICTION_LAW))
        )
        yield _Call(names[k], gap, (_numbers(program, places[at.GAP_P :]), s.q[dofs], s.v[dofs], out))
        own = s.z[z[at.NORMAL_Z] : z[at.FRICTION_Z]]
        arguments = _numbers(program, places[at.NORMAL_P :]), s.h, float(out[GAP]), float(out[GAP_RATE])
        pressed = _Call(names[k], normal, (*arguments, own, own.copy()))
        yield pressed
        N, raised = pressed.run()
        if raised:
            continue
        own = s.z[z[at.FRICTION_Z] : z[at.Z_END]]
        arguments = _numbers(program, places[at.FRICTION_P :]), s.h, float(out[SLIP]), float(N[0])
        yield _Call(names[k], friction, (*arguments, own, own.copy()))


def changed_contacts(program: Program, before: np.ndarray, after: np.ndarray) -> tuple[list[str], list[str]]:
    """Names of contacts that closed, and that opened, between two histories (n_z,)."""
    closed: list[str] = []
    opened: list[str] = []
    for name, place in zip(program.names.contacts, program.tables.contacts.z[:, at.COMMON_Z], strict=True):
        was, now = before[place + at.LAST_GAP] < 0.0, after[place + at.LAST_GAP] < 0.0
        if was != now:
            (closed if now else opened).append(name)
    return closed, opened


def _kernel(program: Program, kind: str, number: Any) -> Kernel:
    return program.kernels[KINDS.index(kind)][int(number)]


def _numbers(program: Program, bounds: np.ndarray) -> np.ndarray:
    return program.tables.p[bounds[at.BEGIN] : bounds[at.END]]


def _shown(value: Any) -> str:
    """A number, or the first entries of an array."""
    if np.ndim(value) == 0:
        return f"{float(value):.6g}"
    entries = [f"{float(x):.6g}" for x in np.ravel(value)[:SHOWN_NUMBERS]]
    return f"({', '.join([*entries, '...'] if np.size(value) > SHOWN_NUMBERS else entries)})"
