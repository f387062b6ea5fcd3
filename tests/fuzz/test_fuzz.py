"""A share of the fuzzing (`make fuzz`): random linkages, sound and damaged, have no silent wrong answers."""

import sys
import warnings
from functools import cache
from pathlib import Path

import pytest
from cases import slow_where

sys.path.insert(0, str(Path(__file__).resolve().parent))

import fuzz

SEEDS = range(0, 40)

tried, tried_damaged = cache(fuzz.tried), cache(fuzz.tried_damaged)


@pytest.mark.quick(2)
@pytest.mark.parametrize("seed", slow_where(lambda n: n % 3, SEEDS))
def test_a_random_linkage(seed):
    """It runs and agrees with itself in other views, or says why not."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        assert tried(seed)


@pytest.mark.quick(11)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_damaged_linkage(seed):
    """It is refused or stopped with a named cause, or the damage does no harm."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        assert tried_damaged(seed)


@pytest.mark.slow
def test_the_share_has_all_kinds_of_ends():
    ends = {tried(seed) for seed in SEEDS} | {tried_damaged(seed) for seed in SEEDS}
    assert {"ok", "damage refused as declared", "damage refused at the start"} <= ends
