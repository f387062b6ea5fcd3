"""Arrays of compiled code: scratch on the stack, views of flat arrays.

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

MATRIX = types.Array(types.float64, 2, "C")  # type of a matrix


def _matrix_view() -> Any:
    """Make the compiled function (flat, rows, columns) that returns the start of `flat` as a matrix, without a copy."""
    if config.DISABLE_JIT:
        return lambda flat, rows, columns: flat[: rows * columns].reshape(rows, columns)

    @intrinsic
    def matrix_view(typingctx, flat, rows, columns):
        def codegen(context, builder, signature, args):
            source = arrayobj.make_array(signature.args[0])(context, builder, args[0])
            view = arrayobj.make_array(MATRIX)(context, builder)
            size = context.get_constant(types.intp, 8)
            strides = (builder.mul(args[2], size), size)
            arrayobj.populate_array(view, source.data, args[1:], strides, size, None)
            return view._getvalue()

        return MATRIX(flat, types.intp, types.intp), codegen

    return matrix_view


matrix_view = _matrix_view()


def _part_of() -> Any:
    """Make the compiled function (flat, begin, end) that returns flat[begin:end] without checks of the bounds."""
    # A slice tests signs and bounds, and so does every index into it, unless numba knows that indices start at 0.
    if config.DISABLE_JIT:
        return lambda flat, begin, end: flat[begin:end]

    @intrinsic
    def part_of(typingctx, flat, begin, end):
        def codegen(context, builder, signature, args):
            source = arrayobj.make_array(signature.args[0])(context, builder, args[0])
            view = arrayobj.make_array(signature.return_type)(context, builder)
            size, length = context.get_constant(types.intp, 8), builder.sub(args[2], args[1])
            arrayobj.populate_array(view, builder.gep(source.data, [args[1]]), [length], [size], size, None)
            return view._getvalue()

        return flat(flat, types.intp, types.intp), codegen

    return part_of


part_of = _part_of()


def _row_of() -> Any:
    """Make the compiled function (matrix, row, length) that returns the start of a row, which may go on in the next."""
    if config.DISABLE_JIT:
        return lambda matrix, row, length: matrix.ravel()[row * matrix.shape[1] :][:length]

    @intrinsic
    def row_of(typingctx, matrix, row, length):
        def codegen(context, builder, signature, args):
            source = arrayobj.make_array(signature.args[0])(context, builder, args[0])
            view = arrayobj.make_array(signature.return_type)(context, builder)
            size = context.get_constant(types.intp, 8)
            columns = builder.extract_value(source.shape, 1)
            begin = builder.gep(source.data, [builder.mul(args[1], columns)])
            arrayobj.populate_array(view, begin, [args[2]], [size], size, None)
            return view._getvalue()

        return types.Array(types.float64, 1, "C")(matrix, types.intp, types.intp), codegen

    return row_of


row_of = _row_of()


def _block_of() -> Any:
    """Make the compiled function (flat, begin, rows, columns) that returns a part of `flat` as a matrix."""
    if config.DISABLE_JIT:
        return lambda flat, begin, rows, columns: flat[begin : begin + rows * columns].reshape(rows, columns)

    @intrinsic
    def block_of(typingctx, flat, begin, rows, columns):
        def codegen(context, builder, signature, args):
            source = arrayobj.make_array(signature.args[0])(context, builder, args[0])
            view = arrayobj.make_array(MATRIX)(context, builder)
            size = context.get_constant(types.intp, 8)
            strides = (builder.mul(args[3], size), size)
            arrayobj.populate_array(view, builder.gep(source.data, [args[1]]), args[2:], strides, size, None)
            return view._getvalue()

        return MATRIX(flat, types.intp, types.intp, types.intp), codegen

    return block_of


block_of = _block_of()


def _entry_of() -> Any:
    """Make the compiled function (matrix, row, column) that returns an entry without a test for negative indices."""
    if config.DISABLE_JIT:
        return lambda matrix, row, column: matrix[row, column]

    @intrinsic
    def entry_of(typingctx, matrix, row, column):
        def codegen(context, builder, signature, args):
            source = arrayobj.make_array(signature.args[0])(context, builder, args[0])
            place = builder.add(builder.mul(args[1], builder.extract_value(source.shape, 1)), args[2])
            return arrayobj.load_item(context, builder, signature.args[0], builder.gep(source.data, [place]))

        return types.float64(matrix, types.intp, types.intp), codegen

    return entry_of


entry_of = _entry_of()


def _item_of() -> Any:
    """Make the compiled function (vector, index) that returns an entry without a test for negative indices."""
    if config.DISABLE_JIT:
        return lambda vector, index: vector[index]

    @intrinsic
    def item_of(typingctx, vector, index):
        def codegen(context, builder, signature, args):
            source = arrayobj.make_array(signature.args[0])(context, builder, args[0])
            return arrayobj.load_item(context, builder, signature.args[0], builder.gep(source.data, [args[1]]))

        return types.float64(vector, types.intp), codegen

    return item_of


item_of = _item_of()


# Scratch matrices and vectors on the stack of a kernel: kernels allocate nothing on the heap
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
    """A function that returns a vector (size,) of floats, on the stack, for functions that are compiled in any case."""
    # Functions made by `flexmb.kernels.fast` can call it, which are compiled without numba's memory management.
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
