"""Predictor: accelerations and multipliers at the end of a step, extrapolated from the accepted states.

Polynomials of order 0 to 3 pass through the last one to four states.  After every step the errors of all orders are
known; the order with the least error predicts the next step.  Smooth motion favours the highest order, vibrations of
beams that the steps do not resolve the constant.  A jump, a starting step and a contact that opens or closes restart
the predictor with order 0.
"""

import math

from flexmb.engine.linalg.lu import solve
from flexmb.engine.state.flow import PAST_STATES
from flexmb.kernels import compiled
from flexmb.program.program import COMMON_Z

# Orders of predictions without accelerations: by the positions at the start of the step, and by its velocities.
STANDING, COASTING = range(-2, 0)
# Displacement by the predicted accelerations, over the size of the mechanism or of its shortest beam, up to which they
# are trusted; rotations count as displacements at the distance of that size. A step that does not resolve them (after a
# jump of a load, waves in short beams) starts from the velocities alone, or from the positions, where the velocities
# lead as far. From farther away Newton's iteration may end at another solution: beams that are folded.
FARTHEST_LEAP = 0.1
OLD_ERROR_WEIGHT = 0.5  # weight of the errors of earlier predictions relative to that of the last one


@compiled
def restart_predictor(predictor):
    """Predict constant accelerations until new states are accepted."""
    predictor.order, predictor.past_states = 0, 0


@compiled
def lagrange_weights(order, h, last, predictor):
    """Weights of the last four states in the Lagrange polynomial of an order, a time h after the last of them."""
    if order == 0:
        return 1.0, 0.0, 0.0, 0.0
    t1 = last
    x0, x1 = h, h + t1
    if order == 1:
        return x1 / t1, -x0 / t1, 0.0, 0.0
    t2 = t1 + predictor.second_last_step
    x2 = h + t2
    if order == 2:
        return x1 * x2 / (t1 * t2), -x0 * x2 / (t1 * (t2 - t1)), x0 * x1 / (t2 * (t2 - t1)), 0.0
    t3 = t2 + predictor.third_last_step
    x3 = h + t3
    return (
        x1 * x2 * x3 / (t1 * t2 * t3),
        -x0 * x2 * x3 / (t1 * (t2 - t1) * (t3 - t1)),
        x0 * x1 * x3 / (t2 * (t2 - t1) * (t3 - t2)),
        -x0 * x1 * x2 / (t3 * (t3 - t1) * (t3 - t2)),
    )


@compiled
def predict(n, m, h, ratio, order, scheme, flow, trial):
    """Predict the trial state: a1 and lam1 by the polynomial, x1, q1 and v1 by the relations of the method."""
    am, af, beta, gamma = scheme.alpha_m, scheme.alpha_f, scheme.beta, scheme.gamma
    last, past = flow.clock.last_step, flow.past
    w0, w1, w2, w3 = lagrange_weights(order, h, last, trial.predictor)
    for i in range(n):
        x0 = flow.a[i] + ratio * (flow.x[i] - flow.a[i])
        a1 = w0 * flow.a[i] + w1 * past[0, i] + w2 * past[1, i] + w3 * past[2, i]
        x1 = ((1.0 - af) * a1 + af * flow.a[i] - am * x0) / (1.0 - am)
        trial.a[i], trial.x[i] = a1, x1
        trial.q[i] = flow.q[i] + h * flow.v[i] + h * h * ((0.5 - beta) * x0 + beta * x1)
        trial.v[i] = flow.v[i] + h * ((1.0 - gamma) * x0 + gamma * x1)
    for i in range(m):
        k = n + i
        trial.lam[i] = w0 * flow.lam[i] + w1 * past[0, k] + w2 * past[1, k] + w3 * past[2, k]
        trial.projected_gaps[i] = 0.0


@compiled
def predict_without_accelerations(n, m, h, ratio, order, scheme, flow, trial):
    """Predict q1 = q0 + h v0 (COASTING) or q1 = q0 (STANDING), with x1, v1 and a1 by the relations of the method."""
    am, af, beta, gamma = scheme.alpha_m, scheme.alpha_f, scheme.beta, scheme.gamma
    for i in range(n):
        x0, v0 = flow.a[i] + ratio * (flow.x[i] - flow.a[i]), flow.v[i]
        way = v0 if order == COASTING else 0.0
        x1 = ((way - v0) / h - (0.5 - beta) * x0) / beta
        trial.x[i], trial.a[i] = x1, ((1.0 - am) * x1 + am * x0 - af * flow.a[i]) / (1.0 - af)
        trial.q[i], trial.v[i] = flow.q[i] + h * way, v0 + h * ((1.0 - gamma) * x0 + gamma * x1)
    for i in range(m):
        trial.lam[i], trial.projected_gaps[i] = flow.lam[i], 0.0


@compiled
def leaps(n_b, coasted, options, flow, trial):
    """Whether a node is predicted farther than is trusted from where it coasts to in a time `coasted` [s]."""
    far, turn = 0.0, 0.0
    for i in range(0, n_b, 3):  # x, y, theta of a node
        far = max(far, abs(trial.q[i] - flow.q[i] - coasted * flow.v[i]))
        far = max(far, abs(trial.q[i + 1] - flow.q[i + 1] - coasted * flow.v[i + 1]))
        turn = max(turn, abs(trial.q[i + 2] - flow.q[i + 2] - coasted * flow.v[i + 2]))
    return not (far <= options.leap and turn * options.length <= options.leap)


@compiled
def project_prediction(n, m, lu, h, order, flow, trial):
    """Project the predicted positions onto the constraints, by gaps that are extrapolated from the last steps."""
    # The gaps are extrapolated, over h^3, and not the shifts: a shift by the present factors has no component along the
    # joints, which no later correction would remove.
    gaps, cube, highest = flow.projected_gaps, h * h * h, trial.predictor.past_states - 1
    w0, w1, w2, w3 = lagrange_weights(min(order, highest), h, flow.clock.last_step, trial.predictor)
    for i in range(n):
        trial.gap_rhs[i] = 0.0
    for i in range(m):
        trial.projected_gaps[i] = cube * (w0 * gaps[0, i] + w1 * gaps[1, i] + w2 * gaps[2, i] + w3 * gaps[3, i])
        trial.gap_rhs[n + i] = trial.projected_gaps[i]
    solve(lu, flow.factors, trial.gap_rhs, trial.shift, trial.scratch)
    for i in range(n):
        trial.q[i] += trial.shift[i]


@compiled
def find_newmark_residual(n, h, flow, trial):
    """Set the mean velocity (q1 - q0)/h, and the residual h (a0 + a1)/2 - (v1 - v0) of the trapezoidal rule."""
    for i in range(n):
        trial.mean_v[i] = (trial.q[i] - flow.q[i]) / h
        trial.newmark_residual[i] = 0.5 * h * (flow.a[i] + trial.a[i]) - (trial.v[i] - flow.v[i])


@compiled
def update_predictor(tables, h, length, flow, trial, work):
    """Choose the order of the next prediction by the errors in this step, and store the accelerations at its start."""
    # Called before the trial is adopted. length : size of the mechanism [m], by which errors of angles count.
    n, m, predictor, past = tables.sizes.n_q, tables.sizes.n_c, flow.predictor, flow.past
    last, highest = flow.clock.last_step, min(predictor.past_states, PAST_STATES)
    u0, u1, _, _ = lagrange_weights(min(1, highest), h, last, predictor)
    v0, v1, v2, _ = lagrange_weights(min(2, highest), h, last, predictor)
    w0, w1, w2, w3 = lagrange_weights(highest, h, last, predictor)
    m0 = m1 = m2 = m3 = 0.0
    for i in range(0, tables.sizes.n_b, 3):  # x, y, theta of a node
        n0 = n1 = n2 = n3 = 0.0
        for k in range(i, i + 3):
            square = length * length if k == i + 2 else 1.0
            a, a0, a1, a2, a3 = trial.a[k], flow.a[k], past[0, k], past[1, k], past[2, k]
            n0 += square * (a - a0) ** 2
            n1 += square * (a - (u0 * a0 + u1 * a1)) ** 2
            n2 += square * (a - (v0 * a0 + v1 * a1 + v2 * a2)) ** 2
            n3 += square * (a - (w0 * a0 + w1 * a1 + w2 * a2 + w3 * a3)) ** 2
            past[2, k], past[1, k], past[0, k] = a2, a1, a0
        m0, m1, m2, m3 = max(m0, n0), max(m1, n1), max(m2, n2), max(m3, n3)
    for k in range(tables.sizes.n_b, n):  # states of controls
        past[2, k], past[1, k], past[0, k] = past[1, k], past[0, k], flow.a[k]
    # Multipliers at the start of the step, and the gaps that its position shifts closed, over h^3.
    gaps, cube = flow.projected_gaps, h * h * h
    for i in range(m):
        k = n + i
        past[2, k], past[1, k], past[0, k] = past[1, k], past[0, k], flow.lam[i]
        gaps[3, i], gaps[2, i], gaps[1, i] = gaps[2, i], gaps[1, i], gaps[0, i]
        gaps[0, i] = trial.projected_gaps[i] / cube
    predictor.order = best_order(highest, (math.sqrt(m0), math.sqrt(m1), math.sqrt(m2), math.sqrt(m3)), flow)
    predictor.third_last_step, predictor.second_last_step = predictor.second_last_step, last
    predictor.past_states, restarts = min(predictor.past_states + 1, PAST_STATES + 1), last == 0.0
    for c in range(tables.contacts.kernel.shape[0]):  # a contact that opens or closes in this step
        k = tables.contacts.z[c, COMMON_Z]
        restarts = restarts or (flow.z[k] == 0.0) != (work.z_new[k] == 0.0)
    if restarts:
        restart_predictor(predictor)


@compiled
def best_order(highest, errors, flow):
    """Order with the least error, earlier errors included; updates `flow.prediction_errors`."""
    best = 0
    for order in range(highest + 1):
        error = errors[order]
        new = order >= flow.predictor.past_states  # a new order has no earlier errors
        error += OLD_ERROR_WEIGHT * (error if new else flow.prediction_errors[order])
        flow.prediction_errors[order] = error
        if error < flow.prediction_errors[best]:
            best = order
    return best
