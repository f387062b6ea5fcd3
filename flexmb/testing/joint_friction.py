"""Checks of friction in ideal joints: how multipliers press, and which way the surfaces slide."""

from __future__ import annotations

import numpy as np

from flexmb.kernels import JOINT_FRICTION_SIZE
from flexmb.model.contributions import ConstraintContribution, JointFriction
from flexmb.testing.bench import Bench
from flexmb.testing.contacts import check_friction
from flexmb.testing.subject import Subject


def check_joint_friction(bench: Bench, contribution: ConstraintContribution, joint_friction: JointFriction) -> None:
    """N >= 0 and its derivatives by the multipliers; J and its derivatives; forces in balance; the law."""
    subject = Subject(bench.owner, joint_friction.kernel, joint_friction.p, out=(JOINT_FRICTION_SIZE,), H=(6, 6))
    scale, m = bench.scales(contribution.coordinates), contribution.rows
    for state in bench.states(contribution.coordinates, "q"):
        lam = 100.0 * bench.random.uniform(-1.0, 1.0, m)
        full = {**state, "lam": lam}
        out = subject.watched(full)
        bench.note(f"{joint_friction.kernel.name}: compiled = Python, finite, repeatable")
        if out["out"][0] < 0.0:
            raise subject.fault(f"the normal load is {out['out'][0]:.9g}; it must be >= 0", full)

        def load(x: np.ndarray, full=full) -> np.ndarray:
            return subject({**full, "lam": x})["out"][:1]

        def way(x: np.ndarray, full=full) -> np.ndarray:
            return subject({**full, "q": x})["out"][4:]

        J, q = out["out"][4:], full["q"]
        size = np.abs(lam)
        bench.derivative(subject, "dN/dlam", full, out["out"][1 : 1 + m][None, :], load, lam, size, columns=size)
        floor = 1e-6 * float(np.abs(scale * J).max())
        bench.derivative(subject, "H = dJ/dq", full, out["H"], way, q, scale, rows=scale, columns=scale, floor=floor)
        rule = "what slides on one body must slide back on the other"
        for axis in (0, 1):
            bench.balanced(subject, f"forces along {'xy'[axis]}", full, [J[axis], J[3 + axis]], rule)
        moments = [J[2], J[5], q[0] * J[1], -q[1] * J[0], q[3] * J[4], -q[4] * J[3]]
        bench.balanced(subject, "moments about the origin", full, moments, rule)
    check_friction(bench, joint_friction.friction)
