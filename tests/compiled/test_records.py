"""Records: named numbers and arrays that compiled code is handed as one pointer."""

import pickle

import numba
import numpy as np
import pytest
from numba.core.errors import NumbaError

from flexmb.engine.compiled.records import Flags, Integers, Matrix, Record, Vector, copy_numbers
from flexmb.kernels import compiled


class Clock(Record):
    """Numbers of all kinds."""

    t: float
    steps: int
    on: bool


class Fixed(Record, frozen=True):
    """Numbers that never change."""

    length: float


class State(Record):
    """Arrays, and records within."""

    clock: Clock
    fixed: Fixed
    q: Vector
    table: Matrix
    count: Integers
    flags: Flags


@compiled
def advance(state, h):
    """One of each kind is read and written."""
    state.clock.t += h
    state.clock.steps += 2
    state.clock.on = state.clock.t > 1.0
    for i in range(state.q.shape[0]):
        state.q[i] += h * state.fixed.length * state.table[i, 1]
    state.count[0] += state.table.shape[0] * 10 + state.table.shape[1]
    state.flags[1] = True
    return state.clock.steps


@compiled
def copied(source, target):
    """Numbers of one record into another."""
    copy_numbers(source.clock, target.clock)


def state(**changes):
    given = {"q": 3, "table": np.arange(6.0).reshape(3, 2), "count": 1, "flags": 2}
    return State(clock=Clock(0.5, 3, False), fixed=Fixed(2.0), **{**given, **changes})


def test_compiled_code_and_python_see_the_same():
    s = state()
    assert advance(s, 0.25) == 5
    assert (s.clock.t, s.clock.steps, s.clock.on) == (0.75, 5, False)
    s.clock.t = 10.0
    assert advance(s, 0.0) == 7
    assert s.clock.on is True
    assert s.q.tolist() == [0.5, 1.5, 2.5]
    assert s.count.tolist() == [64]
    assert s.flags.tolist() == [False, True]


def test_it_is_the_same_function_without_compilation():
    compiled_state, plain_state = state(), state()
    advance(compiled_state, 0.7)
    advance.py_func(plain_state, 0.7)
    for name, array in compiled_state.saved().items():
        assert array.tobytes() == plain_state.saved()[name].tobytes()


def test_a_shape_means_zeros_of_their_own():
    one, other = state(), state()
    assert one.q.tolist() == [0.0, 0.0, 0.0]
    one.q[:] = 1.0
    assert other.q.tolist() == [0.0, 0.0, 0.0]
    assert one.q.ctypes.data % 64 == 0
    assert state(q=0).q.shape == (0,)


def test_what_compiled_code_takes_for_constant_cannot_be_exchanged():
    s = state()
    for name in ("q", "clock", "unknown"):
        with pytest.raises(AttributeError, match=f"State.{name} cannot be exchanged"):
            setattr(s, name, np.zeros(3))

    with pytest.raises(AttributeError, match=r"Fixed\.length cannot be exchanged"):
        s.fixed.length = 1.0
    with pytest.raises(TypeError, match="given were"):
        s.replaced(unknown=1)

    @numba.njit
    def exchange(state):
        state.fixed.length = 1.0

    with pytest.raises((NumbaError, TypeError), match="cannot be exchanged"):
        exchange(s)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("q", np.zeros(3, dtype=np.float32)),
        ("q", np.zeros((3, 1))),
        ("q", np.zeros(6)[::2]),
        ("q", [0.0, 1.0]),
        ("table", np.zeros((2, 3)).T),
        ("count", np.zeros(1)),
    ],
)
def test_arrays_of_another_kind_are_refused(name, value):
    with pytest.raises(TypeError, match=f"State: {name} is .* it must be an array of"):
        state(**{name: value})


def test_fields_that_are_missing_or_unknown_are_refused():
    with pytest.raises(TypeError, match=r"Clock has the fields \('t', 'steps', 'on'\)"):
        Clock(1.0, 2)
    with pytest.raises(TypeError, match="given were"):
        Clock(1.0, 2, now=True)
    with pytest.raises(TypeError, match="State: clock is a Fixed, not a record of the declared kind"):
        State(Fixed(1.0), Fixed(1.0), 3, (3, 2), 1, 2)
    with pytest.raises(TypeError, match="table has 2 dimension"):
        state(table=(3, 2, 1))


def test_a_record_holds_nothing_else():
    with pytest.raises(TypeError, match="a record holds numbers, records and arrays"):

        class Wrong(Record):
            name: str


def test_pickled_and_read_back():
    s = state()
    advance(s, 0.25)
    copy = pickle.loads(pickle.dumps(s))  # noqa: S301 (its own)
    advance(copy, 0.25)
    advance(s, 0.25)
    assert all(array.tobytes() == copy.saved()[name].tobytes() for name, array in s.saved().items())


def test_saved_and_restored():
    s = state()
    kept = s.saved()
    advance(s, 0.25)
    s.restore(kept)
    assert s.clock.steps == 3
    assert s.clock.on is False
    assert s.q.tolist() == [0.0, 0.0, 0.0]
    with pytest.raises(ValueError, match="table"):
        s.restore({**kept, "table": np.zeros((2, 2))})


def test_replaced_shares_the_rest():
    s = state()
    other = s.replaced(q=np.ones(3))
    assert other.table is s.table
    assert other.clock is s.clock
    advance(other, 0.25)
    assert s.clock.steps == 5
    assert s.q.tolist() == [0.0, 0.0, 0.0]


def test_numbers_are_copied_by_compiled_code():
    one, other = state(), state()
    advance(one, 1.5)
    copied(one, other)
    assert (other.clock.t, other.clock.steps, other.clock.on) == (2.0, 5, True)
    assert other.q.tolist() == [0.0, 0.0, 0.0]
