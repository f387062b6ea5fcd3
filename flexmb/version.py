"""Version of the installed package."""

from functools import cache
from importlib.metadata import PackageNotFoundError, version


@cache
def installed_version() -> str:
    """Version of flexmb, "unknown" when it is not installed."""
    try:
        return version("flexmb")
    except PackageNotFoundError:
        return "unknown"
