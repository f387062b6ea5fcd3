"""Compute the numbers and pictures of docs/measured.md: our models beside measured machines and closed forms.

    python docs/measured_table.py [--data FOLDER] [--only pendulums spheres rub emps] [--pictures] [--write]

FOLDER holds the records that docs/measured.md names; without it, sections that need them keep their numbers.  Numbers
are kept in docs/measured.json.  --pictures draws the pictures of the records, --write writes the page from the numbers;
with `--only` and nothing behind it nothing is computed.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from measured import emps, pendulums, rub, spheres  # noqa: E402

PAGE, DATA, PICTURES = HERE / "measured.md", HERE / "measured.json", HERE / "pictures"
SECTIONS = {"pendulums": pendulums, "spheres": spheres, "rub": rub, "emps": emps}
"""Modules with `numbers` (of a folder of records, or None), `passage`, and whether they need `RECORDS`."""


def page_text(text: str, data: dict[str, Any]) -> str:
    """The page with its tables from the numbers."""
    for name, section in SECTIONS.items():
        begin, end = f"<!-- {name}: begin, written by measured_table.py -->", f"<!-- {name}: end -->"
        before, rest = text.split(begin)
        text = f"{before}{begin}\n\n{section.passage(data[name])}\n\n{end}{rest.split(end)[1]}"
    return text


def main() -> None:
    """Compute, keep, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, help="folder with the measured records")
    parser.add_argument("--only", nargs="*", choices=tuple(SECTIONS), default=tuple(SECTIONS), help="these alone")
    parser.add_argument("--pictures", action="store_true", help="draw the pictures of the records")
    parser.add_argument("--write", action="store_true", help="write the page")
    options = parser.parse_args()
    data = json.loads(DATA.read_text(encoding="utf-8")) if DATA.is_file() else {}
    for name in options.only:
        section = SECTIONS[name]
        if section.RECORDS and options.data is None:
            print(f"{name}: no --data FOLDER, so the numbers in {DATA.name} stay.")
            continue
        busy = time.process_time()
        data[name] = section.numbers(options.data)
        print(f"{name}: {time.process_time() - busy:.0f} s of processor time", flush=True)
        DATA.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    if options.pictures and options.data is not None:
        pendulums.pictures(options.data, data["pendulums"], PICTURES)
    if options.write:
        PAGE.write_text(page_text(PAGE.read_text(encoding="utf-8"), data), encoding="utf-8")


if __name__ == "__main__":
    main()
