"""Studies of a live page, in a thread of their own: exponent with its verdict, a bifurcation diagram point by point."""

import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.jobs.executors import Outcome
from flexmb.dynamics.lyapunov import lyapunov
from flexmb.dynamics.sweeps.bifurcation import bifurcation
from flexmb.dynamics.sweeps.parameter_sweep import load_sweep
from flexmb.engine.compiled.digest import digest
from flexmb.errors import USER_ERRORS, InputError
from flexmb.show.live.knobs import LABEL, Knobs, Value

EXPONENT, DIAGRAM = "exponent", "diagram"
STAGES, SKIP = (50, 200), 50  # periods of an exponent, first few and then many; periods before it
MOST_VALUES, MOST_KEPT = 400, 200  # points of a diagram along the parameter; section points of each at most
Told = Callable[[dict[str, Any]], None]
Point = tuple[float, Outcome]


class Studies:
    """One study at a time, which tells its results so far; `store`: folder with a store for each diagram, or None."""

    def __init__(self, knobs: Knobs, told: Told, store: Path | None = None) -> None:
        self.knobs, self.told, self.store = knobs, told, store
        self.stopping = threading.Event()
        self.thread: threading.Thread | None = None

    def begin(self, values: Mapping[str, Value], asked: Mapping[str, Any]) -> None:
        """Begin a study of these values; wrong wishes raise `InputError`, and so does a study that runs."""
        kind = checks.one_of(LABEL, "kind", asked.get("kind"), (EXPONENT, DIAGRAM))
        study = partial(self._exponent, values) if kind == EXPONENT else self._diagram(values, asked)
        if self.thread is not None and self.thread.is_alive():
            self.stopping.set()
            raise InputError(f"{LABEL}: an earlier study is about to end. Try again in a moment.")
        self.stopping.clear()
        self.thread = threading.Thread(target=self._work, args=(kind, study), name="flexmb study", daemon=True)
        self.thread.start()

    def stop(self) -> None:
        """End the study after the point that it computes."""
        self.stopping.set()

    def _work(self, kind: str, study: Callable[[Told], None]) -> None:
        common, fault = {"type": "study", "kind": kind}, {}
        try:
            study(lambda said: self.told({**common, **said, "done": False}))
        except KeyboardInterrupt:  # stopped
            pass
        except USER_ERRORS as error:
            fault = {"fault": str(error)}
        self.told({**common, "done": True, "stopped": self.stopping.is_set(), **fault})

    def _exponent(self, values: Mapping[str, Value], tell: Told) -> None:
        """Largest exponent over few and over many periods, with its error and the verdict."""
        for periods in STAGES:
            found = lyapunov(self.knobs.mechanism(values), skip=SKIP, periods=periods, confirm=False)
            said = {"value": float(found.value), "error": float(found.errors[0]), "unit": found.units}
            verdict = found.verdict
            told = {"verdict": str(verdict), "reason": verdict.reason} if verdict is not None else {}
            history = {"time": found.time.tolist(), "history": found.history[:, 0].tolist()}
            done = {"status": found.status, "ok": found.ok, "periods": periods, "of": STAGES[-1]}
            tell({**said, **told, **history, **done})
            if self.stopping.is_set():
                return

    def _diagram(self, values: Mapping[str, Value], asked: Mapping[str, Any]) -> Callable[[Told], None]:
        """Study of a diagram by checked wishes."""
        name = checks.one_of(LABEL, "parameter", asked.get("parameter"), self.knobs.known)
        knob = self.knobs.known[name]
        if knob.kind != "number":
            raise InputError(f"{LABEL}: {name} is no number; a diagram needs one.")
        ends = (("from", "low"), ("to", "high"))
        low, high = (replace(knob, name=f"{name}, {said}").number(asked.get(end)) for said, end in ends)
        count = checks.count(LABEL, "count", checks.between(LABEL, "count", asked.get("count"), 2, MOST_VALUES))
        skip = checks.count(LABEL, "skip", checks.between(LABEL, "skip", asked.get("skip", SKIP), 0, 10 * SKIP), 0)
        keep = checks.count(LABEL, "keep", checks.between(LABEL, "keep", asked.get("keep", 40), 1, MOST_KEPT))
        signal = asked.get("signal")
        if not isinstance(signal, str) or not low < high:
            raise InputError(f"{LABEL}: a diagram needs a signal, and a range whose first end is the lower one.")
        make, fixed = self.knobs.family(values, name)
        along = np.linspace(low, high, count).tolist()
        settings: Any = {"fixed": fixed, "skip": skip, "keep": keep, "signals": [signal]}
        place = None
        if self.store is not None:
            others = {key: one for key, one in values.items() if key != name}
            model = digest(self.knobs.mechanism({**values, name: low}))  # another model has a store of its own
            text = repr((model, name, low, high, count, skip, keep, signal, sorted(others.items())))
            place = self.store / f"{name}-{sha256(text.encode()).hexdigest()[:12]}.zarr"

        def study(tell: Told) -> None:  # points from the store, which the sweep has checked, and by runs
            with _Painter(tell, self.stopping, count, _kept(place, name, signal)) as painter:
                bifurcation(make, name, along, **settings, executor=painter, pending=1, store=place, resume=True)
                painter.catch_up()

        return study


def _kept(place: Path | None, name: str, signal: str) -> Iterator[Point]:
    """Points of a store; it is read at the first one."""
    if place is not None:
        kept = load_sweep(place)
        for k in np.flatnonzero(kept["status"].values != ""):
            ok = bool(kept["ok"].values[k])
            values = {"points": kept[signal].values[k], "verdict": str(kept["verdict"].values[k])} if ok else {}
            yield float(kept[name].values[k]), Outcome(values, str(kept["status"].values[k]), ok)


class _Painter(ThreadPoolExecutor):
    """Executor of one thread that tells each point of a diagram once it is found."""

    def __init__(self, told: Told, stopping: threading.Event, count: int, kept: Iterator[Point]) -> None:
        super().__init__(1, "flexmb point")
        self.told, self.stopping, self.count, self.number, self.kept = told, stopping, count, 0, kept

    def submit(self, function: Any, /, *arguments: Any, **keywords: Any) -> Future[Any]:
        """See `Executor`."""
        if self.stopping.is_set():
            raise KeyboardInterrupt
        self.catch_up()
        future = super().submit(function, *arguments, **keywords)
        _, _, _, value, _ = arguments  # of `section_point`, see `bifurcation`
        self.tell(value, future.result())
        return future

    def catch_up(self) -> None:
        """Tell the points that were kept, once."""
        for value, found in self.kept:
            self.tell(value, found)

    def tell(self, value: float, found: Outcome) -> None:
        """Tell a point."""
        self.number += 1
        said = {"at": value, "number": self.number, "of": self.count, "fault": "" if found.ok else found.status}
        points = np.ravel(found.values.get("points", ()))
        self.told({**said, "points": points.tolist(), "verdict": found.values.get("verdict", "")})
