"""Derivatives by the numbers of each kind of part, beside differences of runs with the same fixed steps."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np

import flexmb as fm
from flexmb.design.derivatives import Span, derivatives
from flexmb.design.parameters import ParameterModel
from flexmb.errors import FlexmbError

HERE = Path(__file__).resolve()


def _each_part():
    spec = importlib.util.spec_from_file_location("each_part", HERE.parents[1] / "parts" / "test_check_part.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.BUILT_IN


BUILT_IN = _each_part()
STEP, STEPS = 1e-4, 20
CENTRAL = (-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0)


def numbers_of(part, prefix: str) -> Iterator[str]:
    """Names of the real numbers of a part and of the records in it, but for zeros."""
    for one in fields(part):
        value = getattr(part, one.name)
        if not one.init or one.name == "name":
            continue
        if isinstance(value, float) and value != 0.0 and str(one.type) in ("float", "float | None"):
            yield f"{prefix}.{one.name}"
        elif is_dataclass(value) and not isinstance(value, (fm.Part, type)):
            yield from numbers_of(value, f"{prefix}.{one.name}")


def compared(mechanism: fm.Mechanism, name: str) -> float:
    """Largest error of the derivative of any coordinate or joint force, over the largest of its kind; nan: refused."""
    try:
        held = ParameterModel("test", mechanism, [name])
        signals = [s.name for s in fm.compile(mechanism).names.signals if s.units in KINDS]
        span = Span(STEP * STEPS, None, STEPS // 4, STEP, None)
        found = derivatives("test", held, span, signals, every=False)
    except FlexmbError as error:
        return str(error)
    value = held.values[0]
    h, expected = 1e-3 * abs(value), 0.0
    for place, weight in CENTRAL:
        sol = fm.simulate(held.at([value + place * h]), t_end=STEP * STEPS, save=list(found.times), step=STEP)
        expected = expected + weight / h * np.stack([np.asarray(sol[s]) for s in signals], axis=1)
    units = np.array(found.units)
    worst = 0.0
    for unit in set(found.units):
        own = units == unit
        size = max(np.abs(expected[:, own]).max(), LEAST * KINDS[unit] / abs(value))
        worst = max(worst, np.abs(found.slopes[:, 0, own] - expected[:, own]).max() / size)
    return worst


KINDS = {"m": 0.1, "rad": 0.1, "m/s": 0.01, "rad/s": 0.1, "N": 1.0, "N m": 0.1}
"""Units of the signals that are compared, and usual sizes of these signals in the two thousandths of a second."""

LEAST = 1e-2
"""Relative derivative below which a derivative is compared with the size of the signal."""
