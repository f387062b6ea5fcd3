"""Masses, pins, guides and journals, which the loops know without their kernels: their numbers, bit for bit."""

import math
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.system.evaluate import evaluate_accepted
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.mechanisms import nine_bar, slider_crank
from flexmb.places import JOURNAL
from flexmb.program.compiler import compile as compile_mechanism

MECHANISMS = {
    "nine-bar": lambda: nine_bar(2.0 * math.pi, clearance=5e-4),
    "flexible nine-bar": lambda: nine_bar(2.0 * math.pi, clearance=5e-4, flexible=True),
    "slider-crank": lambda: slider_crank(clearance=2e-4, friction="coulomb"),
}
OF_EVALUATION = ("r", "Gl", "g", "gv", "gamma", "G", "lu")


def evaluations(program, seed):
    """All numbers of an evaluation with its matrix, and of one with energies, at a random state."""
    rng, n, rest = np.random.default_rng(seed), program.n_q, np.zeros(3)
    q = np.append(program.reference.q + 0.3 * program.sizes * rng.uniform(-1.0, 1.0, n), rest)
    v, a, x, y = (np.append(rng.normal(size=n), rest) for _ in range(4))
    lam, z = 10.0 * rng.normal(size=program.n_c), np.array(program.reference.z)
    work = StateEvaluation(program).at(q, v, a, lam, t=0.1, weights=(1.0, 300.0, 1e5)).work
    found = {name: getattr(work, name).copy() for name in (*OF_EVALUATION, "contact")}
    evaluate_accepted(program.tables, program.addresses, 0.1, 1e-5, q, v, a, lam, z, x, y, work)
    power = work.power
    energies = [power.kinetic, power.strain, power.gravity, power.damping, power.algorithm]
    return found | {"momentum": work.momentum.copy(), "residual": work.r.copy(), "energies": np.array(energies)}


@pytest.mark.parametrize("name", MECHANISMS)
def test_known_parts_give_the_numbers_of_their_kernels(name):
    program = compile_mechanism(MECHANISMS[name]())
    tables, E, C, K = program.tables, program.tables.elements, program.tables.constraints, program.tables.contacts
    assert E.mass.sum() >= 3
    assert np.bincount(C.known, minlength=4)[1:].min() >= 1  # pins, angles, guides
    assert K.known.tolist() == [JOURNAL]
    unknown = {"elements": E.replaced(mass=0 * E.mass), "constraints": C.replaced(known=0 * C.known)}
    unknown |= {"contacts": K.replaced(known=0 * K.known)}
    own, by_kernels = (evaluations(one, 5) for one in (program, replace(program, tables=tables.replaced(**unknown))))
    for key, values in own.items():
        np.testing.assert_array_equal(values, by_kernels[key], err_msg=key)


class LongPin(fm.Revolute):
    """A joint whose p are no points that coincide."""

    def contributions(self, mechanism):
        first, *rest = super().contributions(mechanism)
        return [replace(first, p=(*first.p[:3], first.p[3] + 0.1), kernel=long_kernel), *rest]


@fm.kernels.constraint_kernel
def long_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    s1x, s1y, s2x, s2y = p
    s2y -= 0.1
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ax, ay, bx, by = c1 * s1x - d1 * s1y, d1 * s1x + c1 * s1y, c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    g[0], g[1] = q[3] + bx - q[0] - ax, q[4] + by - q[1] - ay
    G[0, 0], G[0, 2], G[0, 3], G[0, 5] = -1.0, ay, 1.0, -by
    G[1, 1], G[1, 2], G[1, 4], G[1, 5] = -1.0, -ax, 1.0, bx
    gamma[0], gamma[1] = bx * v[5] ** 2 - ax * v[2] ** 2, by * v[5] ** 2 - ay * v[2] ** 2
    H[2, 2], H[5, 5] = lam[0] * ax + lam[1] * ay, -lam[0] * bx - lam[1] * by


class HeavyLink(fm.RigidLink):
    """A link whose kernel has half of the mass that its numbers say."""

    def contributions(self, mechanism):
        first, *rest = super().contributions(mechanism)
        return [replace(first, p=(2.0 * first.p[0], *first.p[1:]), kernel=half_kernel), *rest]


@fm.kernels.element_kernel
def half_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    m, J, gx, gy = p
    r[0], r[1], r[2] = 0.5 * m * (a[0] - gx), 0.5 * m * (a[1] - gy), J * a[2]
    M[0, 0], M[1, 1], M[2, 2] = 0.5 * m, 0.5 * m, J


def inherited():
    """Two links: a pin and a mass of a user inherit from those of flexmb, with kernels of their own."""
    arm = fm.RigidLink("arm", (0.0, 0.0), (0.1, 0.0), mass=0.2, inertia=1e-4)
    fore = HeavyLink("fore", (0.1, 0.0), (0.4, 0.1), mass=0.3, inertia=2e-3)
    pins = fm.Revolute("A", fm.GROUND, arm, (0.0, 0.0)), LongPin("B", arm, fore, (0.1, 0.0))
    return fm.Mechanism("two", (arm, fore, *pins))


def test_kernels_of_users_are_called_whatever_their_parts_inherit():
    tables = compile_mechanism(inherited()).tables
    assert tables.constraints.known.tolist() == [1, 0]
    assert tables.elements.mass.tolist() == [1, 0]
    fm.testing.check_part(inherited(), "B")


def test_a_pin_with_friction_keeps_its_kernel():
    arm = fm.RigidLink("arm", (0.0, 0.0), (0.1, 0.0), mass=0.2, inertia=1e-4)
    rubs = fm.Revolute("A", fm.GROUND, arm, (0.0, 0.0), friction=fm.ModifiedCoulomb(0.2, v0=0.0, v1=1e-3), radius=0.01)
    tables = compile_mechanism(fm.Mechanism("one", (arm, rubs))).tables
    assert tables.constraints.known.tolist() == [0]
    assert tables.elements.mass.tolist() == [1]
