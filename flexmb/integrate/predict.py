"""Prediction of a step: accelerations and multipliers extrapolated from the accepted states, by the order that fits.

Polynomials of order 0, 1 and 2 through the last one, two and three states.  After every step it is known which of them
would have met its accelerations best; that one predicts the next step.  Smooth motion wants the highest, vibrations of
beams that the steps do not resolve the constant.  A jump, a first step and a contact that opens or closes begin anew.
"""

from flexmb.kernels import compiled

ORDER, KNOWN, MISSED, SPACING = 0, 1, 2, 5
"""Places in `Flow.habits`: order of the next prediction, states in `Flow.past`, what the three orders missed by, step
between the two states of `Flow.past` (that between the last one and the newer of them is the last step)."""

FADING = 0.5
"""Weight of what an order missed before, against the last step."""


@compiled
def forget_past(habits):
    """Predict constant accelerations until new states are known."""
    habits[ORDER], habits[KNOWN] = 0.0, 0.0


@compiled
def weights(order, h, last, spacing):
    """Weights of the last three states in the polynomial of that order at a time h later."""
    if order == 0:
        return 1.0, 0.0, 0.0
    s = h / last
    if order == 1:
        return 1.0 + s, -s, 0.0
    c = h * (h + last) / (last + spacing)
    return 1.0 + s + c / last, -s - c / last - c / spacing, c / spacing


@compiled
def predict(n, m, h, ratio, order, options, flow, trial):
    """Start values of the step."""
    am, af, beta, gamma = options.alpha_m, options.alpha_f, options.beta, options.gamma
    known, last = int(flow.habits[KNOWN]), flow.clock[4]
    w0, w1, w2 = weights(order, h, last, flow.habits[SPACING])
    s0, s1, s2 = weights(max(min(order, known - 1), 0), h, last, flow.habits[SPACING])
    cube = h * h * h if known > 0 else 0.0
    for i in range(n):
        x0 = flow.a[i] + ratio * (flow.x[i] - flow.a[i])
        a1 = w0 * flow.a[i] + w1 * flow.past[0, i] + w2 * flow.past[1, i]
        x1 = ((1.0 - af) * a1 + af * flow.a[i] - am * x0) / (1.0 - am)
        trial.a[i], trial.x[i] = a1, x1
        shift = cube * (s0 * flow.shift[i] + s1 * flow.past[0, n + m + i] + s2 * flow.past[1, n + m + i])
        trial.shift[i] = shift
        trial.q[i] = flow.q[i] + h * flow.v[i] + h * h * ((0.5 - beta) * x0 + beta * x1) + shift
        trial.v[i] = flow.v[i] + h * ((1.0 - gamma) * x0 + gamma * x1)
    for i in range(m):
        trial.lam[i] = w0 * flow.lam[i] + w1 * flow.past[0, n + i] + w2 * flow.past[1, n + i]


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
    n, m, habits, past = tables.sizes.n_q, tables.sizes.n_c, flow.habits, flow.past
    known, last = int(habits[KNOWN]), flow.clock[4]
    r0, r1, _ = weights(min(known, 1), h, last, habits[SPACING])
    s0, s1, s2 = weights(min(known, 2), h, last, habits[SPACING])
    miss0, miss1, miss2 = 0.0, 0.0, 0.0
    for i in range(n):
        a, size = flow.a[i], length if tables.kind[i] == 1 else 1.0
        miss0 = max(miss0, size * abs(trial.a[i] - a))
        miss1 = max(miss1, size * abs(trial.a[i] - r0 * a - r1 * past[0, i]))
        miss2 = max(miss2, size * abs(trial.a[i] - s0 * a - s1 * past[0, i] - s2 * past[1, i]))
        past[1, i], past[0, i] = past[0, i], a
        k = n + m + i
        past[1, k], past[0, k], flow.shift[i] = past[0, k], flow.shift[i], trial.shift[i] / (h * h * h)
    for i in range(m):
        past[1, n + i], past[0, n + i] = past[0, n + i], flow.lam[i]
    miss0 += FADING * habits[MISSED]
    miss1 += FADING * habits[MISSED + 1]
    miss2 += FADING * habits[MISSED + 2]
    habits[MISSED], habits[MISSED + 1], habits[MISSED + 2] = miss0, miss1, miss2
    habits[KNOWN], habits[SPACING] = min(known + 1, 3), last
    if known >= 2 and miss2 < min(miss0, miss1):
        habits[ORDER] = 2.0
    else:
        habits[ORDER] = 1.0 if miss1 < miss0 else 0.0
    if last == 0.0 or phase_changed(tables, flow, work):
        forget_past(habits)


@compiled
def phase_changed(tables, flow, work):
    """Whether a contact opened or closed."""
    for c in range(tables.contacts.kernel.shape[0]):
        k = tables.contacts.z[c, 0]
        if (flow.z[k] == 0.0) != (work.z_new[k] == 0.0):
            return True
    return False
