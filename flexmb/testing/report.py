"""What was checked, as a record."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """One line of a report.

    Parameters
    ----------
    name : kernel and what was checked.
    states : at how many states.
    error : largest relative error found.
    skipped : further states left out because they stand at a kink.
    """

    name: str
    states: int
    error: float = 0.0
    skipped: int = 0


@dataclass(frozen=True)
class Report:
    """What `check_part` has checked; `str(report)` is a readable table.

    Parameters
    ----------
    part : name and class of the part.
    checks : one line a check.
    """

    part: str
    checks: tuple[Check, ...]

    def __str__(self) -> str:
        width = max((len(c.name) for c in self.checks), default=0)
        lines = [f"{self.part}: keeps its contracts"]
        for c in self.checks:
            left_out = f", {c.skipped} at kinks left out" if c.skipped else ""
            lines.append(f"  {c.name:{width}s}  {c.states:4d} states, largest error {c.error:.1e}{left_out}")
        return "\n".join(lines)
