"""Compute anew every number of the pages on the nine-bar mechanism, step by step; a stopped call goes on.

    python docs/study_pages.py [--only STEP ...] [--list] [--fresh]

Steps that are done for the present code stand in out/study_pages.json; `nine_bar_paper.py` goes on within its step, run
by run.  A step that fails does not stop the others.  --list tells what is done and what is left, --fresh begins anew.
"""

import argparse
import hashlib
import json
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DONE = ROOT / "out" / "study_pages.json"
FILM = (
    "run nine-bar --speed 2pi --clearance 0.5mm --flexible --step 20us --periods 2 --out out/film",
    "animate out/film/nine-bar.nc --out docs/pictures/nine_bar.gif --from 1s --to 1.9875s --fps 20 --magnify 200 "
    "--traces panel7,slider --size 600x430",
)
"""Commands of the film on the first page, as docs/howto/files.md has them."""

STAGGERED = "--cases 0.5/0.5 2/0.5 2.5/0.5 2/0.05 --picture --write"

STEPS = {
    "study": ("examples/nine_bar_paper.py", "all", "--out", "out/paper"),
    "study-pages": ("docs/paper_page.py",),
    "table": ("docs/nine_bar_table.py",),
    "staggered": ("docs/staggered_table.py", *STAGGERED.split()),
    "chaos": ("docs/chaos_table.py",),
    "bearings": ("docs/bearings_table.py", "--fresh"),
    "exponents": ("docs/exponents_table.py", "--fresh"),
    "bodies": ("docs/bodies_table.py",),
    "bodies-page": ("docs/bodies_table.py", "--page"),
    "numbers": ("docs/numbers_table.py", "--runs", "c"),
    "film-run": ("-m", "flexmb", *FILM[0].split()),
    "film": ("-m", "flexmb", *FILM[1].split()),
    "pictures": ("docs/report_pictures.py",),
    "gallery": ("docs/gallery_page.py",),
}
"""Arguments of Python by step, in their order."""

MINUTES = {
    "study": 300,
    "table": 4,
    "staggered": 15,
    "chaos": 30,
    "bearings": 30,
    "exponents": 25,
    "bodies": 20,
    "numbers": 90,
}
"""Approximate processor time [min]; other steps take one or two."""


def code_of() -> str:
    """Digest of the code that the numbers come from."""
    files = [file for folder in ("flexmb", "examples/nine_bar_study") for file in sorted((ROOT / folder).rglob("*.py"))]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]


def main() -> int:
    """Steps in their order; 1 if one failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=list(STEPS), default=list(STEPS), metavar="STEP")
    parser.add_argument("--list", action="store_true", help="tell what is done")
    parser.add_argument("--fresh", action="store_true", help="forget what is done")
    options = parser.parse_args()
    code, failed = code_of(), []
    done = json.loads(DONE.read_text(encoding="utf-8")) if DONE.exists() and not options.fresh else {}
    for step in options.only:
        if done.get(step) == code or options.list:
            print(f"{step:12s} {'done' if done.get(step) == code else 'to do'}, {MINUTES.get(step, 2)} min")
            continue
        began = time.monotonic()
        if subprocess.run([sys.executable, *STEPS[step]], cwd=ROOT, check=False).returncode:
            failed.append(step)
            continue
        done[step] = code
        DONE.parent.mkdir(exist_ok=True)
        DONE.write_text(json.dumps(done, indent=2), encoding="utf-8")
        print(f"{step:12s} {(time.monotonic() - began) / 60.0:.1f} min", flush=True)
    print(f"failed: {', '.join(failed)}" if failed else "")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
