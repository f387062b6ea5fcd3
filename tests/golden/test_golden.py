"""Final states of runs are what they were: to the last bit on the machine that they were kept on.

On another processor sums are rounded otherwise.  Where Newton's method took the same iterations, final states of rigid
bodies agree to 1e-12.  Where it took an iteration more or less, they agree within its tolerance: 1e-9 to 7e-9 was seen
between two processors.  Carried differences have no counters, and beams are stiff: both are held to what was seen.
"""

import json

import golden_runs as runs
import pytest
from cases import slow_where

KEPT = json.loads(runs.TEXTS.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", slow_where(lambda name: name == "staggered", runs.RUNS))
def test_final_state(name):
    found, before = runs.RUNS[name](), KEPT["runs"][name]
    found, apart = runs.compared(found, runs.kept(name))
    same_iterations = found.counters != {} and found.counters == before["counters"]
    assert apart <= (1e-5 if name in runs.STIFF else 1e-12 if same_iterations else 2e-8)
    if runs.machine() == before["machine"]:
        text = (
            "bits have moved: `python tests/golden/golden_runs.py` shows where; a commit that keeps new ones says why"
        )
        assert found.digest == before["digest"], text


def test_all_runs_are_kept():
    assert set(KEPT["runs"]) == set(runs.RUNS)
