"""The assembled tangent of a contact (gap x normal x friction) against differences of the assembled force."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.program.compiler import compile as compile_mechanism


def mechanism():
    """Two free bodies, the first with a bearing, the second with a journal, both off their centres of mass."""
    first = fm.RigidBody("first", (0.0, 0.0), 1.0, 0.1, theta=0.3)
    second = fm.RigidBody("second", (0.4, 0.1), 1.0, 0.1)
    joint = fm.RevoluteClearance(
        "C",
        first,
        second,
        at=(0.15, 0.2),
        clearance=5e-4,
        bearing_radius=1e-2,
        normal=fm.LankaraniNikravesh(1e8, restitution=0.6),
        friction=fm.ModifiedCoulomb(0.2, v0=1e-3, v1=10.0),
    )
    return fm.Mechanism("pair", [first, second, joint])


@pytest.mark.parametrize("seed", range(5))
def test_contact_tangent_agrees_with_differences(seed):
    rng = np.random.default_rng(seed)
    program = compile_mechanism(mechanism())
    system = StateEvaluation(program)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    q = np.array(program.reference.q)
    q[3:5] += (5e-4 + 4e-5) * np.array([np.cos(angle), np.sin(angle)])  # pressed in by 40 um
    q[[2, 5]] += 1e-4 * rng.standard_normal(2)
    v = rng.standard_normal(6)
    z = np.array(program.reference.z)
    place = program.tables.contacts.z[0, 1]
    z[place : place + 3] = 5.0, -1e-6, -1.0  # in contact since the last state, begun at 5 m/s

    def force(positions, velocities):
        return system.at(positions, velocities, z=z).force

    scale = abs(force(q, v)).max()
    assert scale > 1.0  # it is in contact
    assert abs(force(q, v)[:2] + force(q, v)[3:5]).max() <= 1e-12 * scale  # action = reaction
    for weights, step, shifted in (
        ((1.0, 0.0, 0.0), 1e-9, lambda d: force(q + d, v)),
        ((0.0, 1.0, 0.0), 1e-5, lambda d: force(q, v + d)),
    ):
        exact = system.at(q, v, z=z, weights=weights).block().toarray()
        columns = [(shifted(d) - shifted(-d)) / (2.0 * step) for d in step * np.eye(6)]
        assert abs(np.array(columns).T - exact).max() <= 2e-6 * abs(exact).max()


def test_an_open_contact_exerts_nothing():
    program = compile_mechanism(mechanism())
    system = StateEvaluation(program).at(program.reference.q, np.ones(6), weights=(1.0, 1.0, 0.0))
    assert not system.force.any()
    assert not system.block().toarray().any()
