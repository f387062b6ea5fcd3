"""Envelopes of dense signals: extremes, columns, when they are drawn."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexmb.show.pictures.signals import COLUMNS, draw_signal, envelope, is_dense

TIME = np.linspace(0.0, 1.0, 20001)


def axes():
    from matplotlib.figure import Figure

    return Figure().subplots()


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.integers(2, 3000))
def test_every_value_lies_in_the_band_and_the_extremes_are_kept(seed, n):
    rng = np.random.default_rng(seed)
    time, values = np.sort(rng.uniform(0.0, 1.0, n)), rng.standard_normal(n)
    middle, low, high = envelope(time, values, 50)
    assert low.min() == values.min()
    assert high.max() == values.max()
    width = (time[-1] - time[0]) / 50
    for k in range(n):
        column = int(np.abs(middle - time[k]).argmin())
        near = slice(max(column - 1, 0), column + 2)  # a value on the seam of two columns
        assert low[near].min() <= values[k] <= high[near].max()
    assert np.all(np.diff(middle) > 0.99 * width)


def test_a_peak_of_one_row_is_seen():
    values = 0.1 * np.sin(2.0 * np.pi * 3000.0 * TIME)
    values[12345] = 7.0
    ax = axes()
    draw_signal(ax, TIME, values, 0, "force")
    (band,) = ax.collections
    assert band.get_paths()[0].vertices[:, 1].max() == 7.0
    assert not ax.lines


@pytest.mark.parametrize(
    ("values", "dense"),
    [
        (np.sin(2.0 * np.pi * 3000.0 * TIME), True),
        (np.sin(2.0 * np.pi * 10.0 * TIME), False),
        (np.sin(2.0 * np.pi * 10.0 * TIME) + 1e-4 * np.sin(2.0 * np.pi * 3000.0 * TIME), False),  # noise, not a block
        (np.zeros(len(TIME)), False),
        (np.where(TIME < 0.5, 0.0, np.sin(2.0 * np.pi * 3000.0 * TIME)), True),
    ],
)
def test_what_is_drawn_as_a_band(values, dense):
    assert is_dense(TIME, values) is dense
    ax = axes()
    draw_signal(ax, TIME, values, 0, "signal")
    assert bool(ax.collections) is dense
    if not dense:
        np.testing.assert_array_equal(ax.lines[0].get_ydata(), values)


def test_few_rows_are_lines():
    time = np.linspace(0.0, 1.0, COLUMNS - 1)
    assert not is_dense(time, np.random.default_rng(0).standard_normal(len(time)))
