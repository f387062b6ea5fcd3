"""How much of the rigid inertia the load of the staggered scheme is, and what its delay does to a contact.

    python docs/staggered_feedback.py

The elastic model answers a change of rigid accelerations J da with U'' = -P J da, and hands J^T M P J da back, where J
are the motions that joints and drives leave to the rigid mechanism, and P = N (N^T A N)^-1 N^T M projects on what they
leave to U, A = M + h/2 C + h^2/4 K.  So differences of the load are multiplied by M_r^-1 J^T M P J in each step.
"""

import numpy as np
import scipy.linalg as la

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.mechanisms import NineBarData, nine_bar
from flexmb.statics.eigen import null_space
from flexmb.statics.start.consistent import RigidMotion

STEPS = (1e-4, 4e-5, 1e-5, 1e-6, 0.0)  # s
RATIOS = (0.5, 0.9, 0.98, 0.995)
PHASES = (0.5, 0.1, 0.01, 1e-3, 1e-4)


def multipliers(mech: fm.Mechanism, *, shared: bool, step: float) -> np.ndarray:
    """Eigenvalues of M_r^-1 J^T M P J in the drawn pose, the largest first."""
    whole = fm.compile(mech)
    bodies = StateEvaluation(fm.compile(fm.Mechanism(mech.name, mech.bodies)))
    q = np.array(whole.reference.q)
    K, C, M = (bodies.at(q, weights=w).block().toarray() for w in np.eye(3))
    open_rows = StateEvaluation(whole).at(q).jacobian.toarray()
    rows = StateEvaluation(fm.compile(mech, closed=True)).at(q).jacobian.toarray() if shared else open_rows
    B = RigidMotion(whole).basis(q).toarray()
    J, N = B @ null_space(open_rows @ B), null_space(rows)
    A = M + 0.5 * step * C + 0.25 * step**2 * K
    handed = J.T @ M @ N @ la.solve(N.T @ A @ N, N.T @ M @ J)
    return np.sort(la.eigvals(la.solve(J.T @ M @ J, handed)).real)[::-1]


def restitution(ratio: float, phase: float) -> float:
    """Speed after an elastic contact over that before; the load is the part `ratio` of the inertia, one step late.

    x'' = -w^2 x + b, b = ratio x'' of the step before; phase = w h; each step is solved exactly.
    """
    x, v, b = 0.0, 1.0, 0.0
    c, s = np.cos(phase), np.sin(phase)
    while x >= 0.0:
        x, v = b + c * (x - b) + s * v, c * v - s * (x - b)
        b = ratio * (b - x)
    return -v


def main() -> None:
    """Both tables."""
    mech = nine_bar(2.0 * np.pi, clearance=5e-4, flexible=True, data=NineBarData(damping=NineBarData.LIGHT_DAMPING))
    for shared in (True, False):
        for step in STEPS:
            found = multipliers(mech, shared=shared, step=step)
            print("shared" if shared else "independent, no mean axes", f"{step:g} s", found.round(4))
    for ratio in RATIOS:
        print(f"ratio {ratio:g}:", *(f"w h = {p:g}: {restitution(ratio, p):.3f}" for p in PHASES))


if __name__ == "__main__":
    main()
