"""Contracts between the compiled loop and the parts, and the class of kernels.

A kernel is one pure function of plain floats and arrays.  Its contract fixes the signature, so the loop is
compiled once for every model and calls each kernel through its address: a new part never recompiles the loop.
All arrays are float64 in C order; outputs are zeroed by the caller.

=============  ==========================================================  ==========================
contract       parameters                                                  result
=============  ==========================================================  ==========================
element        p, t, h, q, v, a, z, r, K, C, M, z_new                      written to r, K, C, M, z_new
energy         p, t, q, v                                                  strain, gravity, damping power
force          p, t, h, q, v, a, z, r, z_new                               written to r, z_new
tangent        p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new                written to r, A, z_new
account        p, t, h, q, v, a, y, z, r, Mv, My, z_new                    strain, gravity, damping power
damping        p, t, q, v, w                                               v.D v, v.D w, powers of dampers D
constraint     p, t, q, v, lam, g, G, g_t, gamma, H                        written to g, G, g_t, gamma, H
gap            p, q, v, out                                                written to out (`GAP_SIZE`)
normal         p, h, gap, gap_rate, z, z_new                               N, dN_dgap, dN_drate
friction       p, h, slip, N, z, z_new                                     T, dT_dslip, dT_dN
motion         p, t                                                        s, s_dot, s_ddot
joint_friction p, q, lam, out, H                                           written to out, H
signal         p, t, q, v, a                                               value
extremum       p, t, q, v, a, least                                        value, number of its place
control        p, t, u, x, dx, y                                           written to dx, y
rates          p, t, x, out                                                written to out
height         p, t, x                                                     value
=============  ==========================================================  ==========================

p : parameters of the part; z : history at the last accepted state, h : time since then [s], z_new : history if this
state is accepted.  h = 0 must be safe.  A normal or friction law may return N or T alone; derivatives are then central
differences.  r : generalised force that the part exerts, inertia included;
K, C, M = dr/dq, dr/dv, dr/da.  G = dg/dq; g_t : partial derivative in time; G a = gamma on the manifold;
H = d(G^T lam)/dq.

force, tangent and account kernels give the results of element and energy kernels at less cost, for elements whose speed
counts: forces alone; forces with A = kq K + kv C + ka M; forces and energies of an accepted state, with M v and M y for
any y; damping kernels give powers for any velocities w.  An element without them is called through those two kernels.

least : a value that is not above it may be given as 0, or any other that is not above it; < 0: the value is wanted.

u : inputs of a controller, x : its own states, dx : their rates, y : its outputs, the factors of loads.

rates and height are of own differential equations with the state x (`dynamics.systems.compiled_ode`): rates of the
state, or the state after a jump; distance from a wall.
"""

import ast
import inspect
import pickle
import re
from collections.abc import Callable, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from numbers import Real
from textwrap import dedent
from types import FunctionType
from typing import Any

import numba
import numpy as np
from numba import types
from numba.core import config
from numba.core.errors import NumbaError
from numba.extending import intrinsic
from numba.np import arrayobj

from flexmb.engine.compiled.arrays import MATRIX
from flexmb.engine.compiled.code_cache import CodeCache, SealedCache, ours, stamp
from flexmb.engine.compiled.digest import Parts, digest, parts_of
from flexmb.engine.compiled.lanes import FUSED
from flexmb.engine.compiled.notice import notice
from flexmb.engine.compiled.pieces import KernelPointer, plain, whole
from flexmb.engine.differences import BY_CONTRACT, with_differences
from flexmb.errors import KernelError

__all__ = [
    "account_kernel", "constraint_kernel", "control_kernel", "damping_kernel", "drive_kernel", "element_kernel",
    "energy_kernel", "force_kernel", "friction_law", "gap_kernel", "normal_law", "signal_kernel", "tangent_kernel",
]  # fmt: skip


_F = types.float64
_V = types.Array(_F, 1, "C")
_P = types.Array(_F, 1, "C", readonly=True)
_M = MATRIX
_TRIPLE, _VOID = types.UniTuple(_F, 3), types.void

compiled = whole(error_model="numpy", _nrt=False, forceinline=True)
"""Decorator of the compiled functions of the loop.

The functions are compiled without numba's memory management: a function that allocates does not compile, and views of
arrays cost nothing.  The functions are inlined into one another, since handing on the tables of a program costs more
than most of them.  Kernels may allocate, since users write them.
"""

fast = whole(error_model="numpy", _nrt=False, forceinline=True, fastmath=set(FUSED))
"""`compiled` with fused multiply-add, for the formulas of elements: a beam takes a sixth less time.

Sums keep their order (another gains 4 % and may lose digits where large terms cancel); NaN and infinity stay visible.
"""


summing = whole(error_model="numpy", _nrt=False, forceinline=True, fastmath={*FUSED, "reassoc"})
"""`fast` with sums in the order that suits the processor, for long sums of numbers that do not cancel."""


@compiled
def copy(source, target):  # type: ignore[no-untyped-def]
    """target = source, element by element."""
    for i in range(source.shape[0]):
        target[i] = source[i]


@dataclass(frozen=True)
class Contract:
    """Contract of one kind of kernel: name, names of the parameters, numba signature."""

    name: str
    parameters: tuple[str, ...]
    signature: Any


_BY_NAME: dict[str, Contract] = {}  # for unpickling typed-in kernels


def _contract(name: str, parameters: str, result: Any, *arguments: Any) -> Contract:
    return _BY_NAME.setdefault(name, Contract(name, tuple(parameters.split()), result(*arguments)))


ELEMENT = _contract("element", "p t h q v a z r K C M z_new", _VOID, _P, _F, _F, _V, _V, _V, _P, _V, _M, _M, _M, _V)
ENERGY = _contract("energy", "p t q v", _TRIPLE, _P, _F, _V, _V)
CONSTRAINT = _contract("constraint", "p t q v lam g G g_t gamma H", _VOID, _P, _F, _V, _V, _V, _V, _M, _V, _V, _M)
GAP = _contract("gap", "p q v out", _VOID, _P, _V, _V, _V)
NORMAL = _contract("normal", "p h gap gap_rate z z_new", _TRIPLE, _P, _F, _F, _F, _P, _V)
FRICTION = _contract("friction", "p h slip N z z_new", _TRIPLE, _P, _F, _F, _F, _P, _V)
MOTION = _contract("motion", "p t", _TRIPLE, _P, _F)
JOINT_FRICTION = _contract("joint_friction", "p q lam out H", _VOID, _P, _V, _V, _V, _M)
FORCE = _contract("force", "p t h q v a z r z_new", _VOID, _P, _F, _F, _V, _V, _V, _P, _V, _V)
TANGENT = _contract(
    "tangent", "p t h q v a z kq kv ka r A z_new", _VOID, *(_P, _F, _F, _V, _V, _V, _P, _F, _F, _F, _V, _M, _V)
)
ACCOUNT = _contract("account", "p t h q v a y z r Mv My z_new", _TRIPLE, _P, _F, _F, _V, _V, _V, _V, _P, _V, _V, _V, _V)
DAMPING = _contract("damping", "p t q v w", types.UniTuple(_F, 2), _P, _F, _V, _V, _V)
SIGNAL = _contract("signal", "p t q v a", _F, _P, _F, _V, _V, _V)
EXTREMUM = _contract("extremum", "p t q v a least", types.UniTuple(_F, 2), _P, _F, _V, _V, _V, _F)
CONTROL = _contract("control", "p t u x dx y", _VOID, _P, _F, _P, _P, _V, _V)
RATES = _contract("rates", "p t x out", _VOID, _P, _F, _V, _V)
HEIGHT = _contract("height", "p t x", _F, _P, _F, _V)

GAP_SIZE = 49
"""Length of `out` of a gap kernel: gap, gap rate, slip, normal (2), arms on the first and on the second body (2 each),
eccentricity (2), its rate (2), derivatives of normal, first arm and second arm by the six coordinates (2 x 6 each, row
by row).  `flexmb.places` names the places."""

JOINT_FRICTION_SIZE = 4 + 6 + 6
"""Length of `out` of a joint-friction kernel: normal load (>= 0), its derivatives by up to three multipliers, the
direction J of sliding, with slip = J v, and derivatives of the load by the coordinates; H = dJ/dq.  A law that needs
the place of the joint and no load, as that of a clutch, gets it as a load of either sign."""

HELPER = re.compile(r"Untyped global name '(\w+)':.*<class 'function'>")
"""Words of numba about a function that is called and not compiled."""


def text_of(function: Any) -> str | None:
    """Source text of a function as it stands in its file, or None where there is none (typed-in code)."""
    try:
        return inspect.getsource(function)
    except (OSError, TypeError):
        return None


class Kernel:
    """A kernel function with its contract; compiled when it is first needed, once a process, cached on disk.

    Parameters
    ----------
    function : the Python function, with the parameters of the contract in their order.
    contract : one of the contracts of this module.

    Raises
    ------
    KernelError : the function does not take the contract's number of parameters; at its first use: numba refuses it.

    Notes
    -----
    A normal or friction law of a user may return its force alone.  Its derivatives are then central differences, with
    an error of some 1e-9 of them; at a kink they are the mean of both sides.
    """

    def __init__(self, function: Callable[..., Any], contract: Contract) -> None:
        try:
            taken = len(inspect.signature(function).parameters)
        except (TypeError, ValueError):
            raise KernelError(f"The {contract.name} kernel is {function!r}; it must be a function.") from None
        if taken != len(contract.parameters):
            expected = ", ".join(contract.parameters)
            text = f"Kernel {function.__qualname__!r} takes {taken} parameters;"
            raise KernelError(f"{text} the {contract.name} contract has {len(contract.parameters)}: ({expected}).")
        self.function, self.contract = function, contract
        self._dispatcher: Any = None
        self._address = 0
        self.__doc__ = function.__doc__

    @property
    def name(self) -> str:
        """Qualified name of the function."""
        return self.function.__qualname__

    @cached_property
    def identity(self) -> str:
        """Full name, of a user's kernel with its source, where there is one."""
        text = None if ours(self.function) else text_of(self.function)
        return f"{self.function.__module__}.{self.name} {text and ast.dump(ast.parse(dedent(text)))}"

    @cached_property
    def content(self) -> str:
        """Digest of the function of a user, with the values of its closure and of all globals; "" of flexmb's own."""
        return "" if ours(self.function) else digest(self.function)

    @cached_property
    def python(self) -> Any:
        """Python function of the contract; a user's law that returns its force alone gets its derivatives."""
        if ours(self.function):
            return plain(self.function)
        if not self._may_be_alone:
            return self.function
        with_derivatives = with_differences(self.contract.name, self.function, self.function)

        def completed(*arguments: Any) -> Any:
            found = self.function(*arguments)
            return with_derivatives(*arguments) if isinstance(found, Real) else found

        return completed

    @property
    def dispatcher(self) -> Any:
        """The compiled function."""
        if self._dispatcher is None:
            with nullcontext() if ours(self.function) else notice.compiling(self.name):
                self._dispatcher = self._compiled_or_refused()
        return self._dispatcher

    @property
    def address(self) -> int:
        """Address of the compiled function in this process, valid as long as the kernel exists."""
        if self._address == 0:
            result = self.dispatcher.get_compile_result(self.contract.signature)
            self._address = int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))
        return self._address

    def __call__(self, *arguments: Any) -> Any:
        """Call the plain Python function."""
        return self.python(*arguments)

    def __repr__(self) -> str:
        return f"<{self.contract.name} kernel {self.name}>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Kernel) and (self.function is other.function or self._key() == other._key())

    def __hash__(self) -> int:
        return hash(self._key())

    def __reduce__(self) -> tuple[Any, ...]:
        module, name = self.function.__module__, self.function.__qualname__
        if _lookup(module, name) is self:
            return _lookup, (module, name)
        return _from_bytes, (numba.cloudpickle.dumps(self.function), self.contract.name, self.identity)

    def _key(self) -> tuple[Any, ...]:
        code = self.function.__code__
        return self.function.__module__, self.function.__qualname__, code.co_code, code.co_consts, self.content

    @property
    def is_alone(self) -> bool:
        """Whether the compiled function has derivatives by differences, of a law that returns its force alone."""
        return getattr(self.dispatcher, "py_func", self.function) is not self.function

    @property
    def _may_be_alone(self) -> bool:
        return self.contract.name in BY_CONTRACT and not ours(self.function)

    def _compiled_or_refused(self) -> Any:
        try:
            return self._compiled(_nrt=False)
        except NumbaError:  # it may allocate memory, which costs time but is allowed
            pass
        try:
            return self._compiled(_nrt=True)
        except NumbaError as error:
            helper = HELPER.search(str(error))
            remedy = "Write it with what numba compiles: numbers, arrays, conditions, functions under `@numba.njit`."
            if helper:
                remedy = f"It calls {helper[1]!r}, which is not compiled; put `@numba.njit` on it."
            text = f"Kernel {self.name!r} cannot be compiled as {self.contract.name}"
            raise KernelError(f"{text}: {str(error).rstrip()}\n{remedy}") from error

    def _compiled(self, **options: Any) -> Any:
        """The function compiled to its contract, with the derivatives of a force alone."""
        if config.DISABLE_JIT:
            return self.python
        signature = self.contract.signature
        if self._may_be_alone:
            alone = self._for(self.function, signature.args, **options)
            result = alone.overloads[signature.args].signature.return_type
            if isinstance(result, types.Number):
                return self._for(with_differences(self.contract.name, self.function, alone), signature, **options)
            if result == signature.return_type:
                return alone
        return self._for(self.function, signature, **options)

    def _for(self, function: Any, signature: Any, **options: Any) -> Any:
        """A function compiled to a signature, or loaded from a cache; code typed into a session has no cache."""
        checked = self.contract is CONTROL  # users count its arrays themselves
        dispatcher = numba.njit(error_model="numpy", boundscheck=checked, **options)(function)
        if ours(function):
            dispatcher._cache = CodeCache(function)
        else:
            with suppress(RuntimeError):  # typed-in code has no file beside which a cache could lie
                dispatcher._cache = SealedCache(function, f"{self.content} {stamp(__name__)}")
        dispatcher.compile(signature)
        dispatcher.disable_compile()
        return dispatcher


def rebound(kernel: Kernel, name: str, functions: dict[str, Any]) -> Kernel:
    """A kernel of the same lines under another name, with the globals `functions` for the functions that it calls."""
    # A function with other globals is no closure, so its machine code is kept and shipped as that of any kernel.
    function = FunctionType(kernel.function.__code__, functions, name.rpartition(".")[2])
    function.__qualname__ = name
    return Kernel(function, kernel.contract)


@parts_of.register
def _parts(value: Kernel) -> Parts:
    return "kernel", [value.contract.name, value.function]


def _lookup(module: str, name: str) -> Any:
    found: Any = import_module(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    return found


def _from_bytes(code: bytes, contract: str, identity: str) -> Kernel:
    kernel = Kernel(pickle.loads(code), _BY_NAME[contract])  # noqa: S301 - written by __reduce__ above
    kernel.identity = identity  # of code typed in, whose text other processes do not see
    return kernel


def _decorator(contract: Contract) -> Callable[[Callable[..., Any]], Kernel]:
    def decorate(function: Callable[..., Any]) -> Kernel:
        return Kernel(function, contract)

    decorate.__doc__ = f"Make a function ({', '.join(contract.parameters)}) a {contract.name} kernel."
    return decorate


element_kernel = _decorator(ELEMENT)
energy_kernel = _decorator(ENERGY)
constraint_kernel = _decorator(CONSTRAINT)
gap_kernel = _decorator(GAP)
normal_law = _decorator(NORMAL)
friction_law = _decorator(FRICTION)
drive_kernel = _decorator(MOTION)
joint_friction_kernel = _decorator(JOINT_FRICTION)
signal_kernel = _decorator(SIGNAL)
extremum_kernel = _decorator(EXTREMUM)
force_kernel = _decorator(FORCE)
tangent_kernel = _decorator(TANGENT)
account_kernel = _decorator(ACCOUNT)
damping_kernel = _decorator(DAMPING)
control_kernel = _decorator(CONTROL)


def address_table(kernels: Sequence[Kernel]) -> Any:
    """Table by which the compiled loop calls `kernels` by number: addresses, or functions without JIT."""
    if config.DISABLE_JIT:
        return tuple(kernel.python for kernel in kernels)
    table = np.zeros(max(1, len(kernels)), dtype=np.int64)
    for i, kernel in enumerate(kernels):
        table[i] = kernel.address
    table.flags.writeable = False
    return table


def _caller(contract: Contract) -> Any:
    """Make the compiled function (table, k) that returns kernel number k as a callable."""
    if config.DISABLE_JIT:
        return lambda table, k: table[k]
    pointer_type = KernelPointer(contract.name, contract.signature)

    @intrinsic
    def kernel_at(typingctx, table, k):  # type: ignore[no-untyped-def]
        def codegen(context, builder, signature, args):  # type: ignore[no-untyped-def]
            array = arrayobj.make_array(signature.args[0])(context, builder, args[0])
            address = builder.load(builder.gep(array.data, [args[1]]))
            return builder.inttoptr(address, context.get_value_type(types.voidptr))

        return pointer_type(table, k), codegen

    return kernel_at


element_at = _caller(ELEMENT)
energy_at = _caller(ENERGY)
constraint_at = _caller(CONSTRAINT)
gap_at = _caller(GAP)
normal_at = _caller(NORMAL)
friction_at = _caller(FRICTION)
motion_at = _caller(MOTION)
joint_friction_at = _caller(JOINT_FRICTION)
signal_at = _caller(SIGNAL)
extremum_at = _caller(EXTREMUM)
force_at = _caller(FORCE)
tangent_at = _caller(TANGENT)
account_at = _caller(ACCOUNT)
damping_at = _caller(DAMPING)
control_at = _caller(CONTROL)
rates_at = _caller(RATES)
height_at = _caller(HEIGHT)
