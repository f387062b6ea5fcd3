"""Stamps of compiled code: a digest of all sources that a function was compiled from.

numba looks at the file of the function alone.  Functions that are called, and constants that are frozen into the code,
lie in other files: here every file counts that the module of the function imports, directly or through others, but for
those of the standard library and of other installed packages.
"""

from __future__ import annotations

import hashlib
import re
import sys
from functools import cache
from importlib.util import resolve_name
from pathlib import Path
from sysconfig import get_path

IMPORT = re.compile(r"^(?:from +([\w.]+) +import +(\([^)]*\)|[^\n#]*)|import +([^\n#]*))", re.MULTILINE)
NAME = re.compile(r"[\w.]+")
PACKAGE = "flexmb"
STANDARD = tuple({str(Path(get_path(name)).resolve()) for name in ("stdlib", "platstdlib")})
INSTALLED = {"site-packages", "dist-packages"}
"""Folders of installed packages."""


def stamp(module: str) -> str:
    """Digest of the sources of a module and of all that importing it needs."""
    found, todo = set[str](), [module]
    while todo:
        name = todo.pop()
        if name not in found:
            found.add(name)
            todo.extend(_source(name)[1])
    return hashlib.sha256("".join(_source(name)[0] for name in sorted(found)).encode()).hexdigest()


@cache
def _source(module: str) -> tuple[str, frozenset[str]]:
    """Digest of the file of a module, and its imports; empty for installed modules and without a file."""
    file = getattr(sys.modules.get(module), "__file__", None)
    own = module.partition(".")[0] == PACKAGE
    if file is None or not (own or is_users_file(file)):
        return "", frozenset()
    try:
        data = Path(file).read_bytes()
    except OSError:  # in an archive
        return "", frozenset()
    text, names = data.decode(errors="replace"), set[str]()
    package = getattr(sys.modules[module], "__package__", None) or ""
    for base, listed, whole in IMPORT.findall(text):
        if base:
            home = resolve_name(base, package) if base.startswith(".") else base
            names |= {home, *(f"{home}.{name}" for name in NAME.findall(listed))}
        else:
            names.update(NAME.findall(whole))
    return hashlib.sha256(data).hexdigest(), frozenset(names & sys.modules.keys())


@cache
def is_users_file(file: str) -> bool:
    """Whether a file belongs neither to Python nor to an installed package."""
    path = Path(file).resolve()
    return not (str(path).startswith(STANDARD) or INSTALLED.intersection(path.parts))


def is_of_user(module: str) -> bool:
    """Whether a module belongs neither to Python nor to an installed package, nor to flexmb."""
    found = sys.modules.get(module)
    if found is None or module == "__main__":
        return True
    file = getattr(found, "__file__", None) or next(iter(getattr(found, "__path__", ())), None)  # of a namespace
    return module.partition(".")[0] != PACKAGE and file is not None and is_users_file(file)
