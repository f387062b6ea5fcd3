"""Flat arrays of a program for the compiled loop.

Lists of different lengths are stored one after the other: dof[k] : dof[k + 1] bounds the entries of element k.
Pairs (n, 2) hold BEGIN and END in the long lists p (numbers of the parts) and z (histories).
Coordinates are numbered 0 .. n_q - 1; n_q, n_q + 1, n_q + 2 are those of the ground, which stay 0.
Positions are indices into the value array of the factored matrix (see `flexmb.linalg.symbolic`).
"""

from __future__ import annotations

from flexmb.compiled.records import Integers, IntegerTable, Places, Record, Vector

BEGIN, END = range(2)
"""Columns of pairs."""

FIRST, SECOND = range(2)
"""Columns of `Measured.angle`."""

MULTIPLIED, ADDED, SUBTRACTED = range(3)
"""Uses of a factor in a signal, in the order of `flexmb.model.contributions.USES_OF_FACTOR`."""

LOAD_KERNEL, SLIDING_LAW = range(2)
"""Columns of `Constraints.joint_friction`: kernel of the normal load, and friction law."""

LOAD_P, LOAD_P_END, SLIDING_P, SLIDING_P_END = range(4)
"""Columns of `Constraints.joint_friction_p`."""

GAP_KERNEL, NORMAL_LAW, FRICTION_LAW = range(3)
"""Columns of `Contacts.kernel`."""

GAP_P, GAP_P_END, NORMAL_P, NORMAL_P_END, FRICTION_P, FRICTION_P_END = range(6)
"""Columns of `Contacts.p`."""

COMMON_Z, NORMAL_Z, FRICTION_Z, Z_END = range(4)
"""Columns of `Contacts.z`: starts of the common history and of the histories of both laws; their end."""

PHASE, ONSET_TIME, LAST_GAP, LAST_FORCE, LAST_GAP_RATE = range(5)
CONTACT_COMMON = 5
"""History that every contact keeps, and its length: phase, time of its onset, gap, force and gap rate at the last
state."""


class Elements(Record):
    """Elements: numbers of their kernels (-1: none), where p, z, dofs, positions (row by row) are.

    An element with force, tangent and account is never called through `kernel` and `energy`, which then are -1.
    """

    kernel: Integers  # (n,)
    energy: Integers  # (n,)
    factor: Integers  # (n,) a motion
    force: Integers  # (n,)
    tangent: Integers  # (n,)
    account: Integers  # (n,)
    p: IntegerTable  # (n, 2)
    factor_p: IntegerTable  # (n, 2)
    z: IntegerTable  # (n, 2)
    dof: Integers  # (n + 1,)
    pos: Integers  # (n + 1,)
    dofs: Places
    positions: Places


class Constraints(Record):
    """Constraints: kernels, motions of their rows (-1: none), where numbers, rows, dofs and positions are, signals."""

    kernel: Integers  # (n,)
    motion: Integers  # (n_c,) of each row
    p: IntegerTable  # (n, 2)
    motion_p: IntegerTable  # (n_c, 2)
    row: Integers  # (n + 1,)
    dof: Integers  # (n + 1,)
    pos_g: Integers  # (n + 1,)
    pos_h: Integers  # (n + 1,)
    dofs: Places
    positions_g: Places
    positions_gt: Places
    positions_h: Places
    second: IntegerTable  # (n, 3) places of x, y, theta of the second body among the dofs, -1: none
    moment: Integers  # (n,) row of the reported moment, -1: none
    out: Integers  # (n,) first of its signals
    forces: Integers  # (n,) how many signals its force has, before those of its motions; 0 for a drive
    joint_friction: IntegerTable  # (n, 2) GRIP_LAW and SLIDING_LAW, -1: no friction
    joint_friction_p: IntegerTable  # (n, 4) GRIP_P, GRIP_P_END, SLIDING_P, SLIDING_P_END
    joint_friction_z: IntegerTable  # (n, 2)
    joint_friction_arm: Vector  # (n,)
    reaction: Integers  # (n + 1,) where its reported reactions are
    reaction_row: Integers  # row of each reaction
    reaction_dof: Integers  # coordinate whose velocity multiplies it, -1: none
    reaction_factor: Vector
    reaction_rate: Integers  # signal that multiplies it, -1: none
    reaction_on: Integers  # (reactions + 1,) where its places are; without places it is that of a row
    reaction_places: Integers  # places among the coordinates of its constraint
    reaction_power: Integers  # whether forces on places are multiplied by velocities


class Contacts(Record):
    """Contacts: numbers of gap, normal and friction kernel, where their numbers, histories and positions are."""

    kernel: IntegerTable  # (n, 3) GAP_KERNEL, NORMAL_LAW, FRICTION_LAW
    p: IntegerTable  # (n, 6) GAP_P, GAP_P_END, NORMAL_P, NORMAL_P_END, FRICTION_P, FRICTION_P_END
    z: IntegerTable  # (n, 4) COMMON_Z, NORMAL_Z, FRICTION_Z, Z_END
    dofs: Places  # (6 n,)
    positions: Places  # (36 n,)
    out: Integers  # (n,) first of its signals


class Measured(Record):
    """Signals computed by kernels, and relative rotations of joints with their rates."""

    kernel: Integers  # (n,) -1: the value has a place
    extremum: Integers  # (n,) kernel of a value with its place, -1: none
    p: IntegerTable  # (n, 2)
    dof: Integers  # (n + 1,)
    dofs: Integers
    element: Integers  # (n,) whose factor the value takes, -1: none
    use: Integers  # (n,) MULTIPLIED, ADDED or SUBTRACTED
    out: Integers  # (n,); a place follows its value
    modes: Integers  # signals that number states or places
    places: IntegerTable  # (k, 2) signals of places, and the signals at whose peaks they are wanted
    angle: IntegerTable  # (m, 2) rotations FIRST and SECOND
    angle_p: IntegerTable  # (m, 2)
    angle_out: Integers  # (m,) signal of the rotation, before that of its rate


NO_FACTOR, FIRST_OUTPUT = -1, -2
"""Values of `Elements.factor` of an element without a factor, and of one whose factor is the first output of a control.

Output k is FIRST_OUTPUT - k."""

SOURCE, SOURCE_NUMBER, SOURCE_P, SOURCE_P_END = range(4)
"""Columns of `Controls.source`: kind of the input; its coordinate, kernel or output; its numbers."""

COORDINATE, VELOCITY, MEASURED, MOTION_VALUE, MOTION_SPEED, OUTPUT = range(6)
"""Kinds of inputs of a control."""


class Controls(Record):
    """Controls: kernels, inputs, own states, outputs, and the coordinates that these depend on.

    The coordinates of a control are those of its states, in threes, then those of its inputs.  A sampled control has
    no coordinates; its history holds its states and its outputs.
    """

    kernel: Integers  # (n,)
    p: IntegerTable  # (n, 2)
    z: IntegerTable  # (n, 2) empty for a control that acts at all times
    input: Integers  # (n + 1,)
    source: IntegerTable  # (inputs, 4) SOURCE, SOURCE_NUMBER, SOURCE_P, SOURCE_P_END
    source_dof: Integers  # (inputs + 1,)
    source_dofs: Integers
    source_places: Integers  # places of the coordinates of an input among those of its control, -1: fixed
    states: Integers  # (n,) number of states
    output: Integers  # (n + 1,)
    owner: Integers  # (outputs,) control of each output
    slope: Integers  # (outputs + 1,) where the derivatives of an output by the coordinates of its control are
    dof: Integers  # (n + 1,)
    dofs: Places
    pos_state: Integers  # (n + 1,)
    positions_state: Places  # rows of the states, columns of all coordinates of the control
    pos_load: Integers  # (outputs + 1,)
    positions_load: Places  # rows of the load, columns of all coordinates of the control
    out: Integers  # (n,) first of its signals


class Sizes(Record, frozen=True):
    """Numbers of coordinates, multipliers, histories, signals; first energy signal; longest lists of a piece.

    n_b : number of the coordinates of bodies, before those of the states of controls
    """

    n_q: int
    n_b: int
    n_c: int
    n_z: int
    n_y: int
    energy: int
    most_dofs: int
    most_rows: int
    has_joint_friction: bool  # whether an ideal joint has friction


class Tables(Record):
    """All arrays of a program."""

    sizes: Sizes
    p: Vector
    elements: Elements
    constraints: Constraints
    contacts: Contacts
    measured: Measured
    controls: Controls
    kind: Integers  # (n_q,) 0 for a length, 1 for an angle


class Addresses(Record):
    """Tables of kernel addresses, made in every process."""

    element: Integers
    energy: Integers
    constraint: Integers
    motion: Integers
    gap: Integers
    normal: Integers
    friction: Integers
    joint_friction: Integers
    signal: Integers
    extremum: Integers
    force: Integers
    tangent: Integers
    account: Integers
    control: Integers
