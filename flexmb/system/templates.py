"""Templates of records of zeros, remembered for each structure of programs."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from flexmb.compiled.records import Record
from flexmb.linalg.symbolic import Symbolic
from flexmb.program.program import Program

R = TypeVar("R", bound=Record)

_TEMPLATES: WeakKeyDictionary[Symbolic, dict[Hashable, Any]] = WeakKeyDictionary()


def new_from_template(program: Program, key: Hashable, make: Callable[[], R], **records: Record) -> R:
    """A new record like the result of `make`, which is called once for each structure of programs and `key`.

    The result of `make` depends on the structure and the key alone; `records` replace inner records.
    """
    known = _TEMPLATES.setdefault(program.symbolic, {})
    if key not in known:
        known[key] = make()
    found: R = known[key].twin(**records)
    return found
