"""Method of Dormand and Prince: order, dense output, joints, energies, singular positions, refusals, restarts."""

import math
import runpy
from pathlib import Path

import numpy as np
import pytest
from andrews import andrews, andrews_angles

import flexmb as fm
from flexmb.engine.dormand_prince.complement import complement, factor_complement, solve_symmetric
from flexmb.engine.dormand_prince.tree import add_inertias, find_arms, tree, turn_bodies
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError

double = runpy.run_path(str(Path(__file__).with_name("double_pendulum.py")))
pendulum, motion, UPPER = (double[name] for name in ("pendulum", "motion", "UPPER"))
radau = runpy.run_path(str(Path(__file__).with_name("test_radau.py")))
missed, driven, ANDREWS = (radau[name] for name in ("missed", "driven", "ANDREWS"))
singular = runpy.run_path(str(Path(__file__).with_name("test_singular.py")))
parallelogram, turned, turned_late = (singular[name] for name in ("parallelogram", "turned", "turned_late"))

METHOD = fm.DormandPrince()
G = 9.81


def run(**options):
    sol = fm.simulate(pendulum(), t_end=2.0, method=METHOD, **{"save": "steps", **options})
    assert sol.ok, sol.status
    return sol


def chain(links):
    """An open chain of rigid links of 1 m in all, from the horizontal."""
    length = 1.0 / links
    bodies = [
        fm.RigidLink(f"link{k}", (k * length, 0.0), ((k + 1) * length, 0.0), length, length**3 / 12.0)
        for k in range(links)
    ]
    joints = [
        fm.Revolute(f"joint{k}", bodies[k - 1] if k else fm.GROUND, bodies[k], (k * length, 0.0)) for k in range(links)
    ]
    return fm.Mechanism("chain", [*bodies, *joints], gravity=(0.0, -G))


def mobile():
    """Two trees on the ground, with branches, pins declared from either side, springs, dampers and a load."""
    places = {"a": (0.0, 0.0), "b": (0.4, 0.1), "c": (0.5, -0.2), "d": (0.9, 0.3), "e": (-0.2, 0.4), "f": (2.0, 0.0)}
    part = {
        name: fm.RigidBody(name, (x + 0.1, y - 0.05 * k), 1.0 + 0.3 * k, 0.02 + 0.01 * k, theta=0.2 * k)
        for k, (name, (x, y)) in enumerate(places.items())
    }
    held = {"c": "ca", "a": " a", "b": "ab", "d": "bd", "e": "ea", "f": "f "}
    part[" "] = fm.GROUND
    pins = [fm.Revolute(f"pin {name}", *(part[end] for end in ends), places[name]) for name, ends in held.items()]
    extras = [
        fm.SpringDamper("spring", part["d"], part["f"], places["d"], places["f"], stiffness=30.0, damping=0.4),
        fm.TorsionSpring("torsion", part["a"], part["e"], stiffness=2.0, damping=0.05),
        fm.Force("load", part["c"], (0.6, -0.3), (1.0, 0.5)),
    ]
    return fm.Mechanism("mobile", [*(part[name] for name in places), *pins, *extras], gravity=(0.0, -G))


# Order of the method and of its dense output


def test_eighth_order_of_positions_velocities_and_joint_forces():
    coarse, fine = (np.array(missed(run(step=h))) for h in (0.08, 0.04))
    orders = np.log2(coarse / fine)
    assert np.all(orders > 7.0)
    assert np.all(orders < 10.5)


def test_instants_within_steps_are_of_order_seven():
    coarse, fine = (np.array(missed(run(step=h, save=997))) for h in (0.08, 0.04))
    orders = np.log2(coarse / fine)
    assert np.all(orders > 5.7)
    finer = np.array(missed(run(step=0.02, save=997)))
    assert np.all(np.log2(fine / finer) > 6.5)
    assert np.all(np.log2(fine / finer) < 9.5)


def test_errors_are_proportional_to_rtol():
    found = [missed(run(step=fm.Adaptive(rtol=r)))[0] for r in (1e-5, 1e-7, 1e-9)]
    assert found[0] > found[1] > found[2]
    assert found[2] < 1e-3 * found[0]
    assert found[0] < 1e-7


def test_published_digits_of_andrews_mechanism():
    sol = fm.simulate(andrews(), t_end=0.03, method=METHOD, step=fm.Adaptive(rtol=1e-8), save=1)
    assert sol.ok, sol.status
    assert np.abs(andrews_angles(sol)[:, -1] - ANDREWS).max() < 1e-8
    assert sol.stats.steps < 200


# Joints, energies, time reversed


@pytest.mark.parametrize("save", ["steps", 301])
def test_joints_are_closed_to_round_off_at_steps_and_between(save):
    sol = run(step=0.05, save=save)
    theta, half = sol.array("upper.theta"), 0.5 * UPPER[0]
    x, y = sol.array("upper.x") - half * np.cos(theta), sol.array("upper.y") - half * np.sin(theta)
    vx = sol.array("upper.vx") + half * np.sin(theta) * sol.array("upper.omega")
    assert np.abs([x, y]).max() < 5e-15
    assert np.abs(vx).max() < 1e-12


def test_the_energy_of_a_long_motion_does_not_drift():
    sol = fm.simulate(pendulum(), t_end=200.0, method=METHOD, step=fm.Adaptive(rtol=1e-10), save=200)
    assert sol.ok, sol.status
    assert np.abs(sol.array("energy.residual")).max() < 1e-9 * np.ptp(sol.array("energy.kinetic"))


def test_a_motion_that_is_turned_round_comes_back():
    bodies = ("upper", "lower")
    there = run(step=fm.Adaptive(rtol=1e-11), save=1)
    back = dict(there.restart)
    back["v"] = -back["v"]
    again = fm.simulate(pendulum(), t_end=4.0, method=METHOD, step=fm.Adaptive(rtol=1e-11), restart=back, save=1)
    for name in bodies:
        assert again.array(f"{name}.theta")[-1] == pytest.approx(there.array(f"{name}.theta")[0], abs=1e-9)
        assert again.array(f"{name}.omega")[-1] == pytest.approx(-there.array(f"{name}.omega")[0], abs=1e-8)


@pytest.mark.parametrize("save", ["steps", 97])
def test_works_of_drive_and_damper_add_up(save):
    sol = fm.simulate(driven(), t_end=0.05, method=METHOD, step=fm.Adaptive(rtol=1e-8), save=save)
    assert sol.ok, sol.status
    drive, damped = sol.array("energy.drive_work")[-1], sol.array("energy.dissipated_damping")[-1]
    assert damped > 0.0
    assert np.abs(sol.array("energy.residual")).max() < 1e-7 * max(abs(drive), damped)


@pytest.mark.parametrize(
    "mech", [driven(), fm.mechanisms.nine_bar(), fm.mechanisms.four_bar(), mobile()], ids=lambda m: m.name
)
def test_mechanisms_with_drives_as_radau_has_them(mech):
    t_end = 0.05 if mech.name == "driven" else 0.2
    sols = [
        fm.simulate(mech, t_end=t_end, method=method, step=fm.Adaptive(rtol=1e-9), save=37)
        for method in (METHOD, fm.RadauIIA())
    ]
    assert all(sol.ok for sol in sols), [sol.status for sol in sols]
    own, other = (sol.values for sol in sols)
    names = [k for k, name in enumerate(sols[0].signals) if not name.name.startswith("energy.")]
    largest, units = np.abs(other).max(axis=0), np.array([name.units for name in sols[0].signals])
    of_kind = np.array([largest[units == unit].max() for unit in units])  # a constant speed has round-off of the others
    scale = (largest + 1e-2 * of_kind)[names] + 1e-12
    assert (np.abs(own - other)[:, names] / scale).max() < 5e-7


# Linear algebra


MIXED = (
    fm.mechanisms.nine_bar(),
    fm.mechanisms.slider_crank(),
    andrews(),
    chain(7),
    parallelogram(),
)


@pytest.mark.parametrize("mech", MIXED, ids=lambda m: m.name)
def test_the_complement_of_the_masses_is_that_of_the_whole_system(mech):
    """S by its pattern, upper half in the order of elimination, beside G M^-1 G^T with plain arrays."""
    program = fm.compile(mech)
    S = complement(program)
    assert S.usable == 1
    q = program.reference.q + 0.3 * np.sin(np.arange(program.n_q))
    at = StateEvaluation(program).at(q, weights=(0.0, 0.0, 1.0))
    M, J = (block if isinstance(block, np.ndarray) else block.toarray() for block in at.blocks)
    assert np.array_equal(S.flexibility[: program.n_q], 1.0 / np.diag(M))
    exact = J @ np.linalg.inv(M) @ J.T
    b, x, scratch = np.cos(np.arange(program.n_c)), np.zeros(program.n_c), np.zeros(program.n_c)
    assert factor_complement(S, at.work.G, 1e-13)
    solve_symmetric(S.lu, S.values, b, x, scratch)
    assert np.abs(exact @ x - b).max() < 1e-9 * np.abs(exact).max() * np.abs(x).max()


@pytest.mark.parametrize("mech", [chain(1), chain(7), pendulum(), mobile()], ids=lambda m: m.name)
def test_the_recursion_over_a_tree_is_the_whole_system(mech):
    """Accelerations and joint forces in poses of any angles, also such with open joints, beside a dense solution."""
    program, random = fm.compile(mech), np.random.default_rng(3)
    T = tree(program, complement(program))
    assert T.usable == 1
    n, m = program.n_q, program.n_c
    for _ in range(3):
        q, v, a, lam = (np.append(random.normal(size=n), np.zeros(3)) for _ in range(4))
        at = StateEvaluation(program).at(q, v, weights=(0.0, 0.0, 1.0))
        M, J = (block if isinstance(block, np.ndarray) else block.toarray() for block in at.blocks)
        exact = np.linalg.solve(np.block([[M, J.T], [J, np.zeros((m, m))]]), np.append(-at.force, at.work.gamma))
        find_arms(program.tables.p, q, T)
        add_inertias(v, at.work.r, T)
        assert turn_bodies(v, a, lam, T)
        assert np.abs(a[:n] - exact[:n]).max() < 1e-11 * np.abs(exact[:n]).max()
        assert np.abs(lam[:m] - exact[n:]).max() < 1e-11 * np.abs(exact[n:]).max()


def hanging(*joints):
    """Two links, with joints that are no tree of pins."""
    first, second = (
        fm.RigidLink(name, (x, 0.0), (x + 1.0, 0.0), 1.0, 0.1) for name, x in (("first", 0.0), ("second", 1.0))
    )
    made = {
        "pin": fm.Revolute("pin", fm.GROUND, first, (0.0, 0.0)),
        "between": fm.Revolute("between", first, second, (1.0, 0.0)),
        "closing": fm.Revolute("closing", second, fm.GROUND, (2.0, 0.0)),
        "weld": fm.Fixed("weld", first, second, (1.0, 0.0)),
        "slide": fm.Prismatic("slide", fm.GROUND, first, (0.0, 0.0)),
        "driven": fm.Drive("driven", "pin", fm.ConstantSpeed(1.0)),
    }
    return fm.Mechanism("hanging", [first, second, *(made[name] for name in joints)])


@pytest.mark.parametrize(
    "joints", ["between", "pin", "pin between closing", "pin weld", "slide between", "pin between driven"]
)
def test_joints_that_are_no_tree_of_pins_with_the_ground_take_the_complement(joints):
    program = fm.compile(hanging(*joints.split()))
    assert complement(program).usable == 1
    assert tree(program, complement(program)).usable == 0


@pytest.mark.parametrize("links", [10, 100])
def test_a_chain_needs_no_factors(links):
    sol = fm.simulate(chain(links), t_end=0.3, method=METHOD, step=fm.Adaptive(rtol=1e-5), save=1)
    assert sol.ok
    assert sol.stats.factorisations == 0
    assert max(np.abs(gap(sol, links)).max(), np.abs(gap(sol, links, "vx", "vy", "omega")).max()) < 1e-12


@pytest.mark.parametrize("links", [10, 100])
def test_a_step_beside_a_free_body_is_closed_by_factors_of_the_complement(links):
    """Factors: eleven of the stages, one or two of the projection, one of the accelerations at its end."""
    free = fm.RigidBody("free", (0.0, 1.0), 1.0, 1.0)
    mech = fm.Mechanism("chain and body", [*chain(links).parts, free], gravity=(0.0, -G))
    sol = fm.simulate(mech, t_end=0.3, method=METHOD, step=fm.Adaptive(rtol=1e-5), save=1)
    stats = sol.stats
    assert sol.ok
    assert 0 < stats.factorisations - 11 * (stats.steps + stats.rejected) <= 2.5 * stats.steps
    assert max(np.abs(gap(sol, links)).max(), np.abs(gap(sol, links, "vx", "vy", "omega")).max()) < 1e-12
    alone = fm.simulate(chain(links), t_end=0.3, method=METHOD, step=fm.Adaptive(rtol=1e-5), save=1)
    assert abs(sol.array(f"link{links - 1}.y")[-1] - alone.array(f"link{links - 1}.y")[-1]) < 1e-5


def gap(sol, links, x="x", y="y", theta="theta"):
    """Distance (2, links - 1) of the ends of neighbours at the end of a chain, or its rate."""
    at = np.array([[sol.array(f"link{k}.{name}")[-1] for k in range(links)] for name in (x, y, "theta", theta)])
    arm = 0.5 / links * np.array([np.cos(at[2]), np.sin(at[2])])
    if theta != "theta":
        arm = at[3] * np.array([-arm[1], arm[0]])
    return at[:2, 1:] - arm[:, 1:] - at[:2, :-1] - arm[:, :-1]


def test_bodies_whose_masses_are_no_diagonal_take_the_whole_system():
    assert complement(fm.compile(rod())).usable == 0


def rod():
    """A flexible pendulum."""
    beam = fm.FlexibleLink(
        "rod", (0.0, 0.0), (1.0, 0.0), section=fm.Rectangle(0.02, 0.02), material=fm.STEEL, elements=2
    )
    return fm.Mechanism("rod", (beam, fm.Revolute("O", fm.GROUND, beam, (0.0, 0.0))), gravity=(0.0, -G))


def test_error_control_keeps_the_steps_of_a_beam_stable():
    sol = fm.simulate(rod(), t_end=0.2, method=METHOD, save=4)
    fine = fm.simulate(rod(), t_end=0.2, step=1e-5, save=4, method=fm.Newmark.trapezoidal())
    assert sol.ok, sol.status
    assert np.abs(sol.array("rod.end.y") - fine.array("rod.end.y")).max() < 2e-6
    assert abs(sol.array("energy.residual")[-1]) < 1e-5 * sol.peak("energy.kinetic").value


# Singular positions, redundant joints


def test_singular_positions_are_passed_under_error_control():
    sol = fm.simulate(parallelogram(), t_end=4 * math.pi, step=fm.Adaptive(rtol=1e-6), save="steps", method=METHOD)
    assert sol.ok, sol.status
    assert turned(sol) < 1e-9
    assert turned_late(sol) < 1e-12


def test_steps_that_end_in_a_singular_position_keep_the_branch_or_say_so():
    h = math.pi / 400
    sol = fm.simulate(parallelogram(), t_end=4 * math.pi, step=h, save="steps", method=METHOD)
    assert turned(sol) < 2.0 * h * h * G or "energies do not add up" in sol.status


def test_parallel_cranks_that_repeat_one_another():
    ends = [((0.5 * k, 0.0), (0.5 * k + 0.1, 0.2)) for k in range(3)]
    cranks = [fm.RigidLink(f"crank{k}", *ends[k], 1.0, 0.01) for k in range(3)]
    bar = fm.RigidLink("rod", ends[0][1], ends[2][1], 1.0, 0.1)
    joints = [fm.Revolute(f"A{k}", fm.GROUND, cranks[k], ends[k][0]) for k in range(3)]
    joints += [fm.Revolute(f"B{k}", cranks[k], bar, ends[k][1]) for k in range(3)]
    mech = fm.Mechanism("cranks", (*cranks, bar, *joints), gravity=(0.0, -G))
    sol = fm.simulate(mech, t_end=0.2, method=METHOD, redundant="least-norm", save=10)
    newmark = fm.simulate(mech, t_end=0.2, step=1e-4, redundant="least-norm", save=10)
    assert sol.ok, sol.status
    assert np.abs(sol.array("rod.x") - newmark.array("rod.x")).max() < 1e-6
    assert np.abs(sol.array("B1.fx") - newmark.array("B1.fx")).max() < 1e-3


def test_a_step_that_is_far_too_long_says_so():
    sol = fm.simulate(fm.mechanisms.slider_crank(), t_end=0.1, method=METHOD, step=0.05)
    assert not sol.ok
    assert "NaN" not in sol.status


# What is refused


def test_laws_with_a_history_are_refused_by_name():
    law = fm.friction.LuGre(static=0.12, kinetic=0.1)
    block = fm.RigidBody("block", at=(0.0, 0.0), mass=1.0, inertia=0.1, velocity=(1.0, 0.0, 0.0))
    guide = fm.Prismatic("guide", fm.GROUND, block, friction=law, length=0.1)
    mech = fm.Mechanism("block", (block, guide), gravity=(0.0, -G))
    with pytest.raises(InputError, match=r"'guide.*has a law with a history"):
        fm.simulate(mech, t_end=1e-3, method=METHOD)


def test_tangents_are_refused():
    with pytest.raises(InputError, match="method is DormandPrince"):
        fm.chaos.MechanismFlow(fm.mechanisms.slider_crank(), method=METHOD)


# Restarts, stops, jumps


def test_a_restart_goes_on_to_the_bit():
    whole = run(step=fm.Adaptive(rtol=1e-6))
    half = fm.simulate(pendulum(), t_end=2.0, method=METHOD, step=fm.Adaptive(rtol=1e-6), save="steps", max_steps=20)
    rest = run(step=fm.Adaptive(rtol=1e-6), restart=half.restart)
    assert np.array_equal(rest.values[-1], whole.values[-1])


def test_saved_instants_change_no_step():
    assert np.array_equal(run(save=7).values[-1], run(save=701).values[-1])


def test_a_restart_of_another_method_is_as_good_as_its_state():
    half = fm.simulate(pendulum(), t_end=1.0, save=1, step=fm.Adaptive(rtol=1e-7))
    sol = fm.simulate(pendulum(), t_end=2.0, method=METHOD, step=fm.Adaptive(rtol=1e-9), restart=half.restart, save=1)
    fine = run(step=fm.Adaptive(rtol=1e-9), save=1)
    assert sol.ok, sol.status
    assert sol.array("lower.theta")[-1] == pytest.approx(fine.array("lower.theta")[-1], abs=1e-3)


def test_a_stop_is_located_to_the_digits_of_the_steps():
    angle, options = -1.0, {"method": METHOD, "step": fm.Adaptive(rtol=1e-9)}
    sol = fm.simulate(pendulum(), t_end=2.0, stop=fm.when("upper.theta", below=angle), **options)
    assert "as asked for" in sol.status
    angles, _, _ = motion(np.array([0.0, sol.time[-1]]))
    assert angles[-1][0] == pytest.approx(angle, abs=1e-8)


def test_a_load_that_jumps_is_met_by_a_step():
    """A block that is pushed from 0.3 s on: v = F/m (t - 0.3)."""
    block = fm.RigidBody("block", at=(0.0, 0.0), mass=2.0, inertia=1.0)
    load = fm.Force("push", block, (0.0, 0.0), (10.0, 0.0), history=fm.drives.Pulse(start=0.3))
    mech = fm.Mechanism("pushed", (block, fm.Prismatic("guide", fm.GROUND, block), load))
    sol = fm.simulate(mech, t_end=1.0, method=METHOD, save=10)
    assert sol.ok, sol.status
    assert sol.array("block.x")[-1] == pytest.approx(0.5 * 5.0 * 0.7**2, rel=1e-12)
    assert sol.array("energy.load_work")[-1] == pytest.approx(0.5 * 2.0 * (5.0 * 0.7) ** 2, rel=1e-12)
