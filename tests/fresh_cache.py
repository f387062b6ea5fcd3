"""Throw numba's cache of this checkout away when any source of the package has changed.

numba looks only at the file of a function itself, not at those of the functions it calls, so a cache left from other
sources would silently run old code.  Run as a script by make, and by conftest.py.
"""

import hashlib
import os
import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def refresh() -> None:
    """Empty the cache folder of this checkout unless its stamp fits the sources; leave folders elsewhere alone."""
    folder = Path(os.environ.setdefault("NUMBA_CACHE_DIR", str(ROOT / ".numba_cache"))).resolve()
    if ROOT not in folder.parents:
        return
    digest = hashlib.sha256()
    for file in sorted((ROOT / "flexmb").rglob("*.py")):
        digest.update(file.read_bytes())
    stamp = folder / "sources"
    if not stamp.is_file() or stamp.read_text(encoding="ascii") != digest.hexdigest():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True, exist_ok=True)
        stamp.write_text(digest.hexdigest(), encoding="ascii")


if __name__ == "__main__":
    refresh()
