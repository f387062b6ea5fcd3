"""Files of a command: packages that they need, and whether they can be written."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from flexmb.errors import InputError, MissingPackageError


def require_packages(needed: Mapping[str, tuple[str, str]]) -> None:
    """Refuse before a long run, not after it; by package what it is needed for, and how to do without."""
    for package, (purpose, other) in needed.items():
        if find_spec(package) is None:
            text = f"{purpose} need the package {package!r}, which is not installed. Install it: pip install {package}"
            raise MissingPackageError(f"{text},{other}." if other else f"{text}.")


def require_folder(folder: Path) -> None:
    """Refuse before a long run a folder that cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        text = f"--out: {str(folder)!r} cannot be written ({error.strerror or error})."
        raise InputError(f"{text} Give a writable folder.") from error
