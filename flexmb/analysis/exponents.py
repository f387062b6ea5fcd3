"""Lyapunov exponents as a record, and what they and their errors are computed from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flexmb.analysis.seen import Seen
from flexmb.analysis.verdict import Verdict
from flexmb.errors import InputError

BLOCKS = 20
FEWEST = 50
"""Periods (iterations, crossings, intervals) that an estimate needs."""
SETTLING = 10
"""One part in so many is left out at the begin, where tangent vectors turn to their directions."""


@dataclass(frozen=True, eq=False)
class Exponents:
    """Lyapunov exponents of a system, the largest first.

    Parameters
    ----------
    name : the system.
    spectrum : (k,) exponents [unit].
    errors : (k,) one standard deviation of each, from block averages [unit]; NaN where the run failed early.
    time : (n,) time after which a history stands [s], or iterations of a map.
    history : (n, k) what the exponents would be if the run had ended there [unit].
    unit : "1/s", "1/iteration" or "1/period".
    ok : whether the run came to its end.
    status : how it ended, in a sentence.
    points : (m, signals) where the system was once a period (iteration, crossing).
    seen : what the points are and how precise, for verdicts.
    period : mean time from one point to the next [s]; NaN for a map.
    verdict : what the motion is, from the points and the largest exponent; None where points are no section.

    Notes
    -----
    An error covers the fluctuations of a stationary motion, not a transient that has not ended nor the steps of a
    solver.  Half of the exponents of a limit cycle do not fluctuate at all; their errors are then those of round-off.
    """

    name: str
    spectrum: np.ndarray
    errors: np.ndarray
    time: np.ndarray
    history: np.ndarray
    unit: str
    ok: bool
    status: str
    points: np.ndarray = field(repr=False)
    seen: Seen = field(repr=False)
    period: float = float("nan")
    verdict: Verdict | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the signals of the points."""
        return self.seen.names

    def seen_through(self, *signals: str) -> Verdict:
        """The verdict that some signals of the points alone lead to, with the exponent of the system.

        Parameters
        ----------
        signals : names of signals; none: all that tell of the motion.

        Raises
        ------
        InputError : an unknown signal.
        """
        value, error = (x if np.isfinite(x) else None for x in (self.value, self.error))
        return self.seen.judged(self.points, signals, value, error)

    @property
    def value(self) -> float:
        """The largest exponent [unit]."""
        return float(self.spectrum[0]) if len(self.spectrum) else float("nan")

    @property
    def error(self) -> float:
        """Its standard deviation [unit]."""
        return float(self.errors[0]) if len(self.errors) else float("nan")

    @property
    def sum(self) -> float:
        """Sum of the exponents [unit]: with all of them the mean rate at which volumes of states grow."""
        return float(self.spectrum.sum())

    def per_period(self) -> Exponents:
        """The same exponents counted by periods (crossings) instead of seconds.

        Raises
        ------
        InputError : exponents of a map, or of a flow without periods.
        """
        if self.unit != "1/s" or not np.isfinite(self.period):
            text = f"Exponents of {self.name!r}: they are in {self.unit} and the system has no period"
            raise InputError(f"{text}. Take them as they are.")
        T = self.period
        scaled = {"spectrum": T * self.spectrum, "errors": T * self.errors, "history": T * self.history}
        return replace(self, **scaled, unit="1/period")

    def __str__(self) -> str:
        listed = ", ".join(f"{v:.4g} +/- {e:.1g}" for v, e in zip(self.spectrum, self.errors, strict=True))
        said = "" if self.verdict is None else f", {self.verdict}"
        return f"{self.name}: {listed or 'nothing'} {self.unit}{said}. {self.status}"


@dataclass
class Growth:
    """What was measured: logarithms of growth, and the time each of them took.

    Parameters
    ----------
    logs : a list of (k,) logarithms, one entry a period.
    times : their durations [s], or iterations.
    """

    logs: list[np.ndarray] = field(default_factory=list)
    times: list[float] = field(default_factory=list)

    def record(self, begin: float, count: int, **about: Any) -> Exponents:
        """The exponents, in order; `begin` is the time at which counting began, `about` goes into the record."""
        logs = np.array(self.logs).reshape(len(self.times), count)
        times = np.array(self.times)
        sums, spent = np.cumsum(logs, axis=0), np.cumsum(times)
        if len(times) == 0:
            nothing = np.full(count, np.nan)
            return Exponents(spectrum=nothing, errors=nothing, time=times, history=logs, **about)
        with np.errstate(invalid="ignore"):
            history = sums / spent[:, None]
        order = np.argsort(-history[-1], kind="stable")
        errors = np.array([block_error(logs[:, j], times) for j in range(count)])
        found = {"spectrum": history[-1][order], "errors": errors[order], "history": history[:, order]}
        return Exponents(time=begin + spent, **found, **about)


def block_error(logs: np.ndarray, times: np.ndarray) -> float:
    """Standard deviation of sum(logs) / sum(times), both (n,); NaN below 2 BLOCKS entries or where it is not finite.

    Twenty blocks of equal numbers of entries make what is left of each block, the mean rate taken away, nearly
    independent.  What correlation r > 0 is left between neighbours makes the variance (1 + r) / (1 - r) times as large,
    as it is where correlations fall off as r^k.
    """
    size = len(logs) // BLOCKS
    if size < 2 or not np.isfinite(logs).all():
        return float("nan")
    n = size * BLOCKS
    logs, times = logs[-n:], times[-n:]
    rest = (logs - logs.sum() / times.sum() * times).reshape(BLOCKS, size).sum(axis=1)
    spread = float(rest @ rest)
    r = float(rest[1:] @ rest[:-1]) / spread if spread > 0.0 else 0.0
    wider = (1.0 + r) / (1.0 - r) if r > 0.0 else 1.0
    return float(np.sqrt(wider * spread * BLOCKS / (BLOCKS - 1.0)) / times.sum())


def check_enough(label: str, count: int, what: str) -> None:
    """Refuse a run that is too short for an estimate with an error."""
    if count < FEWEST:
        text = f"{label}: {count} {what} are too few for exponents with an error"
        raise InputError(f"{text}; at least {FEWEST} are needed, and 1000 for two digits of a chaotic motion.")
