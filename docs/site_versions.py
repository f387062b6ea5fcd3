"""Lay a site into the folder of its version: `python docs/site_versions.py SITE PAGES VERSION`.

PAGES then holds the site in the folder VERSION, beside those of other versions, and a page that lists them all and
leads to the newest release, or to "dev" where there is none.
"""

import re
import shutil
import sys
from pathlib import Path

RELEASE = re.compile(r"\d+\.\d+\.\d+$")

PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>flexmb</title>
<meta http-equiv="refresh" content="0; url={newest}/index.html">
<p>Versions of these pages:</p>
<ul>
{items}
</ul>
</html>
"""


def versions(pages: Path) -> list[str]:
    """Versions that have pages, the newest release first, what is no release last."""
    found = [folder.name for folder in pages.iterdir() if (folder / "index.html").exists()]
    releases = sorted((name for name in found if RELEASE.match(name)), key=number, reverse=True)
    return releases + sorted(set(found) - set(releases))


def number(version: str) -> tuple[int, ...]:
    """Numbers of a version."""
    return tuple(map(int, version.split(".")))


def lay(site: Path, pages: Path, version: str) -> None:
    """Copy a site in the place of the former one of its version, and write the page that lists all versions."""
    if version != "dev" and not RELEASE.match(version):
        sys.exit(f"{version!r} is no version; give dev, or three numbers such as 0.2.0.")
    shutil.rmtree(pages / version, ignore_errors=True)
    shutil.copytree(site, pages / version)
    known = versions(pages)
    items = "\n".join(f'<li><a href="{name}/index.html">{name}</a></li>' for name in known)
    (pages / "index.html").write_text(PAGE.format(newest=known[0], items=items), encoding="utf-8")
    (pages / ".nojekyll").touch()  # folders such as _static are served as they are


if __name__ == "__main__":
    lay(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3])
