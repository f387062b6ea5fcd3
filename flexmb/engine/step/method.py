"""Methods and their steppers: start values, steps, signals, endings and restarts of one compiled model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexmb.engine.compiled import ahead
from flexmb.engine.energy import RESIDUAL_LIMIT, contact_losses, update_balance
from flexmb.engine.linalg.lu import LU
from flexmb.engine.state import record as records
from flexmb.engine.state.flow import Flow, Trial
from flexmb.engine.state.record import RUNNING, Coefficients, Options, RunRecord
from flexmb.engine.step.acceptance import save_instants
from flexmb.engine.step.step_size import LARGEST_STEPS, SMOOTH_STEPS, Adaptive, FixedStep
from flexmb.engine.system.constraints import report_forces
from flexmb.engine.system.evaluate import evaluate_accepted
from flexmb.engine.system.outputs import write_outputs
from flexmb.engine.system.work import Work
from flexmb.errors import InputError
from flexmb.fields import Input
from flexmb.program.program import Addresses, Program, Tables
from flexmb.statics.start.consistent import Start, consistent_start

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism
    from flexmb.run.run import Run

# Types of the arguments that all compiled loops have in common (`Run.arguments`); of others a loop has annotations.
ahead.ARGUMENTS.update(tables=Tables, address=Addresses, lu=LU, options=Options, flow=Flow, trial=Trial, work=Work)
ahead.ARGUMENTS.update(record=RunRecord, steps=int)


# Base of the integration methods: a frozen record of numbers that makes the `Stepper` of a model
@dataclass(frozen=True)
class Method(Input):
    """Base of `Newmark`, `RungeKutta4`, `RadauIIA`, `DormandPrince`, and of methods as in examples/nine_bar_study.

    A further method derives from this class and returns its `Stepper` in `stepper`.  Class variables:
    `estimates_error`, whether the method estimates the error of a step; `independent`, whether it needs independent
    constraint equations; `loops`, compiled loops, which a second process may compile (`compiled/ahead.py`).
    """

    estimates_error: ClassVar[bool] = False
    independent: ClassVar[bool] = False
    loops: ClassVar[tuple[Any, ...]] = ()

    def stepper(self, program: Program, mechanism: Mechanism | None = None) -> Stepper:
        """Stepper of a compiled mechanism; most methods need `program` only."""
        raise NotImplementedError

    def fewest_steps(self, *, contacts: bool) -> float:
        """Least number of steps in a period or a run under error control, with `contacts` or without."""
        return LARGEST_STEPS if contacts else SMOOTH_STEPS

    def impacts(self, step: Adaptive) -> tuple[float, float]:
        """Least number of steps of an impact under the error control `step`; factor of `ONSET_TOLERANCE`."""
        return step.steps_of_an_impact, 1.0

    def check(self, label: str, step: FixedStep | Adaptive, redundant: str) -> None:
        """Refuse steps and constraints that the method does not support.

        Parameters
        ----------
        label : first words of the messages.
        step : kind of steps.
        redundant : "refuse" or "least-norm", see `simulate`.

        Raises
        ------
        InputError : error-controlled steps without an error estimate; `redundant` "least-norm" with `independent`.
        """
        name = type(self).__name__
        if not self.estimates_error and not isinstance(step, FixedStep):
            raise InputError(f"{label}: {name} has no error estimate; give step=FixedStep(size).")
        if self.independent and redundant != "refuse":
            text = f"{label}: redundant is {redundant!r}"
            raise InputError(f"{text}; {name} needs independent joints. Use a Newmark method.")


class Stepper:
    """Steps of one method in one compiled model; base of the steppers of all methods.

    A new method is a subclass of `Method` and a subclass of `Stepper`, whose `advance` calls the compiled loop of the
    method, by default its first one with `stages`.  A `Run` calls its stepper for all that differs between methods.

    Attributes
    ----------
    program : the model whose equations are stepped.
    stages : work arrays of the method itself, a `Record`; None without.
    reported : the model whose signals are saved; the same for most methods.
    residual_limit : largest residual of the balance of energies, relative to the scale of energies.
    form : form of the constraints;  regular, first : coefficients of the Newmark family, see `Options`.
    """

    residual_limit = RESIDUAL_LIMIT
    form = records.GEAR_GUPTA_LEIMKUHLER
    regular = first = Coefficients(0.0, 0.0, 0.25, 0.5)

    def __init__(self, program: Program, stages: Any = None) -> None:
        self.program = self.reported = program
        self.stages = stages

    @property
    def columns(self) -> int:
        """Number of signals."""
        return int(self.reported.tables.sizes.n_y)

    def record(self, rows: int, kept: np.ndarray | None = None) -> RunRecord:
        """Buffers for `rows` saved instants of the signals `kept` of `reported` (places; None: all)."""
        record = records.new_record(self.reported, rows, kept)
        if self.reported is self.program:
            return record
        own = records.new_record(self.program, 1)
        own_of_step = {name: getattr(own, name) for name in ("held_rows", "last_lam", "last_z", "passed")}
        return record.replaced(**own_of_step, poses=records.new_poses(self.reported, self.program.tables.sizes.n_z))

    def start(self, mechanism: Mechanism, closed: Program, *, redundant: bool) -> Start:
        """Start values of the mechanism; `closed`: its program with ideal joints for contacts."""
        return consistent_start(mechanism, self.program, redundant=redundant, closed=closed)

    def prepare(self, run: Run, start: Start, z: np.ndarray, time: float) -> int:  # noqa: ARG002 - methods of users may
        """Prepare the start values of the method itself; RUNNING, or the code of an ending."""
        return RUNNING

    def advance(self, run: Run, options: Options, steps: int) -> int:
        """Take at most `steps` steps; RUNNING, or the code of the ending."""
        own = () if self.stages is None else (self.stages,)
        return int(run.method.loops[0](*run.arguments(options), *own, steps))

    def save(self, run: Run, options: Options) -> None:
        """Save the remaining instants within the last step, after the buffer was full."""
        common = (self.program.tables, self.program.addresses, options)
        save_instants(*common, run.flow, run.trial, run.work, run.record)

    def evaluate(self, run: Run) -> None:
        """Evaluate the present state of `run.flow`; store its powers and forces for the balance of energies."""
        evaluate_state(self.program, run.flow, run.work)
        store_powers(self.program, run.flow, run.work)

    def write(self, run: Run) -> None:
        """Write the signals of the state that was evaluated last to `run.record.signals`."""
        flow = run.flow
        common = (self.program.tables, self.program.addresses, flow.clock.t)
        record = run.record
        write_outputs(*common, flow.q, flow.v, flow.a, run.work, flow.ledger, record.peak, True, record.signals)

    def reset_peaks(self) -> None:
        """Reset the peaks of the method's own signals."""

    def explain(self, code: int) -> str | None:  # noqa: ARG002 - most have none of their own
        """Sentence on an ending of the method itself; None for an ending of all methods."""
        return None

    def remarks(self) -> tuple[str, ...]:
        """Notes on the run."""
        return ()

    def saved(self) -> dict[str, np.ndarray]:
        """Arrays of a restart by name, in addition to the `Flow`."""
        return {}

    def restore(self, restart: Mapping[str, Any]) -> None:
        """Restore the arrays of `saved`; a `ValueError` has the name of an array that is missing or of another size."""


def evaluate_state(program: Program, flow: Flow, work: Any) -> None:
    """Evaluate forces, energies and joint forces of the state in `flow`."""
    still = np.zeros(program.n_q + 3)
    common = (program.tables, program.addresses, flow.clock.t, 0.0)
    evaluate_accepted(*common, flow.q, flow.v, flow.a, flow.lam, flow.z, still, still, work)
    report_forces(program.tables, flow.lam, work)
    flow.momentum[:] = work.momentum


def store_powers(program: Program, flow: Flow, work: Any) -> None:
    """Store powers and forces of the last evaluation, for the balance of energies in the next step."""
    tables, addresses = program.tables, program.addresses
    contact_losses(tables, addresses, 0.0, flow, flow.q, flow.v, work)
    state = (flow.q, flow.v, flow.q, flow.v)
    update_balance(tables, addresses, flow.clock.t, 0.0, *state, flow.ledger, flow.balance, flow.memory, work)
