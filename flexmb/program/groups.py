"""Groups of bodies that are connected by joints, contacts or elements; the ground connects nothing."""

import numpy as np

from flexmb.program.program import Program


def body_groups(program: Program) -> np.ndarray:
    """Number of the group of each coordinate, (n_q + 3,); -1: the ground.  Each state of a control is of group 0.

    The motion of one group does not depend on that of another, unless a control reads it.
    """
    T, n_b = program.tables, program.tables.sizes.n_b
    label = np.arange((program.n_q + 3) // 3)
    pieces = [(T.elements.dof, T.elements.dofs), (T.constraints.dof, T.constraints.dofs)]
    pieces.append((np.arange(0, len(T.contacts.dofs) + 1, 6), T.contacts.dofs))
    ends = [_links(begin, dofs.astype(np.int64), n_b) for begin, dofs in pieces]
    first, second = np.concatenate(ends, axis=1)
    while (label[first] != label[second]).any():
        least = np.minimum(label[first], label[second])
        for end in (first, second):
            np.minimum.at(label, label[end], least)
        label = label[label]
    bodies = np.unique(label[: n_b // 3], return_inverse=True)[1]
    groups = np.zeros(len(label), dtype=np.int64)
    groups[: n_b // 3], groups[-1] = bodies, -1
    return np.repeat(groups, 3)


def _links(begin: np.ndarray, dofs: np.ndarray, n_b: int) -> np.ndarray:
    """Nodes (2, links) that follow one another in the coordinates of a piece, without ground and states of controls."""
    piece = np.repeat(np.arange(len(begin) - 1), np.diff(begin))[dofs < n_b]
    nodes = dofs[dofs < n_b] // 3
    same = piece[1:] == piece[:-1]
    return np.stack([nodes[:-1][same], nodes[1:][same]])
