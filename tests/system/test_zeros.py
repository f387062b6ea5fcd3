"""Entries of the matrix that parts declare as always zero leave its pattern and change no value."""

import math
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.linalg.ordering import elimination_order
from flexmb.engine.linalg.symbolic import symbolic
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import KernelError
from flexmb.mechanisms import nine_bar, slider_crank
from flexmb.model.contributions import ConstraintContribution
from flexmb.parts.joints.revolute import coincidence_kernel
from flexmb.program import structure
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.numbering import Numbering, blocks_and_edges

MECHANISMS = {
    "nine-bar": lambda: nine_bar(2.0 * math.pi, clearance=5e-4),
    "slider-crank": lambda: slider_crank(clearance=2e-4, friction="coulomb"),
}


def states(program, seed):
    """Random coordinates, velocities, accelerations and multipliers near the reference configuration."""
    rng = np.random.default_rng(seed)
    n = program.n_q
    q = program.reference.q + 0.3 * program.sizes * rng.uniform(-1.0, 1.0, n)
    return q, rng.normal(size=n), rng.normal(size=n), 10.0 * rng.normal(size=program.n_c)


@pytest.mark.parametrize("name", MECHANISMS)
def test_matrix_is_that_of_a_full_pattern(name, monkeypatch):
    mechanism = MECHANISMS[name]()
    own = compile_mechanism(mechanism)
    structure._LATEST.clear()
    monkeypatch.setattr(structure, "_zeros", lambda rows, columns, entries: np.zeros(rows * columns, dtype=bool))
    full = compile_mechanism(mechanism)
    structure._LATEST.clear()
    assert own.symbolic.size < 0.8 * full.symbolic.size
    for seed in range(3):
        q, v, a, lam = states(own, seed)
        found, wanted = (
            StateEvaluation(program).at(q, v, a, lam, t=0.1, weights=(1.0, 300.0, 1e5)).dense for program in (own, full)
        )
        assert np.abs(wanted[: own.n_q, : own.n_q]).max() > 0.0
        assert np.array_equal(found, wanted)


def test_joint_friction_fills_the_block_of_its_joint():
    def mechanism(friction):
        crank = fm.RigidLink("crank", (0.0, 0.0), (0.1, 0.0), mass=0.2, inertia=1e-4)
        rod = fm.RigidLink("rod", (0.1, 0.0), (0.4, 0.0), mass=0.3, inertia=2e-3)
        pins = fm.Revolute("A", fm.GROUND, crank, (0.0, 0.0)), fm.Revolute("B", crank, rod, (0.1, 0.0), **friction)
        return fm.Mechanism("double pendulum", (crank, rod, *pins), gravity=(0.0, -9.81))

    rubbing = {"friction": fm.ModifiedCoulomb(0.2, v0=0.0, v1=1e-3), "radius": 0.01}
    smooth, rough = (compile_mechanism(mechanism(own)).symbolic for own in ({}, rubbing))
    assert len(rough.a_rows) > len(smooth.a_rows)


class Liar(fm.Revolute):
    """A pin that declares fewer columns of G than it has."""

    def contributions(self, mechanism):
        first, *rest = super().contributions(mechanism)
        assert isinstance(first, ConstraintContribution)
        assert first.kernel is coincidence_kernel
        return [replace(first, columns=((0, 3, 5), (1, 2, 4, 5))), *rest]


def test_check_part_refuses_a_wrong_declaration():
    arm = fm.RigidLink("arm", (0.0, 0.0), (0.1, 0.0), mass=0.2, inertia=1e-4)
    fore = fm.RigidLink("fore", (0.1, 0.0), (0.4, 0.1), mass=0.3, inertia=2e-3)
    pins = fm.Revolute("A", fm.GROUND, arm, (0.0, 0.0)), Liar("B", arm, fore, (0.1, 0.0))
    with pytest.raises(KernelError, match=r"'B'.*G\[0, 2\] is .*always 0"):
        fm.testing.check_part(fm.Mechanism("two", (arm, fore, *pins)), "B")


def test_a_chain_of_rigid_links_has_half_of_the_values():
    parts, last = [], fm.GROUND
    for k in range(10):
        link = fm.RigidLink(f"L{k}", (float(k), 0.0), (k + 1.0, 0.0), mass=1.0, inertia=0.1)
        parts += [link, fm.Revolute(f"J{k}", last, link, (float(k), 0.0))]
        last = link
    mechanism = fm.Mechanism("chain", tuple(parts))
    own, number = compile_mechanism(mechanism).symbolic, Numbering(mechanism, controls=True)
    blocks, edges, last_ones = blocks_and_edges(mechanism.contributions(), number)
    full = [(i, j) for edge in edges for a in edge for b in edge for i in blocks[a] for j in blocks[b]]
    full = [pair for pair in full if max(pair) < 30 or min(pair) < 30]  # multipliers are not coupled
    whole = symbolic(own.n, *map(np.array, zip(*full, strict=True)), elimination_order(blocks, edges, last_ones))
    assert own.size < 0.5 * whole.size
