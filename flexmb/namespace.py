"""Public names of a package or a module, imported when they are first used.

The stub (.pyi) beside a package is the one list of its public names: type checkers and editors read it, and so
does `lazy_names` here. `import flexmb` stays fast, since nothing is imported before it is needed.
"""

import re
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

_IMPORT = re.compile(r"^from (\S+) import (\w+) as \2$", re.MULTILINE)
"""A line of a stub: module and name."""


def lazy_names(module: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a module whose public names stand in the stub beside it.

    Parameters
    ----------
    module, file
        `__name__` and `__file__` of the module. Each line of the stub is `from package.module import name as name`;
        `name` may be a module itself.

    Returns
    -------
    tuple
        Function that imports a name when it is first used, function that lists the names, and their list.

    """
    stub = Path(file).with_suffix(".pyi").read_text(encoding="utf-8")
    homes = {name: home for home, name in _IMPORT.findall(stub)}
    names = sorted(homes)

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        home = vars(import_module(homes[name]))
        value = home[name] if name in home else import_module(f"{homes[name]}.{name}")
        setattr(sys.modules[module], name, value)
        return value

    return get, lambda: list(names), names
