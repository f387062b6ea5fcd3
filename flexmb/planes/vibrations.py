"""Natural frequencies and shapes of plane bodies, free or held at pins."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.sparse import csc_array
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh, splu

from flexmb import checks
from flexmb.errors import InputError, SolveError
from flexmb.planes.forms import PlaneMatrices
from flexmb.planes.interfaces import Tie

Array = npt.NDArray[np.float64]

RIGID_MOTIONS = 3
"""Motions of a free body without deformation."""

SHIFT = 1e-6
"""Shift of the squared angular frequency below 0, over that of a longitudinal wave of the body's length [1]."""


def vibrations(
    matrices: PlaneMatrices, count: int = 6, tie: Tie | None = None, held: Sequence[str] = ()
) -> tuple[Array, Array]:
    """Lowest natural frequencies (count,) [Hz] and shapes (2n, count), without motions as a rigid body.

    Shapes have the modal mass 1 kg: phi^T M phi = 1.  Pins `held` neither move nor turn.
    """
    label = matrices.mesh.label
    count = checks.count(label, "count", count)
    K, M, T = matrices.stiffness, matrices.mass, None if tie is None else tie.matrix
    if tie is not None and T is not None:
        fixed = [tie.pins.index(checks.one_of(label, "held pin", name, tie.pins)) for name in held]
        kept = np.ones(T.shape[1], dtype=bool)
        kept[(3 * np.array(fixed, dtype=np.int64)[:, None] + np.arange(3)).ravel()] = False
        T = T[:, np.flatnonzero(kept)]
        K, M = T.T @ K @ T, T.T @ M @ T
    rigid = 0 if held else RIGID_MOTIONS
    if K.shape[0] < rigid + 2:
        text = f"{label}: with its pins held it has {K.shape[0]} displacements"
        raise InputError(f"{text}, so it cannot vibrate. Take pins that leave nodes free, or a finer mesh.")
    checks.between(label, "count", count, 1, K.shape[0] - rigid - 1)
    squared, shapes = _lowest(label, csc_array(K), csc_array(M), count + rigid, matrices)
    frequencies = np.sqrt(np.maximum(squared[rigid:], 0.0)) / (2.0 * math.pi)
    shapes = shapes[:, rigid:]
    return frequencies, shapes if T is None else T @ shapes


def _lowest(label: str, K: csc_array, M: csc_array, count: int, matrices: PlaneMatrices) -> tuple[Array, Array]:
    """Lowest eigenvalues of K - w^2 M and their vectors, by Lanczos' method on the inverse of K - shift M."""
    # E/rho and the length of the body give a frequency that no material and no unit changes
    scale = matrices.stiffness.diagonal().max() / matrices.mass.diagonal().max()
    nodes = len(matrices.mesh.points)
    shift = -SHIFT * scale / nodes
    factors = splu(csc_array(K - shift * M), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
                   options={"SymmetricMode": True})  # fmt: skip
    inverse = LinearOperator(K.shape, matvec=factors.solve, dtype=float)
    start = np.random.default_rng(0).standard_normal(K.shape[0])
    try:
        values, vectors = eigsh(K, count, M, sigma=shift, OPinv=inverse, v0=start)
    except ArpackError as error:
        text = f"{label}: {count} natural frequencies were not found ({error})"
        raise SolveError(f"{text}. Ask for fewer, or look for nearly separate pieces of the mesh.") from None
    order = np.argsort(values)
    return values[order], vectors[:, order]
