"""Every fault of the corpus is told with its code and its parts; nothing else than a finding reaches the user."""

import json
import warnings

import pytest
from broken import CASES

import flexmb as fm
from flexmb.doctor import CODES


def test_the_corpus_is_large_and_knows_every_kind():
    told = {code for _, wanted in CASES.values() for code in wanted}
    assert len(CASES) >= 60
    assert set(CODES) - told <= {"not-solvable", "no-inertia", "no-frequencies", "no-statics", "coarse-step"}


@pytest.mark.parametrize("case", CASES)
def test_culprits_are_named(case):
    build, wanted = CASES[case]
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        report = fm.check(build())
    told = {code: {name for finding in report.of(code) for name in finding.parts} for code in wanted}
    assert all(report.of(code) for code in wanted), report
    assert all(names <= told[code] for code, names in wanted.items()), report
    assert not (report.ok and any(CODES[code][0] == "error" for code in wanted))
    assert json.loads(report.to_json())["ok"] is report.ok
    for finding in report.findings:
        assert finding.text.endswith((".", "!"))
        assert "nan" not in finding.text.lower()
