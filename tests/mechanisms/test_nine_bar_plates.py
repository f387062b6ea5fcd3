"""Plane bodies in the shapes of the nine-bar mechanism, from meshes/make_meshes.py: mass and inertia, files, a run."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import nine_bar

MESHES = Path(__file__).parents[2] / "meshes"


@pytest.fixture(scope="module")
def make_meshes():
    spec = spec_from_file_location("make_meshes", MESHES / "make_meshes.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def plates(make_meshes):
    return make_meshes.nine_bar_plates(nine_bar(flexible=True), 0.0125)


@pytest.mark.parametrize("name", ["crank1", "link2", "link3", "crank4", "rocker6", "panel7", "link8"])
def test_masses_are_those_of_the_beams_and_inertias_where_no_shaft_has_a_part(plates, name):
    own, beam = plates[name].properties(), nine_bar(flexible=True).find(name).properties()
    assert own.mass == pytest.approx(beam.mass, rel=3e-4)  # of coarse circles
    assert own.centre == pytest.approx(beam.centre, abs=2e-3 if name == "panel7" else 1e-6)
    if name in ("link2", "link3", "link8", "panel7"):
        assert own.inertia == pytest.approx(beam.inertia, rel=0.015 if name == "panel7" else 1.5e-3)
    else:
        assert own.inertia < beam.inertia


def test_stored_meshes_are_those_of_the_plates(make_meshes, plates, tmp_path, capsys):
    written = make_meshes.write_planes(tmp_path, 0.0125)
    assert [file.name for file in written] == [f"{name}_plane.msh" for name in plates]
    assert len(capsys.readouterr().out.splitlines()) == 8
    for file, plate in zip(written, plates.values(), strict=True):
        new, stored, mesh = fm.meshes.read(file), fm.meshes.read(MESHES / file.name), plate.mesh
        for found in (new, stored):
            assert found.holes == mesh.holes
            assert found.area == pytest.approx(mesh.area, rel=1e-5)
            assert (found.kind, len(found.cells)) == (mesh.kind, pytest.approx(len(mesh.cells), rel=0.02))
            centres = [found.centre_of(name) for name in mesh.holes]
            assert centres == [pytest.approx(mesh.centre_of(name), abs=1e-9) for name in mesh.holes]


def test_nine_bar_with_a_reduced_plate_as_panel_and_clearance_runs(plates):
    mechanism = nine_bar(clearance=0.5e-3).with_part(fm.Reduced(plates["panel7"], modes=3))
    sol = fm.simulate(mechanism, t_end=5e-4, step=1e-5)
    assert sol.ok, sol.status
    at = {pin: np.array([sol.array(f"panel7.{pin}.{axis}") for axis in "xy"]) for pin in "ABC"}
    for pair, side in (("AB", 0.229), ("AC", 0.304), ("BC", 0.315)):
        lengths = np.linalg.norm(at[pair[0]] - at[pair[1]], axis=0)
        np.testing.assert_allclose(lengths, side, rtol=1e-4)
        assert np.ptp(lengths) > 0.0  # the plate is elastic
