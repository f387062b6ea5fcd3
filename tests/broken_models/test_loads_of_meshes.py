"""Loads at rest on plane and reduced bodies: M = F L bends a bar of height h by the stress 6 M/(b h^2)."""

import pytest

import flexmb as fm

YIELDING = fm.Material(young=2.1e11, density=7850.0, poisson=0.3, yield_stress=2.5e8)
LENGTH, HEIGHT, WIDTH = 1.0, 0.05, 0.01


def bar(kind):
    if kind == "reduced beam":
        section = fm.Rectangle(width=WIDTH, height=HEIGHT)
        beam = fm.FlexibleLink("bar", (0.0, 0.0), (LENGTH, 0.0), section=section, material=YIELDING, elements=4)
        return fm.Reduced(beam, modes=3)
    mesh = fm.meshes.rectangle(LENGTH, HEIGHT, 12, 1)
    pins = ("left", "right")
    plate = fm.PlaneBody("bar", mesh, thickness=WIDTH, material=YIELDING, pins=pins, stress=False)
    return fm.Reduced(plate, modes=3) if kind == "reduced plate" else plate


@pytest.mark.quick(1)
@pytest.mark.parametrize("kind", ["plate", "reduced plate", "reduced beam"])
def test_bars_that_yield_are_told(kind):
    body = bar(kind)
    foot, tip = ((node.x, node.y) for node in body.nodes()[:2])
    yields = YIELDING.yield_stress * WIDTH * HEIGHT**2 / (6.0 * LENGTH)
    for share in (0.5, 1.5):
        load = fm.Force("F", body, tip, (0.0, -share * yields))
        parts = [body, fm.Fixed("foot", fm.GROUND, body, at=foot), load]
        found = fm.check(fm.Mechanism("bar", parts, gravity=(0.0, 0.0))).of("overload")
        assert bool(found) == (share > 1.0)
        for one in found:
            assert one.parts == ("bar",)
            assert one.numbers["stress"] == pytest.approx(share * YIELDING.yield_stress, rel=0.1)
