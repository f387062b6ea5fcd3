"""Cache of compiled code: stamps of sources, machine code of the installation, numba's cache of the user.

numba looks at the file of the function alone.  Functions that are called, and constants that are frozen into the code,
lie in other files: here every file counts that the module of the function imports, directly or through others, but for
those of the standard library and of other installed packages.

Machine code of an installation is one file of code, one index with its sources and versions.  It is made for a generic
processor (`make wheel`) and used only where everything fits: the versions of numba, llvmlite and Python, the sources of
the package, the platform, what the processor can do.  Else functions are compiled when they are first called, and this
is said once.  FLEXMB_SHIPPED=0 leaves shipped code alone.
"""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import blake2b
from importlib.util import resolve_name
from pathlib import Path
from sysconfig import get_path
from typing import Any

import llvmlite
import llvmlite.binding as ll
import numba
from numba.core import config
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache, _Cache
from numba.core.compiler import CompileResult
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps
from numba.core.sigutils import normalize_signature

from flexmb.engine.compiled.notice import caches, say, say_once
from flexmb.namespace import CHANGED, IMPORTED, state, states

PACKAGE_FOLDER = Path(__file__).resolve().parents[2]
FOLDER = Path(__file__).resolve().parent / "shipped"
INDEX, CODE = "index.json", "code.bin"

# LLVM's names of what a generic processor can do, for which code is made.
V3 = "avx avx2 bmi bmi2 cmov cx16 f16c fma fxsr lzcnt mmx movbe popcnt sahf sse sse2 sse3 sse4.1 sse4.2 ssse3 xsave"
REQUIRED_FEATURES = {"x86-64-v3": V3.split()}


def key(function: Any, signature: tuple[Any, ...]) -> str:
    """Name in the index of a function compiled for arguments of these types."""
    return f"{function.__module__}.{function.__qualname__} {signature}"


def ours(function: Any) -> bool:
    """Whether a function belongs to the package and is no closure."""
    return str(function.__module__).startswith("flexmb.") and function.__closure__ is None


def sources(package: Path) -> str:
    """Digest of all source files of the package: any of them may be part of a compiled function."""
    files = []
    for folder, _, names in os.walk(package):
        files += [os.path.join(folder, name) for name in names if name.endswith(".py")]  # noqa: PTH118 - half the time
    digest, root = hashlib.sha256(), len(str(package)) + 1
    for file in sorted(files):
        with open(file, "rb") as opened:  # noqa: PTH123 - half the time
            digest.update(file[root:].encode() + b"\0" + opened.read() + b"\0")
    return digest.hexdigest()


def made_with() -> dict[str, str]:
    """Versions on which compiled code depends: numba, llvmlite, Python, platform."""
    python = f"{sys.implementation.name} {sys.version_info[0]}.{sys.version_info[1]}"
    made = {"numba": numba.__version__, "llvmlite": llvmlite.__version__}
    return {**made, "Python": python, "platform": ll.get_process_triple()}


class Shipped:
    """Machine code of an installation; `ValueError` if its files are not there, cannot be read or do not fit."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / CODE
        try:
            index = json.loads((folder / INDEX).read_text(encoding="utf-8"))
            whole = self._file.stat().st_size == index["size"]
        except FileNotFoundError as error:
            raise ValueError(f"{Path(error.filename).name} is not there") from error
        except KeyError as error:
            raise ValueError(f"{INDEX} has no {error}") from error
        except (OSError, ValueError) as error:
            raise ValueError(f"{INDEX} cannot be read ({error})") from error
        if not whole:
            raise ValueError(f"{CODE} is not whole")
        for name, now in made_with().items():
            if index["made_with"][name] != now:
                raise ValueError(f"it was made with {name} {index['made_with'][name]}, here is {now}")
        missing = [name for name in index["needs"] if not ll.get_host_cpu_features().get(name)]
        if missing:
            raise ValueError(f"this processor lacks {', '.join(missing)}")
        if states() != IMPORTED:
            raise ValueError(CHANGED)
        if index["sources"] != sources(PACKAGE_FOLDER):
            raise ValueError("it was made of other sources")
        self._places: dict[str, tuple[int, int, str]] = index["code"]
        self._names = {name.partition(" ")[0] for name in self._places}

    def has(self, function: Any) -> bool:
        """Whether any signature of a function is there."""
        return f"{function.__module__}.{function.__qualname__}" in self._names

    def load(self, function: Any, signature: Any, target: Any) -> Any:
        """The compiled signature, or None if it is not there or damaged."""
        place = self._places.get(key(function, signature))
        if place is None:
            return None
        begin, size, digest = place
        with self._file.open("rb") as file:
            file.seek(begin)
            data = file.read(size)
        if hashlib.sha256(data).hexdigest() != digest:
            _refuse(f"{CODE} is damaged")
            return None
        return CompileResult._rebuild(target, *pickle.loads(data))  # noqa: S301 - its digest is the index's


@cache
def shipped() -> Shipped | None:
    """The code of this installation, or None where there is none that can be used."""
    if os.environ.get("FLEXMB_SHIPPED") == "0" or config.DISABLE_JIT or config.CPU_NAME or not FOLDER.is_dir():
        return None
    try:
        return Shipped(FOLDER)
    except ValueError as error:
        _refuse(str(error))
    except (LookupError, TypeError, AttributeError) as error:
        _refuse(f"{INDEX} is damaged ({error!r})")
    return None


@cache
def _refuse(why: str) -> None:
    """Say once why the code is not used."""
    say(f"the compiled code of this installation is not used: {why}. It is compiled for this machine instead.")


class Shipment:
    """Collector of code that is compiled for a processor (`cpu`), for an installation."""

    def __init__(self, cpu: str) -> None:
        self.cpu = cpu
        self._code: dict[str, bytes] = {}

    def add(self, function: Any, signature: Any, result: Any) -> None:
        """Take a compiled signature in."""
        self._code[key(function, signature)] = dumps(result._reduce())

    def write(self, folder: Path) -> tuple[list[str], int]:
        """Write index and code; names of the functions, and bytes."""
        folder.mkdir(parents=True, exist_ok=True)
        places, begin = {}, 0
        with (folder / CODE).open("wb") as file:
            for name, data in sorted(self._code.items()):
                places[name] = begin, len(data), hashlib.sha256(data).hexdigest()
                begin += file.write(data)
        about = {"made_with": made_with(), "cpu": self.cpu, "needs": REQUIRED_FEATURES[self.cpu]}
        index = {**about, "sources": sources(PACKAGE_FOLDER), "size": begin, "code": places}
        (folder / INDEX).write_text(json.dumps(index, indent=1), encoding="utf-8")
        return list(places), begin


shipment: list[Shipment] = []  # the shipment that is being made, if any


IMPORT = re.compile(r"^(?:from +([\w.]+) +import +(\([^)]*\)|[^\n#]*)|import +([^\n#]*))", re.MULTILINE)
NAME = re.compile(r"[\w.]+")
PACKAGE = "flexmb"
STANDARD = tuple({str(Path(get_path(name)).resolve()) for name in ("stdlib", "platstdlib")})
# Folders of installed packages.
INSTALLED = {"site-packages", "dist-packages"}


class SourcesChangedError(RuntimeError):
    """Sources of another state than at their import."""


def stamp(module: str) -> str:
    """Digest of the sources of a module and of all that importing it needs."""
    found, todo = set[str](), [module]
    while todo:
        name = todo.pop()
        if name not in found:
            found.add(name)
            todo.extend(_source(name)[1])
    return hashlib.sha256("".join(_source(name)[0] for name in sorted(found)).encode()).hexdigest()


@cache
def _source(module: str) -> tuple[str, frozenset[str]]:
    """Digest of the file of a module, and its imports; empty for installed modules and without a file."""
    file = getattr(sys.modules.get(module), "__file__", None)
    own = module.partition(".")[0] == PACKAGE
    if file is None or not (own or is_users_file(file)):
        return "", frozenset()
    data = b""
    with suppress(OSError):  # in an archive
        data = Path(file).read_bytes()
    if file in IMPORTED and state(file) != IMPORTED[file]:
        say_once(f"compiled code is neither read nor kept: {CHANGED}.")
        raise SourcesChangedError
    text, names = data.decode(errors="replace"), set[str]()
    package = getattr(sys.modules[module], "__package__", None) or ""
    for base, listed, whole in IMPORT.findall(text):
        if base:
            home = resolve_name(base, package) if base.startswith(".") else base
            names |= {home, *(f"{home}.{name}" for name in NAME.findall(listed))}
        else:
            names.update(NAME.findall(whole))
    return hashlib.sha256(data).hexdigest(), frozenset(names & sys.modules.keys())


@cache
def is_users_file(file: str) -> bool:
    """Whether a file belongs neither to Python nor to an installed package."""
    path = Path(file).resolve()
    return not (str(path).startswith(STANDARD) or INSTALLED.intersection(path.parts))


def is_of_user(module: str) -> bool:
    """Whether a module belongs neither to Python nor to an installed package, nor to flexmb."""
    found = sys.modules.get(module)
    if found is None or module == "__main__":
        return True
    file = getattr(found, "__file__", None) or next(iter(getattr(found, "__path__", ())), None)  # of a namespace
    return module.partition(".")[0] != PACKAGE and file is not None and is_users_file(file)


ANNOTATION = 6  # place of the annotated source among the parts of a compiled signature that numba keeps
SEAL_SIZE = 16  # bytes of the checksum of a file of the cache


class SlimSignature(CompileResult):
    """A compiled signature of which no more is kept than is used again."""

    __slots__ = ()

    def _reduce(self) -> tuple[Any, ...]:
        """Reduced form for the cache, without the annotated source."""
        parts = list(super()._reduce())
        parts[ANNOTATION] = ""
        return tuple(parts)

    def _find_referenced_environments(self) -> list[Any]:
        """Globals of inner functions that are not inlined."""
        # Those of functions that were inlined are not, and finding them imports half of numba.
        code = str(self.library._final_module)
        return [one for one in super()._find_referenced_environments() if code.count(one.env_name) > 1]


class SealedFiles(IndexDataCacheFile):
    """Index and data files of a function, each behind its checksum; a damaged file counts as missing."""

    # A data file names its sources and its signature and is written before the index, which never leads to other code.

    def load(self, key: Any) -> Any:
        """Compiled signature of a key, or None."""
        name = self._load_index().get(key)
        found = None if name is None else self._read(self._data_path(name))
        return found[-1] if found and found[:-1] == (self._source_stamp, key) else None

    def save(self, key: Any, data: Any) -> None:
        """Write a compiled signature, and then the index."""
        names = self._load_index()
        free = (self._data_name(k) for k in range(1, len(names) + 2))
        name = names.get(key) or next(one for one in free if one not in names.values())
        self._write(self._data_path(name), (self._source_stamp, key, data))
        self._save_index({**names, key: name})

    def _load_index(self) -> dict[Any, str]:
        version, stamp, names = self._read(self._index_path) or (None, None, {})
        return names if (version, stamp) == (self._version, self._source_stamp) else {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._write(self._index_path, (self._version, self._source_stamp, overloads))

    def _write(self, path: str, content: Any) -> None:
        data = self._dump(content)
        with self._open_for_write(path) as file:
            file.write(blake2b(data, digest_size=SEAL_SIZE).digest() + data)

    def _read(self, path: str) -> Any:
        """Content of a file; None for a missing or damaged file."""
        try:
            content = Path(path).read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            say_once(f"compiled code in {self._cache_path} cannot be read ({error.strerror}). It is compiled anew.")
            return None
        data = memoryview(content)[SEAL_SIZE:]
        if blake2b(data, digest_size=SEAL_SIZE).digest() != content[:SEAL_SIZE]:
            say_once(f"compiled code in {self._cache_path} is damaged. It is compiled anew.")
            return None
        return pickle.loads(data)  # noqa: S301 - its digest is that of a file of this class


class SealedCache(FunctionCache):
    """numba's cache of a function, with checksums and without errors of the file system."""

    # `content` is the digest of all values that are frozen into its code, besides its sources.

    def __init__(self, function: Any, content: str = "") -> None:
        super().__init__(function)
        files: Any = self._cache_file
        base = files._index_name.removesuffix(".nbi")
        stamps = files._source_stamp, stamp(function.__module__)
        self._cache_file: Any = SealedFiles(files._cache_path, f"{base}.sealed", stamps)
        self._content = content

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        return *super()._index_key(sig, codegen), self._content

    @contextmanager
    def _guard_against_spurious_io_errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            text = f"compiled code cannot be kept in {self.cache_path} ({error.strerror or error})"
            say_once(f"{text}; make room, or set NUMBA_CACHE_DIR.")


class CodeCache(_Cache):
    """Cache of the compiled signatures of a function of the package, with the interface of numba's caches."""

    # Nothing is looked up before the first call, and numba's tables of types and functions, which take long to fill,
    # are left alone where nothing has to be compiled.

    def __init__(self, function: Any) -> None:
        self._function = function
        self._found: Any = None
        caches[f"{function.__module__}.{function.__qualname__}"] = self

    @property
    def of_user(self) -> Any:
        """numba's cache of this user."""
        if self._found is None:
            try:
                self._found = SealedCache(self._function)
            except SourcesChangedError:
                self._found = NullCache()
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
