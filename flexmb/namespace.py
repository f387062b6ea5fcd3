"""Public names of a package or a module, imported when they are first used.

The stub (.pyi) beside a package is the one list of its public names: type checkers and editors read it, and so
does `lazy_names` here. `import flexmb` stays fast, since nothing is imported before it is needed: an upgrade may change
files meanwhile, so their state is kept, too.
"""

import os
import re
import sys
import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

CLOSE = 0.7  # likeness of names from which they are suggested, 1 for equal ones
_IMPORT = re.compile(r"^from (\S+) import (\w+) as \2$", re.MULTILINE)  # a line of a stub: module and name


def lazy_names(
    module: str, file: str, former: Mapping[str, tuple[str, str]] | None = None
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a module whose public names stand in the stub beside it."""
    # They are a function that imports a name at its first use, one that lists the names, and their list; `module` and
    # `file` are the module's `__name__` and `__file__`. Each line of the stub is `from package.module import name as
    # name`; `name` may be a module itself. `former`: former names, with the present one and the version of their end.
    homes = {name: home for home, name in _IMPORT.findall(Path(file).with_suffix(".pyi").read_text(encoding="utf-8"))}
    names = sorted(name for name in homes if name[0] != "_")

    def get(name: str) -> Any:
        if former is not None and name in former:
            warn_of_former(module, name, *former[name])
            return get(former[name][0])
        if name not in homes:
            text = f"module {module!r} has no attribute {name!r}"
            raise AttributeError(text if name.startswith("_") else f"{text}.{_near(name, module, names)}")
        home = vars(import_module(homes[name]))
        value = home[name] if name in home else import_module(f"{homes[name]}.{name}")
        setattr(sys.modules[module], name, value)
        return value

    return get, lambda: list(names), names


def _near(name: str, module: str, names: list[str]) -> str:
    """Hint on an unknown public name: the namespaces that have it, else the nearest names of the module and of all."""
    from difflib import get_close_matches  # noqa: PLC0415 - `import flexmb` stays fast

    top = Path(__file__).parent
    spaces: dict[str, str] = {}  # of each name, the top of the package first
    for path in sorted(top.rglob("*.pyi"), key=lambda path: (path != top / "__init__.pyi", path)):
        room = path.parent.name if path.stem == "__init__" else path.stem
        for _, one in _IMPORT.findall(path.read_text(encoding="utf-8")):
            spaces.setdefault(one, "flexmb" if room == top.name else f"flexmb.{room}")
    if name in spaces:
        return f" It is {spaces[name]}.{name}."
    near = get_close_matches(name, names, cutoff=CLOSE) or get_close_matches(name, spaces, cutoff=CLOSE)
    places = [f"{module if one in names else spaces[one]}.{one}" for one in near]
    return f" Did you mean {', '.join(places)}?" if places else f" Names: {', '.join(names)}."


def states() -> dict[str, tuple[int, ...]]:
    """State of each source file of the package."""
    walk = os.walk(os.path.dirname(__file__))  # noqa: PTH120 - half the time
    files = (os.path.join(home, name) for home, _, names in walk for name in names if name.endswith(".py"))  # noqa: PTH118
    return {file: state(file) for file in files}


def state(file: str) -> tuple[int, ...]:
    """Time of change, size and number of a file; nothing where it is not there."""
    try:
        found = os.stat(file)  # noqa: PTH116 - half the time
    except OSError:
        return ()
    return found.st_mtime_ns, found.st_size, found.st_ino


IMPORTED = states()  # state of each source file when the package was imported
# Why compiled code is neither read nor kept.
CHANGED = "files of flexmb have changed since it was imported; start Python anew"


INNER = ("flexmb", "numpy", "dataclasses")  # packages between what is told and the line of its user


def level_of_user() -> int:
    """Stack level, seen from the caller of this function, of the first caller that is not flexmb."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] in INNER:
        frame, level = frame.f_back, level + 1
    return level


def warn_of_former(label: str, old: str, now: str, goes: str) -> None:
    """Warn at the line of the user that `old` is called `now`, and `goes` with a version."""
    text = f"{label}: {old} is called {now} now; the former name goes with version {goes}."
    warnings.warn(text, DeprecationWarning, stacklevel=level_of_user())
