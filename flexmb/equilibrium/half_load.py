"""Whether a linear load factor can be trusted: the first one, found again from the equilibrium under half of it.

Linear buckling assumes that the stiffness against the buckling shape x falls in proportion to the loads: with the
forces w = K0 x, which cause x without loads, the compliance w . u of the answer u to w grows from c0 to

    c(s) = c0 / (1 - s/f)

at s times the loads.  With c(s) of the equilibrium at s = f/2, found with large displacements, this gives a factor

    f' = s / (1 - c0 / c(s))

which is f where the structure keeps its shape until it buckles, and another one where it bends before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from flexmb.errors import FlexmbError
from flexmb.linalg.bordered import solver
from flexmb.program.program import Program
from flexmb.system.state_evaluation import StateEvaluation

TRUSTED = 0.1
"""Difference of a load factor from that of the equilibrium under half of it, over the factor, up to which it counts."""

SMALL_MOVEMENT = 0.1
"""Movement under half of a load factor, relative to the size of the mechanism (or rad), up to which it counts."""

LOAD_STEPS = (1, 4)
"""Numbers of load steps with which the equilibrium is sought, until one finds it."""

MOST_ITERATIONS = 15
"""Newton iterations of a load step at most."""

FOUND_STEP = 1e-9
"""Newton step relative to the size of the mechanism, below which an equilibrium is found."""

LONGEST_STEP = 0.5
"""Newton step relative to the size of the mechanism (or rad), to which longer ones are cut."""


@dataclass(frozen=True, eq=False)
class LoadPath:
    """Growing loads on a structure.

    Parameters
    ----------
    program : the structure without loads.
    start : (n_q,) coordinates and (n_c,) multipliers without loads.
    force : (n_q,) residual of the loads at factor 1 there.
    stiffness : (n_q, n_q) their stiffness there; to first order they are force + stiffness (q - q0).
    """

    program: Program
    system: StateEvaluation
    start: tuple[np.ndarray, np.ndarray]
    force: np.ndarray
    stiffness: sp.csc_matrix

    def tangent(self, q: np.ndarray, lam: np.ndarray, s: float) -> tuple[sp.csc_matrix, sp.csr_matrix]:
        """Tangent stiffness (n_q, n_q) under s times the loads and G (n_c, n_q) at coordinates and multipliers."""
        self.system.at(q, lam=lam, weights=(1.0, 0.0, 0.0))
        return (self.system.block() + s * self.stiffness).tocsc(), self.system.jacobian

    def equilibrium(self, s: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Coordinates (n_q,) and multipliers (n_c,) under s times the loads; None where none is found."""
        for steps in LOAD_STEPS:
            q, lam = self.start
            for share in np.arange(1, steps + 1) / steps:
                found = self._newton(q, lam, float(share * s))
                if found is None:
                    break
                q, lam = found
            else:
                return q, lam
        return None

    def solve_held(self, K: Any, G: Any, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """x (n_q,) and multipliers y (n_c,) of K x + G^T y = b, G x = c; `RuntimeError` for a singular matrix."""
        scale = abs(K).max()
        A = sp.block_array([[K / scale, G.T], [G, None]]).tocsc()
        found = solver(A, self.program.symbolic.order)(np.append(b / scale, c))
        return found[: len(b)], scale * found[len(b) :]

    def _newton(self, q: np.ndarray, lam: np.ndarray, s: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Coordinates and multipliers under s times the loads, by Newton's method."""
        program, start = self.program, self.start[0]
        size = np.where(program.tables.kind == 1, 1.0, program.length)
        for _ in range(MOST_ITERATIONS):
            K, G = self.tangent(q, lam, s)
            loads = s * (self.force + self.stiffness @ (q - start))
            rest = self.system.force + self.system.constraint_force + loads
            d, change = self.solve_held(K, G, -rest, -self.system.residual)
            longest = float(np.abs(d / size).max())
            if not math.isfinite(longest):
                return None
            part = min(1.0, LONGEST_STEP / longest) if longest else 1.0
            q, lam = q + part * d, lam + part * change
            if longest <= FOUND_STEP:
                return q, lam
        return None


def factor_from_half(path: LoadPath, factor: float, shape: np.ndarray) -> tuple[float, float]:
    """The load factor f' of a shape (n_q,), and how far the structure moves, under half of the linear `factor`.

    The factor is inf where the stiffness against the shape does not fall.  The movement is the largest rotation [rad]
    or displacement over the size of the mechanism.  Both are nan without an equilibrium.
    """
    program, s = path.program, 0.5 * factor
    start = path.start[0]
    try:
        K, G = path.tangent(*path.start, 0.0)
        pushed = K @ shape
        found = path.equilibrium(s)
        if found is None:
            return math.nan, math.nan
        answer, _ = path.solve_held(*path.tangent(*found, s), pushed, np.zeros(G.shape[0]))
    except (FlexmbError, RuntimeError):
        return math.nan, math.nan
    lost = 1.0 - float(pushed @ shape) / float(pushed @ answer)
    moved = np.abs(found[0] - start) / np.where(program.tables.kind == 1, 1.0, program.length)
    return s / lost if lost > 0.0 else math.inf, float(moved.max())


def trust_note(factor: float, from_half: float, moved: float) -> str:
    """Note on a first load factor that the equilibrium under half of it does not confirm; "" where it does."""
    if abs(from_half - factor) <= TRUSTED * factor and moved <= SMALL_MOVEMENT:
        return ""
    if math.isnan(from_half):
        seen = "no equilibrium was found under half of these loads"
    else:
        share = 100.0 * 0.5 * factor / from_half
        seen = f"under half of these loads the stiffness against the shape is {share:.3g} % lower, in place of 50 %"
        seen += f", and the structure moves by {moved:.2g} of its size (or rad)"
    return (
        f"The load factor {factor:.6g} is no buckling load to rely on: {seen}, since it bends before it buckles. "
        "Look for the load at which static_equilibrium(...) is no longer stable."
    )
