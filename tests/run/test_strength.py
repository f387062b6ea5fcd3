"""Remarks of a run on the safety of flexible bodies against yield."""

import re
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm

STEEL = fm.Material(2.1e11, 7850.0, 0.3, yield_stress=2e8)
SECTION = fm.Rectangle(width=0.01, height=0.02)


def bent(body, force=-100.0):
    wall, load = fm.Fixed("wall", fm.GROUND, body, (1.0, 2.0)), fm.Force("F", body, (1.4, 2.0), (0.0, force))
    return fm.simulate(fm.Mechanism("bent", [body, wall, load]), t_end=5e-3)


def link(material=STEEL, **more):
    return fm.FlexibleLink("rod", (1.0, 2.0), (1.4, 2.0), section=SECTION, material=material, **more)


def plate(material):
    mesh = replace(fm.meshes.rectangle(0.4, 0.02, 6, 1), regions={"near": np.arange(3), "far": np.arange(3, 6)})
    return fm.PlaneBody("rod", mesh, at=(1.0, 1.99), thickness=0.01, material=material, pins=("left", "right"))


def remark(sol):
    """The remark on the rod: stress, safety, and the whole text."""
    (text,) = [note for note in sol.notes if "safety against yield" in note]
    stress = float(re.search(r"([\d.e+]+) Pa at t", text)[1])
    return stress, float(re.search(r"([\d.]+)(?:;|\.$)", text[text.index("against yield") :])[1]), text


@pytest.mark.parametrize("reduced", [False, True])
def test_safety_of_beams(reduced):
    sol = bent(fm.Reduced(link(), modes=3) if reduced else link())
    stress, safety, text = remark(sol)
    assert stress == pytest.approx(sol.peak("rod.von_mises").value, rel=1e-6)
    assert safety == pytest.approx(2e8 / stress, rel=5e-3)
    assert "normal stress in the outer fibres" in text
    assert re.search(r"\(1, (2|1.99|2.01)\) m in the reference", text)


def test_yielding():
    assert "it yields" not in remark(bent(link()))[2]
    sol = bent(link(), force=-500.0)
    assert "it yields" in remark(sol)[2]
    assert sum("yield" in note for note in sol.notes) == 1


def test_plate_of_two_materials():
    """The largest stress stands beside the lower yield stress, wherever that material is."""
    sol = bent(plate({"near": STEEL, "far": replace(STEEL, yield_stress=1e8)}))
    _, safety, text = remark(sol)
    assert safety == pytest.approx(1e8 / sol.peak("rod.von_mises").value, rel=5e-3)
    assert "of the weakest material, at least" in text
    unsure = {"near": STEEL, "far": replace(STEEL, yield_stress=None)}
    assert not [note for note in bent(plate(unsure)).notes if "safety" in note]


def test_place_in_a_plate():
    sol = bent(plate(STEEL))
    stress, safety, text = remark(sol)
    node = sol.peak("rod.von_mises").node
    x, y = sol.mechanism.find("rod").mesh.points[node]
    assert f"at node {node}, ({1.0 + x:.4g}, {1.99 + y:.4g}) m" in text
    assert safety == pytest.approx(2e8 / stress, rel=5e-3)
    assert "largest von Mises stress" in text


def test_silence():
    soft = replace(STEEL, yield_stress=None)
    for body in (link(soft, stress=True), link(stress=False), plate(soft)):
        assert not [note for note in bent(body).notes if "safety" in note]


@pytest.mark.parametrize("reduced", [False, True])
def test_strain_of_a_plate(reduced):
    """A plate of 30 kPa is pulled suddenly: twice F / (E A), a third; of a thousandth of the force nothing is told."""
    soft = fm.Material(3e4, 1000.0, 0.3)
    body = fm.Reduced(plate(soft), modes=3) if reduced else plate(soft)
    wall = fm.Fixed("wall", fm.GROUND, body, (1.0, 2.0))
    loads = [fm.Force("F", body, (1.4, 2.0), (force, 0.0)) for force in (1.0, 1e-3)]
    mechanisms = [fm.Mechanism("soft", [body, wall, load], gravity=(0.0, 0.0)) for load in loads]
    large, small = (fm.simulate(mechanism, t_end=0.2, save=20) for mechanism in mechanisms)
    assert not large.ok
    assert re.search(r"'rod' strains by some 0\.[2-6]\d* .*plane bodies are linear elastic", large.status)
    assert small.ok
    assert not [note for note in small.notes if "strains" in note]
