"""Rigid and elastic steps in turn: the method `Staggered`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flexmb import checks
from flexmb.energy.balance import RESIDUAL_LIMIT_RUNGE_KUTTA
from flexmb.errors import AssemblyError, InputError, ModelError
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile_with_start
from flexmb.program.program import Program
from flexmb.start.consistent import Start, consistent_start
from flexmb.state.options import Options
from flexmb.state.record import RUNNING
from flexmb.step.method import Method
from flexmb.step.runge_kutta import new_stages
from flexmb.step.stepper import Stepper, evaluate_state, store_powers
from flexmb.study.nine_bar.staggered.elastic import elastic_model
from flexmb.study.nine_bar.staggered.elastic_step import ELASTIC_SINGULAR, TOO_FAR
from flexmb.study.nine_bar.staggered.loop import advance_staggered, begin_elastic, whole_motion, write_whole
from flexmb.study.nine_bar.staggered.rigid_counterpart import rigid_twin
from flexmb.system.evaluate import evaluate_accepted

if TYPE_CHECKING:
    from flexmb.run.run import Run

ENDINGS = {
    ELASTIC_SINGULAR: "the elastic equations became singular at {name!r}. Do the joints leave it without mass?",
    TOO_FAR: (
        "{name!r} is displaced by {moved:.3g} against the rigid model, too far for linear elasticity. The load that is "
        "handed back one step late may be unstable: try a smaller step, more passes, or a Newmark method."
    ),
}
"""How elastic steps end a run."""


@dataclass(frozen=True)
class Staggered(Method):
    """A rigid and an elastic model that take steps in turn, each with what the other found last.

    1. Runge and Kutta's step of the rigid mechanism: every flexible body is replaced by the rigid one of the same mass,
       centre and inertia; contact forces come from its motion.
    2. Newmark's step (beta = 1/4, gamma = 1/2) of linear elasticity about the pose found, U being the displacements of
       the nodes along X and Y and their rotations:

           M U'' + (C + 2 R^T m R') U' + (K + R^T m R'') U = F - M a_r,    G U = 0

       with u = R U in the axes of a body, F of contact, loads and weight, a_r accelerations of the rigid model, and G
       the joints and drives of the pose; C is the damping of the bodies.
    3. The inertia force and moment of the elastic motion, summed body by body, load the rigid model in the next step.

    For mechanisms of `RigidBody`, `RigidLink`, `FlexibleLink`, `FlexibleFrame`, with joints without friction in ideal
    ones, drives, contacts and loads, and springs between rigid ones; with `FixedStep` only.

    Parameters
    ----------
    rotation : terms of the rotating axes: "printed", as above; or "inertial", without 2 R^T m R' and R^T m R'', and
        with damping of the rates seen from the body.  See the notes.
    play : what a joint with play does to U: "independent", nothing; or "shared", both of its ends are displaced alike.
    mean_axes : whether rigid motions that G leaves to U are taken out of it: it then has no momentum in any of them.
    passes : times each step is done, with the inertia of the elastic motion that was found at its end, >= 1.

    Raises
    ------
    InputError : an unknown word, passes that are no whole number > 0.

    Notes
    -----
    Where U is in fixed axes, M U'' is the inertia force; the printed terms are correct for none but u'' in place of
    the accelerations, that is for slow turning.  A beam that turns at w has, in the plane, the frequency at rest f
    with "printed", sqrt(f^2 - w^2) with "inertial"; centrifugal forces, which stiffen it, are in neither.

    Drive torques, forces of joints and contacts, ex and ey are those of the rigid model with the load of step 3.
    Positions, velocities and accelerations of nodes are those of the rigid model plus U, U', U''.  Energies belong to
    this sum, and `energy.residual` is what the coupling made or lost.  Loads see the rigid motion only.

    Contacts see the rigid motion alone.  With "independent" displacements and mean axes, U has no momentum in what the
    joints leave free, so impacts are those of the rigid mechanism: compliance softens none.  With "shared" ones the
    play is that of the whole motion, and the scheme tends to the coupled linear equations as h tends to 0.  But the
    load of step 3 is one step late, and nearly as large as the inertia of the rigid model: in contact that acts as
    negative damping, and runs with one pass blow up at any step that can be afforded (docs/design.md); passes repeated
    until the load stays give the impacts of the coupled equations, to the first order of h.  Without mean axes, rigid
    motions of U are neutral: they keep whatever disturbs them.

    Source: X. Chen, S. Jiang, Y. Deng, Q. Wang, Nonlinear Dynamics (2018), section 4, eqs (26)-(30) and 4.4.  There the
    vectors U^1 and U^2 share the coordinates of the clearance joint, though the text calls its members independent.
    """

    independent: ClassVar[bool] = True

    rotation: str = "printed"
    play: str = "independent"
    mean_axes: bool = True
    passes: int = 1

    def __post_init__(self) -> None:
        checks.one_of("Staggered", "rotation", self.rotation, ["printed", "inertial"])
        checks.one_of("Staggered", "play", self.play, ["independent", "shared"])
        if not isinstance(self.mean_axes, bool):
            raise InputError(f"Staggered: mean_axes is {self.mean_axes!r}; it must be True or False.")
        checks.count("Staggered", "passes", self.passes)

    def stepper(self, program: Program, mechanism: Mechanism | None = None) -> Stepper:
        """Stepper of the compiled mechanism."""
        if mechanism is None:
            raise InputError("Staggered: the mechanism is missing; a program alone has no rigid twin.")
        return StaggeredStepper(program, mechanism, self)


class StaggeredStepper(Stepper):
    """Steps of the rigid twin and of the elastic model in turn; signals are those of the mechanism itself.

    Parameters
    ----------
    whole : the compiled mechanism.
    mechanism : the mechanism.
    method : its numbers.
    """

    residual_limit = RESIDUAL_LIMIT_RUNGE_KUTTA

    def __init__(self, whole: Program, mechanism: Mechanism, method: Staggered) -> None:
        self.mechanism = rigid_twin(f"simulate {mechanism.name!r} with Staggered", mechanism)
        twin, self.closed = compile_with_start(self.mechanism)
        super().__init__(twin)
        self.reported = whole
        self.elastic = elastic_model(mechanism, whole, twin, method)
        self.stages = new_stages(twin)

    def start(self, mechanism: Mechanism, closed: Program, *, redundant: bool) -> Start:  # noqa: ARG002 - the twin's
        """Start values of the twin."""
        try:
            return consistent_start(self.mechanism, self.program, closed=self.closed)
        except (ModelError, AssemblyError) as error:
            text, _, advice = str(error).partition(". ")
            if "make a link flexible" not in advice:
                raise
            text = (
                f"simulate {self.mechanism.name!r} with Staggered: with rigid bodies in place of flexible ones, {text}"
            )
            raise type(error)(f"{text}. Remove a joint, start in another pose, or use a Newmark method.") from error

    def prepare(self, run: Run, start: Start, z: np.ndarray, time: float) -> int:
        """Elastic accelerations that go with the start of the twin, the bodies unstressed."""
        n, full = self.program.n_q, [np.zeros(self.program.n_q + 3) for _ in range(3)]
        for target, values in zip(full, (start.q, start.v, start.a), strict=True):
            target[:n] = values
        still = np.zeros(n + 3)
        common = (self.program.tables, self.program.addresses, time, 0.0)
        evaluate_accepted(*common, *full, start.lam, z.copy(), still, still, run.work)
        if not self.elastic.settings.flexible:
            return RUNNING
        return begin_elastic(self.program.tables, time, run.work, self.elastic, *full)

    def advance(self, run: Run, options: Options, steps: int) -> int:
        """Take at most `steps` steps of both models: the code of the ending."""
        return advance_staggered(*run.arguments(options), self.stages, self.elastic, steps)

    def evaluate(self, run: Run) -> None:
        """Evaluate the present state with its displacements; remember its powers and forces for the ledger."""
        flow, el = run.flow, self.elastic
        evaluate_state(self.program, flow, run.work)
        whole_motion(el, flow.clock.t, 0.0, flow.q, flow.v, flow.a, el.now, flow.ledger, run.work)
        store_powers(self.program, flow, run.work)

    def write(self, run: Run) -> None:
        """Signals of the state that was looked at last."""
        common = (self.program.tables, self.program.addresses, run.flow.clock.t)
        write_whole(*common, run.flow, run.work, run.record, self.elastic)

    def reset_peaks(self) -> None:
        """Begin anew to look for the largest shared force."""
        self.elastic.now.memory.tie = 0.0

    def explain(self, code: int) -> str | None:
        """What an elastic step says that could not be done."""
        if code not in ENDINGS:
            return None
        place = int(self.elastic.scratch.b[0])
        moved = float(np.abs(self.elastic.trial.u[:-3]).max())
        names = (*self.reported.names.coordinates, *(f"joint row {k}" for k in range(len(self.elastic.now.drift))))
        return ENDINGS[code].format(name=names[place], moved=moved)

    def remarks(self) -> tuple[str, ...]:
        """What the shared displacements of joints with play carried."""
        force = self.elastic.now.memory.tie
        if not (self.elastic.settings.flexible and len(self.elastic.model.ties)):
            return ()
        text = f"Displacements shared in joints with play carried forces of up to {force:.3g} N"
        return (f"{text}, which tend to 0 with smaller steps.",)

    def saved(self) -> dict[str, np.ndarray]:
        """The displacements."""
        return {f"elastic.{name}": array for name, array in self.elastic.now.saved().items()}

    def restore(self, restart: Mapping[str, Any]) -> None:
        """Take the displacements."""
        own = {name.removeprefix("elastic."): array for name, array in restart.items() if name.startswith("elastic.")}
        self.elastic.now.restore(own)
