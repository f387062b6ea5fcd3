"""Plane bodies with all nodes of their meshes: vibrations, momenta, energy, large deflection, pins, stress."""

import math
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.elastic.planes import plane_body as full_body
from flexmb.elastic.planes.stress import stress_operator, von_mises
from flexmb.model.shape import MeshShape, from_json, to_json
from flexmb.results import drawing
from flexmb.results.positions import momentum

STEEL = fm.Material(young=207e9, density=7850.0, poisson=0.3)
LENGTH, SIDE = 0.12, 0.02
ENDS = {"start": (0.0, 0.0), "end": (LENGTH, 0.0)}


def link(**changes):
    """A steel link with two eyes, from (0, 0) along x."""
    mesh = fm.meshes.link_with_eyes(length=LENGTH, eye=0.015, hole=0.008, width=0.014, size=0.006)
    return fm.PlaneBody("rod", mesh, **{**ENDS, "thickness": 0.01, "material": STEEL, **changes})


def bar(name="bar", kind="quad9", cells=(12, 2), young=2e9, **changes):
    """A soft bar with its ends as pins, whose mesh has the middle of its left side at the origin."""
    mesh = changes.pop("mesh", None) or fm.meshes.rectangle(LENGTH, SIDE, *cells, kind)
    soft = fm.Material(young=young, density=2000.0, poisson=0.3)
    values = {"at": (0.0, 0.0), "thickness": 0.01, "material": soft, "pins": ("left", "right")}
    return fm.PlaneBody(name, mesh, **{**values, **changes})


def pin(body, name):
    """Place of a pin."""
    node = body.node(name)
    return node.x, node.y


def hung(body, **changes):
    """The body as a pendulum on its first pin."""
    joint = fm.Revolute("O", fm.GROUND, body, at=pin(body, body.main))
    return fm.Mechanism("pendulum", [body, joint], gravity=(0.0, -9.81), **changes)


@pytest.mark.slow
@pytest.mark.parametrize("interface", [pytest.param("rigid", marks=pytest.mark.slow), "averaged"])
def test_frequencies_of_the_mechanism_are_those_of_the_matrices(interface):
    """Modes of the compiled cells and pins beside the eigenvalues of scikit-fem's matrices, free and clamped.

    An averaged pin has 1e-7 of the mass of the body, which its nodes lack where they deform the hole.
    """
    body = link(interface=interface)
    free = fm.modes(fm.Mechanism("free", [body]), count=8)
    assert free.rigid == 3
    assert [kind.partition(":")[0] for kind in free.kinds] == ["rigid"] * 3 + ["elastic"] * 5
    assert free.frequencies[3:] == pytest.approx(body.frequencies(5), rel=1e-7)
    clamped = fm.Mechanism("clamped", [body, fm.Fixed("O", fm.GROUND, body, at=(0.0, 0.0))])
    assert fm.modes(clamped, count=4).frequencies == pytest.approx(body.frequencies(4, held=("start",)), rel=1e-7)


@pytest.mark.parametrize(
    "share", [1e-6, pytest.param(1e-8, marks=pytest.mark.slow), pytest.param(1e-12, marks=pytest.mark.slow)]
)
def test_frequencies_need_no_mass_of_averaged_pins(share, monkeypatch):
    """Masses of any size are found beside one another; what the pins have the frequencies differ by."""
    monkeypatch.setattr(full_body, "PIN_SHARE", share)
    body = link(interface="averaged")
    free = fm.modes(fm.Mechanism("free", [body]), count=8)
    assert free.rigid == 3
    assert free.frequencies[3:] == pytest.approx(body.frequencies(5), rel=share + 1e-9)


def spun(step, **changes):
    """Momenta and energy of a soft bar thrown with 60 rad/s, over 3 turns."""
    body = bar(velocity=(1.0, 2.0, 60.0), **changes)
    mechanism = fm.Mechanism("thrown", [body])
    sol = fm.simulate(mechanism, t_end=0.3, step=step, save=100)
    assert sol.ok, sol.status
    return sol, momentum(mechanism, sol)


THROWN = [
    {},
    *(pytest.param(x, marks=pytest.mark.slow) for x in ({"interface": "averaged"}, {"formulation": "total-lagrange"})),
]


@pytest.mark.parametrize("changes", THROWN, ids=str)
def test_thrown_body_keeps_its_momenta_over_many_turns(changes):
    """Linear momentum to round-off, moment of momentum with the square of the step."""
    errors = []
    for step in (2e-4, 1e-4):
        sol, found = spun(step, **changes)
        assert np.ptp(found.linear, axis=0).max() < 1e-12 * np.abs(found.linear).max()
        errors.append(np.ptp(found.angular) / np.abs(found.angular).max())
        assert sol.array("bar.left.theta")[-1] / (2.0 * math.pi) == pytest.approx(2.86, abs=0.01)
    assert errors[0] < 1e-4
    assert 3.0 < errors[0] / errors[1] < 5.5


@pytest.mark.slow
def test_energy_of_a_thrown_body_is_booked():
    """Kinetic and strain energy, with what damping and the method take: the rest falls with the square of the step."""
    rest = []
    for step in (2e-4, 1e-4):
        sol, _ = spun(step, young=2e7, damping=1e-5)
        assert sol.peak("energy.strain").value > 1e-5 * sol.peak("energy.kinetic").value
        assert sol.array("energy.dissipated_damping")[-1] > 0.1 * sol.peak("energy.strain").value
        rest.append(sol.peak("energy.residual").value / sol.peak("energy.strain").value)
    assert rest[0] < 0.5
    assert 3.0 < rest[0] / rest[1] < 5.5


@pytest.mark.slow
@pytest.mark.parametrize("interface", ["rigid", pytest.param("averaged", marks=pytest.mark.slow)])
def test_stiff_pendulum_swings_as_a_rigid_one(interface):
    """The angles differ by errors of the steps alone, the forces first by vibrations of the start."""
    body = link(interface=interface)
    own = body.properties()
    rigid = fm.RigidBody("rod", own.centre, mass=own.mass, inertia=own.inertia)
    joint = fm.Revolute("O", fm.GROUND, rigid, at=(0.0, 0.0))
    alone, apart = fm.Mechanism("rigid", [rigid, joint], gravity=(0.0, -9.81)), []
    for step in (5e-4, 2.5e-4):
        other = fm.simulate(alone, t_end=0.25, step=step, save=10)
        sol = fm.simulate(hung(body), t_end=0.25, step=step, save=10)
        apart.append(np.abs(sol.array("rod.theta") - other.array("rod.theta")).max())
    assert apart[0] < 2e-5
    assert 3.0 < apart[0] / apart[1] < 5.0
    assert np.abs(sol.array("O.force") / other.array("O.force") - 1.0)[5:].max() < 1e-4


def tip_deflection(body, load):
    """Sag and pull-in of the tip of a cantilever over its length."""
    load = fm.Force("load", body, at=pin(body, "right"), force=(0.0, -load))
    clamp = fm.Fixed("O", fm.GROUND, body, at=pin(body, "left"))
    found = fm.static_equilibrium(fm.Mechanism("cantilever", [body, clamp, load]))
    x, y = pin(body, "right")
    return (y - found["bar.right.y"]) / LENGTH, (x - found["bar.right.x"]) / LENGTH


@pytest.mark.quick(1)
@pytest.mark.parametrize(("factor", "sag", "pull"), [(1.0, 0.30172, 0.05643), (5.0, 0.71379, 0.38763)])
def test_large_deflection_is_that_of_the_elastica(factor, sag, pull):
    """Tip of a slender cantilever under P L^2 / E I = 1 and 5.

    Source: K. Mattiasson, Numerical results from large deflection beam and frame problems analysed by means of elliptic
    integrals, Int. J. Numer. Meth. Engng 17 (1981) 145-153, table I.
    """
    slender = fm.meshes.rectangle(LENGTH, LENGTH / 100.0, 40, 1, "quad9")
    straight = fm.Material(young=2e9, density=2000.0, poisson=0.0)
    body = bar(mesh=slender, material=straight)
    stiffness = 2e9 * 0.01 * (LENGTH / 100.0) ** 3 / 12.0
    found = tip_deflection(body, factor * stiffness / LENGTH**2)
    assert found == pytest.approx((sag, pull), rel=2e-3)


def test_formulations_agree_for_small_strain():
    """Their difference falls with the strain, since forces differ by its square."""
    apart = []
    for load in (40.0, 20.0):
        sags = [tip_deflection(bar(formulation=kind), load)[0] for kind in ("corotated", "total-lagrange")]
        assert sags[0] > 0.01 * load / 40.0
        apart.append(abs(sags[0] / sags[1] - 1.0))
    assert apart[0] < 1e-3
    assert apart[1] < 0.7 * apart[0]


def test_pins_of_both_kinds_move_as_they_should():
    """Nodes of a rigid pin keep their arms; an averaged pin is the mean of its nodes, and softer."""
    sags = {}
    for interface in ("rigid", "averaged"):
        body = bar(interface=interface)
        sags[interface] = tip_deflection(body, 4.0)[0]
    assert sags["rigid"] < sags["averaged"] < 1.05 * sags["rigid"]
    body = bar(interface="averaged")
    sol = fm.simulate(hung(body), t_end=0.05, step=1e-4, save=5)
    (shape,) = (s for s in sol.shapes if isinstance(s, MeshShape))
    points = drawing.surface(sol, shape, np.arange(len(sol.time))).points[:, body.mesh.set_of("right")]
    weights = next(i for i in body.interfaces if i.name == "right").weights(body.mesh)
    mean = np.einsum("k,nkx->nx", weights, points)
    places = np.stack([sol.array("bar.right.x"), sol.array("bar.right.y")], axis=1)
    assert np.abs(mean - places).max() < 1e-10


def test_largest_stress_is_that_of_the_operator_with_its_node():
    """A bar sags a little under its weight: stresses by the corotated signal beside those linear in displacements."""
    body = bar(young=200e9, kind="tri6")
    clamp = fm.Fixed("O", fm.GROUND, body, at=pin(body, "left"))
    sol = fm.simulate(fm.Mechanism("sagging", [body, clamp], gravity=(0.0, -9.81)), t_end=0.002, step=1e-5, save=20)
    (surface,) = drawing.surfaces(sol, np.arange(len(sol.time)))
    u = (surface.points - np.array(surface.shape.points)).reshape(len(sol.time), -1)
    expected = von_mises((u @ stress_operator(body.mesh, body.material).T).reshape(len(u), -1, 4))
    assert np.abs(surface.von_mises - expected).max() < 1e-4 * expected.max()
    signal = sol.array("bar.von_mises")
    assert signal == pytest.approx(surface.von_mises.max(axis=1), abs=1e-7 * signal.max())
    nodes = sol.array("bar.von_mises_node").astype(int)[1:]
    found = surface.von_mises[np.arange(1, len(sol.time)), nodes]
    assert found == pytest.approx(surface.von_mises.max(axis=1)[1:], rel=1e-6)


def test_peak_of_the_stress_has_the_node_of_its_instant():
    """Every accepted step is saved: the node is that of the step with the largest stress."""
    body = bar()
    sol = fm.simulate(hung(body), t_end=0.02, step=1e-4, save="steps")
    peak = sol.peak("bar.von_mises")
    row = int(np.argmax(sol.array("bar.von_mises")))
    assert (peak.value, peak.time) == (sol.array("bar.von_mises")[row], sol.time[row])
    assert peak.node == sol.array("bar.von_mises_node")[row]
    assert peak.place == pytest.approx(body.mesh.points[peak.node])
    value, time = peak
    assert (value, time) == (peak.value, peak.time)
    assert sol.peak("O.force").node is None
    assert sol.peak("O.force").place is None


def test_rigid_motion_has_no_stress_in_any_drawing():
    """A bar that starts turned and unstressed far from its place has no stress."""
    body = bar(at=(0.7, -0.3), angle=2.5)
    sol = fm.simulate(hung(body), t_end=1e-4, step=1e-4, save=1)
    (surface,) = drawing.surfaces(sol, np.array([0]))
    assert surface.von_mises.max() < 1e-9 * 2e9
    reference = np.array([[n.x, n.y] for n in body.nodes() if n.name.startswith("node")])
    free = [int(n.name[4:]) for n in body.nodes() if n.name.startswith("node")]
    assert np.abs(surface.points[0, free] - reference).max() < 1e-15


def test_mesh_goes_through_json_and_files(tmp_path):
    body = bar(cells=(3, 1))
    sol = fm.simulate(hung(body), t_end=1e-3, step=1e-4, save=2)
    (shape,) = (s for s in sol.shapes if isinstance(s, MeshShape))
    assert from_json(to_json([shape])) == (shape,)
    back = fm.load(sol.to_netcdf(tmp_path / "run.nc"))
    assert tuple(back.shapes) == tuple(sol.shapes)
    assert back.peak("bar.von_mises").place == sol.peak("bar.von_mises").place


def test_degrees_of_freedom_count_the_body_once():
    """Rotations that nodes of the mesh do not have are no joints: a pendulum has one degree of freedom."""
    report = fm.check(hung(bar()))
    assert (report.freedom, report.gruebler, report.joints) == (1, 1, ("O",))


def test_two_materials_meet_in_one_body():
    """A bar of two halves in series under tension: elongations add up, in the formulations alike."""
    mesh = fm.meshes.rectangle(LENGTH, SIDE, 12, 2, "quad9")
    middle = mesh.points[mesh.cells].mean(axis=1)[:, 0] < 0.5 * LENGTH
    halves = replace(mesh, regions={"soft": np.flatnonzero(middle), "hard": np.flatnonzero(~middle)})
    soft, hard = (fm.Material(young=E, density=2000.0, poisson=0.0) for E in (1e9, 3e9))
    for formulation in ("corotated", "total-lagrange"):
        body = bar(mesh=halves, material={"soft": soft, "hard": hard}, formulation=formulation)
        pull = fm.Force("load", body, at=pin(body, "right"), force=(10.0, 0.0))
        clamp = fm.Fixed("O", fm.GROUND, body, at=pin(body, "left"))
        found = fm.static_equilibrium(fm.Mechanism("rod", [body, clamp, pull]))["bar.right.x"] - pin(body, "right")[0]
        assert found == pytest.approx(10.0 / (0.01 * SIDE) * 0.5 * LENGTH * (1e-9 + 1e-9 / 3.0), rel=1e-4)
