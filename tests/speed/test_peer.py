"""Beside the peer: every row of docs/performance.md is at least so many times faster, at no less accuracy."""

import sys

import pytest

pytest.importorskip("exudyn", reason="the peer is not installed: pip install --group bench")

from duel import Verdict, lines, measured
from rows import ROWS


@pytest.mark.parametrize("name", ROWS)
def test_row(name, capsys):
    record = measured(ROWS[name])
    with capsys.disabled():
        sys.stdout.write("\n" + "\n".join(lines(record)) + "\n")
    missed = [str(v) for v in (Verdict(**one) for one in record["verdicts"]) if not v.holds]
    assert not missed, f"{record['title']}:\n" + "\n".join(missed)


@pytest.mark.slow
@pytest.mark.parametrize("flexible", [False, True], ids=["rigid", "flexible"])
def test_the_nine_bar_is_the_same_motion_in_both_codes(flexible):
    """Means over ten turns after the first agree within four standard errors of their difference."""
    from nine_bar_statistics import TURNS, measured

    own, *others = measured(flexible=flexible)["rows"]
    finest = next(o for o in others if o["label"] == "h = 1e-5")
    far = {
        name: (value, finest["values"][name])
        for name, value in own["values"].items()
        if name != "peak force [N]"  # of single impacts: the peer's fixed steps miss part of them
        and abs(value[0] - finest["values"][name][0])
        > 4.0 * ((value[1] ** 2 + finest["values"][name][1] ** 2) / TURNS) ** 0.5 + 1e-3 * abs(value[0])
    }
    assert not far, f"flexmb and the peer with {finest['label']} (mean, standard deviation of turns): {far}"
