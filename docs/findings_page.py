"""docs/findings.md: every finding of `check`, with its severity and an example from tests/broken_models.

python docs/findings_page.py
"""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "tests" / "broken_models"))

from broken import CASES  # noqa: E402 - found beside this folder

import flexmb as fm  # noqa: E402
from flexmb.doctor import CODES, Finding  # noqa: E402

PAGE = HERE / "findings.md"

HEAD = """# Findings

`fm.check(mechanism)` and `flexmb check NAME` examine a mechanism before it moves and tell everything at once. Each
finding has a stable code, the names of the parts, a sentence with numbers, and a remedy. An *error* means that a run
would be refused or could not be right; a *warning*, that the result is hardly what was meant; a *note*, something worth
knowing. With any error `report.ok` is False, and the exit code is 1. `report.to_json()` and `flexmb check --json` are
for programs. `fm.check(mechanism, step=1e-5)` and `flexmb check NAME --step 10us` also ask whether a fixed step is
short enough.

`simulate` looks at users' laws and motions and at tables by itself, and watches penetrations, strains, contacts and
vibrations. A result that cannot be right has `sol.ok` False and a status that says when, where and what to do; remarks
stand in `sol.notes`. `sol.findings` holds all of them as records, as `report.findings` does; their further codes are
`flexmb.findings.finding.CODES_OF_RUNS`.

A run whose step fails says why: the kernel that raised or gave numbers that are not finite, with its part, the time and
its arguments; or a known cause of this list; or else a step that was tried from the last good state and gets past the
instant. `sol.notes` then names the largest residuals and the contacts that change in the refused step; results so far
are kept, and `sol.restart` is the last good state.

This page is written by `python docs/findings_page.py`. The examples are of `tests/broken_models/broken.py`.

| code | severity | meaning | example |
|---|---|---|---|
"""


def examples() -> dict[str, tuple[str, Finding]]:
    """First model of the corpus that shows each code, and the finding."""
    found: dict[str, tuple[str, Finding]] = {}
    for name, (build, wanted) in CASES.items():
        missing = [code for code in CODES if code not in found]
        if not any(code in missing for code in wanted) and "free-motion" not in missing:
            continue
        for finding in fm.check(build()).findings:
            found.setdefault(finding.code, (name, finding))
    return found


def page() -> str:
    """The text of the page."""
    shown = examples()
    rows = []
    for code, (severity, meaning) in CODES.items():
        name, finding = shown.get(code, ("", None))
        example = f"{name}: *{finding.text} {finding.remedy}*" if finding else ""
        rows.append(f"| `{code}` | {severity} | {meaning} | {example.replace('|', '/').replace(chr(10), ' ')} |")
    return HEAD + "\n".join(rows) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)
