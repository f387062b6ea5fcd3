"""The page of docs/numbers_table.py: what moves results, how far, and the list of all numbers."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from numbers_list import ASKED, ELSEWHERE, LEFT_OUT, READ, Number
from scipy.special import ndtri, stdtr

Rows = Mapping[str, Mapping[str, Any]]
"""Of a case: by "base 0", "base 1" ... and "place factor" what `numbers_runs.measured` returned."""

FLOOR = 1e-3
"""Error of a mean, as a part of it, below which no scatter is believed."""

NUMERICAL = 0.01
"""A smaller change, as a part of the mean, moves nothing."""

SIGMAS = 3.0
SHARES = ("taken by steps", "missing")
"""Quantities that are parts of something larger: their changes are not taken relative to themselves."""

COSTLY = 1.5
"""Factor of the steps that is worth a word."""

HEAD = """\
# Numbers that are no physics

Every threshold, tolerance, floor, cap and default of contact laws, friction, steps, start values, statics and analysis
that no user gave, and what happens to results when it is made smaller and larger. This page is written by
`make numbers`, or by `python docs/numbers_table.py`; a run that was killed goes on where it was, raw results are in
`docs/numbers.json`. Numbers of the compiled loop are varied in one special build that reads them at run time
(`docs/numbers_live.py`); the list is in `docs/numbers_list.py`, and a test holds that it is complete.

The runs of this page began on {day}.

Quantities are means over turns. A change counts in sigmas: by Welch's test of the two means (with the number of turns
that are independent), as that many standard deviations of a normal distribution. Errors below {floor:g} of a mean are
taken as that. A number **moves** a run where a change is above {sigmas:g} sigmas and {numerical:.0%}. Of {count}
comparisons that were made some {chance:.0f} lie above {sigmas:g} sigmas by chance alone; above {sure:.1f} hardly one
does.
"""

EMPTY = """\
Empty: not varied there. With flexible links a turn costs many seconds, so only numbers are varied that meet beams, the
error of steps or the iterations, by a tenth to ten; the others act on the same contact as in the rigid run."""


@dataclass(frozen=True)
class Change:
    """What a number did to a quantity of a run.

    Parameters
    ----------
    case : the run.
    factor : of the number.
    quantity : its name with unit; or "status".
    part : relative change.
    sigmas : how sure it is; inf for a run that failed.
    text : the status of a failed run.
    """

    case: str
    factor: float
    quantity: str
    part: float
    sigmas: float
    text: str = ""

    @property
    def moves(self) -> bool:
        """Whether it counts."""
        return self.sigmas > SIGMAS and abs(self.part) > NUMERICAL

    def __str__(self) -> str:
        if self.text:
            return f"×{self.factor:g} {self.text}"
        return f"×{self.factor:g}: {self.quantity} {100.0 * self.part:+.3g} % ({min(self.sigmas, 99.0):.1f} σ)"


def pooled(runs: Sequence[Mapping[str, Any]]) -> dict[str, tuple[float, float, float]]:
    """Mean, error and independent turns of each quantity of several runs with the same numbers."""
    found = {}
    for name in runs[0]["values"]:
        means, errors, turns = zip(*(run["values"][name] for run in runs), strict=True)
        n, mean = len(runs), sum(means) / len(runs)
        error = math.hypot(*errors) / n
        if n > 2:
            error = max(error, math.sqrt(sum((m - mean) ** 2 for m in means) / (n * (n - 1))))
        found[name] = (mean, error, sum(turns))
    return found


def sigmas(first: Sequence[float], second: Sequence[float]) -> float:
    """Difference of two means (value, error, independent turns) in standard deviations of a normal distribution."""
    difference = abs(first[0] - second[0])
    parts = [(max(e, FLOOR * abs(m)), max(n - 1.0, 1.0)) for m, e, n in (first, second)]
    error = math.hypot(*(e for e, _ in parts))
    if difference == 0.0 or error == 0.0:
        return 0.0 if difference == 0.0 else math.inf
    freedom = error**4 / sum(e**4 / n for e, n in parts)
    chance = 2.0 * float(stdtr(freedom, -difference / error))
    return min(float(-ndtri(0.5 * chance)), 37.0) if chance > 0.0 else 37.0


def changes(case: str, rows: Rows, place: str) -> Iterator[Change]:
    """What each factor of a number did to a run; nothing for one that is the same to the last bit."""
    runs = [row for key, row in rows.items() if key.startswith("base ")]
    base = pooled(runs)
    for key, row in rows.items():
        if key.rpartition(" ")[0] != place:
            continue
        factor = float(key.rpartition(" ")[2])
        stopped = len(row["values"]) < len(base)
        if row["ok"] != runs[0]["ok"] or stopped:
            text = "is ok, which it is not as it is" if row["ok"] else f"fails: {reason(row['status'])}"
            yield Change(case, factor, "status", math.inf, math.inf, text)
        if row["values"] == runs[0]["values"]:
            continue
        for name, value in row["values"].items():
            if name in base:
                whole = 1.0 if name.startswith(SHARES) else abs(base[name][0]) or 1.0
                part = (value[0] - base[name][0]) / whole
                yield Change(case, factor, name, part, sigmas(value, base[name]))


def reason(status: str) -> str:
    """The beginning of a status, without instants and sizes."""
    return " ".join(status.split(",", maxsplit=1)[0].rstrip(".").split()[:20])


def scatter(case: str, rows: Rows) -> Iterator[str]:
    """Lines on the runs with the numbers as they are: each against all others."""
    runs = [row for key, row in rows.items() if key.startswith("base ")]
    for name, (mean, error, _) in pooled(runs).items():
        apart: list[str] = []
        for k in range(len(runs) if len(runs) > 1 else 0):
            others = pooled([run for i, run in enumerate(runs) if i != k])
            apart.append(f"{sigmas(runs[k]['values'][name], others[name]):.1f}")
        yield f"| {case} | {name} | {mean:.5g} | {error:.2g} | {' '.join(apart) or '-'} |"


def doubtful(cases: Mapping[str, Rows]) -> Iterator[tuple[str, str]]:
    """Runs that are not ok with the numbers as they are, and what they say."""
    for case, rows in cases.items():
        bad = [row["status"] for key, row in rows.items() if key.startswith("base ") and not row["ok"]]
        if bad:
            yield case, bad[0]


def cell(case: str, rows: Rows, number: Number) -> str:
    """What a number does to a run, in a few words."""
    tried = [key for key in rows if key.rpartition(" ")[0] == number.place]
    if not tried:
        return ""
    found = list(changes(case, rows, number.place))
    words = [str(c) for c in found if c.text]
    for factor in sorted({c.factor for c in found}):
        moved = [c for c in found if c.factor == factor and c.moves and not c.text]
        words += [str(max(moved, key=lambda c: c.sigmas))] if moved else []
    plain = rows["base 0"]["steps"]
    for key in tried:
        ratio = rows[key]["steps"] / plain
        if rows[key]["ok"] and not 1.0 / COSTLY < ratio < COSTLY:
            words.append(f"×{key.rpartition(' ')[2]}: steps {ratio:.2g} x")
    if words:
        return "; ".join(words)
    return "within the scatter" if found else "to the last bit"


def ranking(cases: Mapping[str, Rows]) -> Iterator[str]:
    """Lines on the numbers that move a run, the worst first."""
    worst = []
    for number in (*READ, *ASKED):
        found = [c for case, rows in cases.items() for c in changes(case, rows, number.place)]
        moved = sorted((c for c in found if c.moves or c.text), key=lambda c: (bool(c.text), -c.sigmas, -abs(c.part)))
        if moved:
            worst.append((moved[0].text != "", -moved[0].sigmas, number, moved))
    for _, _, number, moved in sorted(worst, key=lambda w: w[:2]):
        kinds = sorted({c.case for c in moved})
        yield f"| `{number.place}` | {len(moved)} in {' '.join(kinds)} | {moved[0].case} {moved[0]} |"


def page(cases: Mapping[str, Rows], titles: Mapping[str, str], values: Mapping[str, str], day: str) -> str:
    """The whole page; `values` says by place what each number is, `day` when the runs began."""
    count = sum(len(rows["base 0"]["values"]) * (len(rows) - 1) for rows in cases.values())
    sure = float(-ndtri(0.025 / max(count, 1)))
    chance = 0.0027 * count
    lines = [
        HEAD.format(day=day, floor=FLOOR, sigmas=SIGMAS, numerical=NUMERICAL, count=count, chance=chance, sure=sure)
    ]
    lines += [f"- {case}: {title}" for case, title in titles.items() if case in cases]
    lines += ["", "## Scatter of the runs as they are", ""]
    lines += ["Runs whose starts differ a little; the last column is each of them against the others [sigmas].", ""]
    lines += _table(("run", "quantity", "mean", "error", "repeats"))
    lines += [line for case, rows in cases.items() for line in scatter(case, rows)]
    lines += [f"\n{case} is not ok as it is: {why}" for case, why in doubtful(cases)]
    lines += ["", "## What moves results", "", "The surest first, and numbers with which a run only fails last.", ""]
    lines += [*_table(("number", "moves", "most")), *ranking(cases)]
    lines += ["", "## Numbers that the runs reach", "", *_table(("number", "value", "of", "stands for", *cases))]
    for number in (*READ, *ASKED):
        cells = [cell(case, rows, number) for case, rows in cases.items()]
        lines.append(_row(number, values, cells))
    lines += ["", EMPTY, "", "## Numbers that none of the runs reaches", ""]
    lines += [*_table(("number", "value", "of", "stands for")), *(_row(n, values, ()) for n in ELSEWHERE)]
    lines += ["", "## Left out", ""]
    for reason in dict.fromkeys(LEFT_OUT.values()):
        lines.append(f"- {reason}: " + ", ".join(f"`{p}`" for p, why in LEFT_OUT.items() if why == reason))
    return "\n".join(lines) + "\n"


def _table(head: Sequence[str]) -> list[str]:
    return ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]


def _row(number: Number, values: Mapping[str, str], cells: Sequence[str]) -> str:
    unit = "" if number.unit == "1" else f" {number.unit}"
    first = (f"`{number.place}`", f"{values.get(number.place, '')}{unit}", number.scale, number.meaning)
    return "| " + " | ".join((*first, *cells)) + " |"
