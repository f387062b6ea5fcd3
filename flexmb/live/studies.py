"""Studies of a live page, in a thread of their own: exponent with its verdict, a bifurcation diagram point by point."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.exponents.lyapunov import lyapunov
from flexmb.dynamics.jobs.executors import attempted
from flexmb.dynamics.sweeps.bifurcation import Family, SectionSettings, section_point
from flexmb.errors import USER_ERRORS, InputError
from flexmb.live.knobs import LABEL, Knobs, Value
from flexmb.model.mechanism import Mechanism

EXPONENT, DIAGRAM = "exponent", "diagram"
STAGES, SKIP = (50, 200), 50  # periods of an exponent, first few and then many; periods before it
MOST_VALUES, MOST_KEPT = 400, 200  # points of a diagram along the parameter; section points of each at most

Told = Callable[[dict[str, Any]], None]


class Studies:
    """One study at a time of the mechanism of a live page.

    Parameters
    ----------
    knobs : numbers and choices that may vary.
    told : called in the thread of the study with its results so far.
    """

    def __init__(self, knobs: Knobs, told: Told) -> None:
        self.knobs, self.told = knobs, told
        self.stopping = threading.Event()
        self.thread: threading.Thread | None = None

    def begin(self, values: Mapping[str, Value], asked: Mapping[str, Any]) -> None:
        """Begin a study of these values; wrong wishes raise `InputError`, and so does a study that runs."""
        kind = checks.one_of(LABEL, "kind", asked.get("kind"), (EXPONENT, DIAGRAM))
        steps = self._exponent(values) if kind == EXPONENT else self._diagram(values, asked)
        if self.thread is not None and self.thread.is_alive():
            self.stopping.set()
            raise InputError(f"{LABEL}: an earlier study is about to end. Try again in a moment.")
        self.stopping.clear()
        self.thread = threading.Thread(target=self._work, args=(kind, steps), name="flexmb study", daemon=True)
        self.thread.start()

    def stop(self) -> None:
        """End the study after the point that it computes."""
        self.stopping.set()

    def _work(self, kind: str, steps: Iterator[dict[str, Any]]) -> None:
        common = {"type": "study", "kind": kind}
        try:
            for said in steps:
                self.told({**common, **said, "done": False})
                if self.stopping.is_set():
                    break
            self.told({**common, "done": True, "stopped": self.stopping.is_set()})
        except USER_ERRORS as error:
            self.told({**common, "done": True, "fault": str(error)})

    def _exponent(self, values: Mapping[str, Value]) -> Iterator[dict[str, Any]]:
        """Largest exponent over few and over many periods, with its error and the verdict."""
        for periods in STAGES:
            found = lyapunov(self.knobs.mechanism(values), skip=SKIP, periods=periods, confirm=False)
            said = {"value": float(found.value), "error": float(found.errors[0]), "unit": found.units}
            verdict = found.verdict
            told = {"verdict": str(verdict), "reason": verdict.reason} if verdict is not None else {}
            history = {"time": found.time.tolist(), "history": found.history[:, 0].tolist()}
            done = {"status": found.status, "ok": found.ok, "periods": periods, "of": STAGES[-1]}
            yield {**said, **told, **history, **done}

    def _diagram(self, values: Mapping[str, Value], asked: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
        """Checked wishes of a diagram, and its points one after the other, spread evenly from the first on."""
        name = checks.one_of(LABEL, "parameter", asked.get("parameter"), self.knobs.known)
        knob = self.knobs.known[name]
        if knob.kind != "number":
            raise InputError(f"{LABEL}: {name} is no number; a diagram needs one.")
        ends = ("low", "high")
        low, high = (checks.between(LABEL, end, asked.get(end), knob.low, knob.high, knob.unit) for end in ends)
        count = checks.count(LABEL, "count", checks.between(LABEL, "count", asked.get("count"), 2, MOST_VALUES))
        skip = checks.count(LABEL, "skip", checks.between(LABEL, "skip", asked.get("skip", SKIP), 0, 10 * SKIP), 0)
        keep = checks.count(LABEL, "keep", checks.between(LABEL, "keep", asked.get("keep", 40), 1, MOST_KEPT))
        signal = asked.get("signal")
        if not isinstance(signal, str) or not low < high:
            raise InputError(f"{LABEL}: a diagram needs a signal, and a range whose first end is the lower one.")
        along = np.linspace(low, high, count)[_spread(count)].tolist()
        return self._points(values, name, along, SectionSettings(skip, keep, (signal,)))

    def _points(
        self, values: Mapping[str, Value], name: str, along: list[float], section: SectionSettings
    ) -> Iterator[dict[str, Any]]:
        """Section points at values of a parameter."""
        knobs, model = self.knobs, self.knobs.model
        others = {key: knobs.known[key].argument(one) for key, one in values.items() if key != name}
        if isinstance(model, Mechanism):
            family = Family(knobs.mechanism({**values, name: knobs.known[name].value}), name, {})
        else:
            family = Family(model, name, {**knobs.fixed, **others})
        for number, value in enumerate(along, 1):
            found = attempted(section_point, family, section, value, None)
            said = {"at": value, "number": number, "of": len(along), "fault": "" if found.ok else found.status}
            points = np.ravel(found.values.get("points", ()))
            yield {**said, "points": points.tolist(), "verdict": found.values.get("verdict", "")}


def _spread(count: int) -> np.ndarray:
    """Numbers (count,) of points in an order that fills their range evenly: by their reversed bits."""
    bits = max(count - 1, 1).bit_length()
    order = sorted(range(count), key=lambda k: int(f"{k:0{bits}b}"[::-1], 2))
    return np.array(order)
