"""A rod bent to an arc spins about its end; an observer who flies past at constant speed sees the same forces."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation

BEND, SPIN, FLIGHT = 0.4, 10.0, 1000.0  # [rad], [rad/s], [m/s]


@pytest.mark.parametrize("elements", [1, 2, 8])
def test_the_observers_speed_does_not_matter(elements):
    soft = fm.Material(young=2e9, density=7850.0)
    section = fm.Rectangle(width=0.02, height=0.02)
    rod = fm.FlexibleLink("rod", (0.0, 0.0), (1.0, 0.0), section=section, material=soft, elements=elements)
    system = StateEvaluation(fm.compile(fm.Mechanism("flight", [rod])))
    angle = BEND * np.linspace(0.0, 1.0, elements + 1)
    q = np.stack([np.sin(angle) / BEND, (1.0 - np.cos(angle)) / BEND, angle], axis=1)
    spinning = np.stack([-SPIN * q[:, 1], SPIN * q[:, 0], SPIN + 0.0 * angle], axis=1)
    flying = spinning + np.array([FLIGHT, 0.0, 0.0])
    forces = [system.at(q.ravel(), v.ravel()).force for v in (spinning, flying)]
    assert np.abs(forces[1] - forces[0]).max() < 1e-9 * np.abs(forces[0]).max()
