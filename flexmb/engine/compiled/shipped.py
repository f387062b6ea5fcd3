"""Machine code of an installation: one file of code, one index with its sources and versions.

The code is made for a generic processor (`make wheel`) and used only where everything fits: the versions of
numba, llvmlite and Python, the sources of the package, the platform, what the processor can do.  Else functions are
compiled when they are first called, and this is said once.  FLEXMB_SHIPPED=0 leaves shipped code alone.
"""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import sys
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as ll
import numba
from numba.core import config
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from flexmb.engine.compiled.notice import say
from flexmb.namespace import CHANGED, IMPORTED, states

PACKAGE = Path(__file__).resolve().parents[2]
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
        if index["sources"] != sources(PACKAGE):
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
        index = {**about, "sources": sources(PACKAGE), "size": begin, "code": places}
        (folder / INDEX).write_text(json.dumps(index, indent=1), encoding="utf-8")
        return list(places), begin


shipment: list[Shipment] = []  # the shipment that is being made, if any
