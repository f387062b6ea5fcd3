"""Arrays of the elastic model of `Staggered`: linear elasticity about the pose of the rigid counterpart.

The displacements U belong to the n_q coordinates of the flexible mechanism.  The rigid counterpart has n_t coordinates,
three per body.  Blocks are 3 x 3 parts of the stiffness, mass and damping matrices of the bodies, at rest in the
reference configuration.  The blocks are constant in axes that turn with the bodies.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.engine.compiled.records import Integers, IntegerTable, Matrix, Places, Record, Vector
from flexmb.engine.linalg import lu
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.engine.system.work import Work, workspace
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Addresses, Program, Tables

if TYPE_CHECKING:
    from nine_bar_study.nine_bar.staggered.method import Staggered


class Settings(Record, frozen=True):
    """Parameters of the method and of the elastic model.

    printed : 1 with the published terms of rotation, 0 without
    free : number of rigid motions that are removed from U;  flexible : whether a body is flexible
    passes : repetitions of a step
    gx, gy : gravity [m/s^2]
    shown : first index of the signals of joints and contacts in the mechanism
    first, last : first index of these signals in the rigid counterpart, and index after the last
    """

    printed: float
    free: int
    flexible: bool
    passes: int
    far: float  # largest displacement of the linear model [m]
    gx: float
    gy: float
    shown: int
    first: int
    last: int


class Model(Record):
    """Constant arrays of the elastic model.

    body, arm, turn : body of each node (n,), position (n, 2) [m] and angle (n,) [rad] of each node in axes of its body
    reference : (bodies,) angles of the rigid bodies in the reference configuration
    nodes : (blocks, 2) nodes of each block;  k, m, d : (blocks, 9) stiffness, mass, damping of each block
    places : (9 blocks,) indices of the entries of the blocks in the matrix
    loads : (n,) elements that are not part of a body;  ties : (n,) constraint equations of joints with clearance
    """

    body: Integers
    arm: Matrix
    turn: Vector
    reference: Vector
    nodes: IntegerTable
    k: Matrix
    m: Matrix
    d: Matrix
    places: Places
    loads: Integers
    ties: Integers


class ElasticMemory(Record):
    """Powers and forces of the elastic step.

    damping_power, load_power : power of the damping of the beams, and of loads on U' [W]
    tie : largest constraint force of shared displacements in joints with clearance [N]
    """

    damping_power: float
    tie: float
    load_power: float


class Deformation(Record):
    """Elastic state of a restart, changed in place.

    u, u1, u2 : (n_q + 3,) U, U', U'';  load : (n_t + 3,) elastic inertia forces on the rigid counterpart
    G, drift : constraint Jacobian at the last pose, and rate G U' (n_c,) of the constraints
    motions : (free, n_t) rigid motions that are removed from U
    """

    u: Vector
    u1: Vector
    u2: Vector
    load: Vector
    G: Vector
    drift: Vector
    motions: Matrix
    memory: ElasticMemory


class Scratch(Record):
    """Workspace of an elastic step.

    q, v, a : (n_q + 3,) motion of the nodes with the rigid counterpart, later with the displacements added
    cs : (bodies, 2) cosine and sine of the rotation of each body from the reference configuration
    X, Y, Z : (n_q,) factors of mass, damping and stiffness, in axes of the bodies
    f, given : (n_q + 3,) forces, and forces of loads without a potential
    b, c, x, y, seen, work : (n,) vectors of the linear systems;  pair : (2 n,)
    lam, z : multipliers and history, zero;  signals : signals of the rigid counterpart
    rows, square, side : arrays of `rigid_motions`;  shapes, moved : (free, n_q) rigid motions z of the nodes, and M z
    """

    q: Vector
    v: Vector
    a: Vector
    cs: Matrix
    X: Vector
    Y: Vector
    Z: Vector
    f: Vector
    given: Vector
    b: Vector
    c: Vector
    x: Vector
    y: Vector
    seen: Vector
    work: Vector
    pair: Vector
    lam: Vector
    z: Vector
    signals: Vector
    rows: Matrix
    square: Matrix
    side: Vector
    shapes: Matrix
    moved: Matrix


class Elastic(Record):
    """Elastic model: program of the elastic equations, program of the signals (`whole`), arrays and state."""

    tables: Tables
    address: Addresses
    lu: lu.LU
    work: Work
    whole: Tables
    whole_address: Addresses
    whole_work: Work
    settings: Settings
    model: Model
    now: Deformation
    trial: Deformation
    scratch: Scratch


def elastic_model(mechanism: Mechanism, whole: Program, twin: Program, method: Staggered) -> Elastic:
    """Elastic model of a mechanism from its program `whole` and the program `twin` of its rigid counterpart."""
    shared = method.play == "shared" and bool(whole.names.contacts)
    program = compile_mechanism(mechanism, closed=True) if shared else whole
    model = _model(mechanism, program, twin)
    motions = _free_motions(program, twin, model) if method.mean_axes else np.zeros((0, twin.n_q))
    now, trial = (_deformation(program, twin, motions) for _ in range(2))
    begin, end = 3 * whole.n_q, min([int(k) for k in whole.tables.measured.out] + [whole.tables.sizes.energy])
    settings = Settings(
        1.0 if method.rotation == "printed" else 0.0,
        len(motions),
        any(len(body.nodes()) > 1 for body in mechanism.bodies),
        method.passes,
        0.1 * whole.length,
        *mechanism.gravity,
        begin,
        3 * twin.n_q,
        3 * twin.n_q + end - begin,
    )
    return Elastic(
        program.tables,
        program.addresses,
        lu.tables(program.symbolic),
        workspace(program),
        whole.tables,
        whole.addresses,
        workspace(whole),
        settings,
        model,
        now,
        trial,
        _scratch(program, twin, len(motions)),
    )


def _model(mechanism: Mechanism, program: Program, twin: Program) -> Model:
    """Constant arrays of the elastic model of a mechanism."""
    body = np.asarray(program.reference.body[::3])
    pose = _drawn(mechanism)
    centre = np.asarray(twin.reference.q).reshape(-1, 3)[body]
    c, s = np.cos(centre[:, 2]), np.sin(centre[:, 2])
    dx, dy = (pose - centre)[:, 0], (pose - centre)[:, 1]
    nodes, (k, m, d) = _blocks(mechanism)
    rows, columns = np.repeat(np.arange(3), 3), np.tile(np.arange(3), 3)
    i, j = 3 * nodes[:, :1] + rows, 3 * nodes[:, 1:] + columns
    contributions = mechanism.contributions()
    loads = [
        e
        for e, contribution in enumerate(contributions.elements)
        if not isinstance(mechanism.find(contribution.part), Body)
    ]
    ties = [row for row, name in enumerate(program.names.rows) if name.partition("[")[0] in _with_play(mechanism)]
    return Model(
        np.ascontiguousarray(body),
        np.column_stack([c * dx + s * dy, c * dy - s * dx]),
        np.ascontiguousarray((pose - centre)[:, 2]),
        np.array(twin.reference.q[2::3]),
        nodes,
        k,
        m,
        d,
        _places(program, i.ravel(), j.ravel()),
        np.array(loads, dtype=np.int64),
        np.array(ties, dtype=np.int64),
    )


def _drawn(mechanism: Mechanism) -> np.ndarray:
    """Reference configuration of all nodes (n, 3) [m, m, rad]."""
    return np.array([(node.x, node.y, node.theta) for _, node in mechanism.nodes()])


def _with_play(mechanism: Mechanism) -> set[str]:
    """Names of the joints with clearance and other contacts."""
    return {contribution.part for contribution in mechanism.contributions().contacts}


def _blocks(mechanism: Mechanism) -> tuple[np.ndarray, list[np.ndarray]]:
    """Pairs of nodes (blocks, 2), and stiffness, mass and damping (blocks, 9) of the bodies."""
    bodies = compile_mechanism(Mechanism(mechanism.name, mechanism.bodies))
    system, q = StateEvaluation(bodies), _drawn(mechanism).ravel()
    n, kinds = len(q) // 3, ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    found = [system.at(q, weights=weights).work.lu[bodies.symbolic.places] for weights in kinds]
    rows, columns = bodies.symbolic.a_rows, bodies.symbolic.a_cols
    keys, number = np.unique(n * (rows // 3) + columns // 3, return_inverse=True)
    matrices = [np.zeros((len(keys), 9)) for _ in found]
    for blocks, values in zip(matrices, found, strict=True):
        blocks[number, 3 * (rows % 3) + columns % 3] = values
    return np.column_stack([keys // n, keys % n]), matrices


def _places(program: Program, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Unsigned indices of entries (rows, columns) in the matrix; entries outside its pattern get an unused index."""
    pattern = program.symbolic
    keys = pattern.a_rows * pattern.n + pattern.a_cols
    order = np.argsort(keys)
    wanted = rows * pattern.n + columns
    at = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
    known = keys[order][at] == wanted
    return np.where(known, pattern.places[order][at], pattern.dummy).astype(np.uint64)


def _free_motions(program: Program, twin: Program, model: Model) -> np.ndarray:
    """Rigid motions (k, n_t) without velocity in the joints of `program`, in the reference configuration."""
    from flexmb.statics.eigen import ROW_ROUND_OFF, null_space

    nodes = np.arange(len(model.body))
    centre = np.asarray(twin.reference.q).reshape(-1, 3)[model.body]
    c, s = np.cos(centre[:, 2]), np.sin(centre[:, 2])
    x, y = model.arm.T
    B = np.zeros((program.n_q, twin.n_q))
    for axis in range(3):
        B[3 * nodes + axis, 3 * model.body + axis] = 1.0
    B[3 * nodes, 3 * model.body + 2] = -(s * x + c * y)
    B[3 * nodes + 1, 3 * model.body + 2] = c * x - s * y
    G = StateEvaluation(program).at(np.asarray(program.reference.q)).jacobian
    # rows within one body, such as a pin on its node, leave the round-off of their terms, which resists nothing
    rows, terms = G @ B, (abs(G) @ np.abs(B)).sum(axis=1)
    return np.ascontiguousarray(null_space(rows[np.abs(rows).max(axis=1, initial=0.0) > ROW_ROUND_OFF * terms]).T)


def _deformation(program: Program, twin: Program, motions: np.ndarray) -> Deformation:
    n = program.n_q + 3
    length = int(program.tables.constraints.pos_g[-1])
    arrays: list[Any] = [np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(twin.n_q + 3), np.zeros(length)]
    return Deformation(*arrays, np.zeros(program.n_c), motions.copy(), ElasticMemory(0.0, 0.0, 0.0))


def _scratch(program: Program, twin: Program, free: int) -> Scratch:
    n, m, total = program.n_q, program.n_c, program.n_q + program.n_c
    return Scratch(
        *(n + 3 for _ in range(3)),
        (twin.n_q // 3, 2),
        *(n for _ in range(3)),
        *(n + 3 for _ in range(2)),
        *(total for _ in range(6)),
        2 * total,
        m,
        program.tables.sizes.n_z,
        twin.tables.sizes.n_y,
        (m, twin.n_q),
        (m, m),
        m,
        (free, n),
        (free, n),
    )
