"""Pins of plane bodies: rigid motions, forces that pins hand on, means, bad input."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from flexmb.elastic.meshes.mesh import PlaneMesh
from flexmb.elastic.meshes.outlines import link_with_eyes, rectangle, ring
from flexmb.elastic.planes.cells import matrices
from flexmb.elastic.planes.pins import Interface, tie
from flexmb.errors import InputError
from flexmb.model.law import Material

STEEL = Material(young=2.1e11, density=7850.0, poisson=0.3)
KINDS = ("rigid", "averaged")


def pinned(kinds=("rigid", "rigid"), size=0.005, shape="quad9"):
    mesh = link_with_eyes(0.12, 0.02, 0.01, 0.02, size, shape)
    pins = zip(("start", "end"), kinds, strict=True)
    return mesh, tie([Interface(name, mesh.sets[name], mesh.centre_of(name), kind) for name, kind in pins], mesh)


@pytest.mark.parametrize("shape", ["quad9", "tri6", "quad4", "tri3"])
@pytest.mark.parametrize("kinds", [(a, b) for a in KINDS for b in KINDS])
def test_rigid_motions_of_pins_and_free_nodes_are_those_of_the_body(kinds, shape):
    mesh, tied = pinned(kinds, shape=shape)
    x, y = mesh.points.T
    for motion, pins in (
        (np.stack([1 + 0 * x, 0 * x], 1), [1, 0, 0, 1, 0, 0]),
        (np.stack([-y, x], 1), [0, 0, 1, 0, 0.12, 1]),
    ):
        u = motion.ravel()
        np.testing.assert_allclose(tied.matrix @ np.concatenate([pins, u[tied.free]]), u, atol=1e-14)
        np.testing.assert_allclose(
            tied.averages @ u, np.array(pins)[np.repeat(np.array(kinds) == "averaged", 3)], atol=1e-12
        )


def test_an_averaged_pin_is_the_mean_of_any_displacements():
    _, tied = pinned(("averaged", "rigid"))
    free = np.random.default_rng(3).standard_normal(tied.matrix.shape[1])
    np.testing.assert_allclose(tied.averages @ (tied.matrix @ free), free[:3], atol=1e-12)


def test_the_mean_rotation_of_a_round_hole_is_the_weighted_formula():
    """theta = sum w (r x u) / sum w r^2, u = sum w u, for weights with their centre at the pin."""
    mesh = ring(0.01, 0.02, 0.003)
    nodes = mesh.sets["inner"]
    tied = tie([Interface("start", nodes, (0.0, 0.0), "averaged")], mesh)
    u = np.random.default_rng(5).standard_normal((len(mesh.points), 2))
    w = Interface("start", nodes, (0.0, 0.0)).weights(mesh)
    r = mesh.points[nodes]
    assert w.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(w @ r, 0.0, atol=1e-15)
    turn = w @ (r[:, 0] * u[nodes, 1] - r[:, 1] * u[nodes, 0]) / (w @ (r**2).sum(axis=1))
    np.testing.assert_allclose((tied.averages @ u.ravel())[:3], [*(w @ u[nodes]), turn], atol=1e-12)


def test_weights_of_a_fine_side_do_not_pull_the_mean():
    """Nodes twice as dense on one half of a hole: the mean place is still the centre."""
    angle = np.concatenate([np.linspace(0, np.pi, 33)[:-1], np.linspace(np.pi, 2 * np.pi, 17)[:-1]])
    inner, outer = (r * np.stack([np.cos(angle), np.sin(angle)], 1) for r in (0.01, 0.03))
    n, k = len(angle), np.arange(len(angle))
    cells = np.stack([k, n + k, n + (k + 1) % n, (k + 1) % n], axis=1)
    mesh = PlaneMesh(np.concatenate([inner, outer]), cells, "quad4", {"hole": k})
    w = Interface("hole", k, (0.0, 0.0)).weights(mesh)
    assert np.linalg.norm(w @ inner) < 1e-4
    assert np.linalg.norm(inner.mean(axis=0)) > 1.9e-3
    assert mesh.centre_of("hole") == pytest.approx((0.0, 0.0), abs=1e-15)


@pytest.mark.quick(1)
@pytest.mark.parametrize("kind", KINDS)
def test_compliance_of_a_pin(kind):
    """Of a rigid pin as published for a mesh of this size; an averaged one is softer; the clamp bears the load."""
    mesh, tied = pinned((kind, kind), 0.0025)
    K = (tied.matrix.T @ matrices(mesh, STEEL, 0.01).stiffness @ tied.matrix).tocsc()
    load = np.zeros((K.shape[0], 3))
    load[3:6] = np.eye(3)
    u = np.zeros_like(load)
    u[3:] = spsolve(K[3:, 3:], load[3:])
    compliance = u[3:6]
    np.testing.assert_allclose(compliance, compliance.T, rtol=1e-6, atol=1e-14)
    reaction = (K @ u)[:3]
    np.testing.assert_allclose(reaction, [[-1, 0, 0], [0, -1, 0], [0, -0.12, -1]], atol=1e-7)
    published = np.array([2.39797e-9, 3.16543e-7, 7.02645e-5, 4.21580e-6])
    own = np.array([*np.diag(compliance), compliance[1, 2]])
    if kind == "rigid":
        np.testing.assert_allclose(own, published, rtol=1e-4)
    else:
        assert (own > 1.15 * published).all()


def test_tied_stiffness_has_only_rigid_motions_without_force():
    mesh, tied = pinned(("averaged", "rigid"), 0.01)
    K = (tied.matrix.T @ matrices(mesh, STEEL, 0.01).stiffness @ tied.matrix).toarray()
    values = np.linalg.eigvalsh(K / np.sqrt(np.outer(np.diag(K), np.diag(K))))
    assert (np.abs(values[:3]) < 1e-10).all()
    assert values[3] > 1e-6


@pytest.mark.parametrize(
    ("nodes", "point", "words"),
    [
        ([[0]], [(0, 0)], "pin 'p0' has one node, which cannot turn it"),
        ([[0, 1], [1, 2]], [(0, 0), (1, 0)], "node 1 belongs to the pins 'p0' and 'p1'"),
    ],
)
def test_pins_without_stiffness_are_refused(nodes, point, words):
    mesh = rectangle(1.0, 1.0, 2, 2)
    pins = [Interface(f"p{i}", np.array(n), p) for i, (n, p) in enumerate(zip(nodes, point, strict=True))]
    with pytest.raises(InputError, match=words):
        tie(pins, mesh)
