"""Eigenvalue problems on the null space of the joints: real symmetric ones, and quadratic ones with damping."""

from __future__ import annotations

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs, eigsh, splu

from flexmb.errors import SolveError
from flexmb.solve.motions import null_space

DENSE = 1500
"""Up to so many coordinates all modes are computed by a dense eigensolver."""

DENSE_QUADRATIC = 150
"""The same for quadratic problems, which are twice as large and not symmetric: 20 times the time."""

NO_MASS = "modes: a motion without mass; give every body and node some mass and inertia."


def undamped(
    K: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, rigid: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Lowest omega^2 and shapes of K x = omega^2 M x with G x = 0, x orthogonal in M to the shapes `rigid`."""
    held = sp.vstack([G, sp.csr_matrix((M @ rigid).T)]).tocsr() if rigid.shape[1] else G
    K = ((K + K.T) / 2.0).tocsc()
    if K.shape[0] > DENSE:
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
    squares, y = _sharpened(k, m, squares, y, count)
    return squares, Z @ y


def _sharpened(
    k: np.ndarray, m: np.ndarray, squares: np.ndarray, y: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """The lowest modes, those that are slow against the fastest one once more from the inverse of k.

    The eigensolver leaves an error of round-off times the LARGEST omega^2 in all of them; the inverse has the slow
    modes as its largest eigenvalues and leaves an error relative to the LOWEST one.  Each mode takes the better of
    both.  Where k is not positive definite (an unstable pose) the first values stay.
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
    return (k + k.T) / 2.0


def _sparse(K: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The lowest eigenvalues by inversion of the bordered matrices; a small shift where they are singular."""
    n, m = K.shape[0], G.shape[0]
    scale = abs(K).max()
    A = sp.block_array([[K, scale * G.T], [scale * G, None]]).tocsc()
    B = sp.block_diag([M, sp.csc_matrix((m, m))]).tocsc()
    wanted = max(1, min(count, n - m - 1))
    for shift in (0.0, -1e-6 * scale / abs(M).max()):
        try:
            solve = LinearOperator((n + m, n + m), splu((A - shift * B).tocsc()).solve, dtype=float)
            squares, x = eigsh(A, k=wanted, M=B, sigma=shift, which="LM", v0=np.ones(n + m), OPinv=solve)
        except (ArpackNoConvergence, RuntimeError) as error:
            failure = error
            continue
        order = np.argsort(squares)
        return squares[order], x[:n, order]
    raise SolveError(f"modes: the eigensolver did not converge ({failure}). Ask for fewer modes.") from failure


def damped(
    K: sp.csc_matrix, C: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, rigid: np.ndarray, count: int, *, kept=False
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues s with Im s >= 0, lowest |s| first, and shapes of (s^2 M + s C + K) x = 0, G x = 0.

    x is orthogonal in M to the shapes `rigid`; with `kept` these stay in the problem, their stiffness exactly zero.
    """
    held = sp.vstack([G, sp.csr_matrix((M @ rigid).T)]).tocsr() if rigid.shape[1] else G
    if K.shape[0] > (DENSE if kept else DENSE_QUADRATIC):
        s, x = _sparse_quadratic(K, C, M, G if kept else held, count)
    else:
        free = rigid if kept else rigid[:, :0]
        s, x = _dense_quadratic(K, C, M, np.hstack([free, null_space(held.toarray())]), free.shape[1])
    size = np.abs(s).max(initial=0.0)
    s = np.where(np.abs(s.imag) <= 1e-12 * size, s.real + 0.0j, s)
    keep = np.flatnonzero(s.imag >= 0.0)
    keep = keep[np.argsort(np.abs(s[keep]), kind="stable")][:count]
    return s[keep], x[:, keep]


def _dense_quadratic(K, C, M, Z: np.ndarray, free: int) -> tuple[np.ndarray, np.ndarray]:
    """All eigenvalues, by a companion matrix with blocks of one size; the first `free` columns have no stiffness."""
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


def _sparse_quadratic(K, C, M, G: sp.csr_matrix, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The lowest eigenvalues, by the inverse of the first-order problem on displacements and velocities."""
    n, m = K.shape[0], G.shape[0]
    scale = abs(K).max()
    try:
        lu = splu(sp.block_array([[K, scale * G.T], [scale * G, None]]).tocsc())
    except RuntimeError as error:
        text = "the stiffness is singular: hold the motions that only dampers resist, or model fewer elements"
        raise SolveError(f"modes: {text} ({error}).") from error

    def inverse(x: np.ndarray) -> np.ndarray:
        """One over s times (y, s y): y = -K^-1 (C y + M (s y)) on the null space of G."""
        load = C @ x[:n] + M @ x[n:]
        return np.concatenate([-lu.solve(np.append(load, np.zeros(m)))[:n], x[:n]])

    start = np.concatenate([lu.solve(np.append(np.ones(n), np.zeros(m)))[:n]] * 2)
    try:
        values, x = eigs(LinearOperator((2 * n, 2 * n), inverse, dtype=float), k=2 * count + 2, which="LM", v0=start)
    except (ArpackNoConvergence, RuntimeError) as error:
        raise SolveError(f"modes: the eigensolver did not converge ({error}). Ask for fewer modes.") from error
    return 1.0 / values, x[:n]
