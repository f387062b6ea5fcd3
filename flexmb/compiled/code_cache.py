"""Cache of compiled code: machine code of the installation, and numba's cache of the user."""

from __future__ import annotations

from typing import Any

from numba.core.caching import FunctionCache, NullCache, _Cache
from numba.core.compiler import CompileResult
from numba.core.runtime.nrt import rtsys
from numba.core.sigutils import normalize_signature

from flexmb.compiled.notice import caches, say_once
from flexmb.compiled.shipped import ours, shipment, shipped
from flexmb.compiled.stamps import stamp

ANNOTATION = 6
"""Place of the annotated source among the parts of a compiled signature that numba keeps."""


class SlimSignature(CompileResult):
    """A compiled signature of which no more is kept than is used again."""

    __slots__ = ()

    def _reduce(self) -> tuple[Any, ...]:
        """Reduced form for the cache, without the annotated source."""
        parts = list(super()._reduce())
        parts[ANNOTATION] = ""
        return tuple(parts)

    def _find_referenced_environments(self) -> list[Any]:
        """Globals of inner functions that are not inlined.

        Those of functions that were inlined are not, and finding them imports half of numba.
        """
        code = str(self.library._final_module)
        return [one for one in super()._find_referenced_environments() if code.count(one.env_name) > 1]


class CodeCache(_Cache):
    """Cache of the compiled signatures of a function of the package, with the interface of numba's caches.

    Nothing is looked up before the first call, and numba's tables of types and functions, which take long to fill, are
    left alone where nothing has to be compiled.

    Parameters
    ----------
    function : the Python function.
    """

    def __init__(self, function: Any) -> None:
        self._function = function
        self._found: Any = None
        caches[f"{function.__module__}.{function.__qualname__}"] = self

    @property
    def of_user(self) -> Any:
        """numba's cache of this user."""
        if self._found is None:
            try:
                self._found = FunctionCache(self._function)
                files = self._found._cache_file
                files._source_stamp = files._source_stamp, stamp(self._function.__module__)
            except RuntimeError:
                say_once("compiled code cannot be kept, since no folder can be written; set NUMBA_CACHE_DIR.")
                self._found = NullCache()
        return self._found

    @property
    def cache_path(self) -> Any:
        """Folder of the user's cache."""
        return self.of_user.cache_path

    def there(self) -> bool:
        """Whether some signature of the function is kept."""
        store = shipped()
        if store is not None and store.has(self._function):
            return True
        return isinstance(self.of_user, FunctionCache) and bool(self.of_user._cache_file._load_index())

    def load_overload(self, signature: Any, target: Any) -> Any:
        """A compiled signature, or None; it is kept by its arguments alone."""
        signature = tuple(normalize_signature(signature)[0])
        rtsys.initialize(target)  # arrays that come from Python are asked for by its functions
        store = shipped()
        found = store.load(self._function, signature, target) if store is not None and ours(self._function) else None
        if found is not None or not isinstance(self.of_user, FunctionCache):
            return found
        with self.of_user._guard_against_spurious_io_errors():
            return self.of_user._load_overload(signature, target)

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep a compiled signature."""
        signature, result = tuple(normalize_signature(signature)[0]), SlimSignature._make(result)
        for one in shipment:
            if ours(self._function):
                one.add(self._function, signature, result)
        self.of_user.save_overload(signature, result)

    def enable(self) -> None:
        """Always on."""

    def disable(self) -> None:
        """Always on."""

    def flush(self) -> None:
        """Empty the user's cache of this function."""
        self.of_user.flush()
