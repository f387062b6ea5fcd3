"""Largest von Mises stress of a reduced plane body, and the node where it acts.

Stresses of the shapes are added up before the von Mises stress is taken, for many nodes side by side.  Nodes of similar
stresses form a group, and groups a block; only those that may hold the largest stress are looked at.  With the mean
stress s of a group or block and its von Mises stress |s|, at any of its nodes

    |s_k| <= |s| + |s_k - s| <= |s| + sum_j spread_j |y_j|,   y = R e

by the triangle inequality.  |y| is the root mean square of the von Mises stress of all nodes, the y_j are the parts of
orthogonal fields of stress, and spread_j is the largest |s_k - s| of the field j alone.
"""

import math

import numpy as np

from flexmb.elastic.planes.stress import von_mises_square
from flexmb.elastic.reduced import kernel
from flexmb.engine.compiled.arrays import part_of, stack_matrix, stack_space, stack_vector
from flexmb.kernels import extremum_kernel, fast
from flexmb.model.contributions import Coordinate, SignalContribution

scratch = stack_matrix(kernel.QD + kernel.MOST, kernel.MOST)
LANES = 16  # number of nodes side by side, a group; of groups side by side, a block; and of blocks side by side

# Parameters behind those of the element: number of groups; of stresses sx, sy, txy, sz, without those at the end that
# are zero at all nodes.
# At HEAD: R (n, n). Then for every LANES blocks, and for every LANES groups, of each field their spreads and of each
# coordinate their mean stresses side by side; for every group the numbers of its LANES nodes, and of each coordinate
# their stresses side by side. The last group repeats its last node, the last groups and blocks are followed by zeros.
GROUPS, PARTS, HEAD = range(3)
SX, SY, TXY, SZ = range(0, 4 * LANES, LANES)  # places of the stresses of what is side by side, among all of them
SURE = 1.0 + 1e-9  # factor of the bounds, for their round-off
LEAST = 1e-16  # part of the largest mean square of stresses by which deformations without stress count in R
side_by_side = stack_vector(4 * LANES)


@fast
def squares(p, at, e, n, size, S):
    """Set S = squares of the von Mises stresses side by side, and other numbers behind them."""
    # Set S (size,) = stresses of nodes side by side, by the deformation e (n,), of which e[0] = e[1] = 0
    for k in range(size):
        S[k] = p[at + 2 * size + k] * e[2]
    for i in range(3, n, 3):
        first, second, third = at + i * size, at + (i + 1) * size, at + (i + 2) * size
        e1, e2, e3 = e[i], e[i + 1], e[i + 2]
        for k in range(size):
            S[k] += p[first + k] * e1 + p[second + k] * e2 + p[third + k] * e3
    for k in range(size, 4 * LANES):
        S[k] = 0.0
    for k in range(LANES):
        S[SX + k] = von_mises_square(S[SX + k], S[SY + k], S[TXY + k], S[SZ + k])


@fast
def fields(p, at, e, n, y):
    """Set y = |R e|, entry by entry."""
    for i in range(n):
        row = 0.0
        for j in range(n):
            row += p[at + i * n + j] * e[j]
        y[i] = abs(row)


@fast
def bounds_side_by_side(p, at, e, y, n, size, S):
    """Set S = bounds of the stresses in groups or blocks side by side."""
    squares(p, at + LANES * n, e, n, size, S)
    for k in range(LANES):
        S[k] = math.sqrt(S[k])
    for j in range(n):
        for k in range(LANES):
            S[k] += p[at + LANES * j + k] * y[j]
    for k in range(LANES):
        S[k] *= SURE


@fast
def fill_bounds(p, at, e, y, n, size, S, least, bounds, of_groups):
    """Fill the bounds of all blocks and groups; the group with the largest one."""
    # Groups of blocks that cannot hold more than `least` have the bound 0; -1 is returned when no block can.
    blocks, groups, step = bounds.shape[0], of_groups.shape[0], LANES * n + n * size
    for first in range(0, blocks, LANES):
        bounds_side_by_side(p, at, e, y, n, size, S)
        for k in range(min(LANES, blocks - first)):
            bounds[first + k] = S[k]
        at += step
    best, most = -1, -1.0
    for block in range(blocks):
        first = LANES * block
        seen = not bounds[block] < least  # also what is not a number
        if seen:
            bounds_side_by_side(p, at + block * step, e, y, n, size, S)
        for k in range(min(LANES, groups - first)):
            of_groups[first + k] = S[k] if seen else 0.0
            if seen and not of_groups[first + k] <= most:
                best, most = first + k, of_groups[first + k]
    return best


@extremum_kernel
def peak_stress_kernel(p, t, q, v, a, least):
    """Largest nodal von Mises stress [Pa], and the number of its node; 0 where it is surely not above `least`."""
    n, S, x = int(p[kernel.COUNT]), side_by_side(), scratch()
    e, y = part_of(x[kernel.T1], 0, n), part_of(x[kernel.T2], 0, n)
    c, s, angle, _ = kernel.frame_of(p, q)
    kernel.deformation(p, q, c, s, angle, x)
    for i in range(n):
        x[1, i] = 0.0  # d' has no part in stresses
    kernel.shortened(p, x, e, y)
    begin = kernel.direction(p, int(p[kernel.DIRECTIONS]))  # behind the parameters of the element
    groups, size = int(p[begin + GROUPS]), LANES * int(p[begin + PARTS])
    blocks, step = -(-groups // LANES), LANES * n + n * size
    of_blocks, bounds = stack_space(blocks), stack_space(groups)
    fields(p, begin + HEAD, e, n, y)
    at = begin + HEAD + n * n
    best = fill_bounds(p, at, e, y, n, size, S, least, of_blocks, bounds)
    if best < 0:
        return 0.0, 0.0
    at += (-(-blocks // LANES) + blocks) * step
    floor = least * least if least > 0.0 else -1.0
    largest, where = floor, 0.0
    for turn in range(-1, groups):  # the group with the largest bound first
        group = best if turn < 0 else turn
        if turn == best or bounds[group] * bounds[group] < largest:
            continue
        own = at + group * (LANES + n * size)
        squares(p, own + LANES, e, n, size, S)
        for k in range(LANES):
            if not S[k] < largest:  # also what is not a number
                if S[k] != largest or p[own + k] < where:
                    where = p[own + k]
                largest = S[k]
    if largest == floor:
        return 0.0, 0.0
    return math.sqrt(largest) if where == math.floor(where) else math.nan, where  # NaN: a difference of p mixes nodes


def peak_stress_signal(
    part: str, coordinates: tuple[Coordinate, ...], element: tuple[float, ...], groups: tuple[float, ...]
) -> SignalContribution:
    """The signals `von_mises` and `von_mises_node` of a body, by its `group_parameters`."""
    p = (*element, *groups)
    return SignalContribution(part, "von_mises", "Pa", peak_stress_kernel, coordinates, p, place="von_mises_node")


def group_parameters(stresses: np.ndarray) -> tuple[float, ...]:
    """Parameters of the search: stresses (nodes, 4, n) [Pa/m, Pa/rad] by groups and blocks of nodes."""
    parts = 1 + int(np.flatnonzero(stresses.any(axis=(0, 2)))[-1])
    # Matrices (nodes, 4, n) whose products with R e have the size of the von Mises stress, and R (n, n)
    n = stresses.shape[2]
    V = np.array([[1.0, -0.5, 0.0, -0.5], [-0.5, 1.0, 0.0, -0.5], [0.0, 0.0, 3.0, 0.0], [-0.5, -0.5, 0.0, 1.0]])
    sizes, axes = np.linalg.eigh(V)
    whole = np.einsum("ab,mbn->man", (np.sqrt(np.maximum(sizes, 0.0)) * axes).T, stresses)
    flat = whole.reshape(-1, n)
    squares, shapes = np.linalg.eigh(flat.T @ flat / len(stresses))
    scale = np.sqrt(np.maximum(squares, LEAST * max(float(squares[-1]), 1e-300)))
    metric, root = whole @ (shapes / scale), scale[:, None] * shapes.T
    found = groups_of(metric)
    whole = np.concatenate([found, np.repeat(found[-1:], -len(found) % LANES, axis=0)]).reshape(-1, LANES**2)
    own = []
    for sets in (whole, found):  # spreads by field and mean stresses of sets of nodes, in the order of the kernel
        rows = -(-len(sets) // LANES)
        both = np.zeros((rows * LANES, 1 + parts, n))
        for k, nodes in enumerate(sets):
            both[k, 0] = np.sqrt(((metric[nodes] - metric[nodes].mean(axis=0)) ** 2).sum(axis=1)).max(axis=0)
            both[k, 1:] = stresses[nodes, :parts].mean(axis=0)
        lanes = both.reshape(rows, LANES, 1 + parts, n)
        own.append(_side_by_side(lanes[:, :, 0].transpose(0, 2, 1).reshape(rows, -1), lanes[:, :, 1:]))
    own.append(_side_by_side(found.astype(float), stresses[found][:, :, :parts]))
    return (float(len(found)), float(parts), *root.ravel().tolist(), *np.concatenate(own).tolist())


def _side_by_side(numbers: np.ndarray, stresses: np.ndarray) -> np.ndarray:
    """Numbers (m, ...), each row followed by stresses (m, LANES, parts, n) in the order of the kernel."""
    return np.hstack([numbers, stresses.transpose(0, 3, 2, 1).reshape(len(numbers), -1)]).ravel()


def groups_of(metric: np.ndarray) -> np.ndarray:
    """Numbers (groups, LANES) of the nodes of groups, of similar matrices; the last group repeats its last node."""
    # Nodes are halved at right angles to the direction in which their matrices differ most, until LANES are left.
    # `metric` (nodes, ...) is a matrix of each node.
    flat, left, found = metric.reshape(len(metric), -1), [np.arange(len(metric))], []
    while left:
        nodes = left.pop()
        blocks = -(-len(nodes) // LANES)
        if blocks == 1:
            found.append(np.pad(np.sort(nodes), (0, LANES - len(nodes)), mode="edge"))
            continue
        own = flat[nodes] - flat[nodes].mean(axis=0)
        order = np.argsort(own @ np.linalg.eigh(own.T @ own)[1][:, -1], kind="stable")
        half = LANES * (blocks // 2)
        left += [nodes[order[half:]], nodes[order[:half]]]
    return np.stack(found)
