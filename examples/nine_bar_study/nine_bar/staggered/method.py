"""Method `Staggered`: alternating steps of the rigid counterpart and of a linear elastic model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from nine_bar_study.nine_bar.staggered.elastic import elastic_model
from nine_bar_study.nine_bar.staggered.elastic_step import ELASTIC_SINGULAR, TOO_FAR
from nine_bar_study.nine_bar.staggered.loop import advance_staggered, begin_elastic, whole_motion, write_whole
from nine_bar_study.nine_bar.staggered.rigid_counterpart import rigid_twin
from nine_bar_study.nine_bar.staggered.saved_instants import save_interpolated

from flexmb import checks
from flexmb.engine.energy import RESIDUAL_LIMIT_RUNGE_KUTTA
from flexmb.engine.state.record import RUNNING, Options
from flexmb.engine.step.method import Method, Stepper, evaluate_state, store_powers
from flexmb.engine.step.runge_kutta import new_stages
from flexmb.engine.system.evaluate import evaluate_accepted
from flexmb.errors import AssemblyError, InputError, ModelError
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import refuse_controllers
from flexmb.program.compiler import compile_with_start
from flexmb.program.program import Program
from flexmb.statics.start.consistent import Start, consistent_start

if TYPE_CHECKING:
    from flexmb.run.run import Run

ENDINGS = {
    ELASTIC_SINGULAR: "the elastic equations became singular at {name!r}. Do the joints leave it without mass?",
    TOO_FAR: (
        "{name!r} is displaced by {moved:.3g} against the rigid model, too far for linear elasticity. The inertia load "
        "of the previous step may be unstable: try a smaller step, more passes, or a Newmark method."
    ),
}
"""Messages of the codes of the elastic step."""


@dataclass(frozen=True)
class Staggered(Method):
    """Alternating steps of the rigid counterpart and of a linear elastic model.

    1. Runge-Kutta step of the rigid counterpart.  A rigid body of equal mass, centre of mass and moment of inertia
       replaces each flexible body.  The rigid motion determines the contact forces.
    2. Newmark step (beta = 1/4, gamma = 1/2) of linear elasticity about the new pose.  U are displacements along X and
       Y, and rotations, of the nodes:

           M U'' + (C + 2 R^T m R') U' + (K + R^T m R'') U = F - M a_r,    G U = 0

       with u = R U in the axes of a body, forces F of contacts, loads and weight, accelerations a_r of the rigid
       counterpart, damping C of the bodies, and constraint Jacobian G of the pose.
    3. The inertia forces and moments of the elastic motion, summed over each body, load the rigid counterpart in the
       next step.

    The method simulates mechanisms of `RigidBody`, `RigidLink`, `FlexibleLink`, `FlexibleFrame`, joints, drives,
    contacts, loads, and springs between rigid bodies.  Ideal joints must be frictionless.  Steps must be `FixedStep`.

    Parameters
    ----------
    rotation : terms of rotating axes: "printed", the equations above; "inertial", the equations without 2 R^T m R' and
        R^T m R'', with damping of rates relative to the body.
    play : displacements of journal and bearing in a joint with clearance: "independent" or "shared" (equal).
    mean_axes : whether rigid motions that satisfy G are removed from U; U then has no momentum in these motions.
    passes : repetitions of each step with the inertia load of its end, >= 1.

    Raises
    ------
    InputError : an unknown word, passes not an integer >= 1.

    Notes
    -----
    In fixed axes M U'' is the inertia force of U.  The published terms are correct for slow rotation.  A beam with the
    angular velocity w has the frequency at rest f with "printed", and sqrt(f^2 - w^2) with "inertial".  Both lack the
    centrifugal stiffening.

    Drive torques, forces of joints and contacts, ex and ey are signals of the rigid counterpart under the load of step
    3.  Positions, velocities and accelerations of nodes are signals of the rigid counterpart plus U, U', U''.  Energies
    belong to this sum.  `energy.residual` is the energy gained or lost by the coupling.  Loads depend on the rigid
    motion only.

    Contacts depend on the rigid motion only.  With "independent" displacements and mean axes, impacts are impacts of
    the rigid counterpart, without influence of the elastic compliance.  With "shared" displacements the method
    converges to the coupled linear equations as h tends to 0.  The load of step 3 is one step late and nearly as large
    as the inertia of the rigid counterpart.  During a contact this delay acts as negative damping, and runs with one
    pass diverge at practicable steps (docs/decisions/038-feedback-of-the-staggered-scheme.md).  Repeated passes give
    the impacts of the coupled equations, to first order in h.  Without mean axes, rigid motions of U are neutrally
    stable.

    Source: X. Chen, S. Jiang, Y. Deng, Q. Wang, Nonlinear Dynamics (2018), section 4, eqs (26)-(30) and 4.4.  In the
    equations the vectors U^1 and U^2 share the coordinates of the clearance joint; the text calls them independent.
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
        """Stepper of a compiled mechanism."""
        if mechanism is None:
            raise InputError("Staggered: the mechanism is missing; a program alone has no rigid counterpart.")
        return StaggeredStepper(program, mechanism, self)


class StaggeredStepper(Stepper):
    """Stepper of `Staggered`; the signals belong to the flexible mechanism.

    Parameters
    ----------
    whole : program of the flexible mechanism.
    mechanism : flexible mechanism.
    method : parameters of the method.
    """

    residual_limit = RESIDUAL_LIMIT_RUNGE_KUTTA

    def __init__(self, whole: Program, mechanism: Mechanism, method: Staggered) -> None:
        refuse_controllers(mechanism, "Staggered", "the method splits the motion of the bodies alone")
        self.mechanism = rigid_twin(f"simulate {mechanism.name!r} with Staggered", mechanism)
        twin, self.closed = compile_with_start(self.mechanism)
        super().__init__(twin)
        self.reported = whole
        self.elastic = elastic_model(mechanism, whole, twin, method)
        self.stages = new_stages(twin)

    def start(self, mechanism: Mechanism, closed: Program, *, redundant: bool) -> Start:  # noqa: ARG002
        """Consistent start values of the rigid counterpart; the arguments are not used."""
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
        """Elastic accelerations at the start values, with unstressed bodies; returns a code."""
        n, full = self.program.n_q, [np.zeros(self.program.n_q + 3) for _ in range(3)]
        for target, values in zip(full, (start.q, start.v, start.a), strict=True):
            target[:n] = values
        still = np.zeros(n + 3)
        common = (self.program.tables, self.program.addresses, time, 0.0)
        evaluate_accepted(*common, *full, start.lam, z.copy(), still, still, run.work)
        if not self.elastic.settings.flexible:
            return RUNNING
        code: int = begin_elastic(self.program.tables, time, run.work, self.elastic, *full)
        return code

    def advance(self, run: Run, options: Options, steps: int) -> int:
        """Take at most `steps` steps of both models; returns the code of the ending."""
        code: int = advance_staggered(*run.arguments(options), self.stages, self.elastic, steps)
        return code

    def save(self, run: Run, options: Options) -> None:
        """Save the remaining instants within the last step."""
        save_interpolated(self.reported.tables, options, run.flow, run.record)

    def evaluate(self, run: Run) -> None:
        """Evaluate the accepted state with its displacements, and store its powers for the ledger."""
        flow, el = run.flow, self.elastic
        evaluate_state(self.program, flow, run.work)
        whole_motion(el, flow.clock.t, 0.0, flow.q, flow.v, flow.a, el.now, flow.ledger, run.work)
        store_powers(self.program, flow, run.work)

    def write(self, run: Run) -> None:
        """Write the signals of the last evaluated state."""
        common = (self.program.tables, self.program.addresses, run.flow.clock.t)
        write_whole(*common, run.flow, run.work, run.record, self.elastic)

    def reset_peaks(self) -> None:
        """Reset the largest force of shared displacements to 0."""
        self.elastic.now.memory.tie = 0.0

    def explain(self, code: int) -> str | None:
        """Message of a code of the elastic step; None for another code."""
        if code not in ENDINGS:
            return None
        place = int(self.elastic.scratch.b[0])
        moved = float(np.abs(self.elastic.trial.u[:-3]).max())
        names = (*self.reported.names.coordinates, *(f"joint row {k}" for k in range(len(self.elastic.now.drift))))
        return ENDINGS[code].format(name=names[place], moved=moved)

    def remarks(self) -> tuple[str, ...]:
        """Remark on the largest force of shared displacements in joints with clearance."""
        force = self.elastic.now.memory.tie
        if not (self.elastic.settings.flexible and len(self.elastic.model.ties)):
            return ()
        text = f"Displacements shared in joints with clearance carried forces of up to {force:.3g} N"
        return (f"{text}, which tend to 0 with smaller steps.",)

    def saved(self) -> dict[str, np.ndarray]:
        """Elastic state for a restart, by name."""
        return {f"elastic.{name}": array for name, array in self.elastic.now.saved().items()}

    def restore(self, restart: Mapping[str, Any]) -> None:
        """Set the elastic state of a restart."""
        own = {name.removeprefix("elastic."): array for name, array in restart.items() if name.startswith("elastic.")}
        self.elastic.now.restore(own)
