"""Workspace of an evaluation, allocated once for all steps."""

import math
from collections.abc import Callable, Hashable
from functools import wraps
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from flexmb.engine.compiled.lanes import LANES
from flexmb.engine.compiled.records import Matrix, Record, Vector
from flexmb.engine.linalg.symbolic import Symbolic
from flexmb.kernels import GAP_SIZE, JOINT_FRICTION_SIZE, compiled
from flexmb.program.program import FOUR_SIZE, Program

R = TypeVar("R", bound=Record)
_TEMPLATES: WeakKeyDictionary[Symbolic, dict[Hashable, Any]] = WeakKeyDictionary()


def new_from_template(program: Program, key: Hashable, make: Callable[[], R], **records: Record) -> R:
    """A new record like the result of `make`, which is called once for each structure of programs and `key`."""
    # The result of `make` depends on the structure and the key alone; `records` replace inner records.
    known = _TEMPLATES.setdefault(program.symbolic, {})
    if key not in known:
        known[key] = make()
    found: R = known[key].twin(**records)
    return found


def from_template(make: Callable[[Program], R]) -> Callable[..., R]:
    """Decorator of a function whose record depends on the structure of a program alone; also with inner `records`."""
    return wraps(make)(lambda program, **own: new_from_template(program, make.__name__, lambda: make(program), **own))


# Values of a list of coordinates, gathered for one element, signal or control
@compiled
def gather(values, dofs, begin, n, target):
    """target[:n] = values at the dofs begin .. begin + n."""
    for i in range(n):
        target[i] = values[dofs[begin + i]]


@compiled
def turn_nodes(tables, q, work):
    """Cosines and sines of the angles of nodes in pins, guides and journals."""
    turns = tables.constraints.turns
    for k in range(turns.shape[0]):
        work.cosine[turns[k]], work.sine[turns[k]] = math.cos(q[turns[k]]), math.sin(q[turns[k]])


@compiled
def turns_at(dofs, work):
    """Cosine and sine of the angles of both nodes with the coordinates dofs (6,), by `turn_nodes`."""
    _, _, one, _, _, other = dofs
    return work.cosine[one], work.sine[one], work.cosine[other], work.sine[other]


# Columns of `Work.drive`: s, s_dot and s_ddot of a driven row, and the force that drives it.
MOTION, MOTION_RATE, MOTION_ACCELERATION, DRIVE_FORCE = range(4)
# Columns of `Work.joint`: force on the second body, multiplier of the row whose moment is reported.
FORCE_X, FORCE_Y, MOMENT = range(3)
JOINT_FRICTION_FORCE, JOINT_SLIP = range(2)  # columns of `Work.joint_friction`: friction force and slip of a joint
# Columns of `Work.slopes` of a contact: dN/dgap, dN/drate, dT/dslip, dT/dN.
N_BY_GAP, N_BY_RATE, T_BY_SLIP, T_BY_N = range(4)
JOINT_T_BY_SLIP, JOINT_T_BY_LAM = range(2)  # columns of `Work.slopes` of a joint: dT/dslip, the first of three dT/dlam
# Columns of `Work.loss`: normal and tangential loss [J], impulse [N s], dissipation of the method; from LOSS_MEMORY on
# the memory of the contact for the next step (`CONTACT_MEMORY_SIZE` numbers).
LOSS_NORMAL, LOSS_FRICTION, LOSS_IMPULSE, LOSS_BEYOND, LOSS_MEMORY = range(5)


class Powers(Record):
    """Energies of a state [J], power of dampers [W], and energy that the method dissipates in a step [J]."""

    kinetic: float
    strain: float
    gravity: float
    damping: float
    algorithm: float


class Work(Record):
    """Results of an evaluation, and scratch space for one element, contact or constraint."""

    r: Vector  # (n_q + 3,) residual, inertia less applied forces, without constraint forces
    Gl: Vector  # (n_q + 3,) G^T lambda
    g: Vector  # g, gv, gamma: (n_c,) residual, residual of velocities G v + g_t, right side of G a
    gv: Vector
    gamma: Vector
    lu: Vector  # values of the matrix
    z_new: Vector  # history if the state is accepted
    contact: Matrix  # (n, GAP_SIZE + 2) gap data, normal force, friction force
    drive: Matrix  # (n_c, 4) motion and force
    joint: Matrix  # (n, 4) force on the second body (x, y), moment row, spare
    power: Powers
    ql: Vector
    vl: Vector
    al: Vector
    rl: Vector
    Kl: Vector
    Cl: Vector
    Ml: Vector
    G: Vector  # rows of all constraints, one after the other, on the dofs of their own
    contact_scratch: Matrix  # (2, 6)
    joint_friction: Matrix  # (n, 2) friction force and slip of each joint
    joint_friction_out: Vector
    joint_friction_curve: Matrix
    yl: Vector
    Mvl: Vector
    Myl: Vector
    slopes: Matrix  # (`slopes_rows`, 4) dN/dgap, dN/drate, dT/dslip, dT/dN of contacts; dT/dslip, dT/dlam of joints
    load: Vector  # forces on the dofs of all elements without energies of their own, one after the other
    momentum: Vector  # (n_q + 3,) M v
    cosine: Vector  # cosine, sine: (n_q + 3,) of the angles of nodes, see `turn_nodes`
    sine: Vector
    # (n, 17) of every contact: losses normal, tangential [J], impulse, loss beyond; normal force, generalised forces
    loss: Matrix
    gap: Vector  # gap, z_between: gap data and histories between two states
    z_between: Vector
    output: Vector  # outputs of all controls
    slope: Vector  # their derivatives by the coordinates of their controls
    u: Vector  # u, x, law: inputs and states of one control, and rates of its states with its outputs
    x: Vector
    law: Vector
    # law_column, law_tangent: derivatives of `law` by an input or a state, and by all coordinates of the control
    law_column: Vector
    law_tangent: Vector


@from_template
def workspace(program: Program) -> Work:
    """Workspace for a compiled mechanism."""
    sizes = program.tables.sizes
    E, C, controls = program.tables.elements, program.tables.constraints, program.tables.controls
    own, of_constraints = np.diff(E.dof), np.diff(C.dof)  # signals have no matrices
    n = max(sizes.most_dofs, FOUR_SIZE * LANES)
    square = max(LANES * FOUR_SIZE**2, int(own.max(initial=0)) ** 2, int(of_constraints.max(initial=0)) ** 2)
    n_k, n_g = len(program.tables.contacts.kernel), len(C.kernel)
    inputs, outputs, dofs = (np.diff(x) for x in (controls.input, controls.output, controls.dof))
    rows = controls.states + outputs
    of_controls = {"u": inputs, "x": controls.states, "law": rows, "law_column": rows, "law_tangent": rows * dofs}
    return Work(
        **dict.fromkeys(("r", "Gl", "momentum", "cosine", "sine"), sizes.n_q + 3),
        **dict.fromkeys(("g", "gv", "gamma"), sizes.n_c),
        **dict.fromkeys(("z_new", "z_between"), sizes.n_z),
        **dict.fromkeys(("ql", "vl", "al", "rl", "yl", "Mvl", "Myl"), n), **dict.fromkeys(("Kl", "Cl", "Ml"), square),
        **{name: int(each.max(initial=0)) for name, each in of_controls.items()}, output=int(controls.output[-1]),
        slope=int(controls.slope[-1]), lu=program.symbolic.size, contact=(n_k, GAP_SIZE + 2), drive=(sizes.n_c, 4),
        joint=(n_g, 4), power=Powers.zeros(), G=C.pos_g[-1], contact_scratch=(2, 6), joint_friction=(n_g, 2),
        joint_friction_out=JOINT_FRICTION_SIZE, joint_friction_curve=(6, 6), slopes=(slopes_rows(program), 4),
        load=load_forces(program), loss=(n_k, 17), gap=GAP_SIZE,
    )  # fmt: skip


def slopes_rows(program: Program) -> int:
    """Number of contacts and, where any joint has friction, of constraints."""
    sizes, n_k = program.tables.sizes, len(program.tables.contacts.kernel)
    return n_k + (len(program.tables.constraints.kernel) if sizes.has_joint_friction else 0)


def load_forces(program: Program) -> int:
    """Number of dofs of all elements without energies of their own."""
    E = program.tables.elements
    return int((E.dof[1:] - E.dof[:-1])[E.energy < 0].sum())
