"""Packages that take long to import: each of them is imported at the first use of a name of it."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__all__ = ["h5py", "meshio", "mpl", "pd", "pyvista", "scipy", "sp", "xr"]


class Late:
    """A package, imported at the first use of a name."""

    def __init__(self, package: str) -> None:
        self._package = package

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):  # questions of inspect and copy, which packages do not answer either
            raise AttributeError(name)
        value = getattr(import_module(self._package), name, None) or import_module(f"{self._package}.{name}")
        setattr(self, name, value)
        return value


if TYPE_CHECKING:
    import h5py
    import matplotlib as mpl
    import meshio
    import pandas as pd
    import pyvista
    import scipy.integrate
    import scipy.interpolate
    import scipy.linalg.lapack
    import scipy.ndimage
    import scipy.optimize
    import scipy.signal
    import scipy.sparse as sp
    import scipy.sparse.csgraph
    import scipy.sparse.linalg
    import scipy.spatial.distance
    import scipy.stats
    import xarray as xr
else:
    h5py, meshio, mpl, pd, pyvista = map(Late, ("h5py", "meshio", "matplotlib", "pandas", "pyvista"))
    scipy, sp, xr = map(Late, ("scipy", "scipy.sparse", "xarray"))
