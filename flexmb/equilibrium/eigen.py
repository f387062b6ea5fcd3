"""Eigenvalue problems on the null space of the constraints: real symmetric, and quadratic with damping."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs, eigsh, splu

from flexmb.equilibrium.free_motions import null_space
from flexmb.errors import SolveError

Solve = Callable[[np.ndarray], np.ndarray]

DENSE_COORDINATES = 1500
"""Number of coordinates up to which a dense eigensolver computes all modes."""

FEW_MODES_COORDINATES = 300
"""Number of coordinates above which a sparse eigensolver is faster for less than a quarter of the modes."""

DENSE_QUADRATIC_COORDINATES = 150
"""Number of coordinates up to which a dense eigensolver is used for quadratic problems, which take 20 times longer."""

LOOKED_FOR = 1e-6
"""Accuracy of an eigenvalue that may lie below those found."""

NO_MASS = "modes: a motion without mass; give every body and node some mass and inertia."


def undamped(
    K: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, rigid: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Lowest omega^2 and shapes of K x = omega^2 M x with G x = 0, x orthogonal in M to the shapes `rigid`."""
    held = sp.vstack([G, sp.csr_matrix((M @ rigid).T)]).tocsr() if rigid.shape[1] else G
    K = ((K + K.T) / 2.0).tocsc()
    if K.shape[0] > (FEW_MODES_COORDINATES if 4 * count < K.shape[0] else DENSE_COORDINATES):
        return _sparse(K, M, held, count)
    Z = null_space(held.toarray())
    if Z.shape[1] == 0:
        return np.zeros(0), np.zeros((K.shape[0], 0))
    k, m = (Z.T @ (X @ Z) for X in (K, M))
    k, m = _symmetric(k), _symmetric(m)
    try:
        squares, y = la.eigh(k, m)
    except la.LinAlgError as error:
        raise SolveError(NO_MASS) from error
    squares, y = _refined(k, m, squares, y, count)
    return squares, Z @ y


def _refined(
    k: np.ndarray, m: np.ndarray, squares: np.ndarray, y: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """The lowest modes, with slow modes refined by the inverse of k.

    A dense eigensolver has an error of round-off times the largest omega^2 in all modes.  The inverse has the slow
    modes as its largest eigenvalues, with an error relative to the lowest omega^2.  Each mode takes the better value.
    If k is not positive definite (an unstable pose), no mode is refined.
    """
    largest = squares[-1]
    squares, y = squares[:count].copy(), y[:, :count].copy()
    slow = int((squares < 1e-6 * largest).sum())
    try:
        factor = la.cho_factor(k)
        x = y[:, :slow]
        for _ in range(3):
            mx = m @ x
            x = la.cho_solve(factor, mx)
            inverse, turn = la.eigh(_symmetric(x.T @ m @ x), _symmetric(x.T @ mx))
            x = (x @ turn)[:, ::-1]
            x /= np.sqrt(np.einsum("ij,ij->j", x, m @ x))
    except la.LinAlgError:
        return squares, y
    if slow:
        better = np.flatnonzero(inverse[::-1] ** -2.0 < largest / inverse[-1])
        squares[better], y[:, better] = 1.0 / inverse[::-1][better], x[:, better]
    return squares, y


def _symmetric(k: np.ndarray) -> np.ndarray:
    half: np.ndarray = (k + k.T) / 2.0
    return half


def _sparse(K: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The lowest eigenvalues by inversion of the bordered matrices, with a small shift if they are singular."""
    n, m = K.shape[0], G.shape[0]
    scale = abs(K).max()
    A = sp.block_array([[K, scale * G.T], [scale * G, None]]).tocsc()
    B = sp.block_diag([M, sp.csc_matrix((m, m))]).tocsc()
    wanted = max(1, min(count, n - m - 1))
    for shift in (0.0, -1e-6 * scale / abs(M).max()):
        try:
            solve = splu((A - shift * B).tocsc()).solve
            return _with_copies(A, B, M, solve, shift, wanted)
        except (ArpackNoConvergence, RuntimeError) as error:
            failure = error
    raise SolveError(f"modes: the eigensolver did not converge ({failure}). Ask for fewer modes.") from failure


def _with_copies(A: Any, B: Any, M: Any, solve: Solve, shift: float, wanted: int) -> tuple[np.ndarray, np.ndarray]:
    """The lowest eigenvalues of A x = omega^2 B x, with their multiplicity.

    Lanczos' method finds one vector of a multiple eigenvalue (equal bodies, symmetric frames).  So the method is
    repeated on the complement of all vectors found, until no lower eigenvalue appears.
    """
    n, size = M.shape[0], A.shape[0]
    squares, X = np.zeros(0), np.zeros((n, 0))
    while len(squares) < size:

        def rest(b: np.ndarray, X: np.ndarray = X) -> np.ndarray:
            x = solve(b)
            x[:n] -= X @ (X.T @ (M @ x[:n]))
            return x

        start = rest(B @ np.cos(np.arange(size) ** 2.0 + len(squares)))
        operator = LinearOperator((size, size), rest, dtype=float)
        options = {"M": B, "sigma": shift, "which": "LM", "v0": start, "OPinv": operator}
        if len(squares):  # whether anything as low is left, before many modes of a cluster are told apart
            last = np.sort(squares)[wanted - 1]
            lowest = eigsh(A, k=1, tol=LOOKED_FOR, return_eigenvectors=False, **options)[0]
            if lowest > last + 10.0 * LOOKED_FOR * abs(last) or len(squares) > n - (size - n) - wanted:
                break
        more, x = eigsh(A, k=wanted, **options)
        squares, X = np.append(squares, more), np.hstack([X, x[:n]])
        if len(squares) > wanted and more.min() >= last:
            break
    order = np.argsort(squares)[:wanted]
    return squares[order], X[:, order]


def damped(
    K: sp.csc_matrix,
    C: sp.csc_matrix,
    M: sp.csc_matrix,
    G: sp.csr_matrix,
    rigid: np.ndarray,
    count: int,
    *,
    kept: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues s with Im s >= 0, lowest |s| first, and shapes of (s^2 M + s C + K) x = 0, G x = 0.

    x is orthogonal in M to the shapes `rigid`; with `kept` the problem includes them, with exactly zero stiffness.
    """
    held = sp.vstack([G, sp.csr_matrix((M @ rigid).T)]).tocsr() if rigid.shape[1] else G
    if K.shape[0] > (DENSE_COORDINATES if kept else DENSE_QUADRATIC_COORDINATES):
        s, x = _sparse_quadratic(K, C, M, G if kept else held, count)
    else:
        free = rigid if kept else rigid[:, :0]
        s, x = _dense_quadratic(K, C, M, np.hstack([free, null_space(held.toarray())]), free.shape[1])
    size = np.abs(s).max(initial=0.0)
    s = np.where(np.abs(s.imag) <= 1e-12 * size, s.real + 0.0j, s)
    keep = np.flatnonzero(s.imag >= 0.0)
    keep = keep[np.argsort(np.abs(s[keep]), kind="stable")][:count]
    return s[keep], x[:, keep]


def _dense_quadratic(K: Any, C: Any, M: Any, Z: np.ndarray, free: int) -> tuple[np.ndarray, np.ndarray]:
    """All eigenvalues by a scaled companion matrix; the first `free` columns of Z have no stiffness."""
    n = Z.shape[1]
    if n == 0:
        return np.zeros(0, complex), np.zeros((K.shape[0], 0), complex)
    k, c, m = (Z.T @ (X @ Z) for X in (K, C, M))
    k[:free], k[:, :free] = 0.0, 0.0
    try:
        factor = la.cho_factor((m + m.T) / 2.0)
    except la.LinAlgError as error:
        raise SolveError(NO_MASS) from error
    k, c = la.cho_solve(factor, k), la.cho_solve(factor, c)
    unit = np.sqrt(la.norm(k, 2)) or 1.0
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-k / unit**2, -c / unit]])
    values, vectors = la.eig(A)
    return values * unit, Z @ vectors[:n]


def _sparse_quadratic(K: Any, C: Any, M: Any, G: sp.csr_matrix, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The lowest eigenvalues, by the inverse of the first-order problem on displacements and velocities."""
    n, m = K.shape[0], G.shape[0]
    scale = abs(K).max()
    try:
        lu = splu(sp.block_array([[K, scale * G.T], [scale * G, None]]).tocsc())
    except RuntimeError as error:
        text = "the stiffness is singular: hold the motions that only dampers resist, or model fewer elements"
        raise SolveError(f"modes: {text} ({error}).") from error

    def inverse(x: np.ndarray) -> np.ndarray:
        """Apply the inverse operator: 1/s times (y, s y), with y = -K^-1 (C y + M (s y)) on the null space of G."""
        load = C @ x[:n] + M @ x[n:]
        return np.concatenate([-lu.solve(np.append(load, np.zeros(m)))[:n], x[:n]])

    try:
        values, x = largest_of(inverse, 2 * n, 2 * count + 2)
    except (ArpackNoConvergence, RuntimeError) as error:
        raise SolveError(f"modes: the eigensolver did not converge ({error}). Ask for fewer modes.") from error
    return 1.0 / values, x[:n]


def largest_of_pencil(A: Any, M: Any, solve: Solve, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The eigenvalues of largest modulus of A x = w M x, with their multiplicity, and vectors with x^T M x = 1.

    Parameters
    ----------
    A : (n, n) symmetric.
    M : (n, n) symmetric, positive on the space of the x.
    solve : M^-1 on that space.
    count : number of eigenvalues.
    """
    n = M.shape[0]
    values, X = np.zeros(0), np.zeros((n, 0))
    while len(values) + count < n:

        def rest(b: np.ndarray, X: np.ndarray = X) -> np.ndarray:
            x = solve(b)
            outside: np.ndarray = x - X @ (X.T @ (M @ x))
            return outside

        start = rest(M @ np.cos(np.arange(n) ** 2.0 + len(values)))
        options = {"M": M, "Minv": LinearOperator((n, n), rest, dtype=float), "which": "LM", "v0": start}
        if len(values):
            least = np.sort(np.abs(values))[-count]
            found = eigsh(A, k=1, tol=LOOKED_FOR, return_eigenvectors=False, **options)[0]
            if np.abs(found) < least * (1.0 - 10.0 * LOOKED_FOR):
                break
        more, x = eigsh(A, k=count, **options)
        values, X = np.append(values, more), np.hstack([X, x])
        if len(values) > count and np.abs(more).max() <= least * (1.0 + 1e-9):
            break
    order = np.argsort(-np.abs(values), kind="stable")[:count]
    return values[order], X[:, order]


def largest_of(operator: Solve, size: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The eigenvalues of a real operator of largest modulus, with their multiplicity, and eigenvectors.

    Arnoldi's method finds one vector of a multiple eigenvalue.  So the method is repeated on the complement of the
    invariant subspace Q found so far, until no eigenvalue as large appears; Q^T A Q then has all of them.
    """
    Q, found = np.zeros((size, 0)), np.zeros(0)
    while Q.shape[1] + 2 * count + 2 < size:

        def rest(x: np.ndarray, Q: np.ndarray = Q) -> np.ndarray:
            y = operator(x - Q @ (Q.T @ x))
            outside: np.ndarray = y - Q @ (Q.T @ y)
            return outside

        start = rest(np.cos(np.arange(size) ** 2.0 + len(found)))
        more, x = eigs(LinearOperator((size, size), rest, dtype=float), k=count, which="LM", v0=start)
        least = np.sort(found)[-count] if len(found) else 0.0
        found = np.append(found, np.abs(more))
        Q = la.qr(np.hstack([Q, _basis(x, Q)]), mode="economic")[0]
        if np.abs(more).max() <= least * (1.0 + 1e-9):
            break
    values, y = la.eig(Q.T @ np.column_stack([operator(q) for q in Q.T]))
    order = np.argsort(-np.abs(values), kind="stable")[:count]
    return values[order], Q @ y[:, order]


def _basis(x: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """Orthonormal real basis of complex vectors, orthogonal to Q."""
    parts = np.hstack([x.real, x.imag])
    for _ in range(2):  # twice: round-off of the first time
        parts = parts - Q @ (Q.T @ parts)
    U, sizes, _ = la.svd(parts, full_matrices=False)
    basis: np.ndarray = U[:, sizes > 1e-8 * sizes[0]]
    return basis
