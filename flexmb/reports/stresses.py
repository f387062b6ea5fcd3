"""Stresses of flexible parts at chosen instants."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.flexible import beam_elements
from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.model.shape import BeamShape
from flexmb.results.drawing import pose
from flexmb.results.solution import Solution


def stresses(sol: Solution, mechanism: Mechanism | None, instants: np.ndarray) -> np.ndarray | None:
    """Largest stress (n, m) of the outer fibres of each beam element, axial and bending stress added, >= 0 [Pa].

    None where the mechanism is unknown, or a section does not know its outer fibre.  The stress is Young's modulus
    times the strain of `flexmb.beams.stress`, without damping; elements stand in the order of the shapes, instants by
    the numbers (n,) of saved ones.
    """
    shapes = [shape for shape in sol.shapes if isinstance(shape, BeamShape)]
    found: dict[tuple[str, str, str], np.ndarray] = {}
    for body in mechanism.bodies if mechanism is not None and shapes else ():
        if isinstance(body, FlexibleBody):
            own = _of_body(sol, body, instants)
            if own is None:
                return None
            found |= own
    columns = [found.get((shape.part, shape.start, shape.end)) for shape in shapes]
    known = [column for column in columns if column is not None]
    return np.stack(known, axis=1) if known and len(known) == len(columns) else None


def _of_body(sol: Solution, body: FlexibleBody, instants: np.ndarray) -> dict[tuple[str, str, str], np.ndarray] | None:
    """Stresses (n,) of the elements of a body by part and nodes [Pa]; None for a section without an outer fibre."""
    nodes, found = {node.name: node for node in body.nodes()}, {}
    for beam in body.beams:
        try:
            beam.section.outer_fibre_at(0.0)
        except InputError:
            return None
        poses = np.stack([pose(sol, body.name, node, instants) for node in beam.nodes], axis=1)
        strains = beam_elements(beam, nodes).strains(*poses.transpose(2, 0, 1))
        for k, column in enumerate(strains.T):
            found[body.name, beam.nodes[k], beam.nodes[k + 1]] = beam.material.young * column
    return found
