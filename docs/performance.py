"""Measure speed beside the peer and write docs/performance.md.

    python docs/performance.py [--only NAME ...] [--collect] [--rounds 5] [--before COMMIT]

NAME is a row of tests/speed/rows.py, `work-precision`, `statistics-rigid` or `statistics-flexible`.  Without --only all
are measured but the statistics, which take minutes.  --collect measures nothing and takes what the tests left in
out/speed.  --before measures flexmb alone, from whatever sources are imported, and keeps the times as those of COMMIT:

    PYTHONPATH=<another checkout> python docs/performance.py --before <its commit>

All numbers are kept in docs/performance.json, so that one row can be measured again.  The exit code is 1 when a
ratio is below what it ought to be.
"""

import argparse
import json
import sys
from collections.abc import Iterable
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests" / "speed")]

import performance_page as page  # noqa: E402
from duel import PAIRS, RECORDS, Verdict, lines, measured, stamp, timed  # noqa: E402

DATA = HERE / "performance.json"
LONG = ("statistics-rigid", "statistics-flexible")


def all_rows() -> dict:
    """The rows, for which the peer must be there."""
    try:
        from rows import ROWS  # noqa: PLC0415 - needs the peer
    except ModuleNotFoundError as error:
        if error.name != "exudyn":
            raise
        raise SystemExit("The peer is not installed: pip install --group bench") from error
    return ROWS


def measure(name: str, rounds: int) -> None:
    """Measure one thing; its record goes to out/speed."""
    rows = all_rows()
    if name in LONG:
        import nine_bar_statistics  # noqa: PLC0415 - needs the peer

        for one in nine_bar_statistics.measured(flexible=name == LONG[1])["rows"]:
            print(one, flush=True)
    elif name == "work-precision":
        import work_precision  # noqa: PLC0415 - only for this

        work_precision.measured()
    else:
        print("\n".join(lines(measured(rows[name], rounds))), flush=True)


def before(names: Iterable[str], rounds: int, commit: str) -> dict:
    """Times of our runners from the sources that are imported [s]."""
    found = {}
    for name in names:
        runners = [r for r in all_rows()[name].make() if r.code == "flexmb"]
        timings, _ = timed(runners, rounds)
        found[name] = {"commit": commit, "where": stamp(), "times": {t.label: t.middle for t in timings}}
        print(name, found[name]["times"], flush=True)
    return found


def missed(data: dict, only: list[str] | None) -> list[str]:
    """What is below what it ought to be, among these rows or all."""
    rows = [r for name, r in data["rows"].items() if only is None or name in only]
    verdicts = [(r["title"], Verdict(**v)) for r in rows for v in r["verdicts"]]
    return [f"{title}: {v}" for title, v in verdicts if not v.holds]


def main() -> int:
    """Measure, keep, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these alone")
    parser.add_argument("--collect", action="store_true", help="measure nothing, take what lies in out/speed")
    parser.add_argument("--rounds", type=int, default=PAIRS, help=f"rounds at least ({PAIRS})")
    parser.add_argument("--before", metavar="COMMIT", help="time flexmb alone and keep the times as those of COMMIT")
    options = parser.parse_args()
    known = [*all_rows(), "work-precision", *LONG]
    unknown = [name for name in options.only or () if name not in known]
    if unknown:
        parser.error(f"there is no {', '.join(unknown)}; there are {', '.join(known)}")
    earlier = {}
    if options.before:
        names = [name for name in options.only or known if name in all_rows()]
        earlier = before(names, options.rounds, options.before)
    elif not options.collect:
        for name in options.only or [n for n in known if n not in LONG]:
            measure(name, options.rounds)
    data = json.loads(DATA.read_text(encoding="utf-8")) if DATA.is_file() else {"rows": {}, "before": {}, "others": {}}
    data["before"] |= earlier
    if not options.before:
        collect(data, None if options.collect else options.only)
    DATA.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    page.write(HERE / "performance.md", data, order=list(all_rows()))
    complaints = missed(data, options.only)
    print("\n".join(complaints), file=sys.stderr, end="\n" if complaints else "")
    return 1 if complaints else 0


def collect(data: dict, only: list[str] | None) -> None:
    """Take the records of out/speed."""
    for file in sorted(RECORDS.glob("*.json")):
        if only is None or file.stem in only:
            record = json.loads(file.read_text(encoding="utf-8"))
            data["rows" if "verdicts" in record else "others"][file.stem] = record


if __name__ == "__main__":
    sys.exit(main())
