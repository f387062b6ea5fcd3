"""Compute the numbers of docs/numbers.md anew: what every number that is no physics does to four runs.

    python docs/numbers_table.py [--runs a b d c] [--places landing ledger] [--mild] [--page]

The special build is compiled once (some minutes, kept in out/numbers).  Results stand in docs/numbers.json, one a run;
what is there is not run again, unless the code of flexmb has changed since: then all of it is.  With `--page` the page
is written from what is there, whatever its code, and tells the day of its runs.  On a quiet core a takes
some six minutes, b fifty, d seven; c an hour and a half, with numbers and factors chosen (`FLEXIBLE_TOO`, a tenth to
ten).
"""

import argparse
import ast
import hashlib
import importlib
import json
import sys
from collections.abc import Iterator, Sequence
from datetime import date
from pathlib import Path
from typing import Any

import numbers_live
import numpy as np
from numbers_list import ASKED, ELSEWHERE, FLEXIBLE_TOO, READ, Number

HERE = Path(__file__).resolve().parent
PAGE, ROWS = HERE / "numbers.md", HERE / "numbers.json"
FLEXMB = HERE.parent / "flexmb"
UNUSED = ("cli/", "dynamics/", "engine/compiled/", "results/", "show/", "testing/")
"""Folders and files on which no result of the runs depends."""

CACHE = HERE.parent / "out" / "numbers" / "cache"


def code_of_flexmb() -> str:
    """A name for the code that the runs use, its docstrings and comments left out."""
    digest = hashlib.sha256()
    for file in sorted(FLEXMB.rglob("*.py")):
        if file.relative_to(FLEXMB).as_posix().startswith(UNUSED):
            continue
        tree = ast.parse(file.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(getattr(node, "body", None), list):
                node.body = [line for line in node.body if not _is_text(line)]
        digest.update(ast.dump(tree).encode())
    return digest.hexdigest()[:16]


def _is_text(line: ast.AST) -> bool:
    return isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant)


def kept(*, of_any_code: bool = False) -> dict[str, Any]:
    """The results of this code that are there; those of any code for the page alone."""
    code = code_of_flexmb()
    found = json.loads(ROWS.read_text(encoding="utf-8")) if ROWS.exists() else {}
    empty = {"code": code, "day": f"{date.today():%Y-%m-%d}", "values": {}, "runs": {}}
    return found if found and (of_any_code or found["code"] == code) else empty


def wanted(chosen: argparse.Namespace) -> Iterator[tuple[str, Number, float]]:
    """Case, number and factor of all runs, mild factors first."""
    for case in chosen.runs:
        for mild in (True,) if chosen.mild or case == "c" else (True, False):
            for number in (*ASKED, *READ):
                if chosen.places and not any(part in number.place for part in chosen.places):
                    continue
                if case == "c" and number.place not in FLEXIBLE_TOO:
                    continue
                for factor in number.factors:
                    if mild == (0.1 <= factor <= 10.0) and (not chosen.factors or factor in chosen.factors):
                        yield case, number, factor


def compute(chosen: argparse.Namespace, store: dict[str, Any], build: numbers_live.Build) -> None:
    """Make all runs that are not there yet."""
    import numbers_runs as runs  # noqa: PLC0415 - flexmb is imported after its build was made

    asked: dict[str, dict[str, float]] = {}
    for case in chosen.runs:
        rows = store["runs"].setdefault(case, {})
        asked[case] = runs.defaults(case, runs.model(case))
        for repeat in range(runs.CASES[case].repeats):
            if f"base {repeat}" not in rows:
                keep(store, rows, f"base {repeat}", runs.measured(case, {}, repeat))
        store["values"] |= {f"{place} {case}": value for place, value in asked[case].items()}
    for case, number, factor in wanted(chosen):
        rows, key = store["runs"][case], f"{number.place} {factor:g}"
        if key in rows or (number in ASKED and number.place not in asked[case]):
            continue
        keep(store, rows, key, varied(case, number, factor, asked[case], build, runs))


def varied(case: str, number: Number, factor: float, asked: dict[str, float], build: Any, runs: Any) -> dict[str, Any]:
    """The result of a run with one number times a factor; a failure of any kind is one."""
    changes: dict[str, float] = {}
    if number in ASKED:
        changes[number.place] = factor * asked[number.place]
    else:
        value = build.places[number.place].value
        build.set(number.place, max(round(factor * value), 1) if isinstance(value, int) else factor * value)
    try:
        return runs.measured(case, changes)
    except (runs.fm.errors.FlexmbError, ArithmeticError, ValueError) as error:
        return {"ok": False, "status": f"{type(error).__name__}: {error}", "turns": 0, "steps": 0, "values": {}}
    finally:
        build.reset()


def keep(store: dict[str, Any], rows: dict[str, Any], key: str, result: dict[str, Any]) -> None:
    """Write a result down."""
    rows[key] = result
    print(key, result["ok"], {name: value[0] for name, value in result["values"].items()}, flush=True)
    written = ROWS.with_suffix(".new")
    written.write_text(json.dumps(store).replace('}, "', '},\n"') + "\n", encoding="utf-8")
    written.replace(ROWS)


def value_of(place: str) -> float:
    """A number of the sources: a literal, a constant of a module, or the default of a field of a class."""
    path, _, literal = place.partition("#")
    if literal:
        return ast.literal_eval(literal)
    parts = ["flexmb", *path.split(".")]
    cut = 2 if parts[-2][0].isupper() else 1
    found = importlib.import_module(".".join(parts[:-cut]))
    for name in parts[-cut:]:
        found = getattr(found, name)
    return found


def values_of(store: dict[str, Any]) -> dict[str, str]:
    """What each number is, by place; of arguments whose default depends on the model, that of each run."""
    found = {n.place: ", ".join(f"{v:.6g}" for v in np.atleast_1d(value_of(n.place))) for n in (*READ, *ELSEWHERE)}
    for number in ASKED:
        own = [f"{value:.3g}" for key, value in store["values"].items() if key.rpartition(" ")[0] == number.place]
        found[number.place] = ", ".join(dict.fromkeys(own))
    return found


def write_page(store: dict[str, Any], titles: dict[str, str]) -> None:
    """Write the page from what is there."""
    import numbers_page  # noqa: PLC0415 - scipy is not asked for before flexmb is

    cases = {case: rows for case, rows in sorted(store["runs"].items()) if "base 0" in rows}
    PAGE.write_text(numbers_page.page(cases, titles, values_of(store), store["day"]), encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", nargs="+", choices="abcd", default=list("abdc"))
    parser.add_argument("--places", nargs="+", default=[], help="only numbers whose place has one of these in it")
    parser.add_argument("--factors", type=float, nargs="+", default=[], help="only these factors")
    parser.add_argument("--mild", action="store_true", help="only factors from a tenth to ten: a third of the time")
    parser.add_argument("--page", action="store_true", help="only write the page from what is there")
    chosen = parser.parse_args(arguments)
    store, build = kept(of_any_code=chosen.page), numbers_live.Build([n.place for n in READ], CACHE)
    sys.path.insert(0, str(HERE.parent / "examples"))  # statistics of the study
    import numbers_runs  # noqa: PLC0415 - flexmb is imported after its build was made

    if not chosen.page:
        compute(chosen, store, build)
    write_page(store, {case: whole.title for case, whole in numbers_runs.CASES.items()})


if __name__ == "__main__":
    main()
