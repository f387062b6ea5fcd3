"""Versions of the installed package, and of numba as it compiles for it."""

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version

# Versions of numba, from and below, whose inner pipeline is known here: others compile some five times as long.
FAST_NUMBA = ((0, 68), (0, 69))


@cache
def installed_version() -> str:
    """Version of flexmb, "unknown" when it is not installed."""
    try:
        return version("flexmb")
    except PackageNotFoundError:
        return "unknown"


def compiles_fast(numba_version: str) -> bool:
    """Whether pieces of compiled code can be made with a version of numba (`flexmb/engine/compiled/pieces.py`)."""
    major, minor = (int(part) for part in numba_version.split(".")[:2])
    return FAST_NUMBA[0] <= (major, minor) < FAST_NUMBA[1]


def versions() -> str:
    """Line on the versions of flexmb, Python and numba, and whether this numba compiles fast."""
    numba_version, fast = version("numba"), ".".join(map(str, FAST_NUMBA[0]))
    how = "compiles fast" if compiles_fast(numba_version) else f"compiles slowly; fast is {fast}"
    return f"flexmb {installed_version()}, Python {platform.python_version()}, numba {numba_version} ({how})"


__version__ = installed_version()
