"""Bases of Craig and Bampton: what they keep, how they converge, what is refused."""

import numpy as np
import pytest
from cases import slow_where
from scipy.linalg import eigh

import flexmb as fm
from flexmb.elastic.reduced import superelement
from flexmb.elastic.reduced.bases import rigid_motions
from flexmb.errors import InputError

STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)


def eyes(size=0.003, **options):
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.02, size=size)
    return fm.PlaneBody("rod", mesh, start=(0.2, 0.1), end=(0.2, 0.22), thickness=0.01, material=STEEL, **options)


def bar(**options):
    section = fm.Circle(diameter=0.1)
    return fm.FlexibleLink("rod", (0.0, 0.0), (1.0, 0.0), section=section, material=STEEL, **options)


def clamped(body, modes):
    """Frequencies with the first pin held [Hz]."""
    matrices = fm.Reduced(body, modes=modes).element.matrices
    squares = eigh(matrices["K"][3:, 3:], matrices["M"][3:, 3:], eigvals_only=True)
    return np.sqrt(squares) / (2.0 * np.pi)


def test_rigid_motions_are_kept():
    """Forces vanish, the mass is that of the body, and the basis moves all points as rigid motions do."""
    small = fm.Reduced(eyes(), modes=6)
    free, matrices = rigid_motions(small.basis.nodes), small.element.matrices
    assert np.abs(matrices["K"] @ free).max() <= 1e-14 * np.abs(matrices["K"]).max()
    mass = free.T @ matrices["M"] @ free
    own = small.body.properties()
    assert mass[:2, :2] == pytest.approx(own.mass * np.eye(2), rel=1e-12)
    assert mass[2, 2] - mass[2, 0] ** 2 / own.mass - mass[2, 1] ** 2 / own.mass == pytest.approx(own.inertia, rel=1e-9)
    moved = np.asarray(small.model.shape @ (small.basis.shapes @ free)).reshape(-1, 2, 3)
    points = small.model.points
    turned = np.stack([-points[:, 1], points[:, 0]], axis=1)
    assert moved[:, :, 2] == pytest.approx(turned, abs=1e-12)
    assert moved[:, :, 0] == pytest.approx(np.tile([1.0, 0.0], (len(points), 1)), abs=1e-12)


def test_published_frequencies_of_a_link_with_eyes():
    """Independent values on a mesh of triangles with 9,356 unknowns, left pin held: static shapes alone, and full.

    Computed with scikit-fem and Gmsh: 914.5488, 6021.07, 9779.30 Hz without vibrations; 913.9364, 5327.25, 9488.96 Hz
    with all nodes.  Meshes differ by some 5e-4.
    """
    body = eyes(0.0025)
    assert clamped(body, 0)[:3] == pytest.approx([914.5488, 6021.07, 9779.30], rel=7e-4)
    assert clamped(body, 24)[:3] == pytest.approx([913.9364, 5327.25, 9488.96], rel=2e-3)


@pytest.mark.slow
def test_frequencies_fall_to_those_of_all_nodes():
    """Each further set of modes lowers them: Ritz values from above."""
    body = eyes()
    found = np.array([clamped(body, modes)[:3] for modes in (0, 3, 6, 12, 24)])
    assert np.all(np.diff(found, axis=0) <= 1e-9 * found[1:])
    full = fm.Reduced(body, modes=60)
    assert found[-1] == pytest.approx(clamped(body, 60)[:3], rel=1e-3)
    assert full.frequencies(1)[0] <= fm.Reduced(body, modes=3).frequencies(1)[0]


def test_modes_come_in_threes_or_up_to_a_frequency():
    small = fm.Reduced(eyes(), modes=4)
    assert [node.name for node in small.nodes()] == ["start", "end", "modes1", "modes2"]
    held = small.basis.held
    assert small.dropped_frequency == held[6]
    up_to = fm.Reduced(eyes(), up_to=0.5 * (held[2] + held[3]))
    assert len(up_to.nodes()) == 3
    assert up_to.dropped_frequency == pytest.approx(held[3])


def test_a_body_stands_where_it_is_placed():
    """Pins lie at the given points, and a turned body has the same frequencies."""
    small = fm.Reduced(eyes(), modes=3)
    start, end, middle = small.nodes()
    assert (start.x, start.y) == pytest.approx((0.2, 0.1))
    assert (end.x, end.y) == pytest.approx((0.2, 0.22))
    assert (middle.x, middle.y) == pytest.approx((0.2, 0.16))
    assert fm.modes(fm.Mechanism("free", [small])).frequencies[3] == pytest.approx(small.frequencies(1)[0], rel=1e-6)


def test_damping_ratios_are_those_of_the_free_body():
    small = fm.Reduced(eyes(), modes=3, damping_ratios=(0.01, 0.02))
    found = fm.modes(fm.Mechanism("free", [small]), damped=True)
    values = found.eigenvalues[np.abs(found.eigenvalues) > 1.0]
    ratios = -values.real / np.abs(values)
    assert ratios[:3] == pytest.approx([0.01, 0.02, 0.0], abs=1e-8)


def test_beams_with_bosses_keep_their_mass():
    section = fm.Rectangle(width=0.01, height=0.02)
    rod = fm.FlexibleLink("rod", (0.0, 0.0), (0.3, 0.0), section=section, material=STEEL, mass=0.9, pivot_inertia=1e-3)
    small = fm.Reduced(rod, modes=3)
    assert small.total_mass() == pytest.approx(0.9, rel=1e-12)
    ours, beams = (fm.modes(fm.Mechanism("free", [body])).frequencies[3:5] for body in (small, rod))
    assert ours == pytest.approx(beams, rel=2e-3)
    assert np.all(ours >= beams * (1.0 - 1e-9))


REFUSED = {
    "a rigid body": (
        lambda: fm.Reduced(fm.RigidBody("box", (0.0, 0.0), mass=1.0, inertia=1.0)),
        "does not bend.*leave others as they are",
    ),
    "no body": (lambda: fm.Reduced("rod"), "must be a flexible body"),
    "an unknown pin": (lambda: fm.Reduced(eyes(), pins=("middle",)), "pin.*'middle'"),
    "one pin twice": (lambda: fm.Reduced(bar(elements=4), pins=("start", "node0", "end")), "name each one once"),
    "a node of a mesh as a pin": (lambda: fm.Reduced(eyes(), pins=("start", "node95")), "'node95'.*Known: start, end"),
    "a name for a list": (lambda: fm.Reduced(eyes(), pins="start"), "must be a list of names of pins"),
    "a text for a ratio": (lambda: fm.Reduced(eyes(), damping_ratios="2%"), "damping_ratios"),
    "no pins": (lambda: fm.Reduced(eyes(), pins=()), "pins is empty"),
    "a frame": (lambda: fm.Reduced(eyes(), frame="mean"), "frame.*'chord', 'pin'|frame.*chord"),
    "negative modes": (lambda: fm.Reduced(eyes(), modes=-1), "at least 0"),
    "too many coordinates": (lambda: fm.Reduced(eyes(), modes=120).element, "more than 96. Keep fewer modes"),
    "too high a frequency": (lambda: fm.Reduced(eyes(), up_to=1e9).basis, "more than 96. Keep fewer modes"),
    "more modes than displacements": (lambda: fm.Reduced(bar(elements=2), modes=4).basis, "3 inner displacements"),
    "shapes of inertia of too few elements": (
        lambda: fm.Reduced(bar(elements=3), modes=6, inertia_shapes=True).basis,
        "6 inner displacements.*3 for static shapes of inertia",
    ),
    "a start field": (
        lambda: fm.compile(fm.Mechanism("m", [fm.Reduced(bar(displacement=lambda s: (0.0, 0.01 * s * s, 0.02 * s)))])),
        "start fields",
    ),
}


@pytest.mark.parametrize("case", slow_where(lambda n: n == "too high a frequency", REFUSED))
def test_refused(case):
    make, message = REFUSED[case]
    with pytest.raises(InputError, match=message):
        make()


def test_pins_at_one_place():
    """A ring with a hub and a rim as its pins: the frame is that of the hub, whatever is asked for."""
    mesh = fm.meshes.ring(0.02, 0.05, 0.01)
    disc = fm.PlaneBody("disc", mesh, at=(0.3, 0.1), thickness=0.01, material=STEEL, pins=("inner", "outer"))
    chord, pin = fm.Reduced(disc, modes=3), fm.Reduced(disc, modes=3, frame="pin")
    assert chord.frequencies(3) == pytest.approx(pin.frequencies(3), rel=1e-12)
    assert chord.basis.by_pin
    with pytest.raises(InputError, match=r"no node of Reduced 'disc'.*make it a pin of the body"):
        chord.attach("Force 'F'", (0.35, 0.1))


@pytest.mark.parametrize("factor", [0.1, 10.0, 100.0])
def test_directions_of_shortening_do_not_hang_on_their_round_off(monkeypatch, factor):
    """A straight beam has one, an arc two, a triangle of beams three; their singular values end at 1e-12."""
    section = fm.Rectangle(width=0.01, height=0.02)
    lines = {"section": section, "material": fm.STEEL, "elements": 4}
    bodies = (
        fm.FlexibleLink("rod", (0.0, 0.0), (0.6, 0.8), **lines),
        fm.FlexibleLink("arc", (0.0, 0.0), (1.0, 0.0), turn=1.5, **lines),
        fm.FlexibleFrame("frame", ((0.0, 0.0), (1.0, 0.0), (0.4, 0.7)), ((0, 1), (1, 2), (2, 0)), **lines),
    )
    elements = [fm.Reduced(body, modes=6).element for body in bodies]
    monkeypatch.setattr(superelement, "ROUND_OFF", factor * superelement.ROUND_OFF)
    assert [len(element.directions) for element in elements] == [1, 2, 3]
