"""Four numbers at a time, as one value of compiled code: a lane each.

    p, q = parameters(p), coordinates(q)    # tuples of lanes; made by `rows_of` and `lanes_of`
    write_lanes(r, 0, forces(p, q))         # the same function that is called with numbers for one element

Sums, products, quotients, roots, absolute values and comparisons act on each lane by itself; a number beside lanes is
the same in all of them.  Lane k of entry i stands at LANES i + k of a vector.  A function for both kinds chooses by
`choose` in place of a condition, and asks `any_of` before a branch that all lanes may take.
"""

import math
import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils, config
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, lower_cast, models, register_model
from numba.np import arrayobj

from flexmb.engine.compiled.arrays import compiled_as

LANES = 4
NUMBERS, FLAGS = ir.VectorType(ir.DoubleType(), LANES), ir.VectorType(ir.IntType(1), LANES)
FUSED = ("contract", "nsz", "arcp")  # what may be done with products and sums in the formulas of elements


class Lanes(types.Type):
    """numba's type of four numbers."""

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:  # noqa: ARG002 - as numba asks
        """Numbers are lanes that are all the same."""
        return Conversion.safe if isinstance(other, (types.Float, types.Integer)) else None


class Conditions(types.Type):
    """numba's type of four conditions."""


lanes, conditions = Lanes("lanes"), Conditions("conditions")


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, NUMBERS)


@register_model(Conditions)
class _ConditionsModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, FLAGS)


def _shuffled(builder: Any, pair: Any, places: list[int]) -> Any:
    return builder.shuffle_vector(*pair, ir.Constant(ir.VectorType(ir.IntType(32), LANES), places))


@lower_cast(types.Float, Lanes)
@lower_cast(types.Integer, Lanes)
def _same_in_all(context: Any, builder: Any, kind: Any, _: Any, value: Any) -> Any:
    number = context.cast(builder, value, kind, types.float64)
    nothing = ir.Constant(NUMBERS, ir.Undefined)
    first = builder.insert_element(nothing, number, ir.Constant(ir.IntType(32), 0))
    return _shuffled(builder, (first, nothing), [0] * LANES)


def _on_lanes(function: Any, arguments: int, result: Any, lower: Callable[[Any, Any], Any]) -> None:
    """Let compiled code call a function of numbers with lanes."""

    @infer_global(function)
    class OnLanes(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002 - as numba asks
            known = all(x == lanes or lanes.can_convert_from(None, x) for x in args)
            fits = known and len(args) == arguments and lanes in args
            return signature(result, *[lanes] * arguments) if fits else None

    lower_builtin(function, *[Lanes] * arguments)(lambda context, builder, kind, args: lower(builder, args))


def _called(builder: Any, name: str, args: Any) -> Any:
    kind = ir.FunctionType(args[0].type, [args[0].type])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), args)


if not config.DISABLE_JIT:
    _on_lanes(operator.add, 2, lanes, lambda builder, args: builder.fadd(*args, flags=FUSED))
    _on_lanes(operator.sub, 2, lanes, lambda builder, args: builder.fsub(*args, flags=FUSED))
    _on_lanes(operator.mul, 2, lanes, lambda builder, args: builder.fmul(*args, flags=FUSED))
    _on_lanes(operator.truediv, 2, lanes, lambda builder, args: builder.fdiv(*args, flags=FUSED))
    _on_lanes(operator.lt, 2, conditions, lambda builder, args: builder.fcmp_ordered("<", *args))
    _on_lanes(operator.gt, 2, conditions, lambda builder, args: builder.fcmp_ordered(">", *args))
    _on_lanes(operator.neg, 1, lanes, lambda builder, args: builder.fneg(*args))
    _on_lanes(math.sqrt, 1, lanes, lambda builder, args: _called(builder, "llvm.sqrt.v4f64", args))
    _on_lanes(abs, 1, lanes, lambda builder, args: _called(builder, "llvm.fabs.v4f64", args))


@compiled_as(lambda condition, first, second: first if condition else second)
def choose(typingctx, condition, first, second):
    """`first` where the condition holds, else `second`."""
    kind = lanes if condition == conditions else types.float64

    def codegen(context, builder, signature, args):
        return builder.select(*args)

    return kind(condition, kind, kind), codegen


@compiled_as(bool)
def any_of(typingctx, condition):
    """Whether a condition holds, in one lane at least."""

    def codegen(context, builder, signature, args):
        if condition != conditions:
            return args[0]
        bits = builder.bitcast(args[0], ir.IntType(LANES))
        return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(LANES), 0))

    return types.boolean(condition), codegen


@compiled_as(lambda x: float(round(x)))
def nearest(typingctx, x):
    """The nearest whole number."""

    def codegen(context, builder, signature, args):
        return _called(builder, "llvm.rint.v4f64" if x == lanes else "llvm.rint.f64", args)

    return x(x), codegen


def _loaded(context: Any, builder: Any, kind: Any, array: Any, places: list[int]) -> list[Any]:
    """Four numbers that follow each other, from each of these places of a vector on."""
    data = arrayobj.make_array(kind)(context, builder, array).data
    found = [builder.gep(data, [context.get_constant(types.intp, place)]) for place in places]
    return [builder.load(builder.bitcast(one, NUMBERS.as_pointer()), align=8) for one in found]


def lanes_of(count: int) -> Any:
    """A function that returns the first `count` entries of a vector of lanes."""

    @compiled_as(None)
    def entries(typingctx, vector):
        kind = types.UniTuple(lanes, count)

        def codegen(context, builder, signature, args):
            found = _loaded(context, builder, signature.args[0], args[0], [LANES * i for i in range(count)])
            return context.make_tuple(builder, kind, found)

        return kind(vector), codegen

    return entries


def rows_of(count: int) -> Any:
    """A function that returns the `count` entries (LANES or more) of four rows of a vector: a lane for each row."""

    @compiled_as(None)
    def entries(typingctx, vector):
        kind = types.UniTuple(lanes, count)

        def codegen(context, builder, signature, args):
            found: list[Any] = []
            for begin in (*range(0, count - LANES, LANES), count - LANES):  # the last four may repeat some
                places = [row * count + begin for row in range(LANES)]
                a, b, c, d = _loaded(context, builder, signature.args[0], args[0], places)
                even = [_shuffled(builder, pair, [0, 4, 2, 6]) for pair in ((a, b), (c, d))]
                odd = [_shuffled(builder, pair, [1, 5, 3, 7]) for pair in ((a, b), (c, d))]
                ends = [0, 1, 4, 5], [2, 3, 6, 7]
                found[begin:] = [_shuffled(builder, pair, places) for places in ends for pair in (even, odd)]
            return context.make_tuple(builder, kind, found)

        return kind(vector), codegen

    return entries


@compiled_as(None)
def write_lanes(typingctx, vector, begin, values):
    """Write a tuple of lanes into a vector, from entry `begin` on."""

    def codegen(context, builder, signature, args):
        data = arrayobj.make_array(signature.args[0])(context, builder, args[0]).data
        first = builder.mul(args[1], context.get_constant(types.intp, LANES))
        for i, value in enumerate(cgutils.unpack_tuple(builder, args[2], signature.args[2].count)):
            place = builder.gep(data, [builder.add(first, context.get_constant(types.intp, LANES * i))])
            builder.store(value, builder.bitcast(place, NUMBERS.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(vector, types.intp, values), codegen


@compiled_as(None)
def total(typingctx, x):
    """Sum of all lanes."""

    def codegen(context, builder, signature, args):
        found = [builder.extract_element(args[0], ir.Constant(ir.IntType(32), k)) for k in range(LANES)]
        return builder.fadd(builder.fadd(found[0], found[1]), builder.fadd(found[2], found[3]))

    return types.float64(lanes), codegen
