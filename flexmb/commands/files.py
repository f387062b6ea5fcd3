"""Files of a command: required packages, writable folders, netCDF files."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from flexmb.errors import InputError, MissingPackageError

if TYPE_CHECKING:
    import xarray as xr


def require_packages(needed: Mapping[str, tuple[str, str]]) -> None:
    """Refuse to start without the packages that the results need.

    Parameters
    ----------
    needed : purpose and advice by package.

    Raises
    ------
    MissingPackageError : a package that is not installed.
    """
    for package, (purpose, other) in needed.items():
        if find_spec(package) is None:
            text = f"{purpose} need the package {package!r}, which is not installed. Install it: pip install {package}"
            raise MissingPackageError(f"{text},{other}." if other else f"{text}.")


def require_folder(folder: Path) -> None:
    """Create a folder, and refuse to start if it cannot be written.

    Parameters
    ----------
    folder : the folder.

    Raises
    ------
    InputError : a folder that cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        text = f"--out: {str(folder)!r} cannot be written ({error.strerror or error})."
        raise InputError(f"{text} Give a writable folder.") from error


def write_netcdf(path: Path, groups: Mapping[str, xr.Dataset]) -> Path:
    """Write datasets as groups of one file; after an interruption either the old or the new file is complete.

    Parameters
    ----------
    path : the file; it is written under another name and then renamed.
    groups : datasets by name of the group; "" is the root.
    """
    part = path.with_name(f".{path.name}.part")
    part.unlink(missing_ok=True)
    for name, dataset in groups.items():
        dataset.to_netcdf(part, engine="h5netcdf", group=name or None, mode="a" if part.exists() else "w")
    part.replace(path)
    return path
