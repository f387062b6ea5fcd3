"""Files of a command: required packages, writable folders."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from flexmb.errors import MissingPackageError
from flexmb.jobs.files import unwritable

REPORT = "report.html"
"""Name of the page of a run; the pages of diagrams and studies of a motion have the names of their files."""


def require_packages(needed: Mapping[str, tuple[str, str]]) -> None:
    """Refuse to start without the packages that the results need."""
    for package, (purpose, other) in needed.items():
        if find_spec(package) is None:
            text = f"{purpose} need the package {package!r}, which is not installed. Install it: pip install {package}"
            raise MissingPackageError(f"{text},{other}." if other else f"{text}.")


def require_folder(folder: Path) -> None:
    """Create a folder, and refuse to start if it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except (OSError, ValueError) as error:
        raise unwritable(folder, error, "--out") from error
