"""Stresses of bodies of beams: the signals of the largest one, and the elements at which it is looked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from flexmb.beams.peak_stress import beam_stress_kernel
from flexmb.beams.section import Section
from flexmb.bodies.flexible import Beam, beam_parameters
from flexmb.errors import InputError
from flexmb.model.contributions import Node, SignalContribution, node_coordinates


def knows_stress(section: Section) -> bool:
    """Whether a section knows its outer fibre."""
    try:
        section.outer_fibre_at(0.5)
    except InputError:
        return False
    return True


def number_of(node: str) -> int:
    """Number of a node of a body of beams: 3 of "node3"."""
    return int(node.removeprefix("node"))


def section_factors(beam: Beam) -> np.ndarray:
    """(2, n) stress over axial force, 1/A [1/m^2], and over bending moment, c/I [1/m^3], at the nodes of a beam.

    The section knows its outer fibre.
    """
    places, section = np.array(beam.places), beam.section
    fibre = np.asarray(section.outer_fibre_at(places)) / np.asarray(section.second_moment_at(places))
    return np.stack([1.0 / np.asarray(section.area_at(places)), fibre])


def beam_stress_signal(part: str, beams: Sequence[Beam], nodes: Mapping[str, Node]) -> SignalContribution:
    """The signals `von_mises` and `von_mises_node` of a body of beams, whose sections know their outer fibres."""
    place = {name: 3.0 * k for k, name in enumerate(nodes)}
    coordinates = tuple(c for name in nodes for c in node_coordinates(part, name))
    rows = [row for beam in beams for row in _rows(beam, dict(nodes), place)]
    count, p = float(len(rows)), tuple(x for row in rows for x in row)
    return SignalContribution(
        part, "von_mises", "Pa", beam_stress_kernel, coordinates, (count, *p), place="von_mises_node"
    )


def _rows(beam: Beam, nodes: dict[str, Node], place: Mapping[str, float]) -> Iterator[tuple[float, ...]]:
    """Parameters of each element of a beam."""
    factors = section_factors(beam).T.tolist()
    parameters = beam_parameters(beam, nodes, 0.0, (0.0, 0.0))
    for ends, (first, last), own in zip(pairwise(beam.nodes), pairwise(factors), parameters, strict=True):
        yield (*(place[name] for name in ends), *(float(number_of(name)) for name in ends), *first, *last, *own)
