"""Runs that fail name the kernel, its part, the time and its arguments; or a step with which the run goes on."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from broken import A, O, link, slider_crank, worn

import flexmb as fm
from flexmb.errors import KernelError


@dataclass(frozen=True)
class Limited(fm.Element):
    """A torsion spring that refuses angles beyond its limit, or gives NaN beyond a time."""

    name: str
    body: fm.Part
    stiffness: float
    limit: float = 1e9
    end: float = 1e9
    coords = ("body.theta",)

    @fm.element_kernel
    def kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
        if q[0] > p[1]:
            raise ValueError("the angle is beyond the limit")
        r[0] = p[0] * q[0] * (math.nan if t > p[2] else 1.0)
        K[0, 0] = p[0]


@dataclass(frozen=True)
class Ending(fm.Motion):
    """A constant speed whose kernel raises after its end."""

    speed: float
    end: float

    @fm.drive_kernel
    def kernel(p, t):
        if t > p[1]:
            raise RuntimeError("no data")
        return p[0] * t, p[0], 0.0


@dataclass(frozen=True)
class Fragile(fm.NormalLaw):
    """A linear spring that raises beyond a penetration."""

    stiffness: float
    deepest: float

    @fm.normal_law
    def kernel(p, h, gap, gap_rate, z, z_new):
        if gap < -1e-6 - p[1]:
            raise ValueError("too deep")
        if gap > 0.0:
            return 0.0, 0.0, 0.0
        return -p[0] * gap, -p[0], 0.0


@dataclass(frozen=True)
class Undefined(fm.FrictionLaw):
    """Friction that is not finite beyond a slip."""

    fastest: float

    @fm.friction_law
    def kernel(p, h, slip, N, z, z_new):
        if abs(slip) > p[0]:
            return math.nan, 0.0, 0.0
        return -0.1 * N * math.tanh(slip / 1e-2), -0.1 * N / 1e-2 / math.cosh(slip / 1e-2) ** 2, -0.1 * math.tanh(slip)


def driven(motion=None, **spring):
    """A crank that turns at 2 rad/s against a limited spring."""
    crank = link("crank", O, A)
    spring = Limited("spring", crank, 5.0, **spring)
    drive = fm.Drive("motor", joint="O", motion=motion or fm.ConstantSpeed(2.0))
    return fm.Mechanism("driven", [crank, fm.Revolute("O", fm.GROUND, crank, at=O), drive, spring])


METHODS = {
    "newmark": {},
    "radau": {"method": fm.RadauIIA()},
    "runge": {"method": fm.RungeKutta4(), "step": 1e-3},
}


@pytest.mark.parametrize("method", METHODS)
def test_an_exception_of_a_kernel_ends_the_run_and_keeps_it(method):
    sol = fm.simulate(driven(limit=1.0), t_end=1.0, save=100, **METHODS[method])
    assert not sol.ok
    assert "'spring' raised ValueError: the angle is beyond the limit" in sol.status
    assert "Limited.kernel" in sol.status
    assert "q = (1" in sol.status  # 1 rad at 0.5 s
    assert 0.45 < float(sol.time[-1]) <= 0.5
    assert np.isfinite(sol.values).all()
    assert sol["crank.theta"].values[-1] == pytest.approx(2.0 * sol.time[-1])


@pytest.mark.parametrize("method", METHODS)
def test_nan_of_a_kernel_names_part_time_and_arguments(method):
    sol = fm.simulate(driven(end=0.25), t_end=1.0, save=100, **METHODS[method])
    assert not sol.ok
    assert "Limited.kernel' of part 'spring' gave numbers that are not finite, called with p = (5, " in sol.status
    assert "t = 0.25" in sol.status
    assert 0.2 < float(sol.time[-1]) <= 0.26


def test_an_exception_of_a_drive_names_the_drive():
    sol = fm.simulate(slider_crank(motion=Ending(10.0, 0.1)), t_end=0.3, save=100)
    assert not sol.ok
    assert "Ending.kernel' of part" in sol.status
    assert "raised RuntimeError: no data, called with p = (10, 0.1), t = 0.1" in sol.status


def test_a_drive_may_raise_after_the_end_of_the_run():
    sol = fm.simulate(slider_crank(motion=Ending(10.0, 0.1)), t_end=0.09, save=100)
    assert sol.ok, sol.status


def test_an_exception_of_a_contact_law_names_joint_and_gap():
    sol = fm.simulate(worn("A", normal=Fragile(1e7, 1e-9)), t_end=0.05)
    assert not sol.ok
    assert "Fragile.kernel' of part 'A' raised ValueError: too deep, called with p = (1e+07, 1e-09), h = " in sol.status
    assert "gap = -" in sol.status


def test_friction_that_is_not_finite_names_the_slip():
    """The crank pin slides faster than the law knows, from the start and after some time."""
    with pytest.raises(KernelError, match=r"Undefined.kernel' of part 'A' gave numbers that are not finite.*slip = "):
        fm.simulate(worn("A", friction=Undefined(1e-3)), t_end=0.05)
    sol = fm.simulate(worn("A", friction=Undefined(0.11)), t_end=0.5)
    assert not sol.ok
    assert "Undefined.kernel' of part 'A' gave numbers that are not finite" in sol.status


def test_a_kernel_that_raises_at_the_start_is_an_error_with_its_name():
    with pytest.raises(KernelError, match=r"'spring'.*the angle is beyond the limit"):
        fm.simulate(driven(limit=-1.0), t_end=0.1)


def test_a_kernel_may_refuse_poses_that_no_run_reaches():
    """Start values are tested at turned poses of the mechanism; a kernel may refuse these."""
    sol = fm.simulate(driven(limit=0.5), t_end=0.2)
    assert sol.ok, sol.status


def test_a_sweep_goes_on_after_a_kernel_that_raised():
    found = fm.sweep(end_of_run, {"limit": [1.0, 3.0]})
    assert list(found["ok"].values) == [False, True]
    assert "simulate 'driven': Stopped: The kernel 'Limited.kernel'" in found["status"].values[0]
    assert found["end"].values == pytest.approx([np.nan, 1.0], abs=2e-3, nan_ok=True)


def end_of_run(limit):
    """The last instant of the driven crank with a limit, and whether it is good."""
    sol = fm.simulate(driven(limit=limit), t_end=1.0)
    return {"end": float(sol.time[-1]), "good": sol.ok}


def test_statics_and_modes_name_a_kernel_that_raises():
    crank = link("crank", O, A)
    spring = Limited("spring", crank, 5.0, limit=-1.0)
    mech = fm.Mechanism("still", [crank, fm.Revolute("O", fm.GROUND, crank, at=O), spring])
    with pytest.raises(KernelError, match="'spring'"):
        fm.modes(mech)


def test_a_step_that_helps_was_tried():
    sol = fm.simulate(worn(), t_end=0.02, step=fm.Adaptive(min=1e-4))
    assert not sol.ok
    assert "Tried: with step=Adaptive(rtol=0.0001, min=1e-07) the run gets past this instant." in sol.status
    assert "In the refused step 'A' closes." in sol.notes
    assert fm.simulate(worn(), t_end=0.02, step=fm.Adaptive(min=1e-7)).ok


def test_steps_that_a_method_does_not_take_are_not_tried():
    """Runge-Kutta's method takes fixed steps alone: no other kind is named where coarse ones blow up."""
    crank = link("crank", O, A)
    spring = Limited("spring", crank, 1e9)
    mech = fm.Mechanism(
        "stiff", [crank, fm.Revolute("O", fm.GROUND, crank, at=O), spring, fm.Torque("push", crank, 1.0)]
    )
    sol = fm.simulate(mech, t_end=1.0, method=fm.RungeKutta4(), step=1e-2)
    assert not sol.ok
    assert "Adaptive(" not in sol.status.partition("Tried")[2]


def test_a_tolerance_below_round_off_is_told():
    sol = fm.simulate(worn(), t_end=0.02, step=fm.Adaptive(rtol=1e-15, atol=1e-19, min=1e-7))
    assert not sol.ok
    assert "below the round-off of the coordinates" in sol.status


def test_the_last_good_state_goes_on_without_the_fault():
    """The final state of a run that failed is its last accepted one: a mended model goes on from there."""
    broken, whole = driven(end=0.25), driven(end=1e9)
    sol = fm.simulate(broken, t_end=1.0)
    with pytest.raises(fm.errors.InputError, match="other numbers"):
        fm.simulate(whole, t_end=1.0, restart=sol.restart)
    plain = {name: value for name, value in sol.restart.items() if name != "model"}
    rest = fm.simulate(whole, t_end=1.0, restart=plain)
    assert rest.ok, rest.status
    assert rest["crank.theta"].values[-1] == pytest.approx(2.0)


@pytest.mark.parametrize("how", [{}, {"step": 1e-3}], ids=["adaptive", "fixed"])
def test_a_linkage_that_locks_names_its_joints_and_no_smaller_step(how):
    """A driven crank that is no Grashof crank: coupler and rocker in line."""
    A, B, D = (0.3, 0.0), (0.45, 0.25), (0.5, 0.0)
    ends = {"crank": ((0.0, 0.0), A), "coupler": (A, B), "rocker": (D, B)}
    links = {name: fm.RigidLink(name, *points, mass=0.5, inertia=2e-3) for name, points in ends.items()}
    crank, coupler, rocker = links.values()
    pins = [
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)), fm.Revolute("A", crank, coupler, at=A),
        fm.Revolute("B", coupler, rocker, at=B), fm.Revolute("D", fm.GROUND, rocker, at=D),
    ]  # fmt: skip
    motor = fm.Drive("motor", "O", fm.ConstantSpeed(6.0))
    sol = fm.simulate(fm.Mechanism("triple rocker", [*links.values(), *pins, motor]), t_end=1.0, **how)
    assert not sol.ok
    assert "the joints 'A', 'B', 'D' lie on one line" in sol.status
    assert "Try" not in sol.status
    assert "smaller" not in sol.status
    reach = math.hypot(0.15, 0.25) + math.hypot(0.05, 0.25)
    locked = math.acos((0.3**2 + 0.5**2 - reach**2) / (2.0 * 0.3 * 0.5))
    assert f"'motor' at {locked:.6g}" in sol.status


def test_a_step_beyond_the_limit_of_an_explicit_method_is_no_fault_of_a_kernel():
    """Forces of 1e154 N come from the growth of the motion; a shorter step is the remedy."""
    body = fm.RigidBody("b", (1.0, 0.0), 1e-3, 1e-9)
    guide = fm.Prismatic("guide", fm.GROUND, body, along=(1.0, 0.0))
    spring = fm.SpringDamper(
        "d", fm.GROUND, body, at=(0.0, 0.0), to=(1.0, 0.0), stiffness=100.0, damping=10.0, free_length=1.1
    )
    sol = fm.simulate(fm.Mechanism("m", [body, guide, spring]), t_end=1.0, method=fm.RungeKutta4(), step=1e-3)
    assert not sol.ok
    assert "kernel" not in sol.status
    assert "with step=FixedStep(size=0.0001) the run gets past this instant" in sol.status
