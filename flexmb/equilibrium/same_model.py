"""Whether an equilibrium belongs to a model: its coordinates, the equations of its joints, its forces."""

from __future__ import annotations

import numpy as np

from flexmb.equilibrium.found import Equilibrium
from flexmb.equilibrium.statics import correction
from flexmb.equilibrium.steady_rotation import Spin
from flexmb.errors import InputError, SolveError
from flexmb.program.program import Program
from flexmb.system.state_evaluation import StateEvaluation

OTHER_MODEL_STEP = 1e-6
"""Newton step relative to the size of the mechanism, above which an equilibrium belongs to another model."""


def refuse_other_names(owner: str, program: Program, at: Equilibrium) -> None:
    """`InputError` when an equilibrium has other coordinates or joints than the model; `owner`: the caller."""
    sizes = ((len(at.q), program.n_q, "coordinates"), (len(at.lam), program.n_c, "equations of joints"))
    for given, own, noun in sizes:
        if given != own:
            raise InputError(f"{owner}: the equilibrium has {given} {noun}, the model {own}. Use its own.")
    if at.names != program.names.coordinates:
        other = next(a for a, b in zip(at.names, program.names.coordinates, strict=True) if a != b)
        raise InputError(f"{owner}: the equilibrium has a coordinate {other!r}, the model has none. Use its own.")


def refuse_other_forces(owner: str, program: Program, system: StateEvaluation, at: Equilibrium) -> None:
    """`InputError` when the pose is no equilibrium of this model; `owner`: the caller."""
    try:
        step = correction(system, at.q, at.lam, np.zeros(program.n_q), Spin(at.spin, at.about))[: program.n_q]
    except SolveError:
        return  # on the verge of buckling: nothing can be said
    step = np.abs(step) / np.where(program.tables.kind == 1, 1.0, program.length)
    if step.max() > OTHER_MODEL_STEP:
        raise InputError(
            f"{owner}: the equilibrium given is none of mechanism {program.name!r}: its forces would move "
            f"{program.names.coordinates[int(step.argmax())]!r} by {step.max():.3g} (of the model's size, or rad). "
            "Compute it with the same mechanism."
        )
