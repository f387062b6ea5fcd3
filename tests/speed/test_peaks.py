"""A peak force over rtol: the error at the crest falls; that of the largest step has the distance to the crest, too."""

import numpy as np
import peak_errors
import pytest

import flexmb as fm

RTOL = (4e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5)


@pytest.fixture(scope="module")
def found():
    """Rows of `peak_errors.errors`."""
    return [peak_errors.errors(rtol) for rtol in RTOL]


def test_the_error_at_the_crest_falls_with_rtol(found):
    of_crest = np.abs([row[2] for row in found])
    assert (np.diff(of_crest) < 0.0).all()
    assert of_crest[0] / of_crest[-1] > 8.0  # a fortieth of rtol


def test_what_the_largest_step_misses_beyond_that_is_its_distance_from_the_crest(found):
    """Of a half sine sin(pi s) with n steps, d steps away from the crest: (pi d/n)^2/2."""
    for rtol, (_, of_steps, of_crest, away) in zip(RTOL, found, strict=True):
        n = fm.Adaptive(rtol=rtol).steps_of_an_impact
        assert abs(away) <= 0.55
        assert of_crest - of_steps <= 1.5 * (np.pi * away / n) ** 2 / 2.0 + 1e-5
