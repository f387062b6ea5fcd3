"""Elimination order of the unknowns of A = [[S, G^T], [G, 0]]."""

from collections.abc import Sequence
from heapq import heapify, heappop, heappush
from itertools import chain

import numpy as np

from flexmb.errors import InputError
from flexmb.late import sp

_OWNER = "elimination_order"
# Number of blocks above which the order is that of SuperLU's multiple minimum degree, compiled code: no more fill in a
# tenth of the time. Below it, that library would take longer to import than the order takes.
LARGE_GRAPH = 1000


def elimination_order(
    blocks: Sequence[Sequence[int]], edges: Sequence[Sequence[int]], last: Sequence[bool]
) -> np.ndarray:
    """Order of elimination with little fill, without a zero pivot where G has full rank.

    Minimum degree on blocks, counted in unknowns, ties by number of the block; then a postorder of the elimination
    tree, which changes no fill and brings together what the numeric kernel touches together.  The diagonal of a
    constraint is zero until the coordinates in its row are gone, so its block waits for all blocks it shares an edge
    with.  More than LARGE_GRAPH blocks are ordered by multiple minimum degree, each constraint next after the last of
    the blocks that it waits for.  The result (n,), int64, has the unknowns eliminated first at the front.

    `blocks` are numbers of the unknowns in each block: the three coordinates of a node, the rows of one joint; every
    unknown 0 .. n-1 stands in exactly one.  `edges` are blocks that an element or a joint couples, all with all; `last`
    is true for the blocks of constraints.
    Not for one body with hundreds of joints: they all wait for it and then form a full matrix.
    Source: A. George and J. W. H. Liu, The evolution of the minimum degree ordering algorithm, SIAM Review 31 (1989)
    1-19, sections 2 (elimination graphs), 5 (external degree) and 6 (multiple elimination).
    Two bodies and the joint between them (unknowns 6 and 7):

    >>> elimination_order([[0, 1, 2], [3, 4, 5], [6, 7]], [(0, 1, 2)], [False, False, True]).tolist()
    [0, 1, 2, 3, 4, 5, 6, 7]
    """
    _check(blocks, edges, last)
    if len(blocks) > LARGE_GRAPH:
        sequence = _multiple_minimum_degree(len(blocks), edges, np.array(last, dtype=bool))
    else:
        neighbours: list[set[int]] = [set() for _ in blocks]
        for edge in edges:
            for block in edge:
                neighbours[block].update(edge)
        for number, around in enumerate(neighbours):
            around.discard(number)
        sequence = _postorder(*_minimum_degree(neighbours, [len(block) for block in blocks], last))
    return np.array([unknown for number in sequence for unknown in blocks[number]], dtype=np.int64)


def _check(blocks: Sequence[Sequence[int]], edges: Sequence[Sequence[int]], last: Sequence[bool]) -> None:
    count = len(blocks)
    if len(last) != count:
        raise InputError(f"{_OWNER}: last has {len(last)} entries for {count} blocks; give one for each block.")
    unknowns = sorted(chain.from_iterable(blocks))
    if unknowns != list(range(len(unknowns))):
        for expected, unknown in enumerate(unknowns):
            if unknown == expected:
                continue
            fault = "stands in two blocks" if 0 <= unknown < expected else f"comes where {expected} is missing"
            raise InputError(f"{_OWNER}: unknown {unknown} {fault}; every unknown 0 .. n-1 needs exactly one block.")
    if min(map(min, filter(None, edges)), default=0) >= 0 and max(map(max, filter(None, edges)), default=-1) < count:
        return
    for edge in edges:
        for block in edge:
            if not 0 <= block < count:
                text = f"{_OWNER}: edge {tuple(edge)} names block {block};"
                raise InputError(f"{text} there are blocks 0 .. {count - 1}. Leave the ground out of edges.")


def _multiple_minimum_degree(count: int, edges: Sequence[Sequence[int]], last: np.ndarray) -> list[int]:
    """Blocks in order of elimination, by SuperLU on the graph of the coordinates, in a postorder of its tree."""
    # SuperLU gives its order beside the factors of a matrix alone: here one with a dominant diagonal and a number for
    # every block, whose factors take a twentieth of those of the unknowns.
    lengths = np.fromiter(map(len, edges), np.int64, len(edges))
    members = np.fromiter(chain.from_iterable(edges), np.int64, int(lengths.sum()))
    starts = np.concatenate([[0], np.cumsum(lengths)])
    joined = sp.csr_array((np.ones(len(members)), members, starts), shape=(len(edges), count))
    coordinates = np.flatnonzero(~last)
    own = joined[:, coordinates]
    graph = own.T @ own
    dominant = (graph + sp.diags_array(1.0 + graph.sum(axis=1))).tocsc()
    place = np.full(count, -1, dtype=np.int64)
    options = {"SymmetricMode": True}
    factors = sp.linalg.splu(dominant, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    place[coordinates] = factors.perm_c
    latest = np.full(count, -1, dtype=np.int64)
    if len(edges):
        of_edge = np.full(len(edges), -1, dtype=np.int64)
        np.maximum.at(of_edge, np.repeat(np.arange(len(edges)), lengths), place[members])
        np.maximum.at(latest, members, np.repeat(of_edge, lengths))
    place[last] = latest[last]
    found: list[int] = np.lexsort((np.arange(count), last, place)).tolist()
    return found


def _minimum_degree(neighbours: list[set[int]], sizes: list[int], last: Sequence[bool]) -> tuple[list[int], list[int]]:
    """(parent of each block in the elimination tree, -1 for a root; blocks in order of elimination)."""
    # Eats `neighbours`. The heap holds old degrees too; an entry counts only if its degree is the present one.
    waits = [len(around) - sum(map(last.__getitem__, around)) if last[b] else 0 for b, around in enumerate(neighbours)]
    released_by = [[k for k in around if last[k]] if not last[b] else [] for b, around in enumerate(neighbours)]
    degrees = [sum(map(sizes.__getitem__, around)) for around in neighbours]
    heap = [(degrees[b], b) for b, wait in enumerate(waits) if not wait]
    heapify(heap)
    alive = [True] * len(sizes)
    sequence: list[int] = []
    structure: dict[int, set[int]] = {}
    while heap:
        degree, block = heappop(heap)
        if not alive[block] or degree != degrees[block]:
            continue
        around = structure[block] = neighbours[block]
        alive[block] = False
        sequence.append(block)
        if len(around) == len(sizes) - len(sequence):  # all that is left is coupled: any order fills the same
            rest = sorted(around, key=lambda k: (bool(last[k]), k))  # coordinates, then constraints
            structure.update((k, set(rest[at : at + 1])) for at, k in enumerate(rest, 1))  # the next one is the parent
            sequence.extend(rest)
            break
        for k in released_by[block]:
            waits[k] -= 1
        weight = sum(map(sizes.__getitem__, around))
        for k in around:
            mine = neighbours[k]  # from here on without `block`, with all its neighbours
            mine |= around
            mine -= {k, block}
            nothing_beyond = len(mine) == len(around) - 1
            degrees[k] = weight - sizes[k] if nothing_beyond else sum(map(sizes.__getitem__, mine))
            if not waits[k]:
                heappush(heap, (degrees[k], k))
    return _parents(sequence, structure), sequence


def _parents(sequence: list[int], structure: dict[int, set[int]]) -> list[int]:
    turn = [0] * len(sequence)
    for position, block in enumerate(sequence):
        turn[block] = position
    parents = [-1] * len(sequence)
    for block in sequence:
        if structure[block]:
            parents[block] = min(structure[block], key=turn.__getitem__)
    return parents


def _postorder(parents: list[int], sequence: list[int]) -> list[int]:
    """`sequence` with the descendants of each block directly before it."""
    children: dict[int, list[int]] = {}
    for block in sequence:
        children.setdefault(parents[block], []).append(block)
    backwards: list[int] = []
    stack = list(children.get(-1, ()))
    while stack:
        block = stack.pop()
        backwards.append(block)
        stack.extend(children.get(block, ()))
    return backwards[::-1]
