"""Lyapunov exponents as a record, and what they and their errors are computed from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flexmb.dynamics.exponents.exponent_error import error_of
from flexmb.dynamics.sections.seen import Seen
from flexmb.dynamics.verdict.verdict import Verdict
from flexmb.errors import InputError

FEWEST = 50
"""Periods (iterations, crossings, intervals) that an estimate needs."""
SETTLING = 10
"""One part in so many is left out at the begin, where tangent vectors turn to their directions."""


CLEARLY = 3.0
"""A second exponent that lies above zero by so many times its error speaks against a regular motion."""

CONSERVATIVE = (
    "The exponents pair to zero, so the system is conservative: its motions neither settle nor end near tori that they "
    "stick to, and neighbours that part like a power of time have an exponent of log(t) / t; a finite record need not "
    "decide it."
)


@dataclass(frozen=True, eq=False)
class Confirmed:
    """What a second, shorter run of the same system found, with finer steps and from another start.

    Parameters
    ----------
    spectrum, errors : (k,) its exponents and the errors of its record alone [unit of the first run].
    periods : points that it counts.
    fineness : its steps, such as "rtol 1e-05"; "": a map, which has none.
    """

    spectrum: np.ndarray
    errors: np.ndarray
    periods: int
    fineness: str

    @property
    def value(self) -> float:
        """The largest exponent."""
        return float(self.spectrum[0])

    @property
    def error(self) -> float:
        """Its error."""
        return float(self.errors[0])

    def __str__(self) -> str:
        listed = ", ".join(f"{v:.4g} +/- {e:.1g}" for v, e in zip(self.spectrum, self.errors, strict=True))
        steps = f"{self.fineness}, " if self.fineness else ""
        return f"second run ({steps}another start, {self.periods} points): {listed}"


@dataclass(frozen=True, eq=False)
class Exponents:
    """Lyapunov exponents of a system, the largest first.

    Parameters
    ----------
    name : the system.
    spectrum : (k,) exponents [unit].
    errors : (k,) one standard deviation of each, with what finer steps and another start change where a second run
        was made (`exponent_error.combined`) [unit]; NaN where the run failed early.
    time : (n,) time after which a history stands [s], or iterations of a map.
    history : (n, k) what the exponents would be if the run had ended there [unit].
    unit : "1/s", "1/iteration" or "1/period".
    ok : whether the run came to its end.
    status : how it ended, in a sentence.
    points : (m, signals) where the system was once a period (iteration, crossing).
    seen : what the points are and how precise, for verdicts.
    period : mean time from one point to the next [s]; NaN for a map.
    verdict : what the motion is, from the points and the largest exponent; None where points are no section.
    statistical : (k,) the errors of the record alone (`exponent_error.error_of`) [unit]; None: `errors`.
    confirmed : what the second run found; None: there was none.
    unconfirmed : why a second run that was asked for found nothing; "": it did, or none was asked for.

    Notes
    -----
    The errors of the record cover the fluctuations of a stationary motion, vectors that still turn, growth like a power
    of time and round-off; not a transient that has not ended.  What steps of a solver miss shows in the second run.
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
    statistical: np.ndarray = field(default=None, repr=False)  # type: ignore[assignment]
    confirmed: Confirmed | None = None
    unconfirmed: str = field(default="", repr=False)

    def __post_init__(self) -> None:
        if self.statistical is None:
            object.__setattr__(self, "statistical", self.errors)

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
        alone = float(self.statistical[0]) if len(self.statistical) else float("nan")
        value, error = (x if np.isfinite(x) else None for x in (self.value, alone))
        found = self.seen.judged(self.points, signals, value, error)
        if self.paired and found.kind in ("inconclusive", "transient"):
            found = replace(found, reason=f"{found.reason} {CONSERVATIVE}")
        return self._agreed(found)

    def _agreed(self, verdict: Verdict) -> Verdict:
        """The verdict on the first run, unless the second one speaks against it."""
        second, chaotic = self.confirmed, verdict.kind == "chaotic"
        if second is None:
            if not self.unconfirmed:
                return verdict
            text = f"{verdict.reason} The second run failed, so nothing confirms it: {self.unconfirmed}"
            return replace(verdict, kind="inconclusive" if chaotic else verdict.kind, reason=text)
        told = f"{second.value:.3g} +- {second.error:.2g}"
        evidence = {**verdict.evidence, "confirmed": second.value, "confirmed_error": second.error}
        against = second.value <= second.error if chaotic else second.value > CLEARLY * second.error
        if verdict.kind not in ("periodic", "quasi-periodic", "chaotic") or not against:
            text = f"{verdict.reason} A second run gives {told}."
            return replace(verdict, reason=text, evidence=evidence)
        steps = f"with {second.fineness} and from another start" if second.fineness else "from another start"
        text = f"This run is {verdict}: exponent {self.value:.3g} +- {self.statistical[0]:.2g}. A second one {steps}"
        text += f" gives {told}, which is not. Take finer steps and more periods until both agree."
        return Verdict("inconclusive", text, verdict.k, evidence)

    @property
    def value(self) -> float:
        """The largest exponent [unit]."""
        return float(self.spectrum[0]) if len(self.spectrum) else float("nan")

    @property
    def error(self) -> float:
        """Its error [unit]."""
        return float(self.errors[0]) if len(self.errors) else float("nan")

    @property
    def sum(self) -> float:
        """Sum of the exponents [unit]: with all of them the mean rate at which volumes of states grow."""
        return float(self.spectrum.sum())

    @property
    def paired(self) -> bool:
        """Whether all exponents are known and pair to zero within their errors, as in a conservative system."""
        if len(self.spectrum) != self.seen.dimension or len(self.spectrum) < 2:
            return False
        return bool((np.abs(self.spectrum + self.spectrum[::-1]) <= self.errors + self.errors[::-1]).all())

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
        names, second = ("spectrum", "errors", "history", "statistical"), self.confirmed
        if second is not None:
            second = replace(second, spectrum=T * second.spectrum, errors=T * second.errors)
        scaled = {name: T * getattr(self, name) for name in names}
        return replace(self, **scaled, confirmed=second, unit="1/period")

    def __str__(self) -> str:
        listed = ", ".join(f"{v:.4g} +/- {e:.1g}" for v, e in zip(self.spectrum, self.errors, strict=True))
        said = "" if self.verdict is None else f", {self.verdict}"
        again = "" if self.confirmed is None else f"; {self.confirmed}"
        return f"{self.name}: {listed or 'nothing'} {self.unit}{again}{said}. {self.status}"


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
        errors = np.array([error_of(logs[:, j], times) for j in range(count)])
        found = {"spectrum": history[-1][order], "errors": errors[order], "history": history[:, order]}
        return Exponents(time=begin + spent, **found, **about)


def check_enough(label: str, count: int, what: str) -> None:
    """Refuse a run that is too short for an estimate with an error."""
    if count < FEWEST:
        text = f"{label}: {count} {what} are too few for exponents with an error"
        raise InputError(f"{text}; at least {FEWEST} are needed, and 1000 for two digits of a chaotic motion.")
