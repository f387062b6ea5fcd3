"""Large models: beams assembled together, work that grows as the model does, the same numbers as one by one."""

import gc
import pickle
import sys
import time
from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse as sp
from element_matrices import beam_matrices

import flexmb as fm
from flexmb.elastic.beams import corotational, fem
from flexmb.elastic.beams.fem import BeamData, assembled
from flexmb.engine.linalg.rank import surplus_rows
from flexmb.engine.system import state_evaluation
from flexmb.errors import AssemblyError
from flexmb.parts.bodies import flexible
from flexmb.program.compiler import compile_with_start
from flexmb.statics.start.consistent import consistent_start, least_energy, least_shift

STEEL = fm.Material(young=2.1e11, density=7800.0)
ALUMINIUM = fm.Material(young=7e10, density=2700.0)
SECTIONS = (
    fm.Rectangle(width=0.01, height=0.02),
    fm.Tapered(fm.Circle(diameter=0.03), fm.Circle(diameter=0.02)),
    fm.Tube(outer=0.03, inner=0.02),
)
FIELDS = "lengths axial_stiffness axial_mass bending_stiffness bending_mass rotary_mass ea ei inertia_integrals".split()
FIELDS += ["shear_shares", "bow"]


def chain(links, *, elements=4, length=0.1):
    """Hinged links of equal beams, straight along +x, hanging on the ground."""
    parts, last = [], fm.GROUND
    for k in range(links):
        ends = (length * k, 0.0), (length * (k + 1), 0.0)
        link = fm.FlexibleLink(f"L{k}", *ends, section=SECTIONS[0], material=STEEL, elements=elements)
        parts += [link, fm.Revolute(f"J{k}", last, link, ends[0])]
        last = link
    return fm.Mechanism("chain", tuple(parts), gravity=(0.0, -9.81))


def some_beams():
    """Beams of all kinds and sizes."""
    rng = np.random.default_rng(3)
    for k in range(40):
        stations = np.cumsum([0.3 * (k % 2), *rng.uniform(0.01, 0.3, 1 + k % 5)])
        yield BeamData(
            stations,
            SECTIONS[k % 3],
            (STEEL, ALUMINIUM)[k % 2],
            (False, True, 0.01)[k % 3],
            (False, True, 0.8)[k // 3 % 3],
        )


def test_beams_assembled_together_are_those_assembled_one_by_one():
    beams = list(some_beams())
    for beam, found in zip(beams, assembled(beams), strict=True):
        options = {"rotary_inertia": beam.rotary_inertia, "shear": beam.shear}
        alone = beam_matrices(beam.stations, beam.section, beam.material, **options)
        for name in FIELDS:
            assert np.array_equal(getattr(found, name), getattr(alone, name)), name
        assert found.parameters == alone.parameters


def test_the_numbers_of_a_chain_are_those_of_each_element_by_scikit_fem():
    contributions = [e for e in chain(7).contributions().elements if e.kernel is corotational.beam_kernel]
    alone = [beam_matrices(link.beams[0].stations, SECTIONS[0], STEEL) for link in chain(7).bodies]
    assert len(contributions) == 28
    for k, contribution in enumerate(contributions):
        data, i = alone[k // 4], k % 4
        stiffness = data.axial_stiffness[i, 1, 1], *data.bending_stiffness[i, [1, 1, 3], [1, 3, 3]]
        assert contribution.p[:5] == (data.lengths[i], *stiffness)
        assert contribution.p[10:26] == tuple(data.inertia_integrals[i])
        assert contribution.p[26:] == (2.0, 1.0, 2.0, data.lengths[i], 0.0, 0.0)


def test_equal_links_are_assembled_once_and_all_in_one_mesh(monkeypatch):
    calls = []
    monkeypatch.setattr(flexible, "_KNOWN", {})
    monkeypatch.setattr(fem, "assembled", lambda beams: calls.append(len(beams)) or assembled(beams))
    mechanism = chain(300)
    mechanism.contributions()
    mechanism.shapes()
    assert len(calls) == 1
    assert calls[0] < 30  # lengths that differ by round-off


def test_a_mechanism_is_pickled_without_what_was_worked_out():
    mechanism = chain(5)
    before = len(pickle.dumps(mechanism))
    fm.compile(mechanism)
    assert len(pickle.dumps(mechanism)) == before
    assert pickle.loads(pickle.dumps(mechanism)) == mechanism  # noqa: S301


def test_shapes_are_worked_out_when_they_are_looked_at(monkeypatch):
    monkeypatch.setattr(fm.FlexibleLink, "shapes", lambda *_: pytest.fail("too early"))
    sol = fm.simulate(chain(1), t_end=1e-5, step=1e-5, save=1)
    monkeypatch.undo()
    assert sol.shapes == chain(1).shapes()
    assert pickle.loads(pickle.dumps(sol)).shapes == chain(1).shapes()  # noqa: S301


def calls_of(function):
    """Python functions that are called meanwhile; what other tests left to collect is not counted."""
    count = 0
    gc.collect()
    gc.disable()

    def see(frame, event, argument):
        nonlocal count
        count += event == "call"

    sys.setprofile(see)
    try:
        function()
    finally:
        sys.setprofile(None)
        gc.enable()
    return count


def started(links):
    """A chain from its declaration to its first step."""
    fm.simulate(chain(links), t_end=1.0, step=1e-4, save=1, max_steps=1)


@pytest.mark.slow
def test_work_grows_as_the_chain_does():
    started(60)
    small, large = (calls_of(lambda n=n: started(n)) for n in (100, 400))
    assert large <= 4.2 * small
    assert large / 1600 < 110.0  # calls an element, everything included


@pytest.mark.slow
def test_time_grows_as_the_chain_does():
    """An element of a chain of 4,000 links against one of 500: at most twice the time."""
    started(10)
    took = {}
    for links in (500, 4000, 501, 4001):
        began = time.process_time()
        started(links)
        took[links // 500] = min(took.get(links // 500, np.inf), (time.process_time() - began) / links)
    assert took[8] <= 2.0 * took[1]


def test_the_rank_of_large_matrices_is_that_of_small_ones():
    rng = np.random.default_rng(1)
    blocks = [np.where(rng.random((40, 60)) < 0.2, rng.normal(size=(40, 60)), 0.0) for _ in range(20)]
    assert surplus_rows(sp.block_diag(blocks, format="csr")) == ()
    blocks[3][7], blocks[11][0] = 2.0 * blocks[3][2] - blocks[3][9], blocks[11][5]
    found = surplus_rows(sp.block_diag(blocks, format="csr"))
    alone = [40 * k + row for k in (3, 11) for row in surplus_rows(blocks[k])]
    assert len(found) == len(alone) == 2
    assert {k // 40 for k in found} == {3, 11}


def test_least_movement_by_sparse_factors():
    rng = np.random.default_rng(2)
    A = sp.random(500, 900, 0.01, random_state=5, format="csr") + sp.eye_array(500, 900)
    b = rng.normal(size=500)
    assert least_shift(A.tocsr(), b, np.ones(A.shape[1])) == pytest.approx(np.linalg.lstsq(A.toarray(), b)[0], abs=1e-8)


def test_accelerations_by_kept_factors_are_those_of_small_models(monkeypatch):
    mechanism = chain(600)
    program, closed = compile_with_start(mechanism)
    assert program.symbolic.n > state_evaluation.LARGE_UNKNOWNS
    large = consistent_start(mechanism, program, closed=closed)
    monkeypatch.setattr(state_evaluation, "LARGE_UNKNOWNS", program.symbolic.n)
    small = consistent_start(mechanism, program, closed=closed)
    assert np.abs(large.a - small.a).max() <= 1e-12 * np.abs(small.a).max()
    assert np.abs(large.lam - small.lam).max() <= 1e-12 * np.abs(small.lam).max()


@pytest.mark.slow
def test_a_large_chain_held_twice_names_the_joint():
    mechanism = chain(400)
    again = fm.Revolute("again", fm.GROUND, mechanism.find("L200"), (20.1, 0.0))
    twice = fm.Revolute("twice", fm.GROUND, mechanism.find("L200"), (20.1, 0.0))
    held = mechanism.with_part(again).with_part(twice)
    with pytest.raises(fm.errors.ModelError, match=r"over-constrained by 2 row.*'(again|twice)'"):
        fm.simulate(held, t_end=1e-4, step=1e-4, save=1)


def thrown_chain(links):
    """Rigid links along +x, all with declared velocities; and the rates of their angles."""
    parts, last, end, rates = [], fm.GROUND, 0.0, 0.5 * np.cos(np.arange(links))
    for k, rate in enumerate(rates):
        ends = (0.01 * k, 0.0), (0.01 * (k + 1), 0.0)
        velocity = (0.0, float(end + 0.005 * rate), float(rate))
        link = fm.RigidLink(f"L{k}", *ends, mass=0.01, inertia=1e-7, velocity=velocity)
        parts += [link, fm.Revolute(f"J{k}", last, link, ends[0])]
        last, end = link, end + 0.01 * rate
    return fm.Mechanism("thrown", tuple(parts)), rates


def test_declared_velocities_of_a_large_chain_take_no_time():
    """1,000 links took 14 s by dense matrices."""
    mechanism, rates = thrown_chain(1000)
    program, closed = compile_with_start(mechanism)
    consistent_start(mechanism, program, closed=closed)  # modules are imported
    began = time.process_time()
    found = consistent_start(mechanism, program, closed=closed)
    assert time.process_time() - began < 1.0
    np.testing.assert_allclose(found.v[2::3], rates, atol=1e-12)


def cells(count, thrown, fast=None):
    """Parallel cranks in a row, coupled from each to the next; those in `thrown` turn at 2 rad/s, `fast` at 2.1."""
    parts, heads = [], []
    for k in range(count):
        foot, head = (float(k), 0.0), (k - 0.1, 0.5)
        rate = 2.1 if k == fast else 2.0
        velocity = (-0.25 * rate, -0.05 * rate, rate) if k in thrown else None
        crank = fm.RigidLink(f"C{k}", foot, head, mass=1.0 + k % 3, inertia=0.02, velocity=velocity)
        parts += [crank, fm.Revolute(f"O{k}", fm.GROUND, crank, foot)]
        heads.append((crank, head))
    for k, ((left, start), (right, end)) in enumerate(pairwise(heads)):
        rod = fm.RigidLink(f"R{k}", start, end, mass=0.5, inertia=0.05)
        parts += [rod, fm.Revolute(f"A{k}", left, rod, start), fm.Revolute(f"B{k}", rod, right, end)]
    return fm.Mechanism("cells", tuple(parts))


@pytest.mark.parametrize("thrown", [range(60), [7], [3, 40]], ids=["all", "one", "two"])
def test_declared_velocities_in_many_closed_loops(thrown):
    mechanism = cells(60, thrown)
    program, closed = compile_with_start(mechanism)
    v = consistent_start(mechanism, program, closed=closed).v.reshape(-1, 3)
    np.testing.assert_allclose(v[:60, 2], 2.0, rtol=1e-9)
    np.testing.assert_allclose(v[60:], np.tile([-1.0, -0.2, 0.0], (59, 1)), atol=2e-9)


def test_declared_velocities_that_many_loops_forbid():
    mechanism = cells(60, range(60), fast=20)
    program, closed = compile_with_start(mechanism)
    with pytest.raises(AssemblyError, match=r"no start velocities.*'(O|A|B)(19|20)'.*Correct the declared velocities"):
        consistent_start(mechanism, program, closed=closed)


@pytest.mark.parametrize("contradiction", [0.0, 0.1])
def test_least_energy_with_dependent_rows_by_sparse_factors_is_that_of_eigenvectors(contradiction):
    rng = np.random.default_rng(5)
    rows = rng.normal(size=(12, 30)) * (rng.random((12, 30)) < 0.3)
    A = np.concatenate([rows, rng.normal(size=(25, 12)) @ rows])  # rank 12 of 37 rows
    b = A @ rng.normal(size=30) + contradiction * rng.normal(size=37)
    inertia = np.diag(rng.uniform(0.1, 1.0, 30))
    if contradiction == 0.0:
        inertia[:2, :2] = 0.0  # motions without inertia
    wanted = least_energy(inertia, A, b)
    found = least_energy(sp.csr_matrix(inertia), sp.csr_matrix(A), b)
    np.testing.assert_allclose(found, wanted, atol=1e-10 if contradiction == 0.0 else 1e-7)
