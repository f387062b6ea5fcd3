"""From a mechanism to a program."""

from __future__ import annotations

import numpy as np

from flexmb.errors import InputError, ModelError
from flexmb.model.law import Motion
from flexmb.model.mechanism import Mechanism
from flexmb.model.pieces import Pieces, RowMotion
from flexmb.program.numbering import Numbering, blocks_and_edges
from flexmb.program.ordering import elimination_order
from flexmb.program.packing import KINDS, Packer
from flexmb.program.program import Drawn, Names, Program
from flexmb.program.signals import aliases, layout
from flexmb.program.smoke import call_each_kernel
from flexmb.program.symbolic import symbolic
from flexmb.program.tables import Sizes, Tables


def compile(mechanism: Mechanism, *, closed: bool = False, start: bool = False) -> Program:
    """Flat arrays, kernels and names of a mechanism.

    Parameters
    ----------
    mechanism : what to compile.
    closed : with the clearance joints replaced by ideal ones.
    start : with the elastic ones replaced, too, as loops are closed and start velocities are found.

    Raises
    ------
    ModelError : a mechanism without bodies.
    InputError : something that is no mechanism; parts whose points do not fit their bodies.
    KernelError : a user's kernel that unpacks a wrong number of parameters, cannot be compiled or returns NaN.
    """
    if not isinstance(mechanism, Mechanism):
        raise InputError(f"compile: {mechanism!r} is not a Mechanism.")
    if not mechanism.bodies:
        raise ModelError(f"{mechanism.label} has no bodies; add at least one.")
    pieces = chosen_pieces(mechanism, closed=closed or start, start=start)
    number = Numbering(mechanism)
    call_each_kernel(pieces, number)
    packer = Packer(pieces, number)
    order = elimination_order(*blocks_and_edges(pieces, number))
    pattern = symbolic(number.n_q + packer.n_c, *packer.pattern(), order)
    names = number.names()
    places = layout(pieces, names)
    elements = packer.elements(pattern.positions)
    constraints = packer.constraints(pattern.positions, places.constraints)
    contacts = packer.contacts(pattern.positions, places.contacts)
    measured = packer.measured(places.measured)
    sizes = Sizes(
        number.n_q,
        packer.n_c,
        len(packer.z),
        len(places.signals),
        places.energy,
        max((len(p.coordinates) for p in (*pieces.elements, *pieces.constraints, *pieces.signals)), default=1),
        max((p.rows for p in pieces.constraints), default=1),
        any(p.grip is not None for p in pieces.constraints),
    )
    kind = np.array([k % 3 == 2 for k in range(number.n_q)], dtype=np.int64)
    tables = Tables(sizes, np.array(packer.p, dtype=float), elements, constraints, contacts, measured, kind)
    driven = [(c.part, row) for c in pieces.constraints for row in c.motions]
    return Program(
        mechanism.name,
        tables,
        tuple(tuple(packer.kernels[kind].kernels) for kind in KINDS),
        pattern,
        drawn_pose(mechanism, number, packer.z),
        Names(
            names,
            tuple(f"{c.part}[{i}]" for c in pieces.constraints for i in range(c.rows)),
            tuple(c.label for c in pieces.contacts),
            tuple(body.name for body in mechanism.bodies),
            places.signals,
            aliases(mechanism),
        ),
        mechanism.shapes(),
        tuple(period_of(row) for _, row in driven),
        tuple(f"{part}.{row.name}" if row.name else part for part, row in driven),
        drawn_length(number),
        min((c.p[0] for c in pieces.contacts), default=None),
        motions_of(pieces),
    )


def period_of(row: RowMotion) -> float | None:
    """The period of a driven row [s]; that of a motion which goes on counts for an angle, not for a travel."""
    motion, period = row.motion, row.motion.period
    if period is None or row.units[0] == "rad":
        return period
    p = np.array(motion.parameters(), dtype=float)
    first, half, last = (motion.kernel(p, part * period)[0] for part in (0.0, 0.37, 1.0))
    size = max(abs(first), abs(half - first))
    return period if abs(last - first) <= 1e-9 * size else None


def motions_of(pieces: Pieces) -> tuple[Motion, ...]:
    """Motions of drives and factors of loads."""
    driven = (row.motion for c in pieces.constraints for row in c.motions)
    found = (*driven, *(e.factor for e in pieces.elements))
    return tuple(motion for motion in found if motion is not None)


def chosen_pieces(mechanism: Mechanism, *, closed: bool, start: bool) -> Pieces:
    """The pieces that hold in motion, those with ideal joints for contacts, or those that hold at the start."""
    pieces = mechanism.pieces()
    holding = {"always", *(["closed"] if closed else []), *(["start"] if start else [])}
    constraints = tuple(c for c in pieces.constraints if c.holds in holding)
    return Pieces(pieces.elements, constraints, () if closed else pieces.contacts, pieces.signals)


def drawn_pose(mechanism: Mechanism, number: Numbering, z: list[float]) -> Drawn:
    """Coordinates with start displacements, declared velocities and histories of the drawn pose.

    A rigid motion is declared at the main node alone, so that it holds wherever closing the loops moves the body.
    """
    q = number.pose()
    v = np.full(number.n_q, np.nan)
    owner = np.zeros(number.n_q, dtype=np.int64)
    for k, body in enumerate(mechanism.bodies):
        mine = {node.name: i for i, (part, node) in enumerate(number.nodes) if part == body.name}
        rows = np.array([(3 * i, 3 * i + 1, 3 * i + 2) for i in mine.values()])
        owner[rows] = k
        velocity, displacement = body.start_velocity(), body.start_displacement()
        if displacement is not None:
            q[rows] += np.array(displacement)
        if velocity is not None:
            is_field = np.ndim(velocity) == 2
            v[rows if is_field else 3 * mine[body.main] + np.arange(3)] = velocity
    return Drawn(q, v, np.array(z, dtype=float), owner)


def drawn_length(number: Numbering) -> float:
    """Extent of the nodes in the drawn pose [m], 1 for a single node at the origin."""
    points = number.pose().reshape(-1, 3)[:, :2]
    extent = float(np.ptp(points, axis=0).max())
    return extent or float(np.abs(points).max()) or 1.0
