"""Cases of a test of which some are slow: `make test` takes the others, `make test-all` all."""

from collections.abc import Callable, Iterable
from typing import Any

import pytest


def slow_where(is_slow: Callable[[Any], Any], cases: Iterable[Any]) -> list[Any]:
    """The cases in their order; those for which `is_slow(case)` holds are marked slow."""
    return [pytest.param(case, marks=pytest.mark.slow) if is_slow(case) else case for case in cases]
