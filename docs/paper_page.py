"""Put the results of the study into the documentation: its pages into docs/paper, the verdicts into docs/nine_bar.md.

    python examples/nine_bar_paper.py all --out out/paper
    python docs/paper_page.py [--results out/paper]

What is not there is left as it was, and named.
"""

import argparse
import shutil
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAGE, FOLDER, PICTURES = HERE / "nine_bar.md", HERE / "paper", HERE / "pictures"
PAGES = ("claims", "convergence", "threshold", "exponents", "damping", "sensitivity", "times")
FIGURES = (6, 11, 14, 16, 20, 23, 25, 32, 33, 40)
BEGIN, END = "<!-- verdicts: begin, written by paper_page.py -->", "<!-- verdicts: end -->"


def first_table(text: str) -> str:
    """The first table of a page.

    Parameters
    ----------
    text : Markdown.
    """
    lines = text.splitlines()
    begin = next(k for k, line in enumerate(lines) if line.startswith("|"))
    end = next((k for k in range(begin, len(lines)) if not lines[k].startswith("|")), len(lines))
    return "\n".join(lines[begin:end])


def put_verdicts(table: str) -> None:
    """Put the table of claims between its marks.

    Parameters
    ----------
    table : Markdown.
    """
    page = PAGE.read_text(encoding="utf-8")
    if page.count(BEGIN) != 1 or page.count(END) != 1 or page.index(END) < page.index(BEGIN):
        raise SystemExit(f"{PAGE.name} needs the marks {BEGIN!r} and {END!r}, once each")
    before, after = page.split(BEGIN)[0], page.split(END)[1]
    PAGE.write_text(f"{before}{BEGIN}\n\n{table}\n\n{END}{after}", encoding="utf-8")


def main() -> None:
    """Pages, verdicts, pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=Path, default=HERE.parent / "out" / "paper", help="folder of the study")
    folder = parser.parse_args().results
    copies = {folder / f"{name}.md": FOLDER / f"{name}.md" for name in PAGES}
    copies |= {folder / f"figure-{n:02d}.png": PICTURES / f"paper_{n:02d}.png" for n in FIGURES}
    copies |= {folder / "exponents.png": PICTURES / "paper_exponents.png"}
    FOLDER.mkdir(exist_ok=True)
    for source, target in copies.items():
        if source.exists():
            shutil.copyfile(source, target)
    claims = folder / "claims.md"
    if claims.exists():
        put_verdicts(first_table(claims.read_text(encoding="utf-8")))
    missing = [source.name for source in copies if not source.exists()]
    print(
        f"written: {PAGE}, {FOLDER}",
        *([f"not there, left as it was: {', '.join(missing)}"] if missing else []),
        sep="\n",
    )


if __name__ == "__main__":
    main()
