"""Arrays of compiled code: scratch on the stack, views of flat arrays.

scratch = stack_matrix(20, 96)     # once, in a module

    @element_kernel
    def kernel(p, ...):
        x = scratch()                  # in the kernel itself; functions that it calls are handed x

The memory is that of the function which calls `scratch`: it must not be returned.  Its values are undefined at first.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils, config
from numba.extending import intrinsic, overload
from numba.np import arrayobj

VECTOR, MATRIX = (types.Array(types.float64, ndim, "C") for ndim in (1, 2))  # types of a vector and of a matrix


PLAIN: dict[Any, Callable[..., Any]] = {}  # what plain Python calls in place of an intrinsic of numba


def compiled_as(plain: Any) -> Callable[..., Any]:
    """Decorator of an intrinsic of numba, in place of which `plain` is called without JIT."""

    def made(function: Any) -> Any:
        found = plain if config.DISABLE_JIT else intrinsic(function)
        PLAIN[found] = plain
        return found

    return made


def _source(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """The array that is the first argument."""
    return arrayobj.make_array(signature.args[0])(context, builder, args[0])


def _view(context: Any, builder: Any, kind: Any, data: Any, shape: Sequence[Any]) -> Any:
    """Array in C order that begins at `data`, without checks of bounds."""
    # A slice tests signs and bounds, and so does every index into it, unless numba knows that indices start at 0.
    size = context.get_constant(types.intp, 8)
    strides = [size] if len(shape) == 1 else [builder.mul(shape[1], size), size]
    view = arrayobj.make_array(kind)(context, builder)
    arrayobj.populate_array(view, data, shape, strides, size, None)
    return view._getvalue()


@compiled_as(lambda flat, rows, columns: flat[: rows * columns].reshape(rows, columns))
def matrix_view(typingctx, flat, rows, columns):
    """The start of `flat` as a matrix."""

    def codegen(context, builder, signature, args):
        return _view(context, builder, MATRIX, _source(context, builder, signature, args).data, args[1:])

    return MATRIX(flat, types.intp, types.intp), codegen


@compiled_as(lambda flat, begin, rows, columns: flat[begin : begin + rows * columns].reshape(rows, columns))
def block_of(typingctx, flat, begin, rows, columns):
    """A part of `flat` as a matrix."""

    def codegen(context, builder, signature, args):
        data = builder.gep(_source(context, builder, signature, args).data, [args[1]])
        return _view(context, builder, MATRIX, data, args[2:])

    return MATRIX(flat, types.intp, types.intp, types.intp), codegen


@compiled_as(lambda flat, begin, end: flat[begin:end])
def part_of(typingctx, flat, begin, end):
    """flat[begin:end]."""

    def codegen(context, builder, signature, args):
        data = builder.gep(_source(context, builder, signature, args).data, [args[1]])
        return _view(context, builder, flat, data, [builder.sub(args[2], args[1])])

    return flat(flat, types.intp, types.intp), codegen


@compiled_as(lambda matrix, row, length: matrix.ravel()[row * matrix.shape[1] :][:length])
def row_of(typingctx, matrix, row, length):
    """The start of a row, which may go on in the next."""

    def codegen(context, builder, signature, args):
        source = _source(context, builder, signature, args)
        data = builder.gep(source.data, [builder.mul(args[1], builder.extract_value(source.shape, 1))])
        return _view(context, builder, VECTOR, data, [args[2]])

    return VECTOR(matrix, types.intp, types.intp), codegen


@compiled_as(lambda matrix, row, column: matrix[row, column])
def entry_of(typingctx, matrix, row, column):
    """An entry of a matrix, without a test for negative indices."""

    def codegen(context, builder, signature, args):
        source = _source(context, builder, signature, args)
        place = builder.add(builder.mul(args[1], builder.extract_value(source.shape, 1)), args[2])
        return arrayobj.load_item(context, builder, signature.args[0], builder.gep(source.data, [place]))

    return types.float64(matrix, types.intp, types.intp), codegen


@compiled_as(lambda vector, index: vector[index])
def item_of(typingctx, vector, index):
    """An entry of a vector, without a test for negative indices."""

    def codegen(context, builder, signature, args):
        data = builder.gep(_source(context, builder, signature, args).data, [args[1]])
        return arrayobj.load_item(context, builder, signature.args[0], data)

    return types.float64(vector, types.intp), codegen


# Scratch matrices and vectors on the stack of a kernel: kernels allocate nothing on the heap
def _on_stack(kind: Any, *shape: int) -> Any:
    """An intrinsic that returns an array of floats on the stack of the function that calls it."""

    @compiled_as(lambda: np.zeros(shape))
    def on_stack(typingctx):
        def codegen(context, builder, signature, args):
            data = cgutils.alloca_once(builder, ir.DoubleType(), size=ir.Constant(ir.IntType(64), int(np.prod(shape))))
            return _view(context, builder, kind, data, [context.get_constant(types.intp, n) for n in shape])

        return kind(), codegen

    return on_stack


def stack_matrix(rows: int, columns: int) -> Callable[[], Any]:
    """A function that returns a matrix (rows, columns) of floats, on the stack in compiled code."""

    def scratch() -> Any:
        return np.zeros((rows, columns))

    on_stack = _on_stack(MATRIX, rows, columns)

    @overload(scratch, inline="always")  # by numba, before LLVM: the memory is that of the caller
    def scratch_compiled() -> Any:
        def implementation() -> Any:
            return on_stack()

        return implementation

    return scratch


def stack_vector(size: int) -> Callable[[], Any]:
    """A function that returns a vector (size,) of floats, on the stack, for functions that are compiled in any case."""
    # Functions made by `flexmb.kernels.fast` can call it, which are compiled without numba's memory management.
    found: Callable[[], Any] = _on_stack(VECTOR, size)
    return found


@compiled_as(np.zeros)
def stack_space(typingctx, size):
    """A vector of `size` floats on the stack, for `fast` functions."""

    def codegen(context, builder, signature, args):
        return _view(context, builder, VECTOR, builder.alloca(ir.DoubleType(), size=args[0]), args)

    return VECTOR(types.intp), codegen
