"""Deformed shape and section forces of one element, against closed forms of beam theory."""

from dataclasses import replace

import numpy as np
import pytest
from skfem import CellBasis, ElementLineHermite, MeshLine

from flexmb.elastic.beams import fem as hermite
from flexmb.elastic.beams.corotational import (
    AXIAL,
    B11,
    B12,
    B22,
    BOW11,
    BOW12,
    BOW22,
    FREE1,
    FREE2,
    FREE_LENGTH,
    LENGTH,
    OFFSET1,
    OFFSET2,
    PARAMETERS,
    beam_kernel,
)
from flexmb.model.shape import BeamShape

L, EA, EI = 0.8, 3.0e5, 2.5
BEAM = BeamShape("rod", "a", "b", L, 0.0, 0.0, EA / L, (4.0 * EI / L, 2.0 * EI / L, 4.0 * EI / L), (EI, EI))
XI = np.linspace(0.0, 1.0, 11)


def placed(pose, angle, turns=0):
    """A pose turned about the origin by `angle` and whole `turns`."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * pose[0] - s * pose[1], s * pose[0] + c * pose[1], pose[2] + angle + 2.0 * np.pi * turns])


@pytest.mark.parametrize("angle", [0.0, 1.0, 3.1, -2.0])
@pytest.mark.parametrize("turns", [0, 7])
def test_cantilever_with_a_force_at_its_tip(angle, turns):
    P = 1e-6  # so small that the theory of small deflections holds to 1e-9
    poses = [np.zeros(3), np.array([L, P * L**3 / (3.0 * EI), P * L**2 / (2.0 * EI)])]
    ends = [placed(p, angle, turns) for p in poses]
    x = XI * L
    w = P * x**2 * (3.0 * L - x) / (6.0 * EI)
    points = hermite.element_shape(*ends, BEAM, XI)[0]
    normal = np.array([-np.sin(angle), np.cos(angle)])
    np.testing.assert_allclose(points @ normal, w, atol=1e-14)
    np.testing.assert_allclose(hermite.curvature(*ends, BEAM, XI)[0], P * (L - x) / EI, atol=1e-13)
    forces = hermite.section_forces(*ends, BEAM, XI)
    np.testing.assert_allclose(forces.M[0], P * (L - x), atol=1e-13)
    np.testing.assert_allclose(forces.V[0], P, rtol=1e-6)


def test_stretched_bar():
    forces = hermite.section_forces(np.zeros(3), np.array([1.001 * L, 0.0, 0.0]), BEAM, XI)
    np.testing.assert_allclose(forces.N, 0.001 * EA, rtol=1e-12)
    np.testing.assert_allclose(forces.M, 0.0, atol=1e-12)


def test_offsets_of_the_nodes_make_no_deformation():
    bent = BeamShape("frame", "a", "b", L, 0.7, -0.4, EA / L, BEAM.bending, (EI, EI))
    ends = np.array([0.0, 0.0, 0.3 - 0.7]), np.array([L * np.cos(0.3), L * np.sin(0.3), 0.3 + 0.4])
    forces = hermite.section_forces(*ends, bent, XI)
    for field in forces:
        np.testing.assert_allclose(field, 0.0, atol=1e-9)


def test_ends_are_the_nodes_to_the_last_bit():
    rng = np.random.default_rng(1)
    start, end = rng.normal(size=(50, 3)), rng.normal(size=(50, 3)) + 5.0
    for beam in (BEAM, BeamShape("rod", "a", "b", 1.0 / 3.0, 0.1, 0.2, 1.0, (4.0, 2.0, 4.0), (1.0, 1.0))):
        points = hermite.element_shape(start, end, beam, np.array([0.0, 1.0]))
        np.testing.assert_array_equal(points[:, 0], start[:, :2])
        np.testing.assert_array_equal(points[:, 1], end[:, :2])


def test_the_shape_is_that_of_an_element_of_scikit_fem():
    u1, u2 = 0.03, -0.05
    basis = CellBasis(MeshLine(np.array([[0.0, L]])), ElementLineHermite())
    w = basis.probes(XI[None] * L) @ np.array([0.0, u1, 0.0, u2])
    points = hermite.element_shape(np.array([0.0, 0.0, u1]), np.array([L, 0.0, u2]), BEAM, XI)[0]
    np.testing.assert_allclose(points, np.stack([XI * L, w], axis=-1), atol=1e-15)


TAPERED = BeamShape("rod", "a", "b", L, 0.2, -0.1, 4e3, (13.0, 5.0, 9.0), (2.0, 1.0))
SHEARED_ARC = replace(TAPERED, shear=(0.2, 0.15), bow=(1.2, 2.3, 1.5), unstressed=(1.01 * L, -0.1, 0.12))


@pytest.mark.parametrize("tapered", [TAPERED, SHEARED_ARC])
def test_end_forces_balance_what_the_kernel_exerts_on_the_nodes(tapered):
    p = np.zeros(PARAMETERS)
    p[[LENGTH, AXIAL, B11, B12, B22, OFFSET1, OFFSET2]] = L, 4e3, 13.0, 5.0, 9.0, 0.2, -0.1
    p[[BOW11, BOW12, BOW22, FREE_LENGTH, FREE1, FREE2]] = *tapered.bow, *tapered.free
    q = np.array([0.1, 0.2, 0.9, 0.5, 0.95, 1.35])
    r, zero, none = np.zeros(6), np.zeros(6), np.zeros(0)
    beam_kernel(p, 0.0, 0.0, q, zero, zero, none, r, *np.zeros((3, 6, 6)), none)
    forces = hermite.section_forces(q[:3], q[3:], tapered, np.array([0.0, 1.0]))
    along = (q[3:5] - q[:2]) / np.hypot(*(q[3:5] - q[:2]))
    normal = np.array([-along[1], along[0]])
    # r is what holds the element in this pose: at its end the section force itself, at its start the opposite
    np.testing.assert_allclose(r[3:5], forces.N[0, 1] * along + forces.V[0, 1] * normal, rtol=1e-12)
    np.testing.assert_allclose(r[:2], -forces.N[0, 0] * along - forces.V[0, 0] * normal, rtol=1e-12)
    np.testing.assert_allclose([r[2], r[5]], [-forces.M[0, 0], forces.M[0, 1]], rtol=1e-12)


def test_bending_stiffness_between_the_ends():
    tapered = BeamShape("rod", "a", "b", L, 0.0, 0.0, 1.0, (4.0, 2.0, 4.0), (3.0, 1.0))
    np.testing.assert_allclose(hermite.bending_stiffness(tapered, np.array([0.0, 0.25, 1.0])), [3.0, 2.5, 1.0])
