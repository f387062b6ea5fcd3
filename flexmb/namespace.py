"""Namespaces: names that are imported when they are first used, as a stub lists them.

A module with a stub beside it needs two lines,

    from flexmb.namespace import namespace
    __getattr__, __dir__, __all__ = namespace(__name__, __file__)

and the stub, which type checkers read too, one line for each place that names come from:

    from flexmb.contact.normal.flores import Flores as Flores
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def namespace(name: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Functions `__getattr__` and `__dir__`, and the list `__all__`, of a module whose stub lists its names.

    Parameters
    ----------
    name, file : `__name__` and `__file__` of the module.
    """
    homes = dict(_listed(Path(file).with_suffix(".pyi")))

    def getattr_(attribute: str) -> Any:
        if attribute not in homes:
            raise AttributeError(f"module {name!r} has no attribute {attribute!r}")
        module, own = homes[attribute]
        value = import_module(f"{module}.{own}") if _is_module(module, own) else getattr(import_module(module), own)
        setattr(sys.modules[name], attribute, value)
        return value

    return getattr_, lambda: sorted(homes), sorted(homes)


def _listed(stub: Path) -> list[tuple[str, tuple[str, str]]]:
    """Public name, module and name there of every import of a stub."""
    imports = (node for node in ast.parse(stub.read_text(encoding="utf-8")).body if isinstance(node, ast.ImportFrom))
    return [(one.asname or one.name, (node.module or "", one.name)) for node in imports for one in node.names]


def _is_module(package: str, name: str) -> bool:
    """Whether a name of a package of flexmb is one of its modules or sub-packages."""
    folder = Path(__file__).parent.joinpath(*package.split(".")[1:], name)
    return folder.is_dir() or folder.with_suffix(".py").is_file()
