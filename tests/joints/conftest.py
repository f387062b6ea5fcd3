"""What the tests of joints share."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation


class Posed:
    """Forces of a mechanism whose bodies are put somewhere by hand, at rest unless velocities are given."""

    def __init__(self, mechanism):
        self.program = fm.compile(mechanism)
        self.system = StateEvaluation(self.program)
        self.names = self.program.names.coordinates

    def force(self, positions, velocities=None):
        """(fx, fy, moment) that each body feels, by name; bodies are moved by (dx, dy, dtheta) from the drawing."""
        q, v = np.array(self.program.reference.q), np.zeros(self.program.n_q)
        for target, given in ((q, positions), (v, velocities or {})):
            for body, triple in given.items():
                for axis, value in zip(("x", "y", "theta"), triple, strict=True):
                    target[self.names.index(f"{body}.{axis}")] += value
        r = -self.system.at(q, v).force
        return {name[:-2]: r[k : k + 3] for k, name in enumerate(self.names) if name.endswith(".x")}


@pytest.fixture
def posed():
    """`Posed`, the class."""
    return Posed
