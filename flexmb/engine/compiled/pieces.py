"""Compiled functions as pieces, lowered once each; addresses of kernels.

numba optimises and emits every function by itself, with all that it calls linked in and inlined again: a loop of two
hundred functions is optimised many times over.  Here a function that compiled code calls stays intermediate code (a
piece).  Where Python calls one, its piece and those that it reaches are linked into one module, which is optimised and
emitted once and cached by numba as ever.

Pieces rest on numba's own pipeline and code library.  `flexmb.version.FAST_NUMBA` are the versions that have them as
they are known here; else every function is compiled in the ordinary way.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterable
from functools import cached_property
from types import FunctionType, ModuleType
from typing import Any

import llvmlite.binding as ll
import numba
from numba import types
from numba.core import cgutils, config, funcdesc, typing
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags, _LowerResult
from numba.core.compiler_machinery import register_pass
from numba.core.datamodel import models
from numba.core.dispatcher import Dispatcher
from numba.core.imputils import lower_builtin
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import NativeLowering
from numba.extending import _Intrinsic, register_model

from flexmb.engine.compiled.ahead import finished
from flexmb.engine.compiled.arrays import PLAIN
from flexmb.engine.compiled.code_cache import CodeCache
from flexmb.engine.compiled.notice import UNPIECED_FACTOR, notice
from flexmb.version import compiles_fast


# Addresses of kernels, as compiled code calls them
class KernelPointer(types.Callable, types.Opaque):
    """numba's type of the address of a kernel, which is called directly, with name and signature of its contract."""

    # numba's own first-class functions ask at every call whether there is an address, and else call Python.

    def __init__(self, name: str, signature: Any) -> None:
        self.signature = signature
        super().__init__(f"kernel_{name}")

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:  # noqa: ARG002 - as numba asks
        """The signature of the contract, whatever is given."""
        return typing.signature(self.signature.return_type, *self.signature.args, recvr=self)

    def get_call_signatures(self) -> Any:
        """The signature of the contract."""
        return (self.signature,), False

    def get_impl_key(self, sig: Any) -> Any:  # noqa: ARG002 - as numba asks
        """Key of the registration of `_call_kernel`."""
        return KernelPointer


register_model(KernelPointer)(models.OpaqueModel)


@lower_builtin(KernelPointer, types.VarArg(types.Any))
def _call_kernel(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    kinds = signature.args[1:]
    kind = context.call_conv.get_function_type(signature.return_type, kinds)
    function = builder.bitcast(arguments[0], kind.as_pointer())
    status, result = context.call_conv.call_function(builder, function, signature.return_type, kinds, arguments[1:])
    with cgutils.if_unlikely(builder, status.is_error):
        context.call_conv.return_status_propagate(builder, status)
    return result


# Compiled functions as pieces: each is lowered once; functions called from Python are optimised as a whole

# Instructions of intermediate code below which a piece is always inlined; of longer ones LLVM decides.
INLINE_BELOW = 600


class QuickFlags(Flags):
    """numba's flags of a compilation, compared in a hundredth of the time."""

    # They are part of the key of every function of numba's own that is looked up; numba reads all of them each time.

    def __hash__(self) -> int:
        return 0

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Flags):
            return NotImplemented
        return {**DEFAULTS, **self._values} == {**DEFAULTS, **other._values}


DEFAULTS = {name: option.default for name, option in Flags.options.items()}


class PieceLibrary(JITCodeLibrary):
    """Intermediate code of one function, without that of the functions it calls."""

    _shared_module: Any

    def _ensure_finalized(self) -> None:
        self._finalized = True

    def finalize(self) -> None:
        """Nothing is left to do."""
        self._finalized = True

    def add_ir_module(self, ir_module: Any) -> None:
        """Take the code of the function in."""
        for function in ir_module.functions:
            if sum(len(block.instructions) for block in function.blocks) > INLINE_BELOW:
                function.attributes.discard("alwaysinline")
        super().add_ir_module(ir_module)

    def add_llvm_module(self, ll_module: Any) -> None:
        """Take code in without optimising it."""
        self._final_module.link_in(ll_module)

    def own(self) -> Any:
        """Module of its function, for linking into another module."""
        # As `weak_odr`, since LLVM drops a `linkonce_odr` function that nobody has called yet.
        if self._shared_module is None:
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == ll.Linkage.external:
                    function.linkage = "weak_odr"
            self._shared_module = self._final_module
        return self._shared_module

    def _get_module_for_linking(self) -> Any:
        """The function with all that it calls, for libraries of numba's own."""
        module = self.own().clone()
        for library in reached(self._linking_libraries):
            if library is not self:
                module.link_in(_module_of(library), preserve=True)
        for function in module.functions:
            if not function.is_declaration:
                function.linkage = "linkonce_odr"
        return module


def reached(libraries: Iterable[Any]) -> list[Any]:
    """These libraries and all libraries that they call, pieces first."""
    found: dict[int, Any] = {}
    todo = list(libraries)
    while todo:
        library = todo.pop()
        if id(library) not in found:
            found[id(library)] = library
            if isinstance(library, PieceLibrary):
                todo.extend(library._linking_libraries)
    return sorted(found.values(), key=lambda library: not isinstance(library, PieceLibrary))


def _module_of(library: Any) -> Any:
    return library.own() if isinstance(library, PieceLibrary) else library._get_module_for_linking()


class WholeLibrary(JITCodeLibrary):
    """A function with all that it calls, optimised and emitted once."""

    def add_llvm_module(self, ll_module: Any) -> None:
        """Take code in without optimising it."""
        self._final_module.link_in(ll_module)

    def finalize(self) -> None:
        """Link all that is reached, optimise and emit it."""
        module = self._final_module
        entries = {function.name for function in module.functions if not function.is_declaration}
        for library in reached(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            module.link_in(_module_of(library), preserve=True)
        for function in module.functions:
            if not function.is_declaration and function.name not in entries:
                function.linkage = "internal"
                # Parameters of internal functions may be optimised away, and the loader finds names of all objects.
                function.name = f"{function.name}.of.{min(entries)}"
        manager, builder = self._codegen._module_pass_manager()
        manager.run(module, builder)
        module.verify()
        self._finalize_final_module()

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """Machine code, and names in place of intermediate code: compiled functions that call it have its piece."""
        self._ensure_finalized()
        own = (f for f in self._final_module.functions if not f.is_declaration and f.linkage == ll.Linkage.external)
        names = "".join(f'define void @"{function.name}"() {{ unreachable }}\n' for function in own)
        return self.name, "object", (self._get_compiled_object(), ll.parse_assembly(names).as_bitcode())


class _Key:
    """Stands for a piece among the functions that numba knows."""


@register_pass(mutates_CFG=True, analysis_only=False)
class PieceLowering(NativeLowering):
    """Lower a function to intermediate code alone: no wrapper, no machine code."""

    _name = "flexmb_piece_lowering"

    def run_pass(self, state: Any) -> bool:
        """Lower the function that `state` describes."""
        target, flags = state.targetctx, state.flags
        library = state.library = PieceLibrary(target.codegen(), state.func_id.func_qualname)
        description = funcdesc.PythonFunctionDescriptor.from_specialized_function(
            state.func_ir, state.typemap, state.return_type, state.calltypes, mangler=target.mangler,
            inline=flags.forceinline, noalias=flags.noalias, abi_tags=[flags.get_mangle_string()],
        )  # fmt: skip
        with target.push_code_library(library):
            lower = self.lowering_class(target, library, description, state.func_ir, metadata=state.metadata)
            lower.lower()
        key = _Key()
        target.insert_user_function(key, description, [library])
        state["cr"] = _LowerResult(description, lower.call_helper, cfunc=key, env=lower.env)
        state.metadata["prune_stats"] = None
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class WholeLowering(NativeLowering):
    """Lower a function that Python calls, with all that it reaches."""

    _name = "flexmb_whole_lowering"

    def run_pass(self, state: Any) -> bool:
        """Lower the function that `state` describes."""
        state.library = WholeLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        state.flags.no_cfunc_wrapper = True
        return bool(super().run_pass(state))


def _compiler_with(lowering: Any) -> Any:
    """numba's compiler with another pass for lowering."""

    class Compiler(CompilerBase):
        def define_pipelines(self) -> list[Any]:
            manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
            manager.passes = [(lowering if step is NativeLowering else step, text) for step, text in manager.passes]
            manager.finalize()
            return [manager]

    return Compiler


PieceCompiler, WholeCompiler = _compiler_with(PieceLowering), _compiler_with(WholeLowering)


def _quick(flags: Any) -> QuickFlags:
    """Copy of numba's flags with a fast comparison."""
    return QuickFlags(flags)


class Piece(CPUDispatcher):
    """Callable of compiled functions: the intermediate code of one function."""

    def add_overload(self, result: Any) -> None:
        """Keep a compiled signature, which Python cannot call."""
        self.overloads[tuple(result.signature.args)] = result


class Whole(CPUDispatcher):
    """Callable of Python: a function with all functions that it calls; compiled functions call its piece."""

    @cached_property
    def piece(self) -> Piece:
        """The piece of the function, made at first use."""
        piece = Piece(self.py_func, locals={}, targetoptions=dict(self.targetoptions), pipeline_class=PieceCompiler)
        piece._compiler._customize_flags = _quick
        return piece

    def enable_caching(self) -> None:
        """Look for compiled code in the installation, too."""
        self._cache = CodeCache(self.py_func)

    def compile(self, signature: Any) -> Any:
        """Compile a signature, or find it in the cache."""
        # Python's collector rests meanwhile, since it would look at millions of objects that stay.
        collects = gc.isenabled()
        gc.disable()
        try:
            with finished(self.py_func):
                return super().compile(signature)
        finally:
            if collects:
                gc.enable()

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Call template of the piece for these types."""
        return self.piece.get_call_template(args, kws)

    def get_overload(self, signature: Any) -> Any:
        """The piece of a signature."""
        return self.piece.get_overload(signature)


def whole(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """A decorator like `numba.njit(cache=True, nogil=True, **options)`, whose functions are pieces of one another."""
    if config.DISABLE_JIT or not compiles_fast(numba.__version__):
        notice.times = UNPIECED_FACTOR
        return numba.njit(cache=True, nogil=True, **options)  # type: ignore[no-any-return]

    def decorate(function: Callable[..., Any]) -> Any:
        given = {"nopython": True, "nogil": True, "boundscheck": None, **options}
        outer = Whole(function, locals={}, targetoptions=given, pipeline_class=WholeCompiler)
        outer._compiler._customize_flags = _quick
        outer.enable_caching()
        return outer

    return decorate


_plain_names: dict[int, tuple[Any, dict[str, Any]]] = {}  # globals, and the same in plain Python; by id


def plain(function: Any) -> Any:
    """A function in plain Python, as are the compiled functions that it calls: nothing is compiled for a call."""
    names = function.__globals__
    if id(names) not in _plain_names:
        found = dict(names)
        _plain_names[id(names)] = names, found
        found.update({name: _plain_value(value) for name, value in names.items()})
    found = _plain_names[id(names)][1]
    return FunctionType(function.__code__, found, function.__name__, function.__defaults__, function.__closure__)


def _plain_value(value: Any) -> Any:
    """A compiled function, an intrinsic or a module of the package in plain Python; others as they are."""
    if isinstance(value, Dispatcher):
        return plain(value.py_func)
    if isinstance(value, _Intrinsic):
        return PLAIN.get(value, value)
    return PlainModule(value) if isinstance(value, ModuleType) and value.__name__.startswith("flexmb.") else value


class PlainModule:
    """A module whose compiled functions are in plain Python."""

    def __init__(self, module: ModuleType) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Any:
        return _plain_value(getattr(self._module, name))
