"""Eigenvalue problems on the null space of the constraints, motions without resistance, and stability."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from flexmb.display import quoted
from flexmb.engine.linalg.large import Solve, is_regular, negative_eigenvalues, null_vectors, solver
from flexmb.errors import SolveError
from flexmb.late import scipy, sp
from flexmb.program.program import Program
from flexmb.statics.start.consistent import RigidMotion

DENSE_MOTIONS = 900  # number of rigid motions of bodies (three each) up to which plain matrices find the free ones
DEPENDENT_ROW = 1e-10  # pivot of a constraint row over the largest, below which it depends on others (poses hold 1e-12)
# Entry of a constraint row on bodies, over the sum of the absolute values of its terms, below which it is round-off.
ROW_ROUND_OFF = 1e-14
FREE_FORCE = 1e-13  # force of a free motion relative to the sum of the absolute values of its terms
STIFFNESS_ROUND_OFF = 1e-15  # round-off of an entry of the stiffness relative to the largest entry of its node
SMALL_SHARE = 1e-8  # component of a motion relative to its largest, below which it is not named


def null_space(G: np.ndarray) -> np.ndarray:
    """Orthonormal basis (n, k) of the motions x with G x = 0, by a pivoted QR of G^T with rows of length 1."""
    n, lengths = G.shape[1], np.linalg.norm(G, axis=1)
    G = G[lengths > 0.0] / lengths[lengths > 0.0, None]
    if not len(G):
        return np.eye(n)
    Q, R, _ = scipy.linalg.qr(G.T, pivoting=True)
    diagonal = np.abs(np.diag(R))
    return np.asarray(Q[:, int((diagonal > DEPENDENT_ROW * diagonal[0]).sum()) :])


def free_motions(program: Program, q: np.ndarray, K: sp.csc_matrix, G: sp.csr_matrix) -> np.ndarray:
    """Rigid motions (3 bodies, k) of the bodies that satisfy the constraints without a force of stiffness."""
    # Flexible bodies resist every deformation, so that these are all motions without strain energy. Each row of K B w
    # is compared with the sum of the absolute values of its own terms, its round-off: a spring of 1e-9 of the stiffness
    # of a beam counts, and a large stiffness elsewhere hides nothing.
    B = RigidMotion(program).basis(q)
    sizes = np.where(np.arange(B.shape[1]) % 3 == 2, 1.0, program.length)
    B = (B @ sp.diags_array(sizes)).tocsr()
    if B.shape[1] > DENSE_MOTIONS and is_regular(K, G, program.symbolic.order):
        return np.zeros((B.shape[1], 0))
    find = _sparse_motions if B.shape[1] > DENSE_MOTIONS else _dense_motions
    return np.asarray(sizes[:, None] * simplified(find(program, B, K, G)))


def _dense_motions(program: Program, B: sp.csr_matrix, K: sp.csc_matrix, G: sp.csr_matrix) -> np.ndarray:
    """Free motions (3 bodies, k) by factors of plain matrices."""
    # rows that only the round-off of their own terms resists, as of pins and nodes of one body, resist nothing
    terms_of_rows = np.asarray((abs(G) @ abs(B)).sum(axis=1)).ravel()
    rows_of_bodies = (G @ B).toarray()
    Z = null_space(rows_of_bodies[np.abs(rows_of_bodies).max(axis=1, initial=0.0) > ROW_ROUND_OFF * terms_of_rows])
    if not Z.shape[1]:
        return Z
    moved = B @ Z
    floor = STIFFNESS_ROUND_OFF / FREE_FORCE * stiffest_at(K) * np.abs(moved).max()
    terms = (abs(K) @ np.abs(moved)).sum(axis=1) + floor
    rows = terms > 0.0
    force = (K @ moved)[rows] / terms[rows, None]
    if not np.isfinite(force).all():
        raise SolveError(_too_stiff(program))
    if len(force):
        values, vectors = scipy.linalg.svd(scipy.linalg.qr(force, mode="r")[0][: force.shape[1]])[1:]
        values = np.append(values, np.zeros(Z.shape[1] - len(values)))
        Z = Z @ vectors[values <= FREE_FORCE * np.sqrt(len(force))].T
    return Z


def _sparse_motions(program: Program, B: sp.csr_matrix, K: sp.csc_matrix, G: sp.csr_matrix) -> np.ndarray:
    """Free motions (3 bodies, k) of many bodies, which keep all rows of G B and K B at 0."""
    # Entries that are the round-off of their terms are none; the rest has rows of length 1.
    blocks = []
    for A, share, floor in ((G, ROW_ROUND_OFF, None), (K, FREE_FORCE, STIFFNESS_ROUND_OFF * stiffest_at(K))):
        found = sp.coo_array(A @ B)
        if not np.isfinite(found.data).all():
            raise SolveError(_too_stiff(program))
        terms = np.asarray((abs(A) @ abs(B)).tocsr()[found.row, found.col]).ravel()
        kept = np.abs(found.data) > share * terms + (0.0 if floor is None else floor[found.row])
        block = sp.csr_array((found.data[kept], (found.row[kept], found.col[kept])), shape=found.shape)
        lengths = np.sqrt(np.asarray(block.multiply(block).sum(axis=1)).ravel())
        rows = np.flatnonzero(lengths)
        blocks.append(sp.diags_array(1.0 / lengths[rows]) @ block[rows])
    return null_vectors(sp.vstack(blocks))


def _too_stiff(program: Program) -> str:
    text = f"Mechanism {program.name!r}: its stiffness in this pose is too large for floats."
    return f"{text} Check the numbers of its parts and their units."


def stiffest_at(K: sp.csc_matrix) -> np.ndarray:
    """Largest stiffness (n_q,) of a node along x or y, at both of these coordinates; 0 at rotations."""
    # Entries of a beam along x or y that should be 0 are the round-off of its axial stiffness, since the stiffness is
    # rotated from the axes of the beam.
    largest = abs(K).tocsr().max(axis=1).toarray().ravel()
    along = np.maximum(largest[0::3], largest[1::3])
    return np.column_stack([along, along, np.zeros_like(along)]).ravel()


def simplified(Z: np.ndarray) -> np.ndarray:
    """Combinations of the same motions that are single translations or rotations if possible, translations first."""
    Z, count = Z.copy(), Z.shape[1]
    chosen: list[int] = []
    turning: list[int] = []
    # the first body's translation, all rotations, then what is left: so bodies that hang together translate together
    for place in [0, 1, *range(2, len(Z), 3), *(k for k in range(3, len(Z)) if k % 3 != 2)]:
        left = [k for k in range(count) if k not in chosen]
        if not left:
            break
        best = max(left, key=lambda k: abs(Z[place, k]))
        if abs(Z[place, best]) <= 1e-6:
            continue
        chosen.append(best)
        turning += [best] if place % 3 == 2 else []
        Z[:, best] /= Z[place, best]
        others = [k for k in range(count) if k != best]
        Z[:, others] -= np.outer(Z[:, best], Z[place, others])
    Z = Z[:, [k for k in chosen if k not in turning] + turning]
    return np.where(np.abs(Z) > SMALL_SHARE * np.abs(Z).max(axis=0, initial=0.0), Z, 0.0)


def shapes_of(program: Program, q: np.ndarray, motions: np.ndarray, M: sp.csc_matrix) -> np.ndarray:
    """Motions of bodies as shapes (n_q, k) of the coordinates with x^T M x = 1, orthogonal in M, in their order."""
    # Translations remain translations; the rotation of a free body becomes that about its centre of mass.
    X: np.ndarray = RigidMotion(program).basis(q) @ motions
    for k in range(X.shape[1]):
        for _ in range(2):  # twice: round-off of the first pass
            X[:, k] -= X[:, :k] @ (X[:, :k].T @ (M @ X[:, k]))
        energy = float(X[:, k] @ (M @ X[:, k]))
        X[:, k] /= np.sqrt(energy) if energy > 0.0 else np.abs(X[:, k]).max()
    return X


def motion_in_words(program: Program, motion: np.ndarray) -> str:
    """Description of a rigid motion (3 bodies,): "translation in x of 'rod'"."""
    w = motion.reshape(-1, 3) / np.where(np.arange(3) == 2, 1.0, program.length)
    size = np.abs(w).max()
    moving, turning = np.abs(w).max(axis=1) > SMALL_SHARE * size, np.abs(w[:, 2]) > SMALL_SHARE * size
    if turning.any():
        also = _listed(program, moving & ~turning)
        return f"rotation of {_listed(program, turning)}" + (f", moving {also}" if also else "")
    first = w[int(np.flatnonzero(moving)[0]), :2]
    same = np.abs(w[moving, :2] - first).max() <= 1e-6 * size
    in_x, in_y = (bool(x) for x in np.abs(first) > SMALL_SHARE * size)
    way = {(True, False): "in x", (False, True): "in y"}.get((in_x, in_y))
    if way is None:
        dx, dy = first / np.hypot(*first)
        way = f"along ({dx:.3g}, {dy:.3g})"
    return f"translation {way} of {_listed(program, moving)}" if same else f"motion of {_listed(program, moving)}"


def _listed(program: Program, which: np.ndarray) -> str:
    return quoted((program.names.bodies[b] for b in np.flatnonzero(which)), 3)


def moves_most(names: tuple[str, ...], length: float, shape: np.ndarray) -> str:
    """Name of the coordinate with the largest amplitude in a shape (n_q,), rotations times `length` [m]."""
    return names[int(np.abs(shape * np.where(np.arange(len(shape)) % 3 == 2, length, 1.0)).argmax())]


# Eigenvalue problems on the null space of the constraints: real symmetric, and quadratic with damping

Below = Callable[[float], int | None]
Eigenpairs = tuple[np.ndarray, np.ndarray]  # eigenvalues (k,) and vectors (n, k)
DENSE_COORDINATES = 1500  # number of coordinates up to which a dense eigensolver computes all modes
FEW_MODES_COORDINATES = 300  # number above which a sparse eigensolver is faster for under a quarter of the modes
# Number of coordinates up to which a dense eigensolver is used for quadratic problems, which take 20 times longer.
DENSE_QUADRATIC_COORDINATES = 150
# omega^2 over the largest, below which modes are refined: 10 digits of omega^2 are left to slower ones, and 7 digits.
SLOW, SLOWEST = 1e-6, 1e-9
LOOKED_FOR, COPIES = 1e-6, 1e-9  # accuracy of an eigenvalue that may lie below those found, and of further copies
LONGEST_SEARCH = 60  # number of steps of a search at most, which end after two or three
MOST_RESTARTS = 10  # restarts of Lanczos' method at an end of a spectrum that may cluster at 0: nothing converges
NO_MASS = "modes: a motion without mass; give every body and node some mass and inertia."


def undamped(
    K: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, rigid: np.ndarray, count: int, order: np.ndarray
) -> Eigenpairs:
    """Lowest omega^2 and shapes of K x = omega^2 M x with G x = 0, x orthogonal in M to the shapes `rigid`."""
    # order : order of elimination of the unknowns of [[K, G^T], [G, 0]].
    held = sp.vstack([G, sp.csr_matrix((M @ rigid).T)]).tocsr() if rigid.shape[1] else G
    K = (K + K.T) / 2.0
    if K.shape[0] > (FEW_MODES_COORDINATES if 4 * count < K.shape[0] else DENSE_COORDINATES):
        K = K.tocsc()

        def below(square: float) -> int | None:
            """Number of eigenvalues below one that are no rigid motions."""
            found = negative_eigenvalues(K - square * M, G, order)
            return None if found is None else found - (rigid.shape[1] if square > 0.0 else 0)

        return _sparse(K, M, held, count, order, below)
    Z = null_space(held.toarray())
    squares, y = all_modes(Z.T @ (K @ Z), Z.T @ (M @ Z), SLOW)
    return squares[:count], Z @ y[:, :count]


def all_modes(k: np.ndarray, m: np.ndarray, slow: float = SLOWEST) -> Eigenpairs:
    """All omega^2, ascending, and shapes of k x = omega^2 m x for plain matrices (n, n)."""
    # slow : omega^2 relative to the largest from which modes are refined.
    if not len(k):
        return np.zeros(0), np.zeros((0, 0))
    k, m = _symmetric(k), _symmetric(m)
    try:
        squares, y = scipy.linalg.eigh(k, m)
    except scipy.linalg.LinAlgError as error:
        raise SolveError(NO_MASS) from error
    return _refined(k, m, squares, y) if squares[0] < slow * squares[-1] else (squares, y)


def _refined(k: np.ndarray, m: np.ndarray, squares: np.ndarray, y: np.ndarray) -> Eigenpairs:
    """The modes, with slow modes refined by the inverse of k."""
    # A dense eigensolver has an error of round-off times the largest omega^2 in all modes. The inverse has the slow
    # modes as its largest eigenvalues, with an error relative to the lowest omega^2. Each mode takes the better value.
    # If k is not positive definite (an unstable pose), no mode is refined.
    largest = squares[-1]
    slow = int((squares < SLOW * largest).sum())
    try:
        factor, x = scipy.linalg.cho_factor(k), y[:, :slow]
        for _ in range(3):
            mx = m @ x
            x = scipy.linalg.cho_solve(factor, mx)
            inverse, turn = scipy.linalg.eigh(_symmetric(x.T @ m @ x), _symmetric(x.T @ mx))
            x = (x @ turn)[:, ::-1]
            x /= np.sqrt(np.einsum("ij,ij->j", x, m @ x))
    except scipy.linalg.LinAlgError:
        return squares, y
    if slow:
        better = np.flatnonzero(inverse[::-1] ** -2.0 < largest / inverse[-1])
        squares[better], y[:, better] = 1.0 / inverse[::-1][better], x[:, better]
    return squares, y


def _symmetric(k: np.ndarray) -> np.ndarray:
    return np.asarray((k + k.T) / 2.0)


def _sparse(
    K: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, count: int, order: np.ndarray, below: Below
) -> Eigenpairs:
    """The lowest eigenvalues by inversion of the bordered matrices, with a small shift if they are singular."""
    n, m = K.shape[0], G.shape[0]
    scale = abs(K).max()
    A = sp.block_array([[K, scale * G.T], [scale * G, None]]).tocsc()
    B = sp.block_diag([M, sp.csc_matrix((m, m))]).tocsc()
    wanted, small = max(1, min(count, n - m - 1)), -1e-6 * scale / abs(M).max()
    for shift in (0.0, small):
        try:
            squares, x = _with_copies(A, B, M, order, shift, wanted, below)
            if below(small) not in (int((squares < small).sum()), None):
                lowest = min(small, 4.0 * squares[0])  # an unstable pose: some eigenvalues are negative
                for _ in range(LONGEST_SEARCH):
                    if below(lowest) == 0:
                        break
                    lowest *= 4.0
                return _with_copies(A, B, M, order, lowest, wanted, below)
            return squares, x
        except (sp.linalg.ArpackNoConvergence, RuntimeError) as error:
            failure = error
    raise SolveError(f"modes: the eigensolver did not converge ({failure}). Ask for fewer modes.") from failure


def _with_copies(A: Any, B: Any, M: Any, order: np.ndarray, shift: float, wanted: int, below: Below) -> Eigenpairs:
    """The eigenvalues of A x = omega^2 B x next to a shift, with their multiplicity."""
    # Lanczos' method finds one vector of a multiple eigenvalue (equal bodies, symmetric frames). So the method is
    # repeated on the complement of all vectors found, until as many lie below the last one as Sylvester's law counts.
    n, size = M.shape[0], A.shape[0]
    solve = solver((A - shift * B).tocsc(), order)
    squares, X, count = np.zeros(0), np.zeros((n, 0)), wanted
    while not len(squares) or len(squares) + count < n - (size - n):

        def rest(b: np.ndarray, X: np.ndarray = X) -> np.ndarray:
            x = solve(b)
            x[:n] -= X @ (X.T @ (M @ x[:n]))
            return x

        start = rest(B @ np.cos(np.arange(size) ** 2.0 + len(squares)))
        operator = sp.linalg.LinearOperator((size, size), rest, dtype=float)
        more, x = sp.linalg.eigsh(A, k=count, M=B, sigma=shift, which="LM", v0=start, OPinv=operator)
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
    K: sp.csc_matrix, C: sp.csc_matrix, M: sp.csc_matrix, G: sp.csr_matrix, rigid: np.ndarray, count: int, *,
    kept: bool = False,
) -> Eigenpairs:  # fmt: skip
    """Eigenvalues s with Im s >= 0, lowest |s| first, and shapes of (s^2 M + s C + K) x = 0, G x = 0."""
    # x is orthogonal in M to the shapes `rigid`; with `kept` the problem includes them, with exactly zero stiffness.
    held = sp.vstack([G, sp.csr_matrix((M @ rigid).T)]).tocsr() if rigid.shape[1] else G
    if K.shape[0] > (DENSE_COORDINATES if kept else DENSE_QUADRATIC_COORDINATES):
        s, x = _sparse_quadratic(K, C, M, G if kept else held, count)
    else:
        free = rigid if kept else rigid[:, :0]
        s, x = _dense_quadratic(K, C, M, np.hstack([free, null_space(held.toarray())]), free.shape[1])
    s = np.where(np.abs(s.imag) <= 1e-12 * np.abs(s).max(initial=0.0), s.real + 0.0j, s)
    keep = np.flatnonzero(s.imag >= 0.0)
    keep = keep[np.argsort(np.abs(s[keep]), kind="stable")][:count]
    return s[keep], x[:, keep]


def _dense_quadratic(K: Any, C: Any, M: Any, Z: np.ndarray, free: int) -> Eigenpairs:
    """All eigenvalues by a scaled companion matrix; the first `free` columns of Z have no stiffness."""
    n = Z.shape[1]
    if n == 0:
        return np.zeros(0, complex), np.zeros((K.shape[0], 0), complex)
    k, c, m = (Z.T @ (X @ Z) for X in (K, C, M))
    k[:free], k[:, :free] = 0.0, 0.0
    try:
        factor = scipy.linalg.cho_factor((m + m.T) / 2.0)
    except scipy.linalg.LinAlgError as error:
        raise SolveError(NO_MASS) from error
    k, c = scipy.linalg.cho_solve(factor, k), scipy.linalg.cho_solve(factor, c)
    unit = np.sqrt(scipy.linalg.norm(k, 2)) or 1.0
    values, vectors = scipy.linalg.eig(np.block([[np.zeros((n, n)), np.eye(n)], [-k / unit**2, -c / unit]]))
    return values * unit, Z @ vectors[:n]


def _sparse_quadratic(K: Any, C: Any, M: Any, G: sp.csr_matrix, count: int) -> Eigenpairs:
    """The lowest eigenvalues, by the inverse of the first-order problem on displacements and velocities."""
    n, m = K.shape[0], G.shape[0]
    scale = abs(K).max()
    try:
        lu = sp.linalg.splu(sp.block_array([[K, scale * G.T], [scale * G, None]]).tocsc())
    except RuntimeError as error:
        text = "the stiffness is singular: hold the motions that only dampers resist, or model fewer elements"
        raise SolveError(f"modes: {text} ({error}).") from error
    unit = 1.0

    def inverse(x: np.ndarray) -> np.ndarray:
        """Apply the inverse operator: 1/s times (y, s y/unit), y = -K^-1 (C y + M (s y)) on the null space of G."""
        return np.concatenate([-lu.solve(np.append(C @ x[:n] + unit * (M @ x[n:]), np.zeros(m)))[:n], x[:n] / unit])

    y = inverse(np.append(np.zeros(n), np.cos(np.arange(n) ** 2.0)))[:n]  # nearly a shape of the lowest |s|, the unit
    unit = np.sqrt(np.linalg.norm(y) / np.linalg.norm(inverse(np.append(np.zeros(n), y))[:n])) if y.any() else 1.0
    try:
        values, x = largest_of(inverse, 2 * n, 2 * count + 2)
    except (sp.linalg.ArpackNoConvergence, RuntimeError) as error:
        raise SolveError(f"modes: the eigensolver did not converge ({error}). Ask for fewer modes.") from error
    return 1.0 / values, x[:n]


def largest_of_pencil(A: Any, M: Any, solve: Solve, count: int, beyond: Callable[[float], int | None]) -> Eigenpairs:
    """The largest eigenvalues > 0 and the largest < 0 of A x = w M x, with their multiplicity, and vectors."""
    # A and M (n, n) are symmetric, M is positive on the space of the x, for which x^T M x = 1; `solve` is M^-1 on that
    # space. `count` eigenvalues of each sign suffice; there are less if the others are clustered at 0. `beyond` gives
    # the number of eigenvalues between a w and infinity, of the sign of w; None where it is not known.
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


def _outermost(A: Any, M: Any, solve: Solve, X: np.ndarray, count: int, which: str) -> Eigenpairs:
    """Eigenvalues and vectors at an end of the spectrum of A x = w M x, beside vectors X, which converge soon."""
    n = M.shape[0]

    def rest(b: np.ndarray) -> np.ndarray:
        x = solve(b)
        return np.asarray(x - X @ (X.T @ (M @ x)))

    start = rest(M @ np.cos(np.arange(n) ** 2.0 + X.shape[1]))
    options = {"M": M, "Minv": sp.linalg.LinearOperator((n, n), rest, dtype=float), "which": which, "v0": start}
    restarts = {"maxiter": MOST_RESTARTS} if which != "LM" else {}
    try:
        values, x = sp.linalg.eigsh(A, k=min(count, n // 4), **options, **restarts)
    except sp.linalg.ArpackNoConvergence as error:
        if which == "LM":
            raise
        values, x = error.eigenvalues, error.eigenvectors
    return values, x


def largest_of(operator: Solve, size: int, count: int) -> Eigenpairs:
    """The eigenvalues of a real operator of largest modulus, with their multiplicity, and eigenvectors."""
    # Arnoldi's method finds one vector of a multiple eigenvalue. So the method is repeated on the complement of the
    # invariant subspace Q found so far, until no eigenvalue as large appears; Q^T A Q then has all of them.
    Q, found = np.zeros((size, 0)), np.zeros(0)
    while Q.shape[1] + 2 * count + 2 < size:

        def rest(x: np.ndarray, Q: np.ndarray = Q) -> np.ndarray:
            y = operator(x - Q @ (Q.T @ x))
            return np.asarray(y - Q @ (Q.T @ y))

        start = rest(np.cos(np.arange(size) ** 2.0 + len(found)))
        try:
            operation = sp.linalg.LinearOperator((size, size), rest, dtype=float)
            more, x = sp.linalg.eigs(operation, k=count, which="LM", v0=start, tol=COPIES if len(found) else 0.0)
        except sp.linalg.ArpackNoConvergence as error:
            more, x = error.eigenvalues, error.eigenvectors
            if len(more) < count:  # else all that were asked for are there
                raise
        least = np.sort(found)[-count] if len(found) else 0.0
        found = np.append(found, np.abs(more))
        parts = np.hstack([x.real, x.imag])
        for _ in range(2):  # twice: round-off of the first time
            parts = parts - Q @ (Q.T @ parts)
        U, sizes, _ = scipy.linalg.svd(parts, full_matrices=False)
        Q = scipy.linalg.qr(np.hstack([Q, U[:, sizes > 1e-8 * sizes[0]]]), mode="economic")[0]
        if np.abs(more).max() <= least * (1.0 + 1e-9):
            break
    values, y = scipy.linalg.eig(Q.T @ np.column_stack([operator(q) for q in Q.T]))
    order = np.argsort(-np.abs(values), kind="stable")[:count]
    return values[order], Q @ y[:, order]


STIFFNESS_ASYMMETRY = 1e-9  # no potential: difference of stiffnesses off the diagonal, over the largest


def is_stable(program: Program, K: sp.csc_matrix, G: sp.csr_matrix) -> bool | None:
    """Whether x^T K x > 0 for all motions x with G x = 0; None for an asymmetric K or pivots near zero."""
    # K (n_q, n_q) is the tangent stiffness, multipliers included, G (n_c, n_q) are the constraints.
    sizes = sp.diags_array(program.sizes / program.length)
    K = (sizes @ K @ sizes).tocsc()
    if abs(K - K.T).max() > STIFFNESS_ASYMMETRY * (abs(K).max() if K.nnz else 0.0):
        return None
    found = negative_eigenvalues(K, G @ sizes, program.symbolic.order)
    return None if found is None else found == 0
