"""Loads on edges and in plane bodies, with all nodes and reduced."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.elastic.reduced.bases import inertia_loads
from flexmb.elastic.reduced.superelement import left_out
from flexmb.errors import InputError, ModelError, SolveError
from flexmb.model.contributions import ElementContribution
from flexmb.statics.equilibrium import load_growth

STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
RADIUS, DEPTH, THICKNESS = 0.5, 0.01, 0.01
BENDING = STEEL.young * THICKNESS * DEPTH**3 / 12.0


def bar(**changes):
    mesh = fm.meshes.rectangle(0.4, 0.02, 10, 1)
    given = {"at": (0.1, 0.2), "angle": 0.3, "thickness": 0.01, "material": STEEL, "pins": ("left", "right"), **changes}
    return fm.PlaneBody("bar", mesh, **given)


def clamped(body, *loads, gravity=(0.0, 0.0)):
    pin = body.nodes()[0]
    return fm.Mechanism(
        "clamped", [body, fm.Fixed("wall", fm.GROUND, body, at=(pin.x, pin.y)), *loads], gravity=gravity
    )


def slim_ring():
    mesh = fm.meshes.ring(RADIUS - DEPTH / 2, RADIUS + DEPTH / 2, 0.02)
    body = {"thickness": THICKNESS, "material": STEEL, "pins": ("inner",), "interface": "averaged"}
    return fm.PlaneBody("ring", mesh, **body)


def inward(points):
    return -points / np.linalg.norm(points, axis=1, keepdims=True)


SIZES = {
    "all nodes": lambda body: body,
    "reduced": lambda body: fm.Reduced(body, 12),
    "by a pin": lambda body: fm.Reduced(body, 12, frame="pin"),
}
ALL_SLOW = [pytest.param("all nodes", marks=pytest.mark.slow), "reduced", "by a pin"]


@pytest.mark.parametrize("size", ALL_SLOW[:2])
def test_a_ring_buckles_under_a_pressure_that_follows_it_and_later_under_one_that_does_not(size):
    """Critical forces per length of a slim ring, over EI/R^3: 3 (M. Levy, J. Math. Pures Appl. 10 (1884) 5) if they
    stay normal to it, (2 n)^2 - 1 = 8 for three waves; 4 if they keep their directions (S. R. Bodner, J. Appl. Mech.
    25 (1958) 327)."""
    ring, unit = slim_ring(), BENDING / RADIUS**3
    pressure = fm.loads.EdgePressure("p", ring, "outer", unit / THICKNESS)
    dead = fm.loads.BodyForce("p", ring, lambda x: inward(x) * unit / (THICKNESS * DEPTH))
    for load, factors, error in ((pressure, (3.0, 3.0, 8.0), 3e-3), (dead, (4.0, 4.0), 3e-3)):
        body = SIZES[size](ring)
        found = fm.buckling(clamped(body, load), count=len(factors)).factors
        assert found[: len(factors)] == pytest.approx(factors, rel=error)


@pytest.mark.slow
def test_a_column_pressed_on_its_end_flutters_as_becks():
    """20.05 EI/L^2 (M. Beck, Z. angew. Math. Phys. 3 (1952) 225); all nodes, by the sparse eigensolver."""
    body = fm.PlaneBody("bar", fm.meshes.rectangle(0.4, 0.02, 20, 1), thickness=0.01, material=STEEL, pins=("left",))
    unit = STEEL.young * 0.02**3 / 12.0 / (0.4**2 * 0.02)  # pressure of EI/L^2
    for factor, flutters in ((19.8, False), (20.3, True)):
        column = clamped(body, fm.loads.EdgePressure("p", body, "right", factor * unit))
        found = fm.modes(column, count=4, at=fm.static_equilibrium(column), damped=True)
        assert (found.eigenvalues.real.max() > 1.0) == flutters


@pytest.mark.slow
def test_the_static_shape_of_a_load_changes_its_buckling_by_little():
    ring = slim_ring()
    load = fm.loads.EdgePressure("p", ring, "outer", 1e5)
    bodies = (fm.Reduced(ring, 12), fm.Reduced(ring, 12, load_shapes=(load,)))
    plain, shaped = (fm.buckling(clamped(body, load), count=3).factors for body in bodies)
    assert shaped[:3] == pytest.approx(plain[:3], rel=1e-5)


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "kind",
    [
        pytest.param("dead", marks=pytest.mark.slow),
        "turning",
        pytest.param("edge", marks=pytest.mark.slow),
        "body",
        pytest.param("field", marks=pytest.mark.slow),
    ],
)
def test_reduced_bodies_move_at_their_pins_as_the_full_one(kind):
    body = bar()
    load = {
        "dead": lambda: fm.loads.EdgeLoad("q", body, "top", (2e4, -1e5)),
        "turning": lambda: fm.loads.EdgeLoad("q", body, "right", (1e4, -1e5), follower=True),
        "edge": lambda: fm.loads.EdgePressure("q", body, "top", 1e5, shear=lambda x: 1e5 * x[:, 0]),
        "body": lambda: fm.loads.BodyForce("q", body, (1e5, -1e7)),
        "field": lambda: fm.loads.BodyForce("q", body, lambda x: 1e7 * (x - 0.2), follower=True),
    }[kind]()
    full = fm.static_equilibrium(clamped(body, load))
    size = max(map(abs, full.force("wall")))
    shapes = () if kind == "turning" else (load,)  # that one acts on a rigid pin and has no shape
    for small in (fm.Reduced(body, 6), fm.Reduced(body, 6, load_shapes=shapes)):
        found = fm.static_equilibrium(clamped(small, load))
        moved = full["bar.right.y"] - body.pin_nodes[1].y
        assert found["bar.right.y"] - body.pin_nodes[1].y == pytest.approx(moved, rel=1e-4)
        assert found.force("wall") == pytest.approx(full.force("wall"), abs=1e-5 * size)


def test_a_traction_on_the_nodes_of_a_rigid_pin_is_a_force_on_the_pin():
    body = bar()
    pin = body.pin_nodes[1]
    area = 0.02 * 0.01
    traction = fm.loads.EdgeLoad("q", body, "right", (3e5, -1e5))
    force = fm.Force("q", body, at=(pin.x, pin.y), force=(3e5 * area, -1e5 * area))
    found, known = (fm.static_equilibrium(clamped(body, load)) for load in (traction, force))
    assert found.q == pytest.approx(known.q, abs=1e-12)


def test_a_pressed_ring_widens_as_lame_says():
    """u(b) = 2 p a^2 b/(E (b^2 - a^2)) in plane stress (G. Lame, 1852)."""
    a, b, p = 0.1, 0.2, 1e8
    ring = fm.PlaneBody("ring", fm.meshes.ring(a, b, 0.05), thickness=0.01, material=STEEL, interface="averaged")
    found = fm.static_equilibrium(clamped(ring, fm.loads.EdgePressure("p", ring, "inner", p)))
    k = int(ring.mesh.set_of("outer")[0])
    place = np.array([found[f"ring.node{k}.x"], found[f"ring.node{k}.y"]])
    expected = 2.0 * p * a**2 * b / (STEEL.young * (b**2 - a**2))
    assert np.linalg.norm(place) - b == pytest.approx(expected, rel=4e-3)


def resultant(load, body, q):
    """Sum of the forces and of the moments about the origin that a load exerts on a body in the pose q (n, 3)."""
    places = {(body.name, node.name, axis): q[k, axis] for k, node in enumerate(body.nodes()) for axis in range(3)}
    total, none = np.zeros(3), np.zeros(0)
    for one in load.contributions(fm.Mechanism("free", [body, load])):
        if not isinstance(one, ElementContribution):
            continue
        own = np.array([places[c] for c in one.coordinates])
        n = len(own)
        r, K, rest = np.zeros(n), np.zeros((n, n)), np.zeros((n, n))
        one.kernel(np.array(one.p), 0.0, 0.0, own, np.zeros(n), np.zeros(n), none, r, K, rest, rest, none)
        for (part, node, axis), force in zip(one.coordinates, -r, strict=True):
            x, y = places[part, node, 0], places[part, node, 1]
            total[axis] += force
            total[2] += (-y * force, x * force, 0.0)[axis]
    return total


@pytest.mark.quick(1)
@pytest.mark.parametrize("size", SIZES)
def test_stresses_on_closed_edges_have_the_resultants_of_statics_in_any_pose(size):
    """A pressure has none; a shear has the moment 2 tau t times the area inside."""
    ring = fm.PlaneBody("ring", fm.meshes.ring(0.05, 0.1, 0.025), thickness=0.01, material=STEEL, angle=0.4)
    body, scatter = SIZES[size](ring), np.random.default_rng(3)
    nodes = np.array([(node.x, node.y, node.theta) for node in body.nodes()])
    turn, shift = 1.1, np.array([0.2, -0.1])
    c, s = math.cos(turn), math.sin(turn)
    rigid = np.column_stack([nodes[:, :2] @ np.array([[c, s], [-s, c]]) + shift, nodes[:, 2] + turn])
    bent = rigid + 1e-3 * scatter.standard_normal(rigid.shape)
    pressure = fm.loads.EdgePressure("p", ring, "outer", 1e6)
    shear = fm.loads.EdgePressure("p", ring, "outer", 0.0, shear=1e6)
    for pose in (rigid, bent):
        assert resultant(pressure, body, pose) == pytest.approx(np.zeros(3), abs=1e-8)
        assert resultant(shear, body, pose)[:2] == pytest.approx(np.zeros(2), abs=1e-8)
    area = np.pi * 0.1**2
    assert resultant(shear, body, rigid)[2] == pytest.approx(2e6 * 0.01 * area, rel=1e-3)


@pytest.mark.quick(1)
@pytest.mark.parametrize("size", SIZES)
def test_dead_loads_and_followers_have_their_resultants_in_any_pose(size):
    body = bar()
    nodes = np.array([(node.x, node.y, node.theta) for node in SIZES[size](body).nodes()])
    turn = 1.1
    c, s = math.cos(turn), math.sin(turn)
    rigid = np.column_stack([nodes[:, :2] @ np.array([[c, s], [-s, c]]), nodes[:, 2] + turn])
    start, force = (
        resultant(fm.loads.BodyForce("b", body, (2e5, -1e6)), SIZES[size](body), nodes),
        np.array([16.0, -80.0]),
    )
    centre = np.array(body.properties().centre)
    assert start == pytest.approx([*force, centre[0] * force[1] - centre[1] * force[0]], rel=1e-9)
    for follower in (False, True):
        load = fm.loads.BodyForce("b", body, (2e5, -1e6), follower=follower)
        fx, fy, moment = resultant(load, SIZES[size](body), rigid)
        expected = np.array([c * force[0] - s * force[1], s * force[0] + c * force[1]]) if follower else force
        place = np.array([c * centre[0] - s * centre[1], s * centre[0] + c * centre[1]])
        assert [fx, fy] == pytest.approx(expected, rel=1e-9)
        assert moment == pytest.approx(place[0] * expected[1] - place[1] * expected[0], rel=1e-9)


@pytest.mark.parametrize("size", ALL_SLOW)
def test_a_shear_spins_a_ring_up(size):
    """Moment 2 pi r^2 t tau, which follows the edge round; its work is the energy that the ring gains."""
    r, tau, t_end = 0.1, 1.2e5, 0.05
    step, error = (5e-5, 1e-4) if size == "all nodes" else (2e-4, 1e-6)  # all nodes: modes that no step resolves
    mesh = fm.meshes.ring(0.05, r, 0.05)
    ring = fm.PlaneBody("ring", mesh, thickness=0.01, material=STEEL, pins=("inner",), stress=False)
    load = fm.loads.EdgePressure("shear", ring, "outer", 0.0, shear=tau)
    free = fm.Mechanism("free", [SIZES[size](ring), load])
    sol = fm.simulate(free, t_end=t_end, step=step, save=50)
    assert sol.ok
    expected = 2.0 * math.pi * r**2 * 0.01 * tau * t_end
    assert fm.momentum(free, sol).angular[-1] == pytest.approx(expected, rel=2e-3)
    assert float(sol["ring.inner.theta"][-1]) > 2.0 * math.pi
    gained = sum(float(sol[f"energy.{name}"][-1]) for name in ("kinetic", "strain", "dissipated_algorithm"))
    assert float(sol["energy.load_work"][-1]) == pytest.approx(gained, rel=error)


def test_a_controller_sets_a_load_on_a_reduced_body_alone():
    body = bar(stress=False)
    load = fm.loads.EdgeLoad("q", body, "top", (0.0, 1e3))
    servo = fm.PID("servo", "bar.right.theta", "q", target=0.01, kp=1e4)
    assert fm.compile(clamped(fm.Reduced(body, 3), load, servo)).n_q == 9
    with pytest.raises(ModelError, match="load on the mesh of a Reduced body"):
        fm.compile(clamped(body, load, servo))


def test_a_history_multiplies_a_load_and_its_signals():
    body, ramp = bar(stress=False), fm.drives.PiecewiseLinear((0.0, 1e-3, 2e-3), (0.0, 1.0, 0.0))
    load = fm.loads.EdgeLoad("q", body, "top", (0.0, -1e3), history=ramp)
    sol = fm.simulate(clamped(fm.Reduced(body, 3), load), t_end=2e-3, step=1e-5, save=200)
    factor = 1.0 - np.abs(sol.time / 1e-3 - 1.0)
    assert sol["q.fy"].values == pytest.approx(-1e3 * 0.4 * 0.01 * factor, abs=1e-9)


def test_a_share_of_a_load_changes_its_own_parameters_alone():
    """Counts and places of kernels are parameters, too, which no rounding may change."""
    body = bar()
    mech = clamped(body, fm.loads.EdgePressure("p", body, "top", 1e5))
    program = fm.compile(mech)
    grown, whole, E = load_growth(mech, program), program.tables.p, program.tables.elements
    own = {
        i
        for name, (begin, end) in zip(program.names.elements, E.p, strict=True)
        if name != "p"
        for i in range(begin, end)
    }
    for part in (0.1, 0.3, 0.7, 0.9):
        changed = np.flatnonzero(grown(part).tables.p != whole)
        assert len(changed)
        assert own.isdisjoint(changed.tolist())
        assert np.all(whole[changed] != np.round(whole[changed]))


@pytest.mark.slow
def test_too_large_a_pressure_has_no_equilibrium_and_says_so():
    with pytest.raises(SolveError):
        fm.static_equilibrium(clamped(bar(), fm.loads.EdgePressure("p", bar(), "top", 1e12)))


def test_a_load_is_drawn_by_the_pins_that_its_body_keeps():
    body = bar()
    load = fm.loads.EdgePressure("p", body, "top", 1e5)
    small = fm.Reduced(body, 3, pins=("right",))
    arrows = load.shapes(fm.Mechanism("m", [small, load]))
    assert len(arrows) == 5
    assert {arrow.at[:2] for arrow in arrows} == {("bar", "right")}
    assert np.array([arrow.direction for arrow in arrows])[:, 1].max() < 0.0


def test_a_run_says_when_a_reduced_body_lacks_the_shape_of_its_load():
    ring = fm.PlaneBody("ring", fm.meshes.ring(0.1, 0.2, 0.05), thickness=0.01, material=STEEL, interface="averaged")
    load = fm.loads.EdgePressure("p", ring, "inner", 1e6)
    notes = []
    for shapes in ((), (load,)):
        sol = fm.simulate(clamped(fm.Reduced(ring, 3, load_shapes=shapes), load), t_end=1e-5, step=1e-6)
        notes.append([note for note in sol.notes if "load_shapes=(p,)" in note])
    assert [len(found) for found in notes] == [1, 0]
    slender = bar(stress=False)
    dead = fm.loads.EdgeLoad("q", slender, "top", (0.0, -1e3))
    small = fm.Reduced(slender, 3)
    whole, left = left_out(small, small.model.shape.T @ dead.on(slender).forces.ravel())
    assert left < 0.01 * whole


def corner():
    mesh = bar().mesh
    sets = {**mesh.sets, "corner": mesh.sets["left"][:1]}
    mesh = fm.meshes.PlaneMesh(mesh.points, mesh.cells, mesh.kind, sets)
    return fm.PlaneBody("bar", mesh, pins=("right",), thickness=0.01, material=STEEL)


def beam():
    return fm.FlexibleLink("rod", (0.0, 0.0), (0.3, 0.0), section=fm.Rectangle(0.01, 0.02), material=STEEL)


@pytest.mark.quick(1)
@pytest.mark.parametrize("forces", [[(0.0, 1e5)], [(3e4, 4e4)], [(1e5, 0.0), (2e4, 1e5)]])
def test_a_uniform_force_takes_the_place_of_a_shape_of_inertia(forces):
    """Of equal density it bends as an acceleration does; all loads of both kinds bend exactly, and motions stay."""
    loads = [fm.loads.BodyForce(f"p{k}", bar(), force) for k, force in enumerate(forces)]
    plain = fm.Reduced(bar(), 3, inertia_shapes=True)
    body = fm.Reduced(bar(), 3, inertia_shapes=True, load_shapes=loads)
    columns = [body.model.shape.T @ load.on(body.plane).forces.ravel() for load in loads]
    for force in (*columns, *inertia_loads(body.model).values()):
        whole, left = left_out(body, force)
        assert abs(left) < 1e-10 * whole
    assert body.basis.loaded == plain.basis.loaded == 4  # whatever the number of loads
    assert body.frequencies(6) == pytest.approx(plain.frequencies(6), rel=1e-9)


REFUSED = {
    "no set": (lambda: fm.loads.EdgePressure("p", bar(), "botom", 1e5), InputError, "^Edge.*'p':.*no set 'botom'"),
    "no edge": (lambda: fm.loads.EdgeLoad("p", corner(), "corner", (1e5, 0.0)), InputError, "holds no edge"),
    "a beam": (lambda: fm.loads.BodyForce("p", beam(), (1e5, 0.0)), ModelError, "'p'.*'rod' has none.*PlaneBody"),
    "a reduced beam": (lambda: fm.loads.BodyForce("p", fm.Reduced(beam()), (1e5, 0.0)), ModelError, "has none"),
    "the ground": (lambda: fm.loads.EdgePressure("p", fm.GROUND, "top", 1e5), ModelError, "EdgePressure 'p'.*has none"),
    "a number for a vector": (lambda: fm.loads.EdgeLoad("p", bar(), "top", 1e5), InputError, "traction"),
    "a vector for a number": (lambda: fm.loads.EdgePressure("p", bar(), "top", (0.0, 1e5)), InputError, "pressure"),
    "a wrong function": (lambda: fm.loads.BodyForce("p", bar(), lambda x: x[:, 0]), InputError, r"returns \(p, 2\)"),
    "a wrong pressure": (lambda: fm.loads.EdgePressure("p", bar(), "top", lambda x: x), InputError, r"numbers \(p,\)"),
    "a complex function": (lambda: fm.loads.EdgePressure("p", bar(), "top", lambda x: 1j * x[:, 0]), InputError, "fin"),
    "words": (lambda: fm.loads.EdgePressure("p", bar(), "top", lambda x: ["a"] * len(x)), InputError, "finite"),
    "ragged lists": (lambda: fm.loads.BodyForce("p", bar(), lambda x: [[1.0], [1.0, 2.0]]), InputError, "finite"),
    "a list of sets": (lambda: fm.loads.EdgePressure("p", bar(), ["top"], 1e5), InputError, r"no set \['top'\]"),
    "not a number": (lambda: fm.loads.EdgePressure("p", bar(), "top", math.nan), InputError, "pressure"),
    "no history": (lambda: fm.loads.EdgePressure("p", bar(), "top", 1e5, history=2.0), InputError, "history is 2.0"),
    "no follower": (lambda: fm.loads.EdgeLoad("p", bar(), "top", (0.0, 1.0), follower=1), InputError, "follower"),
    "shapes of no load": (lambda: fm.Reduced(bar(), load_shapes=("p",)), InputError, "load_shapes holds 'p'"),
    "shapes of another body": (
        lambda: fm.Reduced(bar(), load_shapes=(fm.loads.EdgePressure("p", slim_ring(), "outer", 1e5),)),
        InputError, "'p', which acts on PlaneBody 'ring'",
    ),
    "shapes of a force on a pin": (
        lambda: fm.Reduced(bar(), load_shapes=(fm.loads.EdgePressure("p", bar(), "right", 1e5),)).basis,
        InputError, "loads on rigid pins alone",
    ),
    "shapes of equal loads": (
        lambda: fm.Reduced(bar(), load_shapes=[fm.loads.EdgeLoad(n, bar(), "top", (0.0, 1.0)) for n in "ab"]).basis,
        InputError, "combinations of each other",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case):
    make, error, message = REFUSED[case]
    with pytest.raises(error, match=message):
        make()
