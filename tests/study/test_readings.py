"""Units in which printed exponents may be meant."""

import numpy as np
import pytest
from nine_bar_study.nine_bar.readings import READINGS, comparable, ratios

UNITS = {
    "1/s": 1.0,
    "bit/s (base 2)": 1.0 / np.log(2.0),
    "a period": 2.0,
    "a sample of 100 a period": 0.02,
}
"""What 1 1/s is in each, at a period of 2 s."""


@pytest.mark.parametrize("reading", UNITS)
def test_a_value_in_its_own_unit_is_ours(reading):
    found = ratios([[(3.0 * UNITS[reading], 2.0, 3.0, np.nan), (4.0 * UNITS[reading], 2.0, 4.0, 7.0)]])
    np.testing.assert_allclose(found[reading][0], 1.0)
    assert reading in comparable(found)
    assert len(found[reading][1]) == 1  # no estimate, no ratio


def test_values_that_differ_by_more_than_a_unit_fit_none():
    rows = [(0.4, 1.0, 30.0, 2.0), (0.1, 1.0, 30.0, 20.0)]
    assert comparable(ratios([rows])) == []
    assert comparable(dict.fromkeys(READINGS, ([], []))) == []
