"""Records of Lyapunov exponents: values, errors, history, verdict."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmb import arguments, display
from flexmb.display import cut
from flexmb.dynamics.sections import SectionSignals
from flexmb.dynamics.verdict import Verdict
from flexmb.errors import InputError
from flexmb.fields import field, record_with

# Number of blocks whose means are compared; the smallest number of blocks, of two entries each, in short records.
BLOCKS, FEWEST_BLOCKS = 20, 9
# Exponent of the power of time up to which algebraic growth of distances is not taken for exponential growth.
POWER = 3.0
# Logarithm of the ratio of the times at the end and in the middle of a record whose first tenth was left out.
LATE = float(np.log(20.0 / 11.0))
# Round-off of each logarithm, in units of round-off of a number near 1; sqrt(n) units are added for a sum of n.
LOGS = 4.0
WITHIN = 2.0  # multiple of the error up to which two exponents count as equal


def error_of(logs: np.ndarray, times: np.ndarray) -> float:
    """Standard deviation of sum(logs) / sum(times), both (n,); NaN for too few entries or one that is not finite."""
    # The largest of four errors: of block averages (fluctuations of a stationary motion); the difference between the
    # last half and the whole record, if it exceeds twice the error of the blocks (vectors that still turn, or a motion
    # that still changes); round-off, 4 + sqrt(n) units of each logarithm, added up; and the exponent itself, if
    # neighbours part over the last half by no more than the third power of time (a factor of 6): log(t) / t is above
    # zero in any finite record. `logs` are logarithms of growth, `times` the durations of the growth.
    # Blocks are twenty of equal numbers of entries (fewer, of two entries, in short records). The deviations of their
    # sums from the mean rate are nearly independent. A correlation r > 0 between neighbouring blocks increases the
    # variance by (1 + r) / (1 - r), the factor for correlations that decay as r^k.
    # Equation (9.5) of docs/theory/exponents.md.
    count = min(BLOCKS, len(logs) // 2)
    if count < FEWEST_BLOCKS or not np.isfinite(logs).all():
        return float("nan")
    size = len(logs) // count
    last, spans = logs[-size * count :], times[-size * count :]
    rest = (last - last.sum() / spans.sum() * spans).reshape(count, size).sum(axis=1)
    spread = float(rest @ rest)
    r = float(rest[1:] @ rest[:-1]) / spread if spread > 0.0 else 0.0
    wider = (1.0 + r) / (1.0 - r) if r > 0.0 else 1.0
    blocks = float(np.sqrt(wider * spread * count / (count - 1.0)) / spans.sum())
    if not np.isfinite(blocks):
        return float("nan")
    value, half = logs.sum() / times.sum(), len(logs) // 2
    late = float(logs[half:].sum())
    changed = abs(late / times[half:].sum() - value)
    round_off = (LOGS + np.sqrt(len(logs))) * np.finfo(float).eps * np.maximum(np.abs(logs), 1.0).sum() / times.sum()
    algebraic = value + round_off if value > 0.0 and late <= POWER * LATE else 0.0
    return float(max(blocks, changed if changed > WITHIN * blocks else 0.0, round_off, algebraic))


def combined(values: np.ndarray, errors: np.ndarray, others: np.ndarray, other_errors: np.ndarray) -> np.ndarray:
    """Errors (k,) of exponents l with errors s after a second run with exponents l' and errors s'."""
    # sqrt(s^2 + e^2), with the error s of the record and the difference e = |l - l'| of both runs. e counts only if it
    # exceeds twice the errors of both, sqrt(s^2 + s'^2): fluctuations of the second run are no error of the first one.
    # Equation (9.6) of docs/theory/exponents.md. Entries of the second run that are not finite add nothing.
    with np.errstate(invalid="ignore"):
        difference, both = np.abs(values - others), np.hypot(errors, np.nan_to_num(other_errors))
    counts = np.isfinite(difference) & (difference > WITHIN * both)
    return np.asarray(np.hypot(errors, np.where(counts, difference, 0.0)))


FEWEST = 50  # smallest number of periods (iterations, crossings, intervals) for an estimate
# Points after the skipped ones for each point that is not counted, while tangent vectors turn to their directions.
SETTLING = 10
SHOWN = 4  # number of exponents at most in a text
ERRORS = ("errors", "statistical")  # names of the fields of `Exponents` that hold errors
CLEARLY = 3.0  # multiple of its error above which a second exponent > 0 contradicts a regular motion

# Sentence on exponents that pair to zero, added to a verdict that is inconclusive or transient.
CONSERVATIVE = (
    "The exponents pair to zero, so the system is conservative: its motions do not settle, and may stick to tori for a "
    "long time; neighbours that part like a power of time have an exponent of log(t) / t. A finite record need not "
    "decide it."
)


@dataclass(frozen=True, eq=False)
class Confirmed:
    """Exponents of the second run of a system: shorter, with finer steps and another start."""

    spectrum: np.ndarray  # exponents (k,) and the errors of their record alone [unit of the first run]
    errors: np.ndarray
    periods: int  # number of counted points
    fineness: str  # accuracy of the steps, such as "rtol 1e-05"; "" for a map

    @property
    def value(self) -> float:
        """The largest exponent [unit of the first run]."""
        return float(self.spectrum[0])

    @property
    def error(self) -> float:
        """Error of the largest exponent [unit of the first run]."""
        return float(self.errors[0])

    def __repr__(self) -> str:
        listed = ", ".join(f"{v:.4g} +/- {e:.1g}" for v, e in zip(self.spectrum, self.errors, strict=True))
        steps = f"{self.fineness}, " if self.fineness else ""
        return f"second run ({steps}another start, {self.periods} points): {listed}"


@record_with(eq=False)
class Exponents(arguments.Checked):
    """Lyapunov exponents of a system, the largest first.

    Notes
    -----
    The errors of the record cover fluctuations of a stationary motion, vectors that still turn, algebraic growth and
    round-off.  They do not cover a transient that has not ended.  The second run shows errors of the time steps.
    """

    formerly = (("unit", "units", "0.3"),)
    name: str = field("name of the system")
    spectrum: np.ndarray = field("exponents (k,) [unit]")
    errors: np.ndarray = field(
        "standard deviations (k,) [unit], with the difference of a second run, if there was one (`confirmed` of "
        "`lyapunov.py`); NaN after an early failure"
    )
    time: np.ndarray = field("times (n,) of the history [s], or iterations of a map")
    history: np.ndarray = field("exponents (n, k) of the run up to each time [unit]")
    units: str = field('"1/s", "1/iteration" or "1/period"')
    ok: bool = field("whether the run came to its end")
    status: str = field("end of the run, in a sentence")
    points: np.ndarray = field("section points (m, signals), one a period (iteration, crossing)", repr=False)
    signals: SectionSignals = field("names, units and resolution of the signals of the points", repr=False)
    period: float = field("mean time from one point to the next; NaN for a map", "s", default=float("nan"))
    verdict: Verdict | None = field("verdict on the points; None where they are no section", default=None)
    statistical: np.ndarray = field("errors (k,) of the record alone", default_factory=lambda: np.empty(0), repr=False)
    confirmed: Confirmed | None = field("exponents of the second run; None: no second run", default=None)
    unconfirmed: str = field('reason why a requested second run failed; "" otherwise', default="", repr=False)

    def __post_init__(self) -> None:
        if len(self.statistical) == 0:
            object.__setattr__(self, "statistical", self.errors)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the signals of the points."""
        return self.signals.names

    def seen_through(self, *signals: str) -> Verdict:
        """The verdict from some `signals` of the points alone, or the default ones, with the exponent of the system.

        Raises
        ------
        InputError : an unknown signal.
        """
        alone = float(self.statistical[0]) if len(self.statistical) else float("nan")
        verdict = self.signals.verdict(self.points, signals, self.value, alone)
        if self.paired and verdict.kind in ("inconclusive", "transient"):
            verdict = replace(verdict, reason=f"{verdict.reason} {CONSERVATIVE}")
        return self._agreed(verdict)

    def _agreed(self, verdict: Verdict) -> Verdict:
        """The verdict on the first run, made inconclusive if the second run contradicts it."""
        second, chaotic = self.confirmed, verdict.kind == "chaotic"
        if second is None:
            if not self.unconfirmed:
                return verdict
            text = f"{verdict.reason} The second run failed, so nothing confirms it: {self.unconfirmed}"
            return replace(verdict, kind="inconclusive" if chaotic else verdict.kind, reason=text)
        band = f"{second.value:.3g} +- {second.error:.2g}"
        evidence = {**verdict.evidence, "confirmed": second.value, "confirmed_error": second.error}
        against = second.value <= second.error if chaotic else second.value > CLEARLY * second.error
        if verdict.kind not in ("periodic", "quasi-periodic", "chaotic") or not against:
            return replace(verdict, reason=f"{verdict.reason} A second run gives {band}.", evidence=evidence)
        steps = f"with {second.fineness} and from another start" if second.fineness else "from another start"
        text = f"This run is {verdict}: exponent {self.value:.3g} +- {self.statistical[0]:.2g}. A second one {steps}"
        text += f" gives {band}, which contradicts it. Take finer steps and more periods until both agree."
        return Verdict("inconclusive", text, verdict.k, evidence)

    @property
    def value(self) -> float:
        """The largest exponent [unit]."""
        return float(self.spectrum[0]) if len(self.spectrum) else float("nan")

    @property
    def error(self) -> float:
        """Error of the largest exponent [unit]."""
        return float(self.errors[0]) if len(self.errors) else float("nan")

    @property
    def sum(self) -> float:
        """Sum of the exponents [unit]; the sum of all exponents is the mean growth rate of volumes of states."""
        return float(self.spectrum.sum())

    @property
    def paired(self) -> bool:
        """Whether all exponents are known and pair to zero within their errors, as in a conservative system."""
        if len(self.spectrum) != self.signals.dimension or len(self.spectrum) < 2:
            return False
        return bool((np.abs(self.spectrum + self.spectrum[::-1]) <= self.errors + self.errors[::-1]).all())

    def per_period(self) -> Exponents:
        """Exponents per period (crossing) instead of per second.

        Raises
        ------
        InputError : exponents of a map, or of a flow without periods.
        """
        if self.units != "1/s" or not np.isfinite(self.period):
            text = f"Exponents of {self.name!r}: they are in {self.units} and the system has no period"
            raise InputError(f"{text}. Take them as they are.")
        T = self.period
        names, second = ("spectrum", "errors", "history", "statistical"), self.confirmed
        if second is not None:
            second = replace(second, spectrum=T * second.spectrum, errors=T * second.errors)
        return replace(self, **{name: T * getattr(self, name) for name in names}, confirmed=second, units="1/period")

    def __repr__(self) -> str:
        values = zip(self.spectrum[:SHOWN], self.errors, strict=False)
        more = f", and {len(self.spectrum) - SHOWN} more" if len(self.spectrum) > SHOWN else ""
        shown = ", ".join(f"{v:.4g} +- {e:.2g}" for v, e in values)
        verdict = "no verdict" if self.verdict is None else str(self.verdict)
        return cut(f"Exponents of {self.name!r}: {shown or 'none'}{more} {self.units}; {verdict}. {self.status}", 3)

    def _repr_html_(self) -> str:
        second = () if self.confirmed is None else self.confirmed.spectrum
        again = [f"{value:.4g}" for value in second] + [""] * (len(self.spectrum) - len(second))
        values = zip(self.spectrum, self.errors, again, strict=True)
        rows = [(k, f"{v:.4g}", f"{e:.2g}", other) for k, (v, e, other) in enumerate(values, 1)]
        head = ("exponent", f"value [{self.units}]", "error", "second run")
        reason = "" if self.verdict is None else display.texts([f"{self.verdict}: {self.verdict.reason}"])
        return display.page(f"Exponents of {self.name!r}", self.status, display.table(rows, head), reason)

    def __str__(self) -> str:
        listed = ", ".join(f"{v:.4g} +/- {e:.1g}" for v, e in zip(self.spectrum, self.errors, strict=True))
        said = "" if self.verdict is None else f", {self.verdict}"
        again = "" if self.confirmed is None else f"; {self.confirmed}"
        return f"{self.name}: {listed or 'nothing'} {self.units}{again}{said}. {self.status}"


def check_enough(label: str, count: int, what: str) -> None:
    """Refuse a run that is too short for an exponent, below `FEWEST` points; `what` is the unit of the points."""
    if count < FEWEST:
        text = f"{label}: {count} {what} are too few for exponents with an error"
        raise InputError(f"{text}; at least {FEWEST} are needed, and 1000 for two digits of a chaotic motion.")


def with_verdict(exponents: Exponents) -> Exponents:
    """Exponents of a section with the verdict on its points, if the run came to its end."""
    # A flow that stays on a cycle, for longer than the exponent allows round-off to stay small, has another exponent:
    # the difference is added to the error of the largest exponent. Equation (9.7) of docs/theory/exponents.md.
    if not exponents.ok:
        return exponents
    verdict = exponents.seen_through()
    if verdict.kind != "inconclusive" or "since" not in verdict.evidence or exponents.units != "1/s":
        return replace(exponents, verdict=verdict)
    span = (len(exponents.points) - verdict.evidence["since"]) * exponents.period
    # every period of the motion adds round-off, which grows to the size of the motion, by 1/eps, within the span
    limit = -np.log(np.finfo(float).eps) / span if span > 0.0 else np.inf
    excess = float(max(exponents.value - limit, 0.0))
    largest = np.arange(len(exponents.errors)) == 0
    errors = {n: np.where(largest, np.hypot(getattr(exponents, n), excess), getattr(exponents, n)) for n in ERRORS}
    return replace(exponents, **errors, verdict=verdict)
