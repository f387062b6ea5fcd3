"""Beams that are evaluated four at a time: kernels beside those of one beam, and which beams of a model they take."""

from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.elastic.beams import corotational as beam
from flexmb.model.contributions import ElementContribution
from flexmb.program.compiler import compile
from flexmb.program.program import FOUR_FORCES

LANES, SIZE = 4, 6
WEIGHTS = 1.3, 0.7, 0.4
NOTHING = np.zeros(0)


@pytest.fixture(scope="module")
def beams():
    """Numbers (4, PARAMETERS) of four unlike beams, and q, v, a, y (4, 6) of each."""
    random = np.random.default_rng(7)
    p = random.uniform(0.5, 1.5, (LANES, beam.PARAMETERS))
    q = random.normal(size=(LANES, SIZE))
    q[:, 3:5] += [[2.0, 0.1], [-1.5, 2.0], [0.1, -2.0], [-0.2, -3.0]]  # chords in all four quadrants
    q[1, [2, 5]] += 40.0  # many turns ago
    q[3, 2] -= 2.0e4
    return p, q, *random.normal(size=(3, LANES, SIZE))


def side_by_side(x):
    """Entries of four beams as kernels for four read them."""
    return np.ascontiguousarray(x.T).ravel()


def apart(x):
    """Entries (4, n) of four beams."""
    return x.reshape(-1, LANES).T


def test_forces_and_matrices_are_those_of_single_beams(beams):
    p, q, v, a, _ = beams
    r, A = np.zeros(LANES * SIZE), np.zeros((SIZE * SIZE, LANES))
    alone, given = np.zeros(LANES * SIZE), [side_by_side(x) for x in (q, v, a)]
    beam.four_tangents.dispatcher(p.ravel(), 0.0, 0.0, *given, NOTHING, *WEIGHTS, r, A, NOTHING)
    beam.four_forces.dispatcher(p.ravel(), 0.0, 0.0, *given, NOTHING, alone, NOTHING)
    for k in range(LANES):
        own, matrix = np.zeros(SIZE), np.zeros((SIZE, SIZE))
        beam.beam_tangent.dispatcher(p[k], 0.0, 0.0, q[k], v[k], a[k], NOTHING, *WEIGHTS, own, matrix, NOTHING)
        size = np.abs(matrix).max() * np.abs(q[k]).max()
        np.testing.assert_allclose(apart(r)[k], own, atol=1e-15 * size)
        np.testing.assert_allclose(apart(alone)[k], own, atol=1e-15 * size)
        np.testing.assert_allclose(A[:, k].reshape(SIZE, SIZE).T, matrix, atol=1e-14 * np.abs(matrix).max())


def test_energies_and_momenta_are_those_of_single_beams(beams):
    p, q, v, a, y = beams
    r, Mv, My = np.zeros((3, LANES * SIZE))
    given = [side_by_side(x) for x in (q, v, a, y)]
    powers = beam.four_accounts.dispatcher(p.ravel(), 0.0, 0.0, *given, NOTHING, r, Mv, My, NOTHING)
    mixed = beam.four_dampings.dispatcher(p.ravel(), 0.0, given[0], given[1], given[3])
    expected, lost = np.zeros(3), np.zeros(2)
    for k in range(LANES):
        own = np.zeros((3, SIZE))
        expected += beam.beam_account.dispatcher(p[k], 0.0, 0.0, q[k], v[k], a[k], y[k], NOTHING, *own, NOTHING)
        lost += beam.beam_damping.dispatcher(p[k], 0.0, q[k], v[k], y[k])
        for found, wanted in zip((r, Mv, My), own, strict=True):
            np.testing.assert_allclose(apart(found)[k], wanted, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(powers, expected, rtol=1e-11)
    np.testing.assert_allclose(mixed, lost, rtol=1e-11)


def arm(elements):
    """Two flexible links in a row under gravity, with damping, from the horizontal."""
    options = {"elements": elements, "damping": 1e-4, "section": fm.Rectangle(0.02, 0.01), "material": fm.STEEL}
    first = fm.FlexibleLink("A", (0.0, 0.0), (0.4, 0.0), **options)
    second = fm.FlexibleLink("B", (0.4, 0.0), (0.8, 0.0), **options)
    pins = fm.Revolute("J1", fm.GROUND, first, (0.0, 0.0)), fm.Revolute("J2", first, second, (0.4, 0.0))
    return fm.Mechanism("arm", (first, second, *pins), gravity=(0.0, -9.81))


@pytest.mark.parametrize(("elements", "fours"), [(1, 0), (2, 1), (3, 1), (7, 3), (8, 4)])
def test_four_beams_that_follow_each_other_are_evaluated_at_once(elements, fours):
    table = compile(arm(elements)).tables.elements.fours
    assert (table[:, FOUR_FORCES] >= 0).sum() == fours


def test_a_motion_is_that_of_beams_one_by_one(monkeypatch):
    together = fm.simulate(arm(7), t_end=0.1, step=1e-4)
    plain = ElementContribution.__post_init__

    def alone(self):
        plain(self)
        object.__setattr__(self, "fours", ())

    monkeypatch.setattr(ElementContribution, "__post_init__", alone)
    single = fm.simulate(replace(arm(7), name="one by one"), t_end=0.1, step=1e-4)
    assert together.ok
    assert single.ok
    for name in ("B.y", "energy.strain", "energy.kinetic", "energy.dissipated_damping"):
        own, other = together.array(name), single.array(name)
        np.testing.assert_allclose(own, other, atol=1e-7 * np.abs(other).max())
