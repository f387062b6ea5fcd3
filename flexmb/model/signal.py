"""The name and unit of one number that a run reports over time."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Signal:
    """One signal of a run.

    Parameters
    ----------
    name : full name, "PART.SIGNAL" or "PART.NODE.SIGNAL".
    units : SI unit, e.g. "m/s2"; empty for a number without unit.
    """

    name: str
    units: str = ""
