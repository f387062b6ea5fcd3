"""Source of a mechanism, and fields of parts set on the command line."""

from __future__ import annotations

import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, is_dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

from flexmb import checks, mechanisms
from flexmb.cli.arguments.parser import Option, options_of
from flexmb.errors import USER_ERRORS, FlexmbError, InputError
from flexmb.model.mechanism import Mechanism, require_field
from flexmb.model.part import Part


class Field(Option):
    """A field of a part as an option; `name` is that of the option and the path of the field."""

    @property
    def flag(self) -> str:
        """The option and the field as they are typed: "--set B.bearing_radius"."""
        return f"--{self.name}"


GRAVITY = Field("set gravity", "numbers", None, "m/s^2", "")
TRUTH = {"true": True, "yes": True, "on": True, "1": True, "false": False, "no": False, "off": False, "0": False}


def changed(mechanism: Mechanism, texts: Sequence[str]) -> Mechanism:
    """The mechanism with changed fields: "crank.mass=200g", "B.normal.restitution=0.8", "gravity=0,-9.81"."""
    changes: dict[str, Any] = {}
    for text in texts:
        path, equals, value = text.partition("=")
        if not equals or not value:
            raise InputError(f"--set: {text!r} has no value; give PART.FIELD=VALUE, e.g. crank.mass=200g.")
        option = field_option(mechanism, path, "set")
        if option.kind == "flag":
            changes[path] = TRUTH[checks.one_of(option.flag, "value", value.lower(), TRUTH)]
        else:
            changes[path] = option.value(value.strip("()[]") if option.kind == "numbers" else value)
    return mechanism.with_(changes) if isinstance(mechanism, Mechanism) and changes else mechanism


def field_option(mechanism: Mechanism, path: str, flag: str) -> Option:
    """The field of a part as an option, with the kind and the unit that its class declares."""
    # The path is "PART.FIELD", "PART.FIELD.FIELD", or "gravity"; `flag`: the option that names the field, for messages.
    if path == "gravity":
        return GRAVITY
    name, _, rest = path.partition(".")
    label = f"--{flag}: {path!r}"
    if not rest:
        raise InputError(f"{label} names no field; give PART.FIELD. Parts: {', '.join(mechanism.names)}.")
    owner: Any = mechanism.find(name)
    *inner, last = rest.split(".")
    for field in inner:
        owner = getattr(owner, require_field(label, field, owner))
        if not is_dataclass(owner):
            raise InputError(f"{label}: {field!r} has no fields of its own.")
    value = getattr(owner, require_field(label, last, owner))
    found = next((option for option in options_of(type(owner)) if option.name == last), None)
    if found is None or isinstance(value, Part) or is_dataclass(value):
        text = f"{label}: {last!r} is {type(value).__name__}, which cannot be typed"
        raise InputError(f"{text}. Change it in a file of your own with mech.with_ or mech.with_part.")
    return Field(f"{flag} {path}", found.kind, found.default, found.unit, found.help)


NAMES = ("mech", "mechanism")  # default names of a mechanism in a file


@dataclass(frozen=True)
class Source:
    """A function that returns a mechanism, and a short name for files."""

    name: str  # name of the ready mechanism, or of the file without its ending
    make: Callable[..., Any]  # the function; its parameters become options
    file: Path | None = None  # file of the mechanism; None for a ready one

    def with_changes(self, texts: Sequence[str]) -> Source:
        """The source with changed fields of parts, typed as "PART.FIELD=VALUE"."""
        return replace(self, make=Changed(self.make, tuple(texts))) if texts else self

    def mechanism(self, keywords: dict[str, Any]) -> Mechanism:
        """Mechanism of the function with given arguments."""
        try:
            inspect.signature(self.make).bind(**keywords)
        except TypeError as error:
            text = f"{self.name}: the function cannot be called with what was typed: {error}. Give its parameters"
            raise InputError(f"{text} defaults, or annotate them float, int, bool or str.") from error
        try:
            mechanism = self.make(**keywords)
        except FlexmbError:
            raise
        except USER_ERRORS as error:
            if self.file is None:
                raise
            raise InputError(f"{self.file}, {_told(error, self.file)}") from error
        if not isinstance(mechanism, Mechanism):
            kind = type(mechanism).__name__
            raise InputError(f"{self.name}: the function returned {kind}; it must return a Mechanism.")
        return mechanism


@dataclass(frozen=True)
class Changed:
    """Function that makes a mechanism as another one does, with changes as they are typed, "PART.FIELD=VALUE"."""

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
    public = {name.replace("_", "-"): getattr(mechanisms, name) for name in mechanisms.__all__}
    makers = {name: make for name, make in public.items() if inspect.isfunction(make)}
    results = (Mechanism, Mechanism.__name__)
    return {name: make for name, make in makers.items() if inspect.signature(make).return_annotation in results}


def find(text: str) -> Source:
    """Source of a text: "nine-bar", "FILE.py", or "FILE.py:NAME" of a Mechanism or a function that returns one."""
    path, colon, name = text.rpartition(":") if ".py:" in text else (text, "", "")
    if not path.endswith(".py"):
        makers, plain = ready(), text.replace("_", "-")
        if plain in makers:
            return Source(plain, makers[plain])
        raise InputError(f"{text!r} is no mechanism and no file ending in .py. {checks.did_you_mean(plain, makers)}")
    file, module = Path(path), _load(Path(path))
    own = [n for n, value in vars(module).items() if inspect.isfunction(value) and value.__module__ == module.__name__]
    usable = [n for n, value in vars(module).items() if n in own or isinstance(value, Mechanism)]
    alone = [n for n in usable if isinstance(vars(module)[n], Mechanism)]
    names = [name] if colon else [n for n in NAMES if n in vars(module)]
    names = names or (alone if len(alone) == 1 else [])
    if not names or names[0] not in usable:
        wanted = f"no mechanism {name!r}" if name else "no mechanism `mech`"
        offer = f"It has: {', '.join(usable)}." if usable else "Write mech = fm.Mechanism(...) in it."
        raise InputError(f"{file}: the file has {wanted}. {offer} Choose with {file}:NAME.")
    value = vars(module)[names[0]]
    make = (lambda: value) if isinstance(value, Mechanism) else value
    return Source(f"{file.stem}-{name}" if colon else file.stem, make, file)


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
