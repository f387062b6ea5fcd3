"""`check_part`: the kernels of one part of a mechanism against their contracts."""

import pickle
from dataclasses import replace
from typing import Any

import numpy as np

from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import KernelError
from flexmb.model import contributions as model
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program
from flexmb.testing.bench import Bench, Report, TestedKernel, check_control, check_control_tangents, check_element
from flexmb.testing.constraints import check_constraint, check_contact, check_joint_friction, check_motion

MOST_PIECES = 6  # largest number of pieces of one kernel to be checked: the elements of a beam repeat each other


def check_part(mechanism: Mechanism, part_name: str, *, seed: int = 0) -> Report:
    """Check the kernels of one part against their contracts, at random states around the reference configuration.

    Compiled and plain Python function agree.  Tangents agree with differences of forces, energies with forces.  A
    second call gives the same result, and inputs are not changed.  Values are finite, also for h = 0; entries declared
    as zero are zero.  Action equals reaction between two bodies.  Results turn and shift with the frame.  Part,
    mechanism and program can be pickled.

    Parameters
    ----------
    mechanism : a mechanism with the part.
    part_name : name of the part.
    seed : seed of the random states.

    Raises
    ------
    KernelError : the first broken contract, with part, kernel, entry, both numbers and the state.
    ModelError : no such part.

    Notes
    -----
    A state at which differences do not converge counts as a kink and is left out; a kernel with more than a third of
    such states is refused.  Action = reaction is checked without inertia.
    """
    program, part = compile_mechanism(mechanism), mechanism.find(part_name)
    bench = Bench(mechanism, part, seed)
    weightless = part.contributions(replace(mechanism, gravity=(0.0, 0.0)))
    checked: dict[str, set[Any]] = {}
    for contribution, bare in zip(part.contributions(mechanism), weightless, strict=True):
        if isinstance(contribution, model.AngleContribution):  # differences of coordinates, without a kernel
            continue
        kernel = contribution.gap if isinstance(contribution, model.ContactContribution) else contribution.kernel
        checked_p = checked.setdefault(kernel.name, set())
        if contribution.p not in checked_p and len(checked_p) < MOST_PIECES:
            checked_p.add(contribution.p)
            check_piece(bench, contribution, bare)
        if isinstance(contribution, model.ControlContribution):
            check_control_tangents(bench, program, contribution)
    check_pickles(bench, mechanism, part_name, program)
    return bench.report()


def check_piece(bench: Bench, contribution: model.Contribution, weightless: Any) -> None:
    """Check one piece of a part; `weightless` is the same piece without gravity."""
    if isinstance(contribution, model.ElementContribution):
        check_element(bench, contribution, weightless)
        if contribution.factor is not None:
            check_motion(bench, contribution.factor)
    elif isinstance(contribution, model.ConstraintContribution):
        check_constraint(bench, contribution)
        for driven in contribution.motions:
            check_motion(bench, driven.motion)
        if contribution.joint_friction is not None:
            check_joint_friction(bench, contribution, contribution.joint_friction)
    elif isinstance(contribution, model.ContactContribution):
        check_contact(bench, contribution)
    elif isinstance(contribution, model.ControlContribution):
        check_control(bench, contribution)
    elif isinstance(contribution, model.SignalContribution):
        tested = TestedKernel(bench.owner, contribution.kernel, contribution.p)
        for state in bench.states(contribution.coordinates, "t q v a"):
            tested.checked_call(state)
            bench.note(f"{contribution.kernel.name}: compiled = Python, finite, repeatable")


def check_pickles(bench: Bench, mechanism: Mechanism, part_name: str, program: Program) -> None:
    """Check that part, mechanism and program can be sent to another process with the same results."""
    part, copies = mechanism.find(part_name), {}
    for word, thing in (("part", part), ("mechanism", mechanism), ("program", program)):
        try:
            copies[word] = pickle.loads(pickle.dumps(thing))  # noqa: S301 - written on the same line
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            text = f"{bench.owner}: the {word} cannot be pickled ({error})."
            text += " Give it numbers, texts, tuples and functions that other processes can import;"
            raise KernelError(f"{text} no open files, no locks, no lambdas.") from error
    if copies["part"] != part:
        text = f"{bench.owner}: its copy, pickled and read back, differs from it."
        raise KernelError(f"{text} Use plain numbers, texts, tuples and frozen dataclasses as fields.")
    n = program.n_q
    q = program.reference.q + 1e-3 * program.length * bench.random.uniform(-1.0, 1.0, n)
    v, a = bench.random.uniform(-1.0, 1.0, (2, n))
    lam = bench.random.uniform(-1.0, 1.0, program.n_c)
    programs = program, copies["program"]
    mine, theirs = (StateEvaluation(p).at(q, v, a, lam, t=0.1, weights=(1.0, 1.0, 1.0)) for p in programs)
    others = theirs.work.saved()
    for name, values in mine.work.saved().items():
        if not np.array_equal(values, others[name]):
            raise KernelError(f"{bench.owner}: a pickled and reread program computes another {name!r}.")
    bench.note("part, mechanism, program: pickled and reread the same")
