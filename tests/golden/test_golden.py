"""Final states of runs are what they were: to the last bit on the machine that they were kept on.

Elsewhere those of rigid bodies to 1e-12.  Beams are stiff: another order of a sum changes their forces within what
Newton's method is asked for, and sometimes an iteration.
"""

import json

import golden_runs as runs
import pytest

KEPT = json.loads(runs.TEXTS.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", runs.RUNS)
def test_final_state(name):
    found, before = runs.RUNS[name](), KEPT["runs"][name]
    found, apart = runs.compared(found, runs.kept(name))
    assert apart <= (1e-5 if name in runs.STIFF else 1e-12)
    if runs.machine() == KEPT["machine"]:
        text = (
            "bits have moved: `python tests/golden/golden_runs.py` shows where; a commit that keeps new ones says why"
        )
        assert found.digest == before["digest"], text


def test_all_runs_are_kept():
    assert set(KEPT["runs"]) == set(runs.RUNS)
