"""Time of the sparse solver on chains of links with revolute joints: `python tests/speed/lu_time.py`.

A link is a chain of beam elements; a revolute joint couples two nodes by two rows; the first node hangs on a fixed
point.  Prints medians in microseconds; the symbolic part in milliseconds.
"""

from statistics import median
from time import perf_counter

import numba
import numpy as np

from flexmb.engine.linalg.lu import LOST_PIVOT, factor, solve, tables
from flexmb.engine.linalg.ordering import elimination_order
from flexmb.engine.linalg.symbolic import symbolic

# (links, elements a link): n = 3 links (elements + 1) + 2 links
CASES = {"3 rigid": (3, 0), "9 x 4": (9, 4), "9 x 40": (9, 40), "400 x 9": (400, 9)}


def chain(links: int, elements: int) -> tuple[list[list[int]], list[tuple[int, ...]], list[bool]]:
    """Blocks, edges and kinds of blocks of a chain of links, its first joint at the ground."""
    nodes = links * (elements + 1)
    blocks = [[3 * k, 3 * k + 1, 3 * k + 2] for k in range(nodes)]
    blocks += [[3 * nodes + 2 * k, 3 * nodes + 2 * k + 1] for k in range(links)]
    edges: list[tuple[int, ...]] = [(k, k + 1) for k in range(nodes) if (k + 1) % (elements + 1) and k + 1 < nodes]
    edges += [(k * (elements + 1) - 1, k * (elements + 1), nodes + k) for k in range(1, links)] + [(0, nodes)]
    return blocks, edges, [False] * nodes + [True] * links


def entries(blocks, edges, last) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(rows, cols, values) of a random KKT matrix: unsymmetric dominant S, revolute joints in G."""
    rng = np.random.default_rng(1)
    parts = []
    for edge in edges:
        nodes = [k for b in edge if not last[b] for k in blocks[b]]
        joint = [k for b in edge if last[b] for k in blocks[b]]
        if joint:  # x + a theta and y + b theta of the two ends agree
            sides = [s * np.array([[1, 0, rng.uniform(-1, 1)], [0, 1, rng.uniform(-1, 1)]]) for s in (1, -1)]
            G = np.hstack(sides[: len(nodes) // 3])
            parts += [_coo(joint, nodes, G), _coo(nodes, joint, G.T)]
        else:
            parts.append(_coo(nodes, nodes, rng.uniform(-1, 1, (6, 6)) + 6 * np.eye(6)))
    for block, is_joint in zip(blocks, last, strict=True):
        if not is_joint:
            parts.append(_coo(block, block, rng.uniform(-1, 1, (3, 3)) + 4 * np.eye(3)))
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))


def _coo(rows, cols, block):
    i, j = np.nonzero(block)
    return np.asarray(rows)[i], np.asarray(cols)[j], block[i, j]


@numba.njit
def factor_often(sym, values, lu, seen, repeats):
    for _ in range(repeats):
        lu[:] = values
        factor(sym, lu, seen, LOST_PIVOT)


@numba.njit
def copy_often(values, lu, repeats):
    for _ in range(repeats):
        lu[:] = values


@numba.njit
def solve_often(sym, lu, b, x, y, repeats):
    for _ in range(repeats):
        solve(sym, lu, b, x, y)


def microseconds(call, *arguments) -> float:
    """Median time of one repetition; the first call, which compiles, is left out."""
    repeats = max(1, 20000 // len(arguments[-1]))
    call(*arguments, 1)
    times = []
    for _ in range(21):
        start = perf_counter()
        call(*arguments, repeats)
        times.append((perf_counter() - start) / repeats)
    return 1e6 * median(times)


def main() -> None:
    """Print the table."""
    print(f"{'chain':>10} {'n':>6} {'order ms':>9} {'pattern ms':>11} {'factor us':>10} {'solve us':>9}")
    for name, case in CASES.items():
        blocks, edges, last = chain(*case)
        rows, cols, numbers = entries(blocks, edges, last)
        start = perf_counter()
        order = elimination_order(blocks, edges, last)
        ordered = perf_counter()
        pattern = symbolic(len(order), rows, cols, order)
        ready = perf_counter()
        values = np.zeros(pattern.size)
        np.add.at(values, pattern.positions(rows, cols), numbers)
        sym, lu, seen = tables(pattern), values.copy(), np.zeros(len(order))
        factoring = microseconds(factor_often, sym, values, lu, seen) - microseconds(copy_often, values, lu)
        solving = microseconds(solve_often, sym, lu, np.ones(len(order)), np.zeros(len(order)), seen)
        times = f"{1e3 * (ordered - start):>9.1f} {1e3 * (ready - ordered):>11.1f} {factoring:>10.2f} {solving:>9.2f}"
        print(f"{name:>10} {len(order):>6} {times}")


if __name__ == "__main__":
    main()
