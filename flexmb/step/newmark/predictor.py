"""Prediction of a step: accelerations and multipliers extrapolated from the accepted states, by the order that fits.

Polynomials of order 0 to 3 through the last one to four states.  After every step it is known which of them would have
met its accelerations best; that one predicts the next step.  Smooth motion wants the highest, vibrations of beams that
the steps do not resolve the constant.  A jump, a first step and a contact that opens or closes begin anew.
"""

import math

from flexmb.kernels import compiled
from flexmb.linalg.substitute import solve
from flexmb.program.tables import COMMON_Z
from flexmb.state.flow import PAST_STATES

FADING = 0.5
"""Weight of what an order missed before, against the last step."""


@compiled
def forget_past(prediction):
    """Predict constant accelerations until new states are known."""
    prediction.order, prediction.known = 0, 0


@compiled
def weights(order, h, last, prediction):
    """Weights of the last four states in the polynomial of that order at a time h later (Lagrange)."""
    if order == 0:
        return 1.0, 0.0, 0.0, 0.0
    t1 = last
    x0, x1 = h, h + t1
    if order == 1:
        return x1 / t1, -x0 / t1, 0.0, 0.0
    t2 = t1 + prediction.before
    x2 = h + t2
    if order == 2:
        return x1 * x2 / (t1 * t2), -x0 * x2 / (t1 * (t2 - t1)), x0 * x1 / (t2 * (t2 - t1)), 0.0
    t3 = t2 + prediction.earlier
    x3 = h + t3
    return (
        x1 * x2 * x3 / (t1 * t2 * t3),
        -x0 * x2 * x3 / (t1 * (t2 - t1) * (t3 - t1)),
        x0 * x1 * x3 / (t2 * (t2 - t1) * (t3 - t2)),
        -x0 * x1 * x2 / (t3 * (t3 - t1) * (t3 - t2)),
    )


@compiled
def predict(n, m, h, ratio, order, scheme, flow, trial):
    """Start values of the step."""
    am, af, beta, gamma = scheme.alpha_m, scheme.alpha_f, scheme.beta, scheme.gamma
    last, past = flow.clock.last, flow.past
    w0, w1, w2, w3 = weights(order, h, last, trial.prediction)
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
        trial.gaps[i] = 0.0


@compiled
def close_ahead(n, m, lu, h, order, flow, trial):
    """Shift predicted positions to close what the joints will be open by, as the shifts of the steps before tell.

    The gaps are extrapolated, over h^3, not the shifts: with the factors at hand these have no part along the joints,
    which no later correction would take back.
    """
    known, gaps, cube = trial.prediction.known, flow.gaps, h * h * h
    w0, w1, w2, w3 = weights(min(order, known - 1), h, flow.clock.last, trial.prediction)
    for i in range(n):
        trial.c[i] = 0.0
    for i in range(m):
        trial.gaps[i] = cube * (w0 * gaps[0, i] + w1 * gaps[1, i] + w2 * gaps[2, i] + w3 * gaps[3, i])
        trial.c[n + i] = trial.gaps[i]
    solve(lu, flow.factors, trial.c, trial.e, trial.y)
    for i in range(n):
        trial.q[i] += trial.e[i]


@compiled
def compare(n, h, flow, trial):
    """Mean velocity of the step, and what Newmark's relation differs by from the true accelerations."""
    for i in range(n):
        trial.mean_v[i] = (trial.q[i] - flow.q[i]) / h
        trial.lag[i] = 0.5 * h * (flow.a[i] + trial.a[i]) - (trial.v[i] - flow.v[i])


@compiled
def look_back(tables, h, length, flow, trial, work):
    """Before a step is taken over: which order met it best, and what the next prediction needs of its start.

    length [m] : angles count as so long.
    """
    n, m, prediction, past = tables.sizes.n_q, tables.sizes.n_c, flow.prediction, flow.past
    known, last = prediction.known, flow.clock.last
    most = min(known, PAST_STATES)
    u0, u1, _, _ = weights(min(1, most), h, last, prediction)
    v0, v1, v2, _ = weights(min(2, most), h, last, prediction)
    w0, w1, w2, w3 = weights(most, h, last, prediction)
    m0 = m1 = m2 = m3 = 0.0
    for i in range(0, n, 3):  # x, y, theta of a node
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
    gaps, cube = flow.gaps, h * h * h
    for i in range(m):
        k = n + i
        past[2, k], past[1, k], past[0, k] = past[1, k], past[0, k], flow.lam[i]
        gaps[3, i], gaps[2, i], gaps[1, i], gaps[0, i] = gaps[2, i], gaps[1, i], gaps[0, i], trial.gaps[i] / cube
    best, misses = 0, (math.sqrt(m0), math.sqrt(m1), math.sqrt(m2), math.sqrt(m3))
    for order in range(most + 1):
        now = misses[order]
        now += FADING * (flow.missed[order] if order < known else now)  # one that is new has no past yet
        flow.missed[order] = now
        if now < flow.missed[best]:
            best = order
    prediction.earlier, prediction.before = prediction.before, last
    prediction.order, prediction.known = best, min(known + 1, PAST_STATES + 1)
    if last == 0.0 or phase_changed(tables, flow, work):
        forget_past(prediction)


@compiled
def phase_changed(tables, flow, work):
    """Whether a contact opened or closed."""
    for c in range(tables.contacts.kernel.shape[0]):
        k = tables.contacts.z[c, COMMON_Z]
        if (flow.z[k] == 0.0) != (work.z_new[k] == 0.0):
            return True
    return False
