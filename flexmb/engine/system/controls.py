"""Evaluation of controls: outputs, which are factors of loads, residuals of their states, and tangents.

The velocities v of the coordinates of a control are its states x, their accelerations a the rates of x.  The residual
of a state is r = a - f(t, u, x) with the law f.  Outputs and rates are differentiated by differences of the law alone;
the derivatives of the inputs by coordinates and velocities are exact, or differences of the signal's kernel.
"""

from flexmb.engine.compiled.arrays import part_of
from flexmb.engine.system.work import gather
from flexmb.kernels import compiled, control_at, motion_at, signal_at
from flexmb.program.program import (
    BEGIN,
    COORDINATE,
    END,
    FIRST_OUTPUT,
    MEASURED,
    MOTION_VALUE,
    OUTPUT,
    SOURCE,
    SOURCE_NUMBER,
    SOURCE_P,
    SOURCE_P_END,
    VELOCITY,
)

# Difference of an input or a state relative to its size, and least size, in central differences of a control law.
# The cube root of round-off; derivatives of linear laws are exact to some 1e-8 with any difference.
RELATIVE_DIFFERENCE, LEAST_SIZE = 6e-6, 0.1
# Difference of coordinates and velocities in central differences of measured inputs [m, rad, m/s, rad/s].
COORDINATE_DIFFERENCE = 1e-6


@compiled
def evaluate_controls(tables, address, t, q, v, a, z, kq, kv, ka, matrix, work):
    """Outputs of all controls in work.output; residuals of their states in work.r, tangents in work.lu if `matrix`."""
    # Sampled controls keep their outputs.
    C = tables.controls
    for c in range(C.kernel.shape[0]):
        if C.z[c, END] > C.z[c, BEGIN]:
            hold_outputs(tables, c, z, work)
            continue
        read_inputs(tables, address, c, t, q, v, work)
        call_law(tables, address, c, t, work)
        n_x, n_y = C.states[c], C.output[c + 1] - C.output[c]
        for k in range(n_y):
            work.output[C.output[c] + k] = work.law[n_x + k]
        dofs = part_of(C.dofs, C.dof[c], C.dof[c + 1])
        for i in range(threes(n_x)):
            work.r[dofs[i]] = a[dofs[i]] - (work.law[i] if i < n_x else 0.0)
        if matrix:
            differentiate_law(tables, address, c, t, q, v, kq, kv, work)
            add_state_tangents(tables, c, ka, work)


@compiled
def threes(n):
    """The next multiple of three from n on: states stand in nodes of three coordinates."""
    return (n + 2) // 3 * 3


@compiled
def hold_outputs(tables, c, z, work):
    """Keep states and outputs of a sampled control."""
    C = tables.controls
    for i in range(C.z[c, BEGIN], C.z[c, END]):
        work.z_new[i] = z[i]
    n_y = C.output[c + 1] - C.output[c]
    for k in range(n_y):
        work.output[C.output[c] + k] = z[C.z[c, END] - n_y + k]


@compiled
def read_inputs(tables, address, c, t, q, v, work):
    """Inputs of control c in work.u, and its states in work.x."""
    C = tables.controls
    for j in range(C.input[c], C.input[c + 1]):
        kind, what = C.source[j, SOURCE], C.source[j, SOURCE_NUMBER]
        if kind == COORDINATE:
            value = q[what]
        elif kind == VELOCITY:
            value = v[what]
        elif kind == MEASURED:
            value = measured(tables, address, j, t, q, v, -1, 0.0, 0.0, work)
        elif kind == OUTPUT:
            value = work.output[what]
        else:
            s, speed, _ = motion_at(address.motion, what)(
                part_of(tables.p, C.source[j, SOURCE_P], C.source[j, SOURCE_P_END]), t
            )
            value = s if kind == MOTION_VALUE else speed
        work.u[j - C.input[c]] = value
    for i in range(C.states[c]):
        work.x[i] = v[C.dofs[C.dof[c] + i]]


@compiled
def measured(tables, address, j, t, q, v, i, dq, dv, work):
    """Value of a measured input with its i-th coordinate and velocity shifted by dq and dv; i = -1: no shift."""
    C = tables.controls
    begin, n = C.source_dof[j], C.source_dof[j + 1] - C.source_dof[j]
    gather(q, C.source_dofs, begin, n, work.ql)
    gather(v, C.source_dofs, begin, n, work.vl)
    for k in range(n):
        work.al[k] = 0.0
    if i >= 0:
        work.ql[i] += dq
        work.vl[i] += dv
    return signal_at(address.signal, C.source[j, SOURCE_NUMBER])(
        part_of(tables.p, C.source[j, SOURCE_P], C.source[j, SOURCE_P_END]),
        t,
        part_of(work.ql, 0, n),
        part_of(work.vl, 0, n),
        part_of(work.al, 0, n),
    )


@compiled
def call_law(tables, address, c, t, work):
    """Rates of the states and outputs of control c, one after the other in work.law, from work.u and work.x."""
    C = tables.controls
    n_x, n_y = C.states[c], C.output[c + 1] - C.output[c]
    for i in range(n_x + n_y):
        work.law[i] = 0.0
    control_at(address.control, C.kernel[c])(
        part_of(tables.p, C.p[c, BEGIN], C.p[c, END]),
        t,
        part_of(work.u, 0, C.input[c + 1] - C.input[c]),
        part_of(work.x, 0, n_x),
        part_of(work.law, 0, n_x),
        part_of(work.law, n_x, n_x + n_y),
    )


@compiled
def differentiate_law(tables, address, c, t, q, v, kq, kv, work):
    """Derivatives kq d/dq + kv d/dv of rates and outputs in work.law_tangent; of outputs in work.slope, too."""
    C = tables.controls
    n_u, n_x, n_y = C.input[c + 1] - C.input[c], C.states[c], C.output[c + 1] - C.output[c]
    n, rows = C.dof[c + 1] - C.dof[c], n_x + n_y
    for i in range(rows * n):
        work.law_tangent[i] = 0.0
    for j in range(n_u):
        law_column(tables, address, c, t, work.u, j, work)
        source = C.input[c] + j
        for i in range(C.source_dof[source], C.source_dof[source + 1]):
            if C.source_places[i] >= 0:
                rate = input_slope(tables, address, source, i - C.source_dof[source], t, q, v, kq, kv, work)
                add_column(rows, n, C.source_places[i], rate, work)
    for i in range(n_x):
        law_column(tables, address, c, t, work.x, i, work)
        add_column(rows, n, i, kv, work)
    begin = C.slope[C.output[c]]
    for i in range(n_y * n):
        work.slope[begin + i] = work.law_tangent[n_x * n + i]


@compiled
def law_column(tables, address, c, t, values, j, work):
    """Derivatives of rates and outputs by entry j of `values`, the inputs or the states, in work.law_column."""
    C = tables.controls
    n, kept = C.states[c] + C.output[c + 1] - C.output[c], values[j]
    shift = RELATIVE_DIFFERENCE * max(abs(kept), LEAST_SIZE)
    upper, lower = kept + shift, kept - shift
    values[j] = upper
    call_law(tables, address, c, t, work)
    for i in range(n):
        work.law_column[i] = work.law[i]
    values[j] = lower
    call_law(tables, address, c, t, work)
    for i in range(n):
        work.law_column[i] = (work.law_column[i] - work.law[i]) / (upper - lower)
    values[j] = kept


@compiled
def input_slope(tables, address, j, i, t, q, v, kq, kv, work):
    """Derivative kq du/dq + kv du/dv of input j by its i-th coordinate."""
    C = tables.controls
    kind = C.source[j, SOURCE]
    if kind == COORDINATE:
        return kq
    if kind == VELOCITY:
        return kv
    if kind == OUTPUT:
        return work.slope[C.slope[C.source[j, SOURCE_NUMBER]] + i]
    total, e = 0.0, COORDINATE_DIFFERENCE
    if kq != 0.0:
        upper = measured(tables, address, j, t, q, v, i, e, 0.0, work)
        total += kq * (upper - measured(tables, address, j, t, q, v, i, -e, 0.0, work)) / (2.0 * e)
    if kv != 0.0:
        upper = measured(tables, address, j, t, q, v, i, 0.0, e, work)
        total += kv * (upper - measured(tables, address, j, t, q, v, i, 0.0, -e, work)) / (2.0 * e)
    return total


@compiled
def add_column(rows, n, place, factor, work):
    """Add factor times work.law_column to a column of work.law_tangent (rows, n)."""
    for i in range(rows):
        work.law_tangent[i * n + place] += factor * work.law_column[i]


@compiled
def add_state_tangents(tables, c, ka, work):
    """Add the derivatives of the residuals of the states of control c to work.lu."""
    C = tables.controls
    n, n_x = C.dof[c + 1] - C.dof[c], C.states[c]
    positions = part_of(C.positions_state, C.pos_state[c], C.pos_state[c + 1])
    for i in range(threes(n_x)):
        work.lu[positions[i * n + i]] += ka
        for j in range(n if i < n_x else 0):
            work.lu[positions[i * n + j]] -= work.law_tangent[i * n + j]


@compiled
def add_load_tangent(tables, e, n, work):
    """Add force times derivative of the factor of element e, whose force without the factor is in work.rl."""
    C, output = tables.controls, FIRST_OUTPUT - tables.elements.factor[e]
    c = C.owner[output]
    m, slope = C.dof[c + 1] - C.dof[c], C.slope[output]
    positions = part_of(C.positions_load, C.pos_load[output], C.pos_load[output + 1])
    for i in range(n):
        for j in range(m):
            work.lu[positions[i * m + j]] += work.rl[i] * work.slope[slope + j]


@compiled
def write_control_signals(tables, work, z, y):
    """Write outputs of all controls, and the states of sampled ones, into the signals y."""
    C = tables.controls
    for c in range(C.kernel.shape[0]):
        k, n_y = C.out[c], C.output[c + 1] - C.output[c]
        for i in range(C.z[c, BEGIN], C.z[c, END] - n_y):
            y[k] = z[i]
            k += 1
        for i in range(n_y):
            y[k] = work.output[C.output[c] + i]
            k += 1
