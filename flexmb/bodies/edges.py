"""Base of bodies whose axis is a set of edges between corners."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flexmb import checks, planar
from flexmb.errors import InputError
from flexmb.model.part import Body

Point = tuple[float, float]
Edge = tuple[int, int]


@dataclass(frozen=True)
class Edges(Body):
    """Base of bodies of edges between corners of the reference configuration.

    Parameters
    ----------
    name : the body's name.
    points : corners [m].
    edges : pairs of corner numbers.

    Raises
    ------
    InputError : a pair that joins no two different corners, an edge twice, corners that no edge reaches.
    """

    points: Sequence[Point]
    edges: Sequence[Edge]

    def __post_init__(self) -> None:
        super().__post_init__()
        corners = checks.sequence(self.label, "points", self.points, "corners (x, y)")
        points = tuple(checks.point(self.label, f"points[{i}]", p) for i, p in enumerate(corners))
        object.__setattr__(self, "points", points)
        edges = checks.sequence(self.label, "edges", self.edges, "pairs of corner numbers")
        object.__setattr__(self, "edges", tuple(self._checked_edge(i, e) for i, e in enumerate(edges)))
        pairs = [frozenset(edge) for edge in self.edges]
        for i, pair in enumerate(pairs):
            if pair in pairs[:i]:
                raise InputError(
                    f"{self.label}: edges[{i}] is {self.edges[i]}, which joins two corners once more; remove it."
                )
        lonely = set(range(len(points))) - {i for edge in self.edges for i in edge}
        if lonely or not self.edges:
            raise InputError(f"{self.label}: corners {sorted(lonely)} belong to no edge. Remove them or add edges.")

    def _checked_edge(self, i: int, edge: object) -> Edge:
        try:
            a, b = (checks.count(self.label, f"edges[{i}]", k, 0) for k in edge)  # type: ignore[attr-defined]
        except (TypeError, ValueError) as error:
            raise InputError(f"{self.label}: edges[{i}] is {edge!r}; it must be a pair of corner numbers.") from error
        if max(a, b) >= len(self.points) or planar.distance(self.points[a], self.points[b]) <= 0.0:
            raise InputError(
                f"{self.label}: edges[{i}] is {edge!r}; it must join two different corners of {len(self.points)}."
            )
        return a, b
