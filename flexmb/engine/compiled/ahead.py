"""Compilation in a second process: large functions there, while this process compiles all others.

    ahead.start(advance)      # where nothing is compiled yet; returns at once
    ...                       # the program, start values and accounts are compiled meanwhile
    advance(...)              # waits for the second process, then reads the function from the cache

The second process knows the types of the arguments from their names, or annotations.  Nothing is started in worker
processes, on one core, without a cache that can be written, or where the first functions are compiled already.
"""

import atexit
import multiprocessing
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import IO, Any, cast, get_type_hints

from numba.core import config
from numba.core.caching import FunctionCache

from flexmb.engine.compiled.code_cache import shipment
from flexmb.engine.compiled.notice import caches, notice
from flexmb.engine.compiled.records import type_of_hint

# Function that every program is compiled with; where it is kept, the time for a second process is over.
FIRST = "flexmb.engine.system.evaluate.evaluate"
ARGUMENTS: dict[str, Any] = {}  # types of arguments by their names, where a function has no annotations
PACKAGE_PARENT = Path(__file__).resolve().parents[3]


class SecondProcess:
    """A process that compiles functions, given by their full names, and names each on its standard output."""

    def __init__(self, names: list[str]) -> None:
        self.began, self.left = time.perf_counter(), list(names)
        paths = [str(PACKAGE_PARENT), *filter(None, [os.environ.get("PYTHONPATH")])]
        environment = {**os.environ, "FLEXMB_MESSAGES": "0", "PYTHONPATH": os.pathsep.join(paths)}
        if config.CACHE_DIR:
            environment["NUMBA_CACHE_DIR"] = config.CACHE_DIR
        self._process = subprocess.Popen(
            command(names), env=environment, text=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )  # fmt: skip
        self._output = cast("IO[str]", self._process.stdout)
        atexit.register(self.stop)

    def wait_for(self, name: str) -> None:
        """Return when a function is compiled, or the process has ended."""
        while name in self.left:
            line = self._output.readline()
            if not line:
                self.stop()
            elif line.strip() in self.left:
                self.left.remove(line.strip())
        if not self.left:
            self.stop()

    def stop(self) -> None:
        """End the process; nothing is waited for any more."""
        self.left = []
        atexit.unregister(self.stop)
        if self._process.poll() is None:
            self._process.terminate()
        self._process.wait()
        self._output.close()


def command(names: list[str]) -> list[str]:
    """Command line of a process that calls `compile_named` with these names, without the working folder in its path."""
    return [sys.executable, "-P", "-c", f"from {__name__} import compile_named; compile_named()", *names]


running: list[SecondProcess] = []  # the second process, if one was started
asked: set[str] = set()  # names of the functions that `start` was asked for; their caches are read once in a process


def start(*functions: Any) -> None:
    """Compile functions with annotated arguments in a second process, if that saves time."""
    names = [f"{one.__module__}.{one.__qualname__}" for one in functions]
    new = [name for name in names if name not in asked]
    asked.update(new)
    names = [name for name in new if name in caches and not caches[name].there()]
    if not names or running or config.DISABLE_JIT or shipment or multiprocessing.parent_process() or cores() < 2:
        return
    if not Path(sys.executable or "").stem.lower().startswith("python"):
        return  # an application that embeds Python
    if isinstance(caches[names[0]].of_user, FunctionCache) and not caches[FIRST].there():
        running.append(SecondProcess(names))


def cores() -> int:
    """Cores that this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)  # not on every platform
    return len(affinity(0)) if affinity else os.cpu_count() or 1


@contextmanager
def finished(function: Any) -> Iterator[None]:
    """Wait for the second process if it compiles a function."""
    name = f"{function.__module__}.{function.__qualname__}"
    for process in running:
        if name in process.left:
            with notice.waiting(name, time.perf_counter() - process.began):
                process.wait_for(name)
    yield


def argument_types(function: Any) -> tuple[Any, ...]:
    """numba's types of the arguments of a function, by annotations or names; `KeyError` names an unknown argument."""
    hints = {**ARGUMENTS, **get_type_hints(function, include_extras=True)}
    return tuple(type_of_hint(hints[name]) for name in signature(function).parameters)


def compile_named() -> None:
    """Compile the functions named on the command line and print each name when its function is kept."""
    for name in sys.argv[1:]:
        module, _, own = name.rpartition(".")
        function = getattr(import_module(module), own)
        function.compile(argument_types(function.py_func))
        print(name, flush=True)
