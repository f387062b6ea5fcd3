"""Findings, not tracebacks: users' kernels that raise or return no numbers; sizes and places beyond the usual."""

import math
from dataclasses import dataclass, replace

import pytest
from broken import O, link, slider_crank, worn

import flexmb as fm


@dataclass(frozen=True)
class Raising(fm.Motion):
    """A motion that raises an error after some time."""

    speed: float

    @fm.drive_kernel
    def kernel(p, t):
        if t > 0.2:
            raise ValueError("too late")
        return p[0] * t, p[0], 0.0


@dataclass(frozen=True)
class Forgetful(fm.NormalLaw):
    """A law that returns nothing where the surfaces are apart."""

    stiffness: float

    @fm.normal_law  # noqa: RET503 - its fault
    def kernel(p, h, gap, gap_rate, z, z_new):
        if gap < 0.0:
            return -p[0] * gap


@dataclass(frozen=True)
class Wordy(fm.NormalLaw):
    """A law that returns a word."""

    stiffness: float

    @fm.normal_law
    def kernel(p, h, gap, gap_rate, z, z_new):
        return "force"


@dataclass(frozen=True)
class Ending(fm.FrictionLaw):
    """Friction that is not a number at fast slips."""

    coefficient: float

    @fm.friction_law
    def kernel(p, h, slip, N, z, z_new):
        return -p[0] * N * math.tanh(slip / 1e-3) if abs(slip) < 0.05 else math.nan


def test_a_motion_that_raises_is_told_with_its_error():
    (finding,) = fm.check(slider_crank(motion=Raising(5.0))).of("broken-kernel")
    assert finding.parts == ("motor",)
    assert "fails with ValueError (too late) at t = 0.2" in finding.text
    assert finding.remedy


@pytest.mark.parametrize(("law", "code"), [(Forgetful(1e8), "broken-kernel"), (Wordy(1e8), "not-compilable")])
def test_laws_that_return_no_number(law, code):
    report = fm.check(worn("A", normal=law))
    assert [finding.code for finding in report.findings if finding.severity == "error"] == [code]
    assert report.of(code)[0].parts == ("A",)


@pytest.mark.slow
def test_what_follows_from_a_broken_kernel_is_no_lack_of_inertia():
    report = fm.check(worn("A", friction=Ending(0.2)))
    assert {finding.code for finding in report.findings} == {"broken-kernel"}


def four_bar_of_size(size, place=0.0):
    """A sound four-bar that swings by 0.3 rad."""
    P, Q, R = ((x * size + place, y * size + place) for x, y in ((0.0, 0.1), (0.3, 0.0), (0.32, 0.25)))
    start = (O[0] + place, O[1] + place)
    crank, coupler, rocker = link("crank", start, P), link("coupler", P, R), link("rocker", Q, R)
    return fm.Mechanism("four-bar", [
        crank, coupler, rocker,
        fm.Revolute("O", fm.GROUND, crank, at=start), fm.Revolute("A", crank, coupler, at=P),
        fm.Revolute("B", coupler, rocker, at=R), fm.Revolute("D", fm.GROUND, rocker, at=Q),
        fm.Drive("motor", "O", fm.drives.Harmonic(0.3, 5.0)),
    ])  # fmt: skip


@pytest.mark.parametrize(
    "size", [pytest.param(1e-6, marks=pytest.mark.slow), pytest.param(1e-4, marks=pytest.mark.slow), 1e4]
)
def test_the_loops_of_tiny_and_huge_mechanisms_close(size):
    report = fm.check(four_bar_of_size(size))
    assert report.ok, report
    assert {finding.code for finding in report.findings} == {"odd-units"}


@pytest.mark.parametrize(
    ("place", "told"),
    [(100.0, False), pytest.param(1e4, True, marks=pytest.mark.slow), pytest.param(1e6, True, marks=pytest.mark.slow)],
)
def test_a_mechanism_far_from_the_origin_is_told(place, told):
    report = fm.check(four_bar_of_size(1.0, place))
    assert [finding.code for finding in report.findings] == ["far-origin"] * told


def test_coincident_joints_are_not_said_to_lie_on_a_line():
    rod = link("rod", (0.3, 0.0), (0.0, 0.4))
    block, yoke = fm.RigidBody("block", (0.3, 0.0), 0.2, 1e-3), fm.RigidBody("yoke", (0.0, 0.4), 0.2, 1e-3)
    trammel = fm.Mechanism("trammel", [
        rod, block, yoke, fm.Prismatic("gx", fm.GROUND, block, at=(0.3, 0.0), along=(1, 0)),
        fm.Prismatic("gy", fm.GROUND, yoke, at=(0.0, 0.4), along=(0, 1)),
        fm.Revolute("X", rod, block, at=(0.3, 0.0)), fm.Revolute("Y", rod, yoke, at=(0.0, 0.4)),
        fm.Drive("push", "gx", fm.drives.Harmonic(0.25, 2.0)),
    ])  # fmt: skip
    (finding,) = fm.check(trammel).of("locking-drive")
    assert finding.numbers["push to"] == pytest.approx(0.2, rel=1e-6)
    assert "line" not in finding.text


def test_a_kernel_that_is_broken_does_not_hide_a_forbidden_velocity():
    mech = worn("A", friction=Ending(0.2))
    thrown = replace(mech.find("slider"), velocity=(0.0, 5.0, 0.0))
    codes = {finding.code for finding in fm.check(mech.with_part(thrown)).findings}
    assert {"broken-kernel", "forbidden-velocity"} <= codes
