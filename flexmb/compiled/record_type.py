"""numba's type of a record, and how compiled code reads and writes its fields."""

from __future__ import annotations

import hashlib
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import config
from numba.core.datamodel import models
from numba.core.imputils import lower_getattr_generic, lower_setattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import NativeValue, intrinsic, register_model, unbox
from numba.np import arrayobj

WORD = ir.IntType(64)


class RecordType(types.Type):
    """numba's type of a record: the type of every field and the place of its first word.

    Parameters
    ----------
    kind : name of the class.
    fields : name, type and place of each field.
    frozen : whether its numbers never change.
    """

    def __init__(self, kind: str, fields: tuple[tuple[str, Any, int], ...], frozen: bool) -> None:
        self.fields, self.frozen = {name: (field, place) for name, field, place in fields}, frozen
        layout = repr([(name, str(field), place) for name, field, place in fields])
        digest = hashlib.sha256(layout.encode()).hexdigest()[:8]
        super().__init__(name=f"{kind}_{digest}")  # short, since every symbol has it in its name


register_model(RecordType)(models.OpaqueModel)


@unbox(RecordType)
def _unbox(_: Any, value: Any, c: Any) -> Any:
    number = c.pyapi.object_getattr_string(value, "_address")
    address = c.pyapi.long_as_longlong(number)
    c.pyapi.decref(number)
    return NativeValue(c.builder.inttoptr(address, c.context.get_value_type(types.voidptr)))


@infer_getattr
class _Fields(AttributeTemplate):
    key = RecordType

    def generic_resolve(self, kind: Any, name: str) -> Any:
        found = kind.fields.get(name)
        return found and found[0]


def _pointer(builder: Any, record: Any, place: int, kind: Any) -> Any:
    """Pointer to the word `place` of a record."""
    base = builder.bitcast(record, kind.as_pointer())
    return builder.gep(base, [WORD(place)], inbounds=True)


def _loaded(builder: Any, record: Any, place: int, kind: Any, constant: bool) -> Any:
    value = builder.load(_pointer(builder, record, place, kind), align=8)
    if constant:
        value.set_metadata("invariant.load", builder.module.add_metadata([]))
    return value


@lower_getattr_generic(RecordType)
def _get(context: Any, builder: Any, kind: Any, record: Any, name: str) -> Any:
    field, place = kind.fields[name]
    if isinstance(field, RecordType):
        return builder.inttoptr(_loaded(builder, record, place, WORD, True), record.type)
    if isinstance(field, types.Array):
        array = arrayobj.make_array(field)(context, builder)
        item = context.get_data_type(field.dtype)
        data = _loaded(builder, record, place, item.as_pointer(), True)
        shape = [_loaded(builder, record, place + 1 + k, WORD, True) for k in range(field.ndim)]
        size = context.get_abi_sizeof(item)
        strides = [WORD(size)]
        for length in shape[:0:-1]:
            strides.insert(0, builder.mul(strides[0], length))
        arrayobj.populate_array(array, data, shape, strides, size, None)
        return array._getvalue()
    if field is types.float64:
        return _loaded(builder, record, place, ir.DoubleType(), kind.frozen)
    value = _loaded(builder, record, place, WORD, kind.frozen)
    return builder.trunc(value, ir.IntType(1)) if field is types.boolean else value


@lower_setattr_generic(RecordType)
def _set(context: Any, builder: Any, signature: Any, arguments: Any, name: str) -> None:
    kind, given = signature.args
    record, value = arguments
    field, place = kind.fields[name]
    if kind.frozen or isinstance(field, (types.Array, RecordType)):
        raise TypeError(f"{kind}.{name} cannot be exchanged by compiled code")
    value = context.cast(builder, value, given, field)
    if field is types.boolean:
        value = builder.zext(value, WORD)
    builder.store(value, _pointer(builder, record, place, value.type), align=8)


def _copy_numbers() -> Any:
    """A compiled function (source, target) that copies all words of a record of numbers."""
    if config.DISABLE_JIT:
        return lambda source, target: target.set_numbers(source.numbers())

    @intrinsic
    def copy_numbers(typingctx, source, target):
        if not isinstance(source, RecordType) or source != target:
            return None
        if any(isinstance(field, (types.Array, RecordType)) for field, _ in source.fields.values()):
            raise TypeError(f"{source} holds more than numbers")

        def codegen(context, builder, signature, args):
            for _, place in source.fields.values():
                builder.store(_loaded(builder, args[0], place, WORD, False), _pointer(builder, args[1], place, WORD))
            return context.get_dummy_value()

        return types.void(source, target), codegen

    return copy_numbers


copy_numbers = _copy_numbers()
