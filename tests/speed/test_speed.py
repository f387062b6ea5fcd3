"""Speed as a property of the framework: times against limits on a quiet machine.  `make speed` prints the table.

Limits hold for one core of a current x86-64 machine; medians of seven runs.
"""

import json
import math
import os
import subprocess
import sys
import time
from dataclasses import replace
from statistics import median

import numpy as np
import pytest
from duel import RECORDS, keep
from models import GRAVITY, ForceAlone, chain, worn

import flexmb as fm
from flexmb.run.run import Run
from flexmb.statics.start.consistent import consistent_start

REPEATS = 7
TABLE: list[tuple[str, float, float, str]] = []


@pytest.fixture(scope="module", autouse=True)
def printed_table():
    """The table of all measurements, after the last one."""
    yield
    print(f"\n\n{'what':52s} {'median':>10s} {'limit':>8s}")
    for what, found, allowed, unit in TABLE:
        print(f"{what:52s} {found:10.3g} {allowed:8.3g} {unit}")
    noted = [(what, found, None if math.isnan(allowed) else allowed, unit) for what, found, allowed, unit in TABLE]
    file, new = RECORDS / "limits.json", {row[0] for row in TABLE}
    kept = json.loads(file.read_text(encoding="utf-8"))["rows"] if file.is_file() else []
    keep("limits", {"name": "limits", "rows": [*(row for row in kept if row[0] not in new), *noted]})


def hold(what, found, allowed, unit):
    """Note a measurement and hold it against its limit."""
    TABLE.append((what, found, allowed, unit))
    assert found <= allowed, f"{what}: {found:.3g} {unit}, allowed {allowed:g}"


def prepared(mechanism):
    """The program and its start values: what is done once a model."""
    program = fm.compile(mechanism)
    return program, consistent_start(mechanism, program)


def begun(program, start, step):
    """A run three steps from its start, its code compiled."""
    run = Run(program, fm.Newmark.generalised_alpha(0.8), fm.FixedStep(step), 1e3, None)
    run.begin(start)
    run.run_to(3 * step, saving=None)
    return run


def per_step(mechanism, step, steps):
    """Median CPU time of a step [us], over REPEATS runs from the start."""
    times = []
    program, start = prepared(mechanism)
    begun(program, start, step)
    for _ in range(REPEATS):
        run = begun(program, start, step)
        before = time.process_time()
        run.run_to((steps + 3) * step, saving=None)
        times.append(1e6 * (time.process_time() - before) / steps)
        assert run.record.count.steps == steps + 3, run.status()
        assert np.isfinite(run.flow.q).all()
    return median(times)


def test_rigid_slider_crank_with_clearance():
    hold("rigid slider-crank with clearance, one step", per_step(worn(), 1e-5, 2400), 8.0, "us")


def test_law_that_returns_its_force_alone():
    """Against the same law with its derivatives written by hand; in turns, so that a busy machine slows both."""
    mechanism = worn()
    pin = mechanism.find("C")
    by_hand = pin.normal.for_radii(pin.bearing_radius, pin.journal_radius)
    laws = (by_hand, ForceAlone(by_hand.stiffness)) * 3
    times = [per_step(mechanism.with_part(replace(pin, normal=law)), 1e-5, 2400) for law in laws]
    hold("law with its force alone over one with derivatives", min(times[1::2]) / min(times[::2]), 1.5, "")


def test_chain_of_nine_links_of_four_beams():
    hold("chain of 9 links x 4 beams, one step", per_step(chain(9, 4), 1e-4, 2000), 120.0, "us")


def test_the_chain_ends_where_it_should():
    """Speed of the right motion: the tip after 0.5 s is at (3.08548, -1.22543) m in another code (ANCF, same model)."""
    sol = fm.simulate(chain(9, 4), t_end=0.5, step=1e-4, save=1, method=fm.Newmark.generalised_alpha(0.9))
    tip = sol.array("L8.end.x")[-1], sol.array("L8.end.y")[-1]
    np.testing.assert_allclose(tip, (3.08548, -1.22543), atol=2e-3)


def test_cost_grows_linearly_with_the_number_of_elements():
    """One step a beam element, from 36 elements to 3,600."""
    sizes = ((9, 4, 1000), (90, 4, 100), (900, 4, 12))
    cost = [per_step(chain(links, n), 1e-4, steps) / (links * n) for links, n, steps in sizes]
    for (links, n, _), us in zip(sizes, cost, strict=True):
        TABLE.append((f"chain of {links} links x {n} beams, one step an element", us, math.nan, "us"))
    hold("cost an element, 3,600 elements over 36", cost[-1] / cost[0], 1.3, "")


def test_finer_beams_cost_linearly_too():
    sizes = ((9, 4, 1000), (9, 40, 100), (9, 400, 12))
    cost = [per_step(chain(links, n), 1e-5, steps) / (links * n) for links, n, steps in sizes]
    for (links, n, _), us in zip(sizes, cost, strict=True):
        TABLE.append((f"chain of {links} links x {n} beams, one step an element", us, math.nan, "us"))
    hold("cost an element, 400 beams a link over 4", cost[-1] / cost[0], 1.3, "")


def with_plays(mechanism, names):
    """The named revolute joints replaced by joints with 0.2 mm of play and friction, seated where there is gravity."""
    law, friction = (
        fm.contact.ExactRestitution(stiffness=1e9, restitution=0.5),
        fm.friction.SmoothCoulomb(0.05, v0=1e-2),
    )
    start = "seated" if any(mechanism.gravity) else "centred"
    options = {"clearance": 2e-4, "bearing_radius": 0.01, "normal": law, "friction": friction, "start": start}
    for name in names:
        joint = mechanism.find(name)
        worn = fm.RevoluteClearance(name, joint.first, joint.second, at=joint.at, **options)
        mechanism = mechanism.with_part(worn)
    return mechanism


def slack(count):
    """Slider-crank turned through an elastic coupling, with play in so many of its joints O, A, B."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.05, 0.0), 0.30, 1e-5, velocity=(0.0, 1.5, 60.0))
    rod = fm.RigidLink("rod", (0.05, 0.0), (0.17, 0.0), 0.21, 2.5e-4)
    slider, rotor = fm.RigidBody("slider", (0.17, 0.0), 0.14, 1e-4), fm.RigidBody("rotor", (0.0, 0.0), 1.0, 1e-2)
    parts = (
        fm.Revolute("axle", fm.GROUND, rotor, (0.0, 0.0)),
        fm.TorsionSpring("coupling", rotor, crank, stiffness=2e3, damping=0.5),
        fm.Revolute("O", fm.GROUND, crank, (0.0, 0.0)),
        fm.Revolute("A", crank, rod, (0.05, 0.0)),
        fm.Revolute("B", rod, slider, (0.17, 0.0)),
        fm.Prismatic("guide", fm.GROUND, slider),
        fm.Drive("motor", "axle", fm.ConstantSpeed(60.0)),
    )
    return with_plays(fm.Mechanism("slack", (crank, rod, slider, rotor, *parts)), "BAO"[:count])


def hanging(links):
    """Rigid links of 0.1 m one below the other, all pinned with play, swinging a little."""
    parts, last = [], fm.GROUND
    for k in range(links):
        link = fm.RigidLink(f"L{k}", (0.0, -0.1 * k), (0.0, -0.1 * (k + 1)), 0.2, 2e-4)
        parts += [link, fm.Revolute(f"J{k}", last, link, (0.0, -0.1 * k))]
        last = link
    return with_plays(fm.Mechanism("hanging", tuple(parts), gravity=(0.3, -GRAVITY)), [f"J{k}" for k in range(links)])


def test_each_joint_with_play_costs_alike_in_a_slider_crank():
    """From none of its three pins to all: each one adds no more than a fixed cost (an ideal joint is saved for it)."""
    cost = [per_step(slack(count), 1e-5, 5000) for count in range(4)]
    for count, us in enumerate(cost):
        TABLE.append((f"slider-crank, {count} joints with play, one step", us, math.nan, "us"))
    hold("slider-crank, dearest of three joints with play", max(np.diff(cost)), 3.0, "us")


def test_cost_of_a_step_grows_no_faster_than_the_number_of_joints_with_play():
    counts = (1, 2, 4, 8)
    cost = [per_step(hanging(count), 1e-5, 4000) / count for count in counts]
    for count, us in zip(counts, cost, strict=True):
        TABLE.append((f"chain of {count} links with play, one step a joint", us, math.nan, "us"))
    hold("cost a joint with play, 8 over 2", cost[-1] / cost[1], 1.3, "")


def clocked(code, folder):
    """Median wall time of new Python processes that run `code` [s].

    Python keeps its bytecode in `folder`, as it does beside the sources of whoever does not forbid it: a process that
    translates all sources anew is no second one.
    """
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    environment["PYTHONPYCACHEPREFIX"] = str(folder)
    times = []
    for _ in range(REPEATS + 1):
        before = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True, env=environment, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - before)
    return median(times[1:])  # the first one may fill the caches


def test_import(tmp_path):
    empty = clocked("pass", tmp_path)
    hold("import flexmb, in a new process", clocked("import flexmb", tmp_path) - empty, 0.6, "s")


SMALL = """
import flexmb as fm
bob = fm.RigidBody("bob", (1.0, 0.0), mass=1.0, inertia=0.1)
rod = fm.FlexibleLink("rod", (1.0, 0.0), (1.5, 0.0), section=fm.Rectangle(width=0.02, height=0.004),
    material=fm.Material(young=2.1e11, density=7850.0), elements=4)
joints = fm.Revolute("O", fm.GROUND, bob, (0.0, 0.0)), fm.Revolute("P", bob, rod, (1.0, 0.0))
sol = fm.simulate(fm.Mechanism("small", (bob, rod, *joints), gravity=(0.0, -9.81)), t_end=0.1, step=1e-3)
print(float(sol["rod.end.y"][-1]))
"""


def test_first_result_in_a_second_process(tmp_path):
    hold("first result of a small model, second process", clocked(SMALL, tmp_path), 1.5, "s")
