"""Source of a mechanism: a ready one by its name, or FILE.py[:NAME]."""

from __future__ import annotations

import argparse
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

from flexmb import checks, mechanisms
from flexmb.commands.arguments.mechanism_options import options_of, shown_default
from flexmb.commands.arguments.settings import changed
from flexmb.errors import USER_ERRORS, FlexmbError, InputError
from flexmb.model.mechanism import Mechanism

NAMES = ("mech", "mechanism")
"""Default names of a mechanism in a file."""


def _no_parameters(mechanism: Mechanism) -> Callable[[], Mechanism]:
    def make() -> Mechanism:
        return mechanism

    return make


@dataclass(frozen=True)
class Source:
    """A function that returns a mechanism, and a short name for files.

    Parameters
    ----------
    name : name of the ready mechanism, or of the file without its ending.
    make : the function; its parameters become options.
    file : file of the mechanism; None for a ready one.
    """

    name: str
    make: Callable[..., Any]
    file: Path | None = None

    def with_changes(self, texts: Sequence[str]) -> Source:
        """The source with changed fields of parts, typed as "PART.FIELD=VALUE"."""
        return replace(self, make=Changed(self.make, tuple(texts))) if texts else self

    def mechanism(self, keywords: dict[str, Any]) -> Mechanism:
        """Mechanism of the function with given arguments."""
        try:
            inspect.signature(self.make).bind(**keywords)
        except TypeError as error:
            text = f"{self.name}: the function cannot be called with what was typed: {error}."
            raise InputError(
                f"{text} Give its parameters defaults, or annotate them float, int, bool or str."
            ) from error
        try:
            mechanism = self.make(**keywords)
        except FlexmbError:
            raise
        except USER_ERRORS as error:
            if self.file is None:
                raise
            raise InputError(f"{self.file}, {_told(error, self.file)}") from error
        if not isinstance(mechanism, Mechanism):
            raise InputError(
                f"{self.name}: the function returned {type(mechanism).__name__}; it must return a Mechanism."
            )
        return mechanism


@dataclass(frozen=True)
class Changed:
    """Function that returns a mechanism with changed fields; it takes the arguments of another one.

    Parameters
    ----------
    make : the other function.
    texts : changes as they are typed, "PART.FIELD=VALUE".
    """

    make: Callable[..., Any]
    texts: tuple[str, ...]

    def __call__(self, **keywords: Any) -> Mechanism:
        """The changed mechanism of the other function's `keywords`."""
        return changed(self.make(**keywords), self.texts)

    @property
    def __signature__(self) -> inspect.Signature:
        return inspect.signature(self.make)


def ready() -> dict[str, Callable[..., Any]]:
    """Ready mechanisms by the name on the command line: functions that return a mechanism."""
    public = {name: getattr(mechanisms, name) for name in mechanisms.__all__}
    makers = {name: make for name, make in public.items() if inspect.isfunction(make)}
    return {name.replace("_", "-"): make for name, make in makers.items() if returns_mechanism(make)}


def returns_mechanism(make: Callable[..., Any]) -> bool:
    """Whether the annotated result of a function `make` is a Mechanism."""
    return inspect.signature(make).return_annotation in (Mechanism, Mechanism.__name__)


def find(text: str) -> Source:
    """Source of a mechanism from a text: "nine-bar", "FILE.py", or "FILE.py:NAME".

    The name is that of a Mechanism or of a function that returns one.
    """
    path, colon, name = text.rpartition(":") if ".py:" in text else (text, "", "")
    if path.endswith(".py"):
        return _from_file(Path(path), name if colon else None)
    makers = ready()
    plain = text.replace("_", "-")
    if plain in makers:
        return Source(plain, makers[plain])
    hint = checks.did_you_mean(plain, makers)
    raise InputError(f"{text!r} is no mechanism and no file ending in .py. {hint}")


def _from_file(path: Path, name: str | None) -> Source:
    module = _load(path)
    names = [name] if name is not None else [n for n in NAMES if n in vars(module)]
    usable = [n for n, value in vars(module).items() if _is_source(value, module)]
    if not names:
        alone = [n for n in usable if isinstance(vars(module)[n], Mechanism)]
        names = alone if len(alone) == 1 else []
    if not names or not _is_source(vars(module).get(names[0]), module):
        wanted = f"no mechanism {name!r}" if name else "no mechanism `mech`"
        offer = f"It has: {', '.join(usable)}." if usable else "Write mech = fm.Mechanism(...) in it."
        raise InputError(f"{path}: the file has {wanted}. {offer} Choose with {path}:NAME.")
    value = vars(module)[names[0]]
    make = _no_parameters(value) if isinstance(value, Mechanism) else value
    return Source(path.stem if name is None else f"{path.stem}-{name}", make, path)


def _is_source(value: Any, module: ModuleType) -> bool:
    own = inspect.isfunction(value) and value.__module__ == module.__name__
    return own or isinstance(value, Mechanism)


def _load(path: Path) -> ModuleType:
    """Module of a file; the block `if __name__ == "__main__"` is not executed."""
    if not path.is_file():
        raise InputError(f"{path}: there is no such file. Check the path, or see `flexmb list` for ready mechanisms.")
    spec = importlib.util.spec_from_file_location(f"flexmb_model_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise InputError(f"{path}: Python cannot load this file.")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses and pickle find the module of a class by name
    folder = str(path.resolve().parent)
    if folder not in sys.path:
        sys.path.insert(0, folder)  # as for a script: files beside it can be imported
    try:
        spec.loader.exec_module(module)
    except (SyntaxError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not a Python file: {error}.") from error
    except SystemExit as error:
        text = f"{path}, line {_line_in(path, error)}: the file ends Python (sys.exit({error.code!r})) while it is read"
        raise InputError(f'{text}. Put what a script does under `if __name__ == "__main__":`.') from error
    except ModuleNotFoundError:
        raise  # told with the command that installs the package
    except FlexmbError as error:
        raise InputError(f"{path}, line {_line_in(path, error)}: {error}") from error
    except USER_ERRORS as error:
        raise InputError(f"{path}, {_told(error, path)}") from error
    return module


def _told(error: BaseException, path: Path) -> str:
    """Line, class and text of an error in a user's file."""
    text = str(error).rstrip(".")
    return f"line {_line_in(path, error)}: {type(error).__name__}: {text}. --debug shows the traceback."


def _line_in(path: Path, error: BaseException) -> int:
    """Last line of a file in the traceback of an error."""
    frames = traceback.extract_tb(error.__traceback__)
    return next((frame.lineno or 0 for frame in reversed(frames) if Path(frame.filename) == path.resolve()), 0)


def list_mechanisms(options: argparse.Namespace) -> int:
    """`flexmb list`: print every ready mechanism with its `options`."""
    for name, make in ready().items():
        print(f"{name}: {(inspect.getdoc(make) or '').splitlines()[0]}")
        for option in options_of(make):
            print(f"    {option.flag:<18s}{option.help}{shown_default(option)}")
        print()
    print("Run one of them:      flexmb run NAME [options]")
    print("or a mechanism of your own:  flexmb new NAME, flexmb run NAME.py")
    return 0
