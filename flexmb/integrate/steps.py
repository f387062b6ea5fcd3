"""Step control: fixed steps, or steps by an estimate of the local error."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb import checks
from flexmb.errors import InputError


@dataclass(frozen=True)
class FixedStep:
    """Steps of one size.

    Parameters
    ----------
    size : step [s], > 0; where t_end is no multiple of it, the last two are shorter.
    """

    size: float

    def __post_init__(self) -> None:
        checks.positive("FixedStep", "size", self.size, "s")


@dataclass(frozen=True)
class Adaptive:
    """Steps chosen so that the estimated local error of every position stays below `error`.

    Parameters
    ----------
    error : accepted error of a step [m]; for angles it is divided by the size of the mechanism.  None: 1e-4 of the
        least clearance, or 1e-7 of the size of a mechanism without clearance.
    max : largest step [s]; None: 1/1000 of the period of the drives, or of the duration.
    min : smallest step [s]; None: 1e-9 of the largest one.

    Raises
    ------
    InputError : values that are not > 0.
    """

    error: float | None = None
    max: float | None = None
    min: float | None = None

    def __post_init__(self) -> None:
        for name, unit in (("error", "m"), ("max", "s"), ("min", "s")):
            if getattr(self, name) is not None:
                checks.positive("Adaptive", name, getattr(self, name), unit)
        if self.max is not None and self.min is not None and self.min > self.max:
            raise InputError(f"Adaptive: min is {self.min:g} s; it must not be larger than max = {self.max:g} s.")
