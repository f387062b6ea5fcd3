"""Curves of bodies: splines, lift laws, profiles, outlines; and what they refuse."""

import math
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError
from flexmb.parts.cams.curves import sampled

TURN = np.linspace(0.0, 2.0 * math.pi, 181)[:-1]
STATIONS = ((0.0, 0.0), (1.2, 0.01), (1.6, 0.01), (2.8, 0.0))


def ellipse(a, b, turn=TURN):
    """Points of an ellipse."""
    return np.column_stack([a * np.cos(turn), b * np.sin(turn)])


def test_a_spline_has_length_and_curvature_of_its_ellipse():
    """Length 4 a E(e), curvatures b/a^2 and a/b^2."""
    from scipy.special import ellipe

    a, b = 0.05, 0.03
    curve = fm.ClosedCurve(ellipse(a, b))
    least, largest, place = curve.extreme_curvature()
    assert curve.length == pytest.approx(4.0 * a * ellipe(1.0 - (b / a) ** 2), rel=1e-9)
    assert least == pytest.approx(b / a**2, rel=1e-5)
    assert largest == pytest.approx(a / b**2, rel=1e-5)
    assert np.abs(place) == pytest.approx((0.0, b), abs=1e-6)


def test_curvature_of_a_spline_converges_with_order_four():
    errors = []
    for n in (30, 60, 120):
        curve = fm.ClosedCurve(ellipse(0.05, 0.03, np.linspace(0.0, 2.0 * math.pi, n + 1)[:-1]))
        errors.append(abs(curve.extreme_curvature()[1] * 0.03**2 / 0.05 - 1.0))
    assert math.log2(errors[0] / errors[1]) > 3.5
    assert math.log2(errors[1] / errors[2]) > 3.5


def test_direction_and_closing_point_do_not_matter():
    points = ellipse(0.05, 0.03)
    one, other = fm.ClosedCurve(points), fm.ClosedCurve(points[::-1])
    assert other.length == pytest.approx(one.length, rel=1e-12)
    assert other.extreme_curvature()[0] == pytest.approx(one.extreme_curvature()[0], rel=1e-6)
    assert fm.ClosedCurve(np.vstack([points, points[:1]])) == one
    assert fm.ClosedCurve.from_function(lambda u: (0.05 * math.cos(u), 0.03 * math.sin(u))).length == pytest.approx(
        one.length, rel=1e-12
    )


def test_wrong_curves_are_refused():
    points = ellipse(0.05, 0.03)
    with pytest.raises(InputError, match=r"points 17 and 18 are both \("):
        fm.ClosedCurve(np.insert(points, 17, points[17], axis=0))
    with pytest.raises(InputError, match=r"crosses itself near \("):
        fm.ClosedCurve(np.column_stack([0.05 * np.sin(TURN), 0.03 * np.sin(2.0 * TURN)]))
    with pytest.raises(InputError, match="so the curve is not closed"):
        fm.ClosedCurve(points[:100])
    with pytest.raises(InputError, match="7 points; give at least 8"):
        fm.ClosedCurve(points[:7])
    with pytest.raises(InputError, match=r"points\[3\]\[1\] is nan; it must be finite"):
        fm.ClosedCurve([*points[:3], (0.0, math.nan), *points[4:]])
    with pytest.raises(InputError, match=r"function\(0\) and function\(2 pi\) are 0.1 m apart"):
        fm.ClosedCurve.from_function(lambda u: (0.1 * math.cos(0.5 * u) / 2, math.sin(u)))
    curve = fm.ClosedCurve(points)
    with pytest.raises(InputError, match=r"span 0 from .* begins elsewhere or has a corner"):
        replace(curve, points=1.1 * points)
    assert replace(curve, points=1.1 * points, spans=None).length == pytest.approx(1.1 * curve.length)
    corner = np.array(curve.spans)
    corner[5, 0, 1:3] += (1e-4, -1e-4)
    with pytest.raises(InputError, match=r"span 4 from .* begins elsewhere or has a corner"):
        fm.ClosedCurve(points, corner)
    with pytest.raises(InputError, match="it must be a list of points"):
        fm.ClosedCurve(3.0)
    with pytest.raises(InputError, match="a segment needs a length"):
        fm.Line((1.0, 2.0), (1.0, 2.0))
    with pytest.raises(InputError, match="radius is 0 m; it must be > 0"):
        fm.cams.CircularCurve((1.0, 2.0), 0.0)


def test_a_circle_of_a_beam_is_no_curve():
    """fm.Circle is the section of a beam; the curve had the same name."""
    cam, follower = (fm.RigidBody(name, (0.0, y), 1.0, 1.0) for name, y in (("cam", 0.0), ("follower", 0.1)))
    angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    curve = fm.ClosedCurve(np.column_stack([0.05 * np.cos(angles), 0.05 * np.sin(angles)]))
    with pytest.raises(InputError, match=r"a Line, cams\.CircularCurve or .*fm\.Circle is the section of a beam"):
        fm.CurveOnCurve("pair", cam, curve, follower, fm.Circle(0.01))
    with pytest.warns(DeprecationWarning, match="Circle is called CircularCurve now"):
        assert fm.cams.Circle is fm.cams.CircularCurve
    assert "Circle" not in dir(fm.cams)


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("law", "speed", "acceleration"),
    [
        ("cycloidal", 2.0, 2.0 * math.pi), ("3-4-5", 1.875, 10.0 / math.sqrt(3.0)),
        pytest.param("4-5-6-7", 2.1875, 84.0 * math.sqrt(5.0) / 25.0, marks=pytest.mark.slow),
        ("harmonic", 0.5 * math.pi, 0.5 * math.pi**2),
    ],
)  # fmt: skip
def test_peaks_of_lift_laws(law, speed, acceleration):
    """Largest speed and acceleration over h/b and h/b^2, as tabulated by Norton (2009), table 3-1."""
    lift = fm.cams.Lift(STATIONS, law)
    found = np.array([lift.at(x) for x in np.linspace(0.0, 1.2, 4001)])
    assert found[:, 1].max() == pytest.approx(speed * 0.01 / 1.2, rel=1e-6)
    assert found[:, 2].max() == pytest.approx(acceleration * 0.01 / 1.44, rel=1e-6)
    assert found[2000, 0] == pytest.approx(0.005, rel=1e-12)
    assert lift.at(1.4) == (0.01, 0.0, 0.0)
    assert lift.at(2.2 - 2.0 * math.pi)[0] == pytest.approx(0.005, rel=1e-12)


def test_wrong_lifts_and_undercut_are_refused():
    with pytest.raises(InputError, match="angles must increase and span less than a turn"):
        fm.cams.Lift(((0.0, 0.0), (7.0, 0.01)))
    with pytest.raises(InputError, match="law is 'cubic'"):
        fm.cams.Lift(STATIONS, "cubic")
    lift = fm.cams.Lift(STATIONS)
    # h + h'' = 0.03 + 0.005 + ... falls below zero where -2 pi 0.01/1.44 = -0.0436 is reached, at 0.9 rad
    with pytest.raises(InputError, match=r"undercut at the cam angle 0.9000 rad \(51.6 degrees\)"):
        fm.cams.flat_profile(lift, 0.03)
    with pytest.raises(InputError, match="undercut at the cam angle"):
        fm.cams.roller_profile(lift, 0.01, roller=0.03)
    with pytest.raises(InputError, match="must be less than base radius"):
        fm.cams.roller_profile(lift, 0.01, roller=0.0, offset=0.02)
    with pytest.raises(InputError, match="it must be a Lift"):
        fm.cams.flat_profile("cycloidal", 0.03)


def test_a_dwell_is_an_arc_of_the_base_circle():
    profile = fm.cams.flat_profile(fm.cams.Lift(STATIONS, "3-4-5"), 0.06, at=(0.2, 0.1))
    away = np.hypot(*(np.array(profile.points) - (0.2, 0.1)).T)
    assert away.min() == pytest.approx(0.06, rel=1e-12)
    assert away.max() == pytest.approx(0.07, rel=1e-12)


def test_area_and_pieces_of_outlines():
    """A square with a round side and a round hollow: areas of segments of circles."""
    square = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    outline = fm.cams.Outline(square, (0.0, 1.0, 0.0, -math.tan(math.pi / 8.0)))
    hollow = 0.5 * 0.5 * (math.pi / 2.0 - 1.0)  # a quarter of a circle of radius 1/sqrt 2
    assert outline.area == pytest.approx(1.0 + math.pi / 8.0 - hollow, rel=1e-12)
    assert len(outline.points) == 5  # the semicircle is stored as two arcs
    x, y = np.roll(outline.polygon, -1, axis=0).T, outline.polygon.T
    assert 0.5 * np.sum(y[0] * x[1] - x[0] * y[1]) == pytest.approx(outline.area, rel=2e-4)
    other = fm.cams.Outline(square[::-1], (0.0, 1.0, 0.0, 0.0)[::-1])
    assert other.area == pytest.approx(fm.cams.Outline(square, (0.0, 0.0, 0.0, 0.0)).area + math.pi / 8.0 * -1.0)


def test_arcs_stay_within_the_tolerance_of_their_curve():
    """Area within tolerance times length; no corners; pieces grow with the cube root of 1/tolerance."""
    curve, pieces = fm.ClosedCurve(ellipse(0.05, 0.03, TURN[::20])), []
    for tolerance in (1e-5, 1e-7, 1e-9):
        outline = fm.cams.Outline.from_curve(curve, tolerance)
        x, y = sampled(curve.array, 3000).T
        assert outline.hollow_corners() == []
        for k in range(len(outline.points)):
            before, after = outline.directions(k - 1)[1], outline.directions(k)[0]
            assert abs(before[0] * after[1] - before[1] * after[0]) < 1e-9
        fine = 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
        assert abs(outline.area - fine) < tolerance * curve.length + 1e-9  # of the polygon
        pieces.append(len(outline.points))
    assert 2.0 < pieces[1] / pieces[0] <= 8.0
    assert 2.0 < pieces[2] / pieces[1] <= 8.0
    with pytest.raises(InputError, match="needs more than 128 arcs between two points"):
        fm.cams.Outline.from_curve(curve, 1e-16)


def test_wrong_outlines_are_refused():
    with pytest.raises(InputError, match="crosses itself near"):
        fm.cams.Outline(((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)))
    with pytest.raises(InputError, match=r"bulges\[0\] is 2; it must lie between -1 and 1"):
        fm.cams.Outline(((0.0, 0.0), (1.0, 1.0)), (2.0, 0.0))
    with pytest.raises(InputError, match="3 points and 2 bulges"):
        fm.cams.Outline(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), (0.0, 0.0))
    with pytest.raises(InputError, match="points 1 and 2 are both"):
        fm.cams.Outline(((0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
    with pytest.raises(InputError, match="2 points enclose nothing"):
        fm.cams.Outline(((0.0, 0.0), (1.0, 0.0)))
