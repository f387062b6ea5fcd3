"""Compiler from a mechanism to a program."""

from __future__ import annotations

import gc
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from flexmb.arguments import checked
from flexmb.errors import InputError, ModelError
from flexmb.model.contributions import Contributions, ControlContribution, RowMotion, node_coordinates
from flexmb.model.law import Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.shape import LateShapes, Shapes
from flexmb.program.check_kernels import call_each_kernel
from flexmb.program.controls import samplers, wired
from flexmb.program.numbering import Numbering, state_coordinates
from flexmb.program.program import Names, Program, ReferenceConfiguration
from flexmb.program.signals import aliases
from flexmb.program.structure import numbers_of, structure_of


@checked
def compile(
    mechanism: Mechanism,
    *,
    closed: bool = False,
    start: bool = False,
    controlled: bool = False,
    touching: bool = False,
) -> Program:
    """Flat arrays, kernels and names of a mechanism.

    Parameters
    ----------
    mechanism : the mechanism.
    closed : with the clearance joints replaced by ideal ones.
    start : with elastic joints replaced, too, for closed loops and start velocities.
    controlled : with controls in spite of `closed`; these must have no states.
    touching : with the contacts that no ideal joint replaces, such as cables and stops, in spite of `closed`.

    Raises
    ------
    ModelError : a mechanism without bodies.
    InputError : something that is no mechanism; parts whose points do not fit their bodies.
    KernelError : a user's kernel that unpacks a wrong number of parameters, cannot be compiled or returns NaN.
    """
    with _without_collector():
        contributions = chosen_contributions(
            _contributions(mechanism), closed=closed or start, start=start, controlled=controlled, touching=touching
        )
        number = Numbering(mechanism, controls=not (closed or start))
        return _compiled(mechanism, contributions, number, LateShapes(mechanism.shapes))


def compile_with_start(mechanism: Mechanism) -> tuple[Program, Program]:
    """Program of a mechanism, and the program of its start values, from one reading of the parts."""
    with _without_collector():
        contributions, number, shapes = _contributions(mechanism), Numbering(mechanism), LateShapes(mechanism.shapes)
        program = _compiled(mechanism, chosen_contributions(contributions, closed=False, start=False), number, shapes)
        always = all(c.holds == "always" for c in contributions.constraints)
        if always and not contributions.contacts and not contributions.controls:
            return program, program
        if contributions.controls:
            number = Numbering(mechanism, controls=False)
        return program, _compiled(
            mechanism, chosen_contributions(contributions, closed=True, start=True), number, shapes
        )


@contextmanager
def _without_collector() -> Iterator[None]:
    """Switch off Python's collector of cycles, which would inspect a hundred thousand new objects."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def _contributions(mechanism: Mechanism) -> Contributions:
    """All contributions to a mechanism with bodies, or an error."""
    if not isinstance(mechanism, Mechanism):
        raise InputError(f"compile: {mechanism!r} is not a Mechanism.")
    if not mechanism.bodies:
        raise ModelError(f"{mechanism.label} has no bodies; add at least one.")
    return mechanism.contributions()


def _compiled(mechanism: Mechanism, contributions: Contributions, number: Numbering, shapes: Shapes) -> Program:
    """Program of the contributions of a mechanism."""
    call_each_kernel(contributions, number)
    declared, others = contributions.controls, aliases(mechanism)
    contributions = wired(contributions, number, others)
    structure = structure_of(contributions, number)
    p, z = numbers_of(contributions)
    driven = [row for c in contributions.constraints for row in c.motions]
    names = Names(
        structure.elements,
        structure.coordinates,
        structure.rows,
        structure.contacts,
        tuple(body.name for body in mechanism.bodies),
        structure.signals,
        others,
    )
    return Program(
        mechanism.name,
        structure.filled(p),
        structure.kernels,
        structure.symbolic,
        reference_configuration(mechanism, number, z),
        names,
        shapes,
        tuple(period_of(row) for row in driven),
        structure.drives,
        number.extent,
        least_clearance(contributions),
        motions_of(contributions),
        tuple(c.normal for c in contributions.contacts),
        samplers(declared, contributions.controls, structure.tables.controls.z, names),
        tuple(c.part for c in contributions.controls),
        tuple(k for c in declared if c.sample is None for k in _settled(c, number)),
    )


def least_clearance(contributions: Contributions) -> float | None:
    """The smallest clearance of all contacts [m]; infinite where none has one, None without contacts."""
    return min((c.p[0] or math.inf for c in contributions.contacts), default=None)


def _settled(control: ControlContribution, number: Numbering) -> list[int]:
    """Coordinates of the states of a control that begin where their rates are 0."""
    dofs = number.dofs(state_coordinates(control))
    return [dofs[k] for k in control.settled]


def period_of(row: RowMotion) -> float | None:
    """The period of a driven row [s]; that of a motion which goes on counts for an angle, not for a travel."""
    motion, period = row.motion, row.motion.period
    if period is None or row.units[0] == "rad":
        return period
    p = np.array(motion.parameters(), dtype=float)
    first, half, last = (motion.kernel(p, part * period)[0] for part in (0.0, 0.37, 1.0))
    size = max(abs(first), abs(half - first))
    return period if abs(last - first) <= 1e-9 * size else None


def motions_of(contributions: Contributions) -> tuple[Motion, ...]:
    """Motions of drives, factors of loads, and prescribed inputs of controls that act at all times."""
    driven = [row.motion for c in contributions.constraints for row in c.motions]
    inputs = [source.motion for control in contributions.controls for source in control.sources]
    found = [*driven, *[e.factor for e in contributions.elements], *inputs]
    return tuple([motion for motion in found if motion is not None])


def chosen_contributions(
    contributions: Contributions, *, closed: bool, start: bool, controlled: bool = False, touching: bool = False
) -> Contributions:
    """The contributions in motion; with ideal joints for contacts, and without controls (`closed`); for start values.

    Controls and their loads have no part in closed loops and start velocities, nor have contacts and their friction;
    `touching` keeps the ones that no ideal joint replaces, and the friction of the ideal joints.
    """
    holding = {"always", *(["closed"] if closed else []), *(["start"] if start else [])}
    constraints = tuple(c for c in contributions.constraints if c.holds in holding)
    if not closed:
        return replace(contributions, constraints=constraints)
    if not touching:
        constraints = tuple(replace(c, joint_friction=None) if c.rubs_closed else c for c in constraints)
    replaced = {c.part for c in contributions.constraints if c.holds == "closed"}
    contacts = tuple(c for c in contributions.contacts if touching and c.part not in replaced)
    if controlled:
        return replace(contributions, constraints=constraints, contacts=contacts)
    own = {name for control in contributions.controls for name in control.loads}
    elements = tuple([e for e in contributions.elements if not own or e.part not in own])
    signals = tuple([s for s in contributions.signals if not own or s.part not in own])
    return replace(
        contributions, elements=elements, constraints=constraints, contacts=contacts, signals=signals, controls=()
    )


def reference_configuration(mechanism: Mechanism, number: Numbering, z: np.ndarray) -> ReferenceConfiguration:
    """Reference configuration with start displacements, declared velocities, and histories at the start.

    A rigid motion is declared at the main node alone, so that it holds wherever closing the loops moves the body.
    """
    q = number.pose()
    v = np.full(number.n_q, np.nan)
    owner = np.zeros(number.n_q, dtype=np.int64)
    for k, body in enumerate(mechanism.bodies):
        first, last = number.of_body[body.name]
        owner[first:last] = k
        velocity, displacement = body.start_velocity(), body.start_displacement()
        if displacement is not None:
            q[first:last] += np.array(displacement).ravel()
        if velocity is not None and np.ndim(velocity) == 2:
            v[first:last] = np.array(velocity).ravel()
        elif velocity is not None:
            v[number.dofs(node_coordinates(body.name, body.main))] = velocity
    v[number.n_b :], owner[number.n_b :] = 0.0, len(mechanism.bodies) + np.arange(number.n_q - number.n_b) // 3
    for controller in mechanism.controllers if number.n_q > number.n_b else ():
        control = controller.control()
        states = number.dofs(state_coordinates(control))  # none of a sampled control
        v[states[: len(control.start)]] = control.start[: len(states)]
    turns = np.array([node.turns for _, node in number.nodes], dtype=float)
    return ReferenceConfiguration(q, v, z, owner, turns)
