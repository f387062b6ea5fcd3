"""Numbers of findings against closed forms."""

import math

import pytest
from broken import Jumping, beam, four_bar, servo, slider_crank, upright, worn

import flexmb as fm


@pytest.mark.parametrize(
    ("angle", "speed"),
    [(1.2, 1.0), pytest.param(1.2, -1.0, marks=pytest.mark.slow), pytest.param(1.0, 2.5, marks=pytest.mark.slow)],
)
def test_where_a_rocker_locks(angle, speed):
    """Coupler and rocker lie on one line where the crank's end is b + c or |b - c| from the rocker's pin."""
    a, b, c, d = 0.3, 0.1, 0.3, 0.32
    (finding,) = fm.check(four_bar((a, b, c, d), angle, fm.ConstantSpeed(speed))).of("locking-drive")
    reach = b + c if speed > 0.0 else abs(c - b)
    limit = math.acos((a * a + d * d - reach * reach) / (2.0 * a * d)) - angle
    assert finding.numbers["motor to"] == pytest.approx(limit, abs=1e-6)
    assert finding.numbers["time"] == pytest.approx(limit / speed, abs=1e-6)
    assert set(finding.parts) == {"motor", "A", "B", "D"}


def test_a_jump_is_located():
    (finding,) = fm.check(slider_crank(motion=Jumping(0.2))).of("jumping-drive")
    assert finding.numbers["time"] == pytest.approx(0.4321, abs=1e-9)
    assert finding.numbers["jump"] == pytest.approx(0.2, rel=1e-6)


def test_penetration_of_a_soft_contact():
    """F = K d^1.5 with the weight and half of the size times speed squared on all masses."""
    stiffness = 5e4
    (finding,) = fm.check(worn("A", normal=fm.contact.Hertz(stiffness))).of("soft-contact")
    assert finding.numbers["penetration"] == pytest.approx((finding.numbers["force"] / stiffness) ** (2 / 3), rel=1e-9)
    assert finding.numbers["force"] == pytest.approx((0.4 + 0.4 + 0.3) * 0.5 * 0.5 * 10.0**2, rel=1e-9)


def test_counts_of_a_nine_bar():
    """Gruebler: 3 x 8 bodies less 22 equations of eleven joints; the mechanism of the paper has two cranks."""
    report = fm.check(fm.mechanisms.nine_bar(clearance=5e-4))
    assert (report.gruebler, report.freedom, report.free, len(report.drives)) == (2, 2, 0, 2)


def test_gruebler_is_wrong_about_parallel_cranks():
    """Three equal cranks move though the count says that they cannot."""
    from broken import parallel_cranks

    report = fm.check(parallel_cranks())
    assert (report.gruebler, report.freedom) == (0, 1)


@pytest.mark.slow
def test_a_flexible_linkage_may_bend_where_a_rigid_one_locks():
    """A warning: a thin coupler can give way; with rigid links it is an error."""
    rigid = four_bar((0.3, 0.1, 0.3, 0.32), 1.2, fm.ConstantSpeed(1.0))
    coupler = rigid.find("coupler")
    bar = fm.Rectangle(width=0.01, height=1e-3)
    soft = rigid.with_part(fm.FlexibleLink("coupler", coupler.start, coupler.end, section=bar, material=fm.STEEL))
    report = fm.check(soft)
    (finding,) = report.of("locking-drive")
    assert report.ok
    assert finding.severity == "warning"
    assert finding.text.startswith("With rigid bodies in place of 'coupler': The loops close only up to")
    assert not fm.check(rigid).ok


def test_loads_without_an_equilibrium_are_noted():
    """A load far beyond the limit point of an arch."""
    left, right = beam("left", (0.0, 0.0), (0.5, 0.02)), beam("right", (0.5, 0.02), (1.0, 0.0))
    pins = [fm.Revolute("L", fm.GROUND, left, at=(0.0, 0.0)), fm.Revolute("R", fm.GROUND, right, at=(1.0, 0.0))]
    top = fm.Revolute("T", left, right, at=(0.5, 0.02))
    push = fm.Force("push", left, at=(0.5, 0.02), force=(0.0, -1e5))
    report = fm.check(fm.Mechanism("arch", [left, right, *pins, top, push]))
    assert report.of("no-statics", "overload", "buckled")


@pytest.mark.parametrize("share", [0.0, 0.5, 0.95])
def test_growth_of_a_fall(share):
    """m g l/2 less the spring, over m l^2/3."""
    (finding,) = fm.check(upright(share)).of("unstable-reference")
    assert finding.numbers["rate"] == pytest.approx(math.sqrt((1.0 - share) * 1.5 * 9.81 / 0.3), rel=1e-6)


def test_growth_of_a_loop_with_integral_action_alone():
    """I s^3 + ki = 0, with I = m l^2/3 about the pin."""
    (finding,) = fm.check(servo(0.0, 0.0, 5.0)).of("unstable-loop")
    size = (5.0 / (0.4 * 0.13 / 3.0)) ** (1.0 / 3.0)
    assert finding.numbers["rate"] == pytest.approx(0.5 * size, rel=1e-6)
    assert finding.numbers["frequency"] == pytest.approx(0.5 * math.sqrt(3.0) * size / (2.0 * math.pi), rel=1e-6)
