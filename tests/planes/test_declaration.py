"""Plane bodies as declared: place, pins, mass properties, messages."""

import dataclasses
import math
import pickle

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

import flexmb as fm
from flexmb.errors import InputError
from flexmb.findings.dimensions import dimension_findings

STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
A, B = (0.3, -0.1), (0.3 + 0.12 * math.cos(2.0), -0.1 + 0.12 * math.sin(2.0))


@pytest.fixture(scope="module")
def mesh():
    return fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.02, size=0.005)


def body(mesh, **changes):
    return fm.PlaneBody("rod", mesh, **{"start": A, "end": B, "thickness": 0.01, "material": STEEL, **changes})


def test_start_and_end_place_the_mesh(mesh):
    rod = body(mesh)
    start, end = rod.pin_nodes
    assert (start.name, end.name, rod.main) == ("start", "end", "start")
    assert (start.x, start.y) == A
    assert (end.x, end.y) == pytest.approx(B, abs=1e-15)
    assert start.theta == end.theta == pytest.approx(2.0, abs=1e-14)
    properties = rod.properties()
    assert properties.mass == rod.total_mass() == pytest.approx(0.2762929, rel=1e-6)
    assert properties.centre == pytest.approx(np.mean([A, B], axis=0), abs=1e-12)
    assert properties.inertia == pytest.approx(6.4555e-4, rel=1e-5)


def test_at_and_angle_place_the_same_body(mesh):
    one, other = body(mesh), body(mesh, start=None, end=None, at=A, angle=2.0)
    for a, b in zip(one.nodes(), other.nodes(), strict=True):
        assert (a.name, a.x, a.y, a.theta) == (b.name, pytest.approx(b.x), pytest.approx(b.y), pytest.approx(b.theta))
    free = body(mesh, start=None, end=None)
    assert (free.pin_nodes[0].x, free.pin_nodes[0].y, free.pin_nodes[0].theta) == (0.0, 0.0, 0.0)


def test_nodes_are_pins_and_all_nodes_that_no_rigid_pin_holds(mesh):
    holes = len(mesh.sets["start"])
    counts = {kind: len(body(mesh, interface=kind).nodes()) - len(mesh.points) - 2 for kind in ("rigid", "averaged")}
    assert counts == {"rigid": -2 * holes, "averaged": 0}
    mixed = body(mesh, interface={"end": "averaged"})
    assert [i.kind for i in mixed.interfaces] == ["rigid", "averaged"]
    assert len(mixed.nodes()) == len(mesh.points) + 2 - holes
    node = mixed.nodes()[5]
    world = mesh.placed(mixed.direction, mixed.origin).points[int(node.name[4:])]
    assert (node.x, node.y) == pytest.approx(tuple(world), abs=1e-15)


def test_joints_find_pins_alone(mesh):
    rod = body(mesh)
    attached = rod.attach("Revolute 'A'", B)
    assert (attached.node, attached.offset) == ("end", (0.0, 0.0))
    with pytest.raises(InputError, match=r"Revolute 'A': the point .* is no pin of PlaneBody 'rod'; it lies .* Pins:"):
        rod.attach("Revolute 'A'", (0.0, 0.0))


def test_sets_can_be_chosen_as_pins(mesh):
    plate = fm.meshes.rectangle(0.2, 0.1, 4, 2)
    rod = fm.PlaneBody("plate", plate, thickness=0.01, material=STEEL, pins=("left", "right"))
    assert [(p.name, p.x, p.y) for p in rod.pin_nodes] == [("left", 0.0, 0.05), ("right", 0.2, 0.05)]
    assert body(mesh, pins=["end"], start=None, end=None).pin_nodes[0].name == "end"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"end": (120.0, 0.0), "start": (0.0, 0.0)},
            r"are 120 m apart, but 0.12 m .* mesh.scaled\(1000\)",
        ),
        ({"end": (0.42, -0.1000)}, None),
        ({"end": (0.43, -0.1)}, "start and end are 0.13 m apart, but 0.12 m"),
        ({"end": None}, "give either start and end, or at and angle; given are start"),
        ({"angle": 1.0}, "given are start, end and angle"),
        ({"at": (0.0, 0.0)}, "given are start, end, at"),
        ({"pins": ()}, "name at least one set"),
        ({"pins": ("start", "start")}, "each one once"),
        ({"pins": ("strat",)}, "has no set 'strat'. Did you mean 'start'"),
        ({"interface": "soft"}, "interface is 'soft'"),
        ({"interface": {"middle": "rigid"}}, "pin is 'middle'"),
        ({"material": None}, "must be a Material"),
        ({"material": {"a": STEEL}}, "The mesh has no regions"),
        ({"thickness": -0.01}, r"^PlaneBody 'rod': thickness is -0.01 m; it must be > 0\.$"),
        ({"thickness": "thin"}, "thickness is 'thin'; it must be a number"),
        ({"state": "thick"}, "state is 'thick'"),
        ({"damping": -1.0}, "damping is -1 s"),
        ({"velocity": (1.0, 2.0)}, "velocity is"),
        ({"velocity": [(1.0, 2.0, 0.0)] * 3}, "velocity has 3 entries, but the body has"),
        ({"mesh": "rod.msh"}, "mesh is 'rod.msh'; it must be a PlaneMesh"),
    ],
)
def test_bad_input_is_refused(mesh, changes, words):
    given = {"mesh": mesh, **changes}
    if words is None:
        assert body(**given).direction == pytest.approx(0.0, abs=1e-14)
        return
    with pytest.raises(InputError, match=words):
        body(**given)


def test_a_mesh_without_holes_asks_for_pins():
    with pytest.raises(InputError, match=r"so the body has no pins. Name sets of it as pins=\(...\): left, right"):
        fm.PlaneBody("plate", fm.meshes.rectangle(0.2, 0.1, 4, 2), thickness=0.01, material=STEEL)


def test_bodies_of_equal_data_are_equal_and_share_their_matrices(mesh):
    one, other = body(mesh), body(mesh)
    assert one == other
    assert hash(one) == hash(other)
    assert pickle.loads(pickle.dumps(one)) == one  # noqa: S301 - written here
    changed = dataclasses.replace(one, damping=1e-5)
    assert changed != one
    assert changed.matrices is one.matrices
    assert "815 nodes" in repr(one)
    assert len(repr(one)) < 400


def test_frequencies(mesh):
    """As in `test_vibrations`, for a coarse mesh; rigid pins keep the holes of the free link round."""
    rod = body(mesh)
    bare = [3451.64, 8317.23, 13009.08]
    np.testing.assert_allclose(body(mesh, interface="averaged").frequencies(3), bare, rtol=1e-6)
    assert (rod.frequencies(3) > 1.05 * np.array(bare)).all()
    np.testing.assert_allclose(rod.frequencies(2, held=("start",)), [915.40, 5335.58], rtol=1e-5)
    wide = body(mesh, state="strain", interface="averaged").frequencies(1)[0]
    assert wide == pytest.approx(3451.6 / math.sqrt(1 - 0.3**2), rel=0.01)  # bending and stretch with E / (1 - nu^2)


def test_regions_have_their_own_material_and_thickness(mesh):
    x = mesh.points[mesh.cells].mean(axis=1)[:, 0]
    shank = np.flatnonzero((x > 0.02) & (x < 0.1))
    eyes = np.setdiff1d(np.arange(len(mesh.cells)), shank)
    parted = fm.meshes.PlaneMesh(mesh.points, mesh.cells, mesh.kind, mesh.sets, {"eyes": eyes, "shank": shank})
    thin = body(parted, thickness={"eyes": 0.01, "shank": 0.004})
    alone = [
        fm.PlaneBody("rod", parted, material=STEEL, thickness={"eyes": a, "shank": b}).total_mass()
        for a, b in ((0.01, 1e-9), (1e-9, 0.004))
    ]
    assert thin.total_mass() == pytest.approx(sum(alone), rel=1e-6)
    assert thin.frequencies(1)[0] < body(parted).frequencies(1)[0]


def test_odd_units_of_plates_are_told(mesh):
    """Millimetres, a thickness in millimetres, a modulus in GPa of one region."""
    regions = {"a": np.arange(10), "b": np.arange(10, len(mesh.cells))}
    parted = fm.meshes.PlaneMesh(mesh.points, mesh.cells, mesh.kind, mesh.sets, regions)
    gigapascal = fm.Material(young=210.0, density=7850.0)
    cases = {
        "160 m long": fm.PlaneBody("rod", mesh.scaled(1e3), thickness=10.0, material=STEEL),
        "is 10 m thick and 0.16 m large": fm.PlaneBody("rod", mesh, thickness=10.0, material=STEEL),
        "sound travels at": fm.PlaneBody("rod", parted, thickness=0.01, material={"a": STEEL, "b": gigapascal}),
    }
    for words, rod in cases.items():
        findings = dimension_findings(fm.Mechanism("plate", [rod]))
        assert [f.code for f in findings] == ["odd-units"]
        assert words in findings[0].text
    assert not dimension_findings(fm.Mechanism("plate", [fm.PlaneBody("rod", mesh, thickness=0.01, material=STEEL)]))


def test_odd_units_inside_of_reduced_bodies_are_told(mesh):
    """Materials and sizes are those of the body that is reduced, under the name of the reduced one."""
    gigapascal = fm.Material(young=210.0, density=7850.0, poisson=0.3)
    plates = {
        "sound travels at": fm.PlaneBody("rod", mesh, thickness=0.01, material=gigapascal),
        "is 10 m thick": fm.PlaneBody("rod", mesh, thickness=10.0, material=STEEL),
        "no slender beam": fm.FlexibleLink("rod", A, B, section=fm.Rectangle(0.01, 0.05), material=STEEL),
    }
    for words, rod in plates.items():
        findings = dimension_findings(fm.Mechanism("plate", [fm.Reduced(rod, name="small")]))
        assert [f.parts for f in findings] == [("small",)]
        assert words in findings[0].text


@pytest.mark.parametrize("interface", ["rigid", "averaged"])
def test_the_body_in_a_mechanism_yields_as_its_matrices_say(interface):
    """Cells and pins of the compiled mechanism against the sparse matrices with tied pins, at a force of 1 N."""
    rod = body(fm.meshes.link_with_eyes(0.12, 0.02, 0.01, 0.02, 0.01), interface=interface)
    force = (0.6, -0.8)
    parts = [rod, fm.Fixed("A", fm.GROUND, rod, at=A), fm.Force("F", rod, at=B, force=force)]
    pose = fm.static_equilibrium(fm.Mechanism("cantilever", parts, gravity=(0.0, 0.0)))
    K = (rod.tie.matrix.T @ rod.matrices.stiffness @ rod.tie.matrix).tocsc()
    c, s = math.cos(2.0), math.sin(2.0)
    load = np.zeros(K.shape[0])
    load[3:5] = [c * force[0] + s * force[1], -s * force[0] + c * force[1]]
    u = spsolve(K[3:, 3:], load[3:])
    found = [pose["rod.end.x"] - B[0], pose["rod.end.y"] - B[1], pose["rod.end.theta"] - 2.0]
    np.testing.assert_allclose(found, [c * u[0] - s * u[1], s * u[0] + c * u[1], u[2]], rtol=1e-5)


@pytest.mark.parametrize(
    ("name", "options", "text"),
    [
        ("node3", None, "PlaneBody 'rod': the pin 'node3' has a name of the nodes of the mesh, 'node' and a number"),
        ("modes1", {}, "Reduced 'rod': the pin 'modes1' has a name of the nodes of its vibrations"),
        (
            "inertia",
            {"inertia_shapes": True},
            "Reduced 'rod': pin 'inertia' has the name of the node of shapes of inertia",
        ),
    ],
)
def test_pins_named_as_further_nodes_are_refused(name, options, text):
    plate = fm.meshes.rectangle(0.1, 0.1, 2, 2)
    mesh = dataclasses.replace(plate, sets={"left": plate.set_of("left"), name: plate.set_of("right")})

    def make():
        body = fm.PlaneBody("rod", mesh, thickness=0.01, material=fm.STEEL, pins=("left", name))
        return body if options is None else fm.Reduced(body, **options)

    with pytest.raises(InputError, match=text):
        make()
