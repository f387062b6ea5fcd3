"""Numbers of coordinates and unknowns, and the elimination order of the matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, pairwise
from typing import Any

import numpy as np

from flexmb.model.contributions import AXES, Contributions, ControlContribution, Coordinate, Node
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND

UNUSED = ("unused1", "unused2")  # names of coordinates that fill up the states of a control to threes


@dataclass(frozen=True, eq=False)
class Lists:
    """Lists of whole numbers, one behind the other in `values`; list k is values[ptr[k] : ptr[k + 1]]."""

    ptr: np.ndarray
    values: np.ndarray

    @staticmethod
    def of(lists: Sequence[Sequence[int]]) -> Lists:
        """These lists."""
        lengths = np.fromiter(map(len, lists), dtype=np.int64, count=len(lists))
        ptr = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
        return Lists(ptr, np.fromiter(chain.from_iterable(lists), dtype=np.int64, count=int(ptr[-1])))


class Numbering:
    """Numbers of the coordinates of a mechanism: three a node, in the order of declaration, bodies before controls."""

    def __init__(self, mechanism: Mechanism, *, controls: bool = True) -> None:
        bodies = mechanism.nodes()
        self.n_b = 3 * len(bodies)
        self._states = state_nodes(mechanism) if controls else []
        self.nodes: tuple[tuple[str, Node], ...] = (*bodies, *((part, node) for part, node, _ in self._states))
        self.of_body: dict[str, tuple[int, int]] = {}  # where the coordinates of each body begin and end
        for k, (part, _) in enumerate(self.nodes):
            self.of_body[part] = self.of_body.get(part, (3 * k, 0))[0], 3 * k + 3
        self.n_q = 3 * len(self.nodes)
        named = [(part, node.name) for part, node in self.nodes]
        every = [(part, node, axis) for part, node in (*named, (GROUND.name, "")) for axis in (0, 1, 2)]
        self._number: dict[Coordinate, int] = dict(zip(every, range(len(every)), strict=True))
        self._lists: dict[int, tuple[Sequence[Any], Lists]] = {}

    def dofs(self, coordinates: Sequence[Coordinate]) -> list[int]:
        """Numbers of coordinates; the ground's are n_q, n_q + 1, n_q + 2."""
        return [self._number[c] for c in coordinates]

    def lists(self, contributions: Sequence[Any]) -> Lists:
        """Numbers of the `coordinates` of each piece, remembered for the same sequence of pieces."""
        if id(contributions) not in self._lists:
            number = self._number.__getitem__
            numbers = [list(map(number, contribution.coordinates)) for contribution in contributions]
            self._lists[id(contributions)] = (contributions, Lists.of(numbers))
        return self._lists[id(contributions)][1]

    def names(self) -> tuple[str, ...]:
        """Names of the coordinates: of bodies by node and axis, of controls by state."""
        bodies = self.nodes[: self.n_b // 3]
        stems = [f"{part}.{node.name}" if node.name else part for part, node in bodies]
        states = [f"{part}.{name}" for part, _, names in self._states for name in names]
        return (*[f"{stem}.{axis}" for stem in stems for axis in AXES], *states)

    def pose(self) -> np.ndarray:
        """Coordinates of the reference configuration (n_q,) [m, rad]."""
        return np.array([x for _, n in self.nodes for x in (n.x, n.y, n.theta)], dtype=float)

    @cached_property
    def extent(self) -> float:
        """Extent of the nodes in the reference configuration, in any direction [m]; 1 for a node at the origin."""
        points = self.pose()[: self.n_b].reshape(-1, 3)[:, :2]
        end = points[np.argmax(np.hypot(*(points - points.mean(axis=0)).T))]
        extent = float(np.hypot(*(points - end).T).max())
        return extent or float(np.hypot(*points.T).max()) or 1.0


def state_nodes(mechanism: Mechanism) -> list[tuple[str, Node, tuple[str, str, str]]]:
    """Controller, node and names of three states at a time of controllers without sampling; missing ones stay 0."""
    found = []
    for controller in mechanism.controllers:
        control = controller.control()
        if control.sample is not None:
            continue
        for k in range(0, len(control.states), 3):
            names = (*control.states[k : k + 3], *UNUSED)
            found.append((control.part, Node(state_node(k), 0.0, 0.0, 0.0), (names[0], names[1], names[2])))
    return found


def state_node(state: int) -> str:
    """Name of the node that holds a state of a control, by the number of the state."""
    return f"states{state // 3}"


def state_coordinates(control: ControlContribution) -> tuple[Coordinate, ...]:
    """Coordinates of the states of a control, in threes; none of a sampled one."""
    nodes = range(0, 0 if control.sample is not None else len(control.states), 3)
    return tuple((control.part, state_node(k), axis) for k in nodes for axis in (0, 1, 2))


def blocks_and_edges(
    contributions: Contributions, number: Numbering
) -> tuple[list[range], list[tuple[int, ...]], list[bool]]:
    """Blocks of unknowns (nodes, then constraints), groups of coupled blocks, and which blocks are constraints."""
    n_nodes = number.n_q // 3
    blocks = [range(3 * k, 3 * k + 3) for k in range(n_nodes)]
    groups = (contributions.elements, contributions.contacts, contributions.constraints)
    touched = [nodes for group in groups for nodes in _nodes_of(number.lists(group), n_nodes)]
    free, row = len(touched) - len(contributions.constraints), number.n_q
    touched += _nodes_of(Lists.of([number.dofs(control.touched) for control in contributions.controls]), n_nodes)
    for k, contribution in enumerate(contributions.constraints):
        touched[free + k] = (*touched[free + k], n_nodes + k)
        blocks.append(range(row, row + contribution.rows))
        row += contribution.rows
    return blocks, touched, [False] * n_nodes + [True] * len(contributions.constraints)


def _nodes_of(dofs: Lists, ground: int) -> list[tuple[int, ...]]:
    """The nodes that each piece stands on, ascending, without that of the ground."""
    nodes, bounds = (dofs.values // 3).tolist(), dofs.ptr.tolist()
    found = []
    for begin, end in pairwise(bounds):
        own = sorted(set(nodes[begin:end]))
        found.append(tuple(own[:-1] if own and own[-1] == ground else own))
    return found
