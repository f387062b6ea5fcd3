"""Controllers that drive their signal away from the target: a run ends, with the name of the controller."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flexmb.model.mechanism import Mechanism
from flexmb.model.signal import resolved
from flexmb.program.program import Program
from flexmb.run.stopping import Condition

LOST = {"rad": 200.0 * np.pi, "rad/s": 1e4, "m": 100.0, "m/s": 1e4}
"""Distance of a signal from its target, by its unit, at which control is lost; m count in sizes of the mechanism."""

TIMES_TARGET = 100.0
"""The same distance over the largest target, where that is more."""


def lost_control(mechanism: Mechanism, program: Program, end: float) -> Iterator[Condition]:
    """Conditions that end a run until `end` [s]: a signal far from its target, pushed further by a controller's load.

    Far is what no controller at work lets happen, as a hundred turns.  One whose load brakes the signal goes on.
    """
    signals = program.names.signals
    for controller in mechanism.controllers:
        name, low, high = controller.followed(end) or ("", 0.0, 0.0)
        place = signals.places.get(resolved(name, signals, program.names.aliases))
        unit = "" if place is None else signals.units[place]
        if place is None or unit not in LOST:
            continue
        far = max(LOST[unit] * (program.length if unit == "m" else 1.0), TIMES_TARGET * max(abs(low), abs(high)))
        load = next(iter(controller.control().loads), "")
        text = f"{controller.label} drives {name!r} away from its target, by {far:.3g} {unit} so far: the sign of its"
        text = f"{text} gains{f' or of {load!r}' if load else ''} is wrong, or the loop is unstable (see fm.check)"
        power = f"{load}.power" if f"{load}.power" in signals.places else ""
        for level, sign in ((high + far, 1), (low - far, -1)):
            yield Condition(signals.names[place], level, sign, text, is_fault=True, pushed_by=power)
