"""Put the results of the study into docs/nine_bar.md: its tables between their marks, some of its pictures.

    flexmb paper all --out out/paper
    python docs/paper_page.py [--results out/paper]

A passage is written if its file is there; which were not is said at the end.
"""

import argparse
import shutil
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAGE, PICTURES = HERE / "nine_bar.md", HERE / "pictures"
PASSAGES = ("claims", "convergence", "threshold", "exponents", "sensitivity", "times")
FIGURES = (6, 11, 14, 15, 16, 20, 22, 23, 25, 27, 30, 32, 33, 36, 40, 44)
DRAWN_PAGES = ("exponents",)


def write(name: str, text: str) -> None:
    """Put a passage between its marks in the page.

    Parameters
    ----------
    name : of the passage.
    text : Markdown.
    """
    begin, end = f"<!-- {name}: begin, written by paper_page.py -->", f"<!-- {name}: end -->"
    page = PAGE.read_text(encoding="utf-8")
    if page.count(begin) != 1 or page.count(end) != 1 or page.index(end) < page.index(begin):
        raise SystemExit(f"{PAGE.name}: the passage {name!r} needs the marks {begin!r} and {end!r}, once each")
    before, after = page.split(begin)[0], page.split(end)[1]
    PAGE.write_text(f"{before}{begin}\n\n{text.strip()}\n\n{end}{after}", encoding="utf-8")


def main() -> None:
    """Passages and pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=Path, default=HERE.parent / "out" / "paper", help="folder of the study")
    folder = parser.parse_args().results
    missing = []
    for name in PASSAGES:
        found = folder / f"{name}.md"
        if found.exists():
            write(name, found.read_text(encoding="utf-8"))
        else:
            missing.append(found.name)
    for stem in [f"figure-{number:02d}" for number in FIGURES] + list(DRAWN_PAGES):
        found = folder / f"{stem}.png"
        if found.exists():
            shutil.copyfile(found, PICTURES / f"paper_{stem.removeprefix('figure-')}.png")
        else:
            missing.append(found.name)
    print(f"written: {PAGE}", *([f"not there, left as it was: {', '.join(missing)}"] if missing else []), sep="\n")


if __name__ == "__main__":
    main()
