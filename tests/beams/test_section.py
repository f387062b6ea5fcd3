"""Sections and materials against closed forms, and their messages."""

import dataclasses
import math
import pickle

import numpy as np
import pytest
from scipy.integrate import quad

from flexmb.elastic.beams.section import Circle, GeneralSection, Rectangle, Section, Tapered, Tube
from flexmb.errors import InputError
from flexmb.model.law import STEEL, Material

SMALL_TUBE, LARGE_TUBE = Tube(outer=0.02, inner=0.01), Tube(outer=0.03, inner=0.025)
GENERAL = GeneralSection(area=2e-4, second_moment=3e-9, outer_fibre=0.01)
SECTIONS = [
    Rectangle(width=0.012, height=0.025),
    Circle(diameter=0.02),
    SMALL_TUBE,
    GENERAL,
    Tapered(Rectangle(width=0.01, height=0.03), Rectangle(width=0.02, height=0.01)),
    Tapered(Circle(0.03), Circle(0.01)),
    Tapered(SMALL_TUBE, LARGE_TUBE),
    Tapered(GENERAL, GeneralSection(area=1e-4, second_moment=1e-9, outer_fibre=0.008)),
]


def integrated(half_width, radius: float) -> tuple[float, float]:
    """Area and second moment by integrating strips of width 2 half_width(y) over the height."""
    # y = R sin(phi) takes the square root out of the integrand at the edge
    area = quad(lambda phi: 2 * half_width(radius * math.sin(phi)) * radius * math.cos(phi), -math.pi / 2, math.pi / 2)
    second = quad(
        lambda phi: 2 * half_width(radius * math.sin(phi)) * (radius * math.sin(phi)) ** 2 * radius * math.cos(phi),
        -math.pi / 2,
        math.pi / 2,
    )
    return area[0], second[0]


def test_rectangle_bends_about_the_normal_of_the_plane():
    """25 mm x 12 mm by hand: flat and on edge."""
    on_edge, flat = Rectangle(width=0.012, height=0.025), Rectangle(width=0.025, height=0.012)
    assert on_edge.area_at(0.3) == pytest.approx(300e-6, rel=1e-15)
    assert on_edge.second_moment_at(0.3) == pytest.approx(15625e-12, rel=1e-14)
    assert flat.second_moment_at(0.3) == pytest.approx(3600e-12, rel=1e-14)
    assert on_edge.outer_fibre_at(0.3) == 0.0125


def test_circle_is_the_integral_over_its_strips():
    radius = 0.013
    area, second = integrated(lambda y: math.sqrt(radius**2 - y**2), radius)
    assert Circle(diameter=2 * radius).area_at(0.0) == pytest.approx(area, rel=1e-12)
    assert Circle(diameter=2 * radius).second_moment_at(0.0) == pytest.approx(second, rel=1e-12)
    assert Circle(diameter=2 * radius).outer_fibre_at(0.0) == radius


def test_tube_is_a_circle_less_a_circle():
    tube, outer, inner = Tube(outer=0.03, inner=0.025), Circle(0.03), Circle(0.025)
    assert tube.area_at(0.5) == pytest.approx(outer.area_at(0.5) - inner.area_at(0.5), rel=1e-14)
    difference = outer.second_moment_at(0.5) - inner.second_moment_at(0.5)
    assert tube.second_moment_at(0.5) == pytest.approx(difference, rel=1e-13)
    assert tube.outer_fibre_at(0.5) == 0.015


def test_general_section_gives_back_its_numbers():
    assert (GENERAL.area_at(0.7), GENERAL.second_moment_at(0.7), GENERAL.outer_fibre_at(0.7)) == (2e-4, 3e-9, 0.01)


@pytest.mark.parametrize("section", SECTIONS, ids=lambda section: f"{type(section).__name__}")
def test_every_section_keeps_the_shape_of_s_and_can_be_pickled(section):
    assert pickle.loads(pickle.dumps(section)) == section  # noqa: S301, made in this line
    for s in (0.5, [0.0, 1.0], np.linspace(0.0, 1.0, 6).reshape(2, 3), np.zeros((0,))):
        for method in (section.area_at, section.second_moment_at, section.outer_fibre_at):
            values = method(s)
            assert np.shape(values) == np.shape(s)
            assert np.all(np.asarray(values) > 0.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(section, dataclasses.fields(section)[0].name, 1.0)


@pytest.mark.parametrize("taper", SECTIONS[4:], ids=lambda section: type(section.start).__name__)
def test_taper_meets_its_sections_and_itself_reversed(taper):
    for method in ("area_at", "second_moment_at", "outer_fibre_at"):
        assert getattr(taper, method)(0.0) == pytest.approx(float(getattr(taper.start, method)(0.0)), rel=1e-14)
        assert getattr(taper, method)(1.0) == pytest.approx(float(getattr(taper.end, method)(0.0)), rel=1e-14)
        back = getattr(Tapered(taper.end, taper.start), method)(0.75)
        assert getattr(taper, method)(0.25) == pytest.approx(back, rel=1e-14)


def test_taper_changes_dimensions_not_areas():
    """Half way from 30 mm to 10 mm the diameter is 20 mm, the side lengths 15 mm and 20 mm."""
    assert SECTIONS[5].second_moment_at(0.5) == pytest.approx(float(Circle(0.02).second_moment_at(0.0)), rel=1e-14)
    middle = Rectangle(width=0.015, height=0.02)
    assert SECTIONS[4].second_moment_at(0.5) == pytest.approx(float(middle.second_moment_at(0.0)), rel=1e-14)


def test_tapered_general_section_changes_linearly():
    taper = Tapered(GENERAL, GeneralSection(area=1e-4, second_moment=1e-9))
    assert taper.area_at(0.25) == pytest.approx(1.75e-4, rel=1e-14)
    assert taper.second_moment_at(0.25) == pytest.approx(2.5e-9, rel=1e-14)
    with pytest.raises(InputError, match="outer_fibre is None"):
        taper.outer_fibre_at(0.25)


BAD_SECTIONS = [
    (lambda: Rectangle(width=0.01, height=-0.01), "Rectangle: height is -0.01 m; it must be > 0."),
    (lambda: Rectangle(width=0.0, height=0.01), "Rectangle: width is 0 m; it must be > 0."),
    (lambda: Rectangle(width=math.nan, height=0.01), "Rectangle: width is nan; it must be finite in m."),
    (lambda: Rectangle(width="1 cm", height=0.01), "Rectangle: width is '1 cm'; it must be a number in m."),
    (lambda: Circle(diameter=-1.0), "Circle: diameter is -1 m; it must be > 0."),
    (lambda: Circle(diameter=math.inf), "Circle: diameter is inf; it must be finite in m."),
    (lambda: Tube(outer=0.01, inner=0.0), "Tube: inner is 0 m; it must be > 0. For a solid bar use Circle"),
    (lambda: Tube(outer=0.01, inner=0.01), "Tube: inner is 0.01 m and outer is 0.01 m; inner must be smaller"),
    (lambda: Tube(outer=-0.01, inner=0.01), "Tube: outer is -0.01 m; it must be > 0."),
    (lambda: GeneralSection(area=0.0, second_moment=1e-9), "GeneralSection: area is 0 m^2; it must be > 0."),
    (lambda: GeneralSection(area=1e-4, second_moment=-1.0), "GeneralSection: second_moment is -1 m^4; it must be > 0."),
    (lambda: GeneralSection(area=1.0, second_moment=1.0, outer_fibre=0.0), "outer_fibre is 0 m; it must be > 0."),
    (lambda: GeneralSection(area=1.0, second_moment=1.0).outer_fibre_at(0.0), "outer_fibre is None; give its distance"),
    (lambda: Tapered(Circle(0.1), SMALL_TUBE), "Tapered: start is a Circle and end a Tube; both must be of one class."),
    (lambda: Tapered(Circle(0.1), 0.05), "Tapered: end is 0.05; it must be a section with constant dimensions"),
    (lambda: Tapered(SECTIONS[5], Circle(0.1)), "Tapered: start is Tapered"),
]


@pytest.mark.parametrize(("make", "message"), BAD_SECTIONS, ids=[message[:40] for _, message in BAD_SECTIONS])
def test_bad_sections_are_named(make, message):
    with pytest.raises(InputError) as caught:
        make()
    assert message in str(caught.value)


def test_misspelt_keyword_is_refused():
    with pytest.raises(TypeError, match="heigth"):
        Rectangle(width=0.01, heigth=0.02)  # type: ignore[call-arg]


def test_own_section_needs_two_methods_and_says_what_it_cannot_give():
    class Wedge(Section):
        def area_at(self, s):
            return np.asarray(s) * 1e-4

        def second_moment_at(self, s):
            return np.asarray(s) ** 3 * 1e-9

    with pytest.raises(InputError, match="Wedge: the distance of the outer fibre is unknown"):
        Wedge().outer_fibre_at(0.5)
    with pytest.raises(TypeError, match="abstract"):
        Section()


def test_steel_weighs_what_the_table_says():
    """76.5 kN/m^3 and 207 GPa (Shigley, appendix A), standard gravity 9.80665 m/s^2."""
    assert STEEL.density == pytest.approx(76.5e3 / 9.80665, abs=0.5)
    assert Material(207e9, 7801.0, 0.29) == STEEL
    assert pickle.loads(pickle.dumps(STEEL)) == STEEL  # noqa: S301, made in this line


def test_compliance_of_steel_bodies():
    """Two steel bodies with E = 210 GPa, nu = 0.3 have E* = 210 / (2 x 0.91) = 115.3846... GPa."""
    steel = Material(young=210e9, density=7850.0)
    assert 1.0 / (2.0 * steel.compliance) == pytest.approx(1500e9 / 13.0, rel=1e-14)


BAD_MATERIALS = [
    ({"young": 0.0, "density": 7800.0}, "Material: young is 0 Pa; it must be > 0. Young's modulus of steel"),
    ({"young": 2e11, "density": -1.0}, "Material: density is -1 kg/m^3; it must be > 0."),
    ({"young": 2e11, "density": math.nan}, "Material: density is nan; it must be finite in kg/m^3."),
    ({"young": 2e11, "density": 1.0, "poisson": 0.5}, "Material: poisson is 0.5; it must lie between -1 and 0.5"),
    ({"young": 2e11, "density": 1.0, "poisson": -1.0}, "Material: poisson is -1; it must lie between -1 and 0.5"),
    ({"young": 2e11, "density": 1.0, "poisson": None}, "Material: poisson is None; it must be a number."),
]


@pytest.mark.parametrize(("values", "message"), BAD_MATERIALS, ids=[message[:30] for _, message in BAD_MATERIALS])
def test_bad_materials_are_named(values, message):
    with pytest.raises(InputError) as caught:
        Material(**values)
    assert message in str(caught.value)
