"""Scratch matrices and vectors on the stack of a kernel: kernels allocate nothing on the heap.

    scratch = stack_matrix(20, 96)     # once, in a module

    @element_kernel
    def kernel(p, ...):
        x = scratch()                  # in the kernel itself; functions that it calls are handed x

The memory is that of the function which calls `scratch`, so it must not be returned from there.  Its values are
undefined at first.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils, config
from numba.extending import intrinsic, overload
from numba.np import arrayobj

from flexmb.compiled.views import MATRIX


def stack_matrix(rows: int, columns: int) -> Callable[[], Any]:
    """A function that returns a matrix (rows, columns) of floats, on the stack in compiled code."""

    def scratch() -> Any:
        return np.zeros((rows, columns))

    @intrinsic
    def on_stack(typingctx):
        def codegen(context, builder, signature, args):
            data = cgutils.alloca_once(builder, ir.DoubleType(), size=ir.Constant(ir.IntType(64), rows * columns))
            view = arrayobj.make_array(MATRIX)(context, builder)
            size = context.get_constant(types.intp, 8)
            shape = [context.get_constant(types.intp, rows), context.get_constant(types.intp, columns)]
            strides = [context.get_constant(types.intp, 8 * columns), size]
            arrayobj.populate_array(view, data, shape, strides, size, None)
            return view._getvalue()

        return MATRIX(), codegen

    @overload(scratch, inline="always")  # by numba, before LLVM: the memory is that of the caller
    def scratch_compiled() -> Any:
        def implementation() -> Any:
            return on_stack()

        return implementation

    return scratch


def stack_vector(size: int) -> Callable[[], Any]:
    """A function that returns a vector (size,) of floats, on the stack, for functions that are compiled in any case.

    Functions made by `flexmb.kernels.fast` can call it, which are compiled without numba's memory management.
    """
    if config.DISABLE_JIT:
        return lambda: np.zeros(size)

    @intrinsic
    def on_stack(typingctx):
        def codegen(context, builder, signature, args):
            data = cgutils.alloca_once(builder, ir.DoubleType(), size=ir.Constant(ir.IntType(64), size))
            view = arrayobj.make_array(signature.return_type)(context, builder)
            width, length = context.get_constant(types.intp, 8), context.get_constant(types.intp, size)
            arrayobj.populate_array(view, data, [length], [width], width, None)
            return view._getvalue()

        return types.Array(types.float64, 1, "C")(), codegen

    vector: Callable[[], Any] = on_stack
    return vector


def _stack_space() -> Any:
    """Make the compiled function (size) that returns a vector of `size` numbers on the stack, for `fast` functions."""
    if config.DISABLE_JIT:
        return np.zeros

    @intrinsic
    def stack_space(typingctx, size):
        def codegen(context, builder, signature, args):
            data = builder.alloca(ir.DoubleType(), size=args[0])
            view = arrayobj.make_array(signature.return_type)(context, builder)
            width = context.get_constant(types.intp, 8)
            arrayobj.populate_array(view, data, [args[0]], [width], width, None)
            return view._getvalue()

        return types.Array(types.float64, 1, "C")(types.intp), codegen

    return stack_space


stack_space = _stack_space()
