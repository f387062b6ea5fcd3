"""A run of `Staggered`: that of the rigid twin, with the elastic model beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from flexmb.errors import AssemblyError, InputError, ModelError
from flexmb.integrate.arrays import BUFFER_FULL, RUNNING, Options, new_record
from flexmb.integrate.contact_work import contact_losses
from flexmb.integrate.elastic import elastic_model
from flexmb.integrate.elastic_step import ELASTIC_SINGULAR, TOO_FAR
from flexmb.integrate.finish import save
from flexmb.integrate.ledger import MISSING_IN_RUNGE_KUTTA, keep_account
from flexmb.integrate.method import Staggered
from flexmb.integrate.run import Run
from flexmb.integrate.saved import SavedRows
from flexmb.integrate.solution import Solution
from flexmb.integrate.staggered import advance_staggered, begin_elastic, whole_motion, write_whole
from flexmb.integrate.status import sentence
from flexmb.integrate.steps import FixedStep
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile_with_start
from flexmb.program.program import Program
from flexmb.solve.start import Start, consistent_start
from flexmb.solve.twin import rigid_twin
from flexmb.system.constraints import report_forces
from flexmb.system.evaluate import evaluate_accepted

ENDINGS = {
    ELASTIC_SINGULAR: "the elastic equations became singular at {name!r}. Do the joints leave it without mass?",
    TOO_FAR: (
        "{name!r} is displaced by {moved:.3g} against the rigid model, too far for linear elasticity. The load that is "
        "handed back one step late may be unstable: try a smaller step, more passes, or a Newmark method."
    ),
}
"""How elastic steps end a run."""


class StaggeredRun(Run):
    """One run of a mechanism that compiles to `whole`; see `simulate` for the arguments.

    `program`, `flow` and `work` are those of the rigid twin; what is saved are the signals of `whole`.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        whole: Program,
        method: Staggered,
        step: FixedStep,
        t_end: float,
        period: float | None,
        *,
        max_steps: int | None = None,
        progress: bool = False,
        kept: np.ndarray | None = None,
    ) -> None:
        self.mechanism = rigid_twin(f"simulate {mechanism.name!r} with Staggered", mechanism)
        twin, self.closed = compile_with_start(self.mechanism)
        self.whole, self.given = whole, method
        self.elastic = elastic_model(mechanism, whole, twin, method)
        super().__init__(twin, method, step, t_end, period, max_steps=max_steps, progress=progress)
        self.kept, rigid = kept, new_record(twin, 1)
        self.record = self._new_record(whole).replaced(held=rigid.held)
        self.saved = SavedRows(self.record.values.shape[1], kept)

    def start(self) -> None:
        """Take the start values of the twin, and elastic accelerations that go with them."""
        try:
            start = consistent_start(self.mechanism, self.program, closed=self.closed)
        except (ModelError, AssemblyError) as error:
            text, _, advice = str(error).partition(". ")
            if "make a link flexible" not in advice:
                raise
            text = (
                f"simulate {self.mechanism.name!r} with Staggered: with rigid bodies in place of flexible ones, {text}"
            )
            raise type(error)(f"{text}. Remove a joint, start in another pose, or use a Newmark method.") from error
        self.begin(start)

    def begin(self, start: Start, *, z: np.ndarray | None = None, time: float = 0.0) -> None:
        """Take start values of the twin, the bodies unstressed; see `Run.begin`."""
        n, full = self.program.n_q, [np.zeros(self.program.n_q + 3) for _ in range(3)]
        for target, values in zip(full, (start.q, start.v, start.a), strict=True):
            target[:n] = values
        still, history = np.zeros(n + 3), self.program.drawn.z.copy() if z is None else z
        common = (self.program.tables, self.program.addresses, time, 0.0)
        evaluate_accepted(*common, *full, start.lam, history, still, still, self.work)
        code = RUNNING
        if self.elastic.settings.flexible:
            code = begin_elastic(self.program.tables, time, self.work, self.elastic, *full)
        super().begin(start, z=z, time=time)
        if code != RUNNING:
            self.code, self.note = code, self._ending(code)

    def resume(self, restart: Mapping[str, np.ndarray], *, redundant: bool = False) -> None:
        """Take the final state of another run of the same model."""
        super().resume(restart, redundant=redundant)
        own = {name.removeprefix("elastic."): array for name, array in restart.items() if name.startswith("elastic.")}
        try:
            self.elastic.now.restore(own)
        except ValueError as error:
            text = (
                f"simulate {self.program.name!r}: restart does not fit this model ({str(error)!r} of the elastic part)"
            )
            raise InputError(f"{text}. Use `restart` of a solution with the same method.") from error

    def _look(self) -> None:
        """Evaluate the present state, and remember its powers and forces for the ledger."""
        flow, still, el = self.flow, np.zeros(self.program.n_q + 3), self.elastic
        common = (self.program.tables, self.program.addresses, flow.clock.t, 0.0)
        evaluate_accepted(*common, flow.q, flow.v, flow.a, flow.lam, flow.z, still, still, self.work)
        report_forces(self.program.tables, flow.lam, self.work)
        flow.momentum[:] = self.work.momentum
        contact_losses(*common[:2], 0.0, flow, flow.q, flow.v, self.work)
        whole_motion(el, flow.clock.t, 0.0, flow.q, flow.v, flow.a, el.now, flow.ledger, self.work)
        keep_account(*common, flow.q, flow.v, flow.q, flow.v, flow.ledger, flow.account, flow.memory, self.work)

    def _write(self) -> None:
        """Signals of the state that was looked at last."""
        common = (self.program.tables, self.program.addresses, self.flow.clock.t)
        write_whole(*common, self.flow, self.work, self.record, self.elastic)

    def forget_peaks(self) -> None:
        """Begin to look for peaks at the present state."""
        super().forget_peaks()
        self.elastic.now.memory.tie = 0.0

    def _reach(self, target: float, interval: float, bar: Any, *, ahead: bool = False) -> bool:
        self.flow.account.limit = MISSING_IN_RUNGE_KUTTA
        return super()._reach(target, interval, bar, ahead=ahead)

    def _block(self, options: Options, steps: int) -> int:
        common = (self.program.tables, self.program.addresses, self.lu, options, self.flow, self.trial)
        return advance_staggered(*common, self.work, self.record, self.stages, self.elastic, steps)

    def _empty(self, options: Options) -> None:
        """Fetch the buffer, again and again where the last step passed more instants than it has room for."""
        self._fetch()
        while self.code == BUFFER_FULL and options.save_interval > 0.0:
            begin, size = self.record.step.began, self.record.step.size
            save(self.whole.tables, begin, size, options, self.flow, self.record)
            if self.record.count.rows == 0:
                return
            self._fetch()

    def solution(self, model: dict[str, Any], *, notes: tuple[str, ...] = (), wall_time: float = 0.0) -> Solution:
        """The record of what was run so far, with the nodes of the flexible bodies; see `Run.solution`."""
        twin, self.program = self.program, self.whole
        try:
            text, deformation = self._status_of(twin), self.elastic.now.saved()
            found = super().solution(model, notes=(*notes, *self._remarks()), wall_time=wall_time)
        finally:
            self.program = twin
        elastic = {f"elastic.{name}": array for name, array in deformation.items()}
        return replace(found, status=text, restart={**found.restart, **elastic})

    def status(self) -> str:
        """How the run ended, in a sentence."""
        return self._status_of(self.program) if self.program is not self.whole else ""

    def _status_of(self, twin: Program) -> str:
        if self.note:
            return f"{self.note}, at t = {self.flow.clock.t:.6g} s."
        if self.code in ENDINGS:
            return f"Stopped at t = {self.flow.clock.t:.6g} s: {self._ending(self.code)}"
        return sentence(twin, self.code, self.flow, self.trial, self.record)

    def _ending(self, code: int) -> str:
        """What an elastic step says that could not be done."""
        place = int(self.elastic.scratch.b[0])
        moved = float(np.abs(self.elastic.trial.u[:-3]).max())
        names = (*self.whole.names.coordinates, *(f"joint row {k}" for k in range(len(self.elastic.now.drift))))
        return ENDINGS[code].format(name=names[place], moved=moved)

    def _remarks(self) -> tuple[str, ...]:
        """What the shared displacements of joints with play carried."""
        force = self.elastic.now.memory.tie
        if not (self.elastic.settings.flexible and len(self.elastic.model.ties)):
            return ()
        text = f"Displacements shared in joints with play carried forces of up to {force:.3g} N"
        return (f"{text}, which tend to 0 with smaller steps.",)
