"""From a mechanism to a program."""

from __future__ import annotations

import numpy as np

from flexmb.errors import InputError, ModelError
from flexmb.model.mechanism import Mechanism
from flexmb.model.pieces import Pieces
from flexmb.program.numbering import Numbering, blocks_and_edges
from flexmb.program.ordering import elimination_order
from flexmb.program.packing import KINDS, Packer
from flexmb.program.program import Drawn, Names, Program
from flexmb.program.signals import aliases, layout
from flexmb.program.smoke import call_each_kernel
from flexmb.program.symbolic import symbolic
from flexmb.program.tables import Sizes, Tables


def compile(mechanism: Mechanism, *, closed: bool = False) -> Program:
    """Flat arrays, kernels and names of a mechanism.

    Parameters
    ----------
    mechanism : what to compile.
    closed : with the clearance joints replaced by ideal ones, as loops are closed and start velocities are found.

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
    pieces = chosen_pieces(mechanism, closed=closed)
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
    )
    kind = np.array([k % 3 == 2 for k in range(number.n_q)], dtype=np.int64)
    tables = Tables(sizes, np.array(packer.p, dtype=float), elements, constraints, contacts, measured, kind)
    drives = [c for c in pieces.constraints if c.motion is not None]
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
        tuple(c.motion.period for c in drives if c.motion is not None),
        tuple(c.part for c in drives),
        drawn_length(number),
        min((c.p[0] for c in pieces.contacts), default=None),
    )


def chosen_pieces(mechanism: Mechanism, *, closed: bool) -> Pieces:
    """The pieces that hold in motion, or those that hold while loops are closed."""
    pieces = mechanism.pieces()
    if closed:
        return Pieces(pieces.elements, pieces.constraints, (), pieces.signals)
    moving = tuple(c for c in pieces.constraints if not c.start_only)
    return Pieces(pieces.elements, moving, pieces.contacts, pieces.signals)


def drawn_pose(mechanism: Mechanism, number: Numbering, z: list[float]) -> Drawn:
    """Coordinates, declared velocities and histories of the drawn pose."""
    q = number.pose()
    v = np.full(number.n_q, np.nan)
    owner = np.zeros(number.n_q, dtype=np.int64)
    for k, body in enumerate(mechanism.bodies):
        mine = [i for i, (part, _) in enumerate(number.nodes) if part == body.name]
        velocity = body.start_velocity()
        main = body.node(body.main)
        for i in mine:
            owner[3 * i : 3 * i + 3] = k
            if velocity is not None:
                vx, vy, omega = velocity
                dx, dy = q[3 * i] - main.x, q[3 * i + 1] - main.y
                v[3 * i : 3 * i + 3] = vx - omega * dy, vy + omega * dx, omega
    return Drawn(q, v, np.array(z, dtype=float), owner)


def drawn_length(number: Numbering) -> float:
    """Extent of the nodes in the drawn pose [m], 1 for a single node at the origin."""
    points = number.pose().reshape(-1, 3)[:, :2]
    extent = float(np.ptp(points, axis=0).max())
    return extent or float(np.abs(points).max()) or 1.0
