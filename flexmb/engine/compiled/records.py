"""Records: named numbers and arrays that are passed to compiled code as one pointer.

numba hands a tuple of arrays on field by field, in every call of every compiled function.  A record keeps what compiled
code needs to know of its fields in one buffer of 64-bit words: of a number its value, of an array where its data are
and its shape, of a record within it where that one is.  Compiled code gets the address of the buffer and loads what it
reads.  A field is read and written by its name on both sides:

    class Clock(Record):
        t: float
        steps: int

    class State(Record):
        clock: Clock
        q: Vector

    state = State(Clock(0.0, 0), np.zeros(3))
    state.clock.t += h          # in compiled functions and in Python alike

Arrays are filled in place and never exchanged, so compiled code may take where they are for constant.  The numbers of
a record that is declared with `frozen=True` never change either.
"""

from __future__ import annotations

import hashlib
import math
import sys
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self, get_args, get_origin, get_type_hints

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import config
from numba.core.datamodel import models
from numba.core.imputils import lower_getattr_generic, lower_setattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import NativeValue, register_model, typeof_impl, unbox
from numba.np import arrayobj, numpy_support

from flexmb.engine.compiled.arrays import compiled_as

WORD = ir.IntType(64)


class RecordType(types.Type):
    """numba's type of a record: name, type and place of the first word of each field; `frozen`: nothing changes."""

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
    return builder.gep(builder.bitcast(record, kind.as_pointer()), [WORD(place)], inbounds=True)


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


@compiled_as(lambda source, target: target.set_numbers(source.numbers()))
def copy_numbers(typingctx, source, target):
    """Copy all words of a record of numbers."""
    if not isinstance(source, RecordType) or source != target:
        return None
    if any(isinstance(field, (types.Array, RecordType)) for field, _ in source.fields.values()):
        raise TypeError(f"{source} holds more than numbers")

    def codegen(context, builder, signature, args):
        for _, place in source.fields.values():
            builder.store(_loaded(builder, args[0], place, WORD, False), _pointer(builder, args[1], place, WORD))
        return context.get_dummy_value()

    return types.void(source, target), codegen


def _array(dtype: Any, ndim: int) -> Any:
    return types.Array(numpy_support.from_dtype(np.dtype(dtype)), ndim, "C")


Vector = Annotated[np.ndarray, _array(np.float64, 1)]
Matrix = Annotated[np.ndarray, _array(np.float64, 2)]
Integers = Annotated[np.ndarray, _array(np.int64, 1)]
IntegerTable = Annotated[np.ndarray, _array(np.int64, 2)]
# Indices: compiled code need not ask whether they count from the end.
Places = Annotated[np.ndarray, _array(np.uint64, 1)]
Flags = Annotated[np.ndarray, _array(np.bool_, 1)]
SmallPlaces = Annotated[np.ndarray, _array(np.uint32, 1)]
CACHE_LINE = 64  # bytes of a cache line, at which the arrays of a record begin
PLAIN_FLAGS = 0x0001 | 0x0100  # numpy's flags of arrays in C order and of aligned ones
LARGEST = 2.0**53  # largest whole number that a file may hold: beyond it floats leave some out
NUMBERS = {float: types.float64, int: types.int64, bool: types.boolean}


class Record:
    """Base of the records; a subclass declares its fields as annotations, in order."""

    # Fields are float, int, bool, another record, or one of the array types of this module. `limits` of a class are the
    # least and the largest value of some numbers, which hold for values from files. Values are given in order or by
    # name; a length stands for a vector of zeros, a shape for such a matrix. Fields that are missing or unknown, and
    # arrays of another type or not in C order, are TypeErrors.

    _fields: ClassVar[tuple[str, ...]] = ()
    _numba_type_: ClassVar[Any] = None
    _places: ClassVar[dict[str, tuple[Any, int]]] = {}
    _layout: ClassVar[tuple[tuple[str, Any, int, Any, int], ...]] = ()
    _plans: ClassVar[dict[Any, Any]] = {}
    _groups: ClassVar[dict[Any, Any]] = {}
    _inner: ClassVar[tuple[tuple[str, int], ...]] = ()
    _size: ClassVar[int] = 0
    _arrays: ClassVar[dict[str, tuple[int, Any, int]]] = {}
    _all_floats: ClassVar[bool] = False
    _limits: ClassVar[Mapping[str, tuple[float, float]]] = {}

    def __init_subclass__(
        cls, *, frozen: bool = False, limits: Mapping[str, tuple[float, float]] | None = None, **options: Any
    ) -> None:
        super().__init_subclass__(**options)
        own = cls.__annotations__
        bare = type(cls.__name__, (), {"__annotations__": own})  # hints of the base are not asked for
        hints = get_type_hints(bare, vars(sys.modules[cls.__module__]), include_extras=True)
        fields, place = [], 0
        for name in own:
            kind = type_of_hint(hints[name])
            fields.append((name, kind, place))
            place += 1 + (kind.ndim if isinstance(kind, types.Array) else 0)
        cls._fields, cls._size = tuple(own), place
        cls._numba_type_ = RecordType(cls.__name__, tuple(fields), frozen)
        cls._places = cls._numba_type_.fields
        cls._plans, cls._groups, cls._limits = {}, {}, limits or {}
        cls._inner = tuple((name, at) for name, kind, at in fields if kind not in NUMBERS.values())
        cls._all_floats = bool(fields) and all(kind is types.float64 for _, kind, _ in fields)
        cls._layout = tuple((name, kind, at, *_stored(kind)) for name, kind, at in fields)
        cls._arrays = {name: (at, dtype, ndim) for name, _, at, dtype, ndim in cls._layout if ndim}
        for name, kind, at in fields:
            if kind in NUMBERS.values():
                setattr(cls, name, _number(name, kind, at))

    def __init__(self, *values: Any, **named: Any) -> None:
        given: Any = values
        if named or len(values) != len(self._fields):
            pairs = dict(zip(self._fields, values, strict=False), **named)
            if len(values) + len(named) != len(self._fields) or set(pairs) != set(self._fields):
                raise TypeError(f"{type(self).__name__} has the fields {self._fields}; given were {tuple(pairs)}")
            given = [pairs[name] for name in self._fields]
        if self._all_floats:
            self._adopt(np.array(given, dtype=np.float64).view(np.uint64))
            return
        kinds = tuple(map(type, given))
        groups = self._groups.get(kinds)
        if groups is None:
            groups = self._groups[kinds] = _grouped(type(self), given)
        shaped, arrays, records, floats, integers = groups
        store, others = self.__dict__, []
        for k, name, place, dtype, ndim in arrays:
            value = store[name] = given[k]
            if not _fits(value, dtype, ndim):
                self._refuse(name, value, dtype, ndim)
                continue
            interface = value.__array_interface__
            others.append((place, interface["data"][0]))
            others += [(place + 1 + k, length) for k, length in enumerate(interface["shape"])]
        for k, name, place, kind in records:
            value = store[name] = given[k]
            if getattr(value, "_numba_type_", None) is not kind:
                text = f"{type(self).__name__}: {name} is a {type(value).__name__}"
                raise TypeError(f"{text}, not a record of the declared kind")
            others.append((place, value._address))
        words = self._adopt(self._begun(tuple([(name, given[k]) for k, name in shaped])))
        for place, word in others:
            words[place] = word
        for k, place in floats:
            store["_floats"][place] = given[k]
        for k, place in integers:
            store["_integers"][place] = given[k]

    def _adopt(self, words: np.ndarray) -> np.ndarray:
        """Take these words for the record's own."""
        store = self.__dict__
        store["_words"], store["_address"] = words, words.__array_interface__["data"][0]
        if len(self._inner) < len(self._fields):  # there are numbers
            store["_floats"], store["_integers"] = words.view(np.float64), words.view(np.int64)
        return words

    def _begun(self, shapes: tuple[tuple[str, Any], ...]) -> np.ndarray:
        """The words of a record whose arrays of zeros lie one after the other in one block of memory."""
        # Python's view of such an array is made when it is asked for.
        if not shapes:
            return np.zeros(max(self._size, 1), dtype=np.uint64)
        plan = self._plans.get(shapes)
        if plan is None:
            plan = self._plans[shapes] = _Plan(type(self), shapes)
        arena, first, address = plan.arena()
        self.__dict__["_arena"] = arena, first, plan
        return plan.words + plan.moved * np.uint64(address + first)

    def __getattr__(self, name: str) -> Any:
        arena, first, plan = self.__dict__.get("_arena", (None, 0, None))
        if plan is None or name not in plan.views:
            raise AttributeError(f"{type(self).__name__} has no field {name!r}")
        shape, dtype, begin = plan.views[name]
        array = self.__dict__[name] = np.ndarray(shape, dtype, arena, first + begin)
        return array

    def _refuse(self, name: str, value: Any, dtype: Any, ndim: int) -> None:
        """Refuse an array of another type; without JIT a table of kernels holds functions, which pass."""
        if config.DISABLE_JIT and not isinstance(value, np.ndarray):
            return
        text = f"{type(self).__name__}: {name} is {type(value).__name__} {getattr(value, 'dtype', '')}"
        raise TypeError(f"{text}; it must be an array of {dtype} with {ndim} dimension(s) in C order")

    def __setattr__(self, name: str, value: Any) -> None:
        kind, place = self._places.get(name, (None, 0))
        if kind is None or isinstance(kind, (types.Array, RecordType)) or self._numba_type_.frozen:
            raise AttributeError(f"{type(self).__name__}.{name} cannot be exchanged; change it in place")
        (self._floats if kind is types.float64 else self._integers)[place] = value

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={getattr(self, name)!r}' for name in self._fields)})"

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), tuple(getattr(self, name) for name in self._fields)

    @classmethod
    def zeros(cls) -> Self:
        """A record of numbers alone, all 0."""
        return cls(*(0,) * len(cls._fields))

    def as_dict(self) -> dict[str, Any]:
        """Values of the fields by name."""
        return {name: getattr(self, name) for name in self._fields}

    def replaced(self, **changes: Any) -> Self:
        """A record with other values of some fields; arrays that are not named are shared."""
        if not changes.keys() <= self._arrays.keys():
            return type(self)(**{**self.as_dict(), **changes})
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__)
        words = other._adopt(self._words.copy())
        for name, value in changes.items():
            place, dtype, ndim = self._arrays[name]
            if not _fits(value, dtype, ndim):
                return type(self)(**{**self.as_dict(), **changes})
            other.__dict__[name] = value
            words[place : place + 1 + ndim] = value.__array_interface__["data"][0], *value.shape
        return other

    def twin(self, **records: Record) -> Self:
        """A new record with the same shapes and numbers, arrays of zeros included, in a fifth of the time."""
        # Arrays that were given are shared; records within have twins of their own, or are exchanged for `records`.
        mine, words, other = self.__dict__, self._words.copy(), type(self).__new__(type(self))
        if "_arena" in mine:
            _, first, plan = mine["_arena"]
            base = mine["_arena"][0].__array_interface__["data"][0] + first
            arena, first, address = plan.arena()
            other.__dict__["_arena"] = arena, first, plan
            words += plan.moved * np.uint64((address + first - base) % (1 << 64))
        views = mine["_arena"][2].views if "_arena" in mine else {}
        for name, place in self._inner:
            if name in views:
                continue
            value = mine[name]
            if isinstance(value, Record):
                value = records[name] if name in records else value.twin()
                words[place] = value._address
            other.__dict__[name] = value
        other._adopt(words)
        return other

    def saved(self) -> dict[str, np.ndarray]:
        """Copies of the arrays by name, and of the numbers of each record in it by its name."""
        found = {name: getattr(self, name) for name in self._fields}
        return {name: x.numbers() if isinstance(x, Record) else x.copy() for name, x in found.items()}

    def restore(self, saved: Mapping[str, np.ndarray]) -> None:
        """Restore the arrays and numbers of `saved`; a `ValueError` has the name of a missing or misfit one."""
        for name in self._fields:
            target = getattr(self, name)
            given = fitting(saved, name, target.numbers() if isinstance(target, Record) else target)
            if not isinstance(target, Record):
                target[...] = given
            elif not target._numba_type_.frozen:
                target.set_numbers(given)

    def numbers(self) -> np.ndarray:
        """The values of the fields that are numbers, in order, as floats."""
        found = [getattr(self, name) for name, (kind, _) in self._places.items() if kind in NUMBERS.values()]
        return np.array(found, dtype=np.float64)

    def set_numbers(self, values: np.ndarray) -> None:
        """Give the fields that are numbers the `values` that `numbers` returned."""
        # A `ValueError` has the name of a number beyond its limits or no whole one: compiled code, which takes such
        # numbers for indices, is not asked whether they fit.
        names = [name for name, (kind, _) in self._places.items() if kind in NUMBERS.values()]
        for name, value in zip(names, values.tolist(), strict=True):
            least, most = self._limits.get(name, (-LARGEST, LARGEST))
            whole = self._places[name][0] is not types.float64
            if (whole or name in self._limits) and not (least <= value <= most and (not whole or value == int(value))):
                raise ValueError(f"{type(self).__name__}.{name}")
            setattr(self, name, int(value) if whole else value)


def fitting(saved: Mapping[str, Any], name: str, like: np.ndarray) -> np.ndarray:
    """Numbers of a restart by their name, in the shape of an array; ValueError with the name if they are not that."""
    given = np.asarray(saved.get(name, ()))
    if given.shape != like.shape or given.dtype.kind not in "fiub":
        raise ValueError(name)
    return given


class _Plan:
    """Layout of arrays of zeros in one block of memory, by the name and shape, or length, of each array of a record."""

    def __init__(self, kind: type[Record], shapes: tuple[tuple[str, Any], ...]) -> None:
        self.words = np.zeros(max(kind._size, 1), dtype=np.uint64)
        self.moved = np.zeros_like(self.words)
        self.views: dict[str, tuple[tuple[int, ...], Any, int]] = {}
        end = 0
        for name, given in shapes:
            place = kind._places[name][1]
            dtype, ndim = _stored(kind._places[name][0])
            shape = tuple(int(n) for n in given) if ndim > 1 else (int(given),)
            if len(shape) != ndim:
                raise TypeError(f"{kind.__name__}: {name} has {ndim} dimension(s), not the shape {shape}")
            self.views[name] = shape, dtype, end
            self.words[place], self.moved[place] = end, 1
            self.words[place + 1 : place + 1 + ndim] = shape
            end += (math.prod(shape) * dtype.itemsize + CACHE_LINE - 1) // CACHE_LINE * CACHE_LINE
        self.size = end + CACHE_LINE

    def arena(self) -> tuple[np.ndarray, int, int]:
        """New memory, where in it the first array begins, and its address."""
        arena = np.zeros(self.size, dtype=np.uint8)
        address = arena.__array_interface__["data"][0]
        return arena, -address % CACHE_LINE, address


def _grouped(kind: type[Record], given: Any) -> tuple[list[tuple[Any, ...]], ...]:
    """The fields as they are filled from values of these types: zeros, arrays, records, floats, whole numbers."""
    groups: tuple[list[tuple[Any, ...]], ...] = tuple([] for _ in range(5))
    shaped, arrays, records, floats, integers = groups
    for k, ((name, declared, place, dtype, ndim), value) in enumerate(zip(kind._layout, given, strict=True)):
        if ndim and (isinstance(value, (int, np.integer)) or (ndim > 1 and isinstance(value, tuple))):
            shaped.append((k, name))
        elif ndim:
            arrays.append((k, name, place, dtype, ndim))
        elif dtype is None:
            records.append((k, name, place, declared))
        else:
            (floats if dtype is float else integers).append((k, place))
    return groups


def type_of_hint(hint: Any) -> Any:
    """numba's type of an annotation: a number, a record or an array."""
    if hint in NUMBERS:
        return NUMBERS[hint]
    if get_origin(hint) is Annotated:
        return get_args(hint)[1]
    if isinstance(hint, type) and issubclass(hint, Record):
        return hint._numba_type_
    raise TypeError(f"a record holds numbers, records and arrays, not {hint!r}")


def _stored(kind: Any) -> tuple[Any, int]:
    """Type and dimensions of an array; float or int and 0 of a number; None and 0 of a record."""
    if isinstance(kind, types.Array):
        return numpy_support.as_dtype(kind.dtype), kind.ndim
    return (None if isinstance(kind, RecordType) else float if kind is types.float64 else int), 0


def _fits(value: Any, dtype: Any, ndim: int) -> bool:
    """Whether a value is an array of this type in C order."""
    if not isinstance(value, np.ndarray) or value.ndim != ndim or value.flags.num & PLAIN_FLAGS != PLAIN_FLAGS:
        return False
    return value.dtype is dtype or bool(value.dtype == dtype)


def _number(name: str, kind: Any, place: int) -> property:
    """A number that stands in the words."""
    store = "_floats" if kind is types.float64 else "_integers"
    python = {types.float64: float, types.int64: int, types.boolean: bool}[kind]

    def read(record: Any) -> Any:
        return python(record.__dict__[store][place])

    return property(read, doc=name)


@typeof_impl.register(Record)
def _typeof(value: Record, _: Any) -> Any:
    return value._numba_type_
