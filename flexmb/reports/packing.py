"""Arrays as compressed texts inside a page.

A column becomes whole numbers between 0, its smallest value, and some thousands or millions, its largest value; or the
bits of its floats.
The differences from row to row, byte by byte, are compressed (zlib) and written as base64.  `decode.js` reads them.
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np

COARSE, MIDDLE, FINE = 2**10 - 1, 2**12 - 1, 2**24 - 1
"""Steps between the smallest and the largest value: of colours, of lengths on a screen, of coordinates."""

FLOAT = 4
"""Bytes of a float of single precision, which keeps seven digits."""


def quantised(values: np.ndarray, steps: int, *, common: bool = False) -> dict[str, Any]:
    """Columns (n, m) of finite numbers as whole ones; the error is at most half a step of the range of a column.

    `steps` are `COARSE`, `MIDDLE` or `FINE`; `common`: all columns have one range.
    """
    n, m = values.shape
    low, high = (values.min(axis=0), values.max(axis=0)) if n else (np.zeros(m), np.zeros(m))
    if common and m:
        low, high = np.full(m, low.min()), np.full(m, high.max())
    step = (high - low) / steps
    whole = np.rint((values - low) / np.where(step > 0.0, step, 1.0)).astype(np.uint32)
    kept = 1 if common and m else m
    size = 2 if steps < 2**16 else 3
    scale = {"low": _short(low[:kept]), "step": _short(step[:kept])}
    return {"n": n, "m": m, "size": size, **scale, "data": _compressed(whole, size)}


def floats(values: np.ndarray) -> dict[str, Any]:
    """Columns (n, m) as floats of single precision; numbers that are not finite remain so."""
    n, m = values.shape
    with np.errstate(over="ignore"):
        bits = np.ascontiguousarray(values, dtype=np.float32).view(np.uint32)
    return {"n": n, "m": m, "size": FLOAT, "data": _compressed(bits.reshape(n, m), FLOAT)}


def instants(times: np.ndarray) -> dict[str, Any]:
    """Times (n,) as floats of double precision."""
    raw = np.ascontiguousarray(times, dtype="<f8").view(np.uint8).reshape(-1, 8)
    return {"n": len(times), "size": 8, "data": _text(raw.T.tobytes())}


def _compressed(whole: np.ndarray, size: int) -> str:
    """Differences of whole numbers (n, m) along the rows, column by column, lowest bytes first."""
    first = np.zeros((1, whole.shape[1]), dtype=np.uint32)
    steps = np.diff(whole, axis=0, prepend=first)  # modulo 2^32
    columns = np.ascontiguousarray(steps.T.astype("<u4")).view(np.uint8).reshape(-1, 4)
    return _text(columns[:, :size].T.tobytes())


def _text(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode("ascii")


def _short(numbers: np.ndarray) -> list[float]:
    """Numbers with nine digits, which is finer than a step."""
    return [float(f"{x:.9g}") for x in numbers]
