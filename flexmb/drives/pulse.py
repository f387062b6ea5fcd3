"""A value between two instants, as the history of a load."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexmb.errors import InputError
from flexmb.kernels import drive_kernel
from flexmb.model.law import Motion


@drive_kernel
def pulse_kernel(p, t):
    """s = value for start <= t < end."""
    value, start, end = p
    return (value if start <= t < end else 0.0), 0.0, 0.0


@dataclass(frozen=True)
class Pulse(Motion):
    """s = value for start <= t < end, else 0: a load that is switched on and off.

    Parameters
    ----------
    value : the factor from start to end.
    start : first instant [s]; 0: from the beginning.
    end : end of the pulse [s], > start; None: no end.

    Raises
    ------
    InputError : an end that does not lie after the start.

    Notes
    -----
    The value jumps, so a pulse can be the history of a load but cannot drive a joint.  A run ends a step at each jump
    and starts anew there, so the method keeps its order.

    Examples
    --------
    >>> Pulse(2.0, start=1.0, end=3.0).breaks(10.0)
    (1.0, 3.0)
    """

    value: float = 1.0
    start: float = 0.0
    end: float | None = None

    kernel = pulse_kernel
    is_smooth = swings = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.end is not None and self.end <= self.start:
            raise InputError(f"Pulse: end is {self.end:g} s; it must be > start = {self.start:g} s.")

    def parameters(self) -> tuple[float, ...]:
        """Value, start, end (infinity: no end)."""
        return self.value, self.start, math.inf if self.end is None else self.end

    def breaks(self, t_end: float) -> tuple[float, ...]:
        """Start and end."""
        return tuple(t for t in self.parameters()[1:] if 0.0 < t <= t_end)
