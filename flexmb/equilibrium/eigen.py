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
from flexmb.linalg.bordered import Solve, negative_eigenvalues, solver

Below = Callable[[float], int | None]

DENSE_COORDINATES = 1500
"""Number of coordinates up to which a dense eigensolver computes all modes."""

FEW_MODES_COORDINATES = 300
"""Number of coordinates above which a sparse eigensolver is faster for less than a quarter of the modes."""

DENSE_QUADRATIC_COORDINATES = 150
"""Number of coordinates up to which a dense eigensolver is used for quadratic problems, which take 20 times longer."""

LOOKED_FOR = 1e-6
"""Accuracy of an eigenvalue that may lie below those found."""

LONGEST_SEARCH = 60
"""Number of steps of a search at most, which end after two or three."""

MOST_RESTARTS = 10
"""Restarts of Lanczos' method at an end of a spectrum that may be a cluster at 0, where nothing converges."""

NO_MASS = "modes: a motion without mass; give every body and node some mass and inertia."


def undamped(
    K: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, rigid: np.ndarray, count: int, order: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Lowest omega^2 and shapes of K x = omega^2 M x with G x = 0, x orthogonal in M to the shapes `rigid`.

    order : order of elimination of the unknowns of [[K, G^T], [G, 0]].
    """
    held = sp.vstack([G, sp.csr_matrix((M @ rigid).T)]).tocsr() if rigid.shape[1] else G
    K = ((K + K.T) / 2.0).tocsc()
    if K.shape[0] > (FEW_MODES_COORDINATES if 4 * count < K.shape[0] else DENSE_COORDINATES):

        def below(square: float) -> int | None:
            """Number of eigenvalues below one that are no rigid motions."""
            found = negative_eigenvalues(K - square * M, G, order)
            return None if found is None else found - (rigid.shape[1] if square > 0.0 else 0)

        return _sparse(K, M, held, count, order, below)
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


def _sparse(
    K: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, count: int, order: np.ndarray, below: Below
) -> tuple[np.ndarray, np.ndarray]:
    """The lowest eigenvalues by inversion of the bordered matrices, with a small shift if they are singular."""
    n, m = K.shape[0], G.shape[0]
    scale = abs(K).max()
    A = sp.block_array([[K, scale * G.T], [scale * G, None]]).tocsc()
    B = sp.block_diag([M, sp.csc_matrix((m, m))]).tocsc()
    wanted = max(1, min(count, n - m - 1))
    small = -1e-6 * scale / abs(M).max()
    for shift in (0.0, small):
        try:
            squares, x = _with_copies(A, B, M, order, shift, wanted, below)
            if below(small) not in (int((squares < small).sum()), None):
                lowest = _below_all(below, min(small, 4.0 * squares[0]))
                return _with_copies(A, B, M, order, lowest, wanted, below)
            return squares, x
        except (ArpackNoConvergence, RuntimeError) as error:
            failure = error
    raise SolveError(f"modes: the eigensolver did not converge ({failure}). Ask for fewer modes.") from failure


def _below_all(below: Below, shift: float) -> float:
    """A shift below all eigenvalues, of which some are negative: an unstable pose."""
    for _ in range(LONGEST_SEARCH):
        if below(shift) == 0:
            break
        shift *= 4.0
    return shift


def _with_copies(
    A: Any, B: Any, M: Any, order: np.ndarray, shift: float, wanted: int, below: Below
) -> tuple[np.ndarray, np.ndarray]:
    """The eigenvalues of A x = omega^2 B x next to a shift, with their multiplicity.

    Lanczos' method finds one vector of a multiple eigenvalue (equal bodies, symmetric frames).  So the method is
    repeated on the complement of all vectors found, until as many lie below the last one as Sylvester's law counts.
    """
    n, size = M.shape[0], A.shape[0]
    solve = solver((A - shift * B).tocsc(), order)
    squares, X = np.zeros(0), np.zeros((n, 0))
    count = wanted
    while not len(squares) or len(squares) + count < n - (size - n):

        def rest(b: np.ndarray, X: np.ndarray = X) -> np.ndarray:
            x = solve(b)
            x[:n] -= X @ (X.T @ (M @ x[:n]))
            return x

        start = rest(B @ np.cos(np.arange(size) ** 2.0 + len(squares)))
        operator = LinearOperator((size, size), rest, dtype=float)
        more, x = eigsh(A, k=count, M=B, sigma=shift, which="LM", v0=start, OPinv=operator)
        last = np.sort(squares)[wanted - 1] if len(squares) else np.inf
        squares, X = np.append(squares, more), np.hstack([X, x[:n]])
        if more.min() >= last:
            break
        last = np.sort(squares)[wanted - 1]
        last -= LOOKED_FOR * abs(last)
        there = below(last)
        count = wanted if there is None else min(wanted, there - int((squares < last).sum()))
        if count <= 0:
            break
    places = np.argsort(squares)[:wanted]
    return squares[places], X[:, places]


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


def largest_of_pencil(
    A: Any, M: Any, solve: Solve, count: int, beyond: Callable[[float], int | None]
) -> tuple[np.ndarray, np.ndarray]:
    """The largest eigenvalues > 0 and the largest < 0 of A x = w M x, with their multiplicity, and vectors.

    A and M (n, n) are symmetric, M is positive on the space of the x, for which x^T M x = 1; `solve` is M^-1 on that
    space.

    `count` eigenvalues of each sign suffice; there are less if the others are clustered at 0.  `beyond` gives the
    number of eigenvalues between a w and infinity, of the sign of w; None where it is not known.
    """
    values, X = _outermost(A, M, solve, np.zeros((M.shape[0], 0)), count, "LM")
    for sign, end in ((1.0, "LA"), (-1.0, "SA")):
        if (sign * values > 0.0).sum() < count:
            more, x = _outermost(A, M, solve, X, count, end)
            values, X = np.append(values, more), np.hstack([X, x])
        for _ in range(LONGEST_SEARCH):
            mine = np.sort(sign * values[sign * values > 0.0])[::-1][:count]
            if not len(mine):
                break
            last = mine[-1] * (1.0 + LOOKED_FOR)
            there = beyond(sign * last)
            missing = count if there is None else there - int((sign * values > last).sum())
            if missing <= 0:
                break
            more, x = _outermost(A, M, solve, X, min(missing, count), end)
            values, X = np.append(values, more), np.hstack([X, x])
            if not len(more) or (sign * more).max() <= last:
                break
    return values, X


def _outermost(A: Any, M: Any, solve: Solve, X: np.ndarray, count: int, which: str) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and vectors at an end of the spectrum of A x = w M x, beside vectors X, which converge soon."""
    n = M.shape[0]

    def rest(b: np.ndarray) -> np.ndarray:
        x = solve(b)
        outside: np.ndarray = x - X @ (X.T @ (M @ x))
        return outside

    start = rest(M @ np.cos(np.arange(n) ** 2.0 + X.shape[1]))
    options = {"M": M, "Minv": LinearOperator((n, n), rest, dtype=float), "which": which, "v0": start}
    restarts = {"maxiter": MOST_RESTARTS} if which != "LM" else {}
    try:
        values, x = eigsh(A, k=min(count, n // 4), **options, **restarts)
    except ArpackNoConvergence as error:
        if which == "LM":
            raise
        values, x = error.eigenvalues, error.eigenvectors
    return values, x


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
        try:
            more, x = eigs(LinearOperator((size, size), rest, dtype=float), k=count, which="LM", v0=start)
        except ArpackNoConvergence as error:
            more, x = error.eigenvalues, error.eigenvectors
            if len(more) < count:  # else all that were asked for are there
                raise
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
