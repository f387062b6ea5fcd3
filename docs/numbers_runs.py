"""The four runs of docs/numbers.md, and what is measured of each; import it after `numbers_live.Build` was made."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from nine_bar_study.statistics import Mean

import flexmb as fm
from flexmb.mechanisms import NineBarData, nine_bar, slider_crank
from flexmb.program.compiler import compile_with_start
from flexmb.run.run import Run

STEEL = fm.Material(young=207e9, poisson=0.3, density=7801.0)
LIGHT, PLAY, BEARING, FALL = 1e-3, 0.5e-3, 10e-3, 0.5
"""Of the light contact: mass [kg], clearance and radius of the bearing [m], time [s]."""

AT_REST = 1e-5
"""Speed below which the light body is at rest [m/s]."""

ARGUMENTS = ("rtol", "atol", "max", "min", "impact_steps")
LAWS = {"normal.least_approach": "normal", "ModifiedCoulomb.v0": "friction", "ModifiedCoulomb.v1": "friction"}


@dataclass(frozen=True)
class Case:
    """A run that is repeated with other numbers.

    Parameters
    ----------
    title : what it is.
    joint : its joint with clearance.
    period : a turn [s].
    skip, keep : turns that are run before, and that count.
    block : so many turns in a row count as one value, since their values go up and down by turns.
    most : steps a turn above which it is given up.
    repeats : runs with the numbers as they are, from starts that differ a little.
    """

    title: str
    joint: str
    period: float
    skip: int
    keep: int
    block: int
    most: int
    repeats: int


CASES = {
    "a": Case("worn slider-crank at 5000 rpm, 0.5 mm", "B", 60.0 / 5000.0, 8, 60, 6, 10_000, 4),
    "b": Case("rigid nine-bar at 2 pi rad/s, 0.05 mm", "P1", 1.0, 4, 16, 2, 60_000, 4),
    "c": Case("flexible nine-bar at 2 pi rad/s, 0.05 mm", "P1", 1.0, 2, 6, 1, 150_000, 3),
    "d": Case("1 g falls 0.5 mm in its bearing and comes to rest", "P", FALL, 0, 1, 1, 200_000, 1),
}


def model(case: str, repeat: int = 0) -> fm.Mechanism:
    """The mechanism of a case; `repeat` moves its start a little."""
    angle = 1e-3 * repeat
    if case == "a":
        return slider_crank(2.0 * math.pi / CASES["a"].period, clearance=0.5e-3, friction="coulomb", start=angle)
    if case in ("b", "c"):
        data = NineBarData(damping=NineBarData.LIGHT_DAMPING)
        return nine_bar(2.0 * math.pi, clearance=0.05e-3, flexible=case == "c", start=(angle, 0.0), data=data)
    return light(0.0)


def light(start: float | str, mass: float = LIGHT) -> fm.Mechanism:
    """A light body whose journal falls in its bearing from `start` above the middle [m], or is seated."""
    law = fm.LankaraniNikravesh.from_materials(STEEL, STEEL, restitution=0.9)
    body = fm.RigidBody("body", (0.0, 0.0), mass, 0.5 * mass * BEARING**2)
    place = start if isinstance(start, str) else (0.0, start)
    options = {"clearance": PLAY, "bearing_radius": BEARING, "normal": law, "start": place}
    friction = fm.ModifiedCoulomb(0.03)
    pin = fm.RevoluteClearance("P", fm.GROUND, body, (0.0, 0.0), friction=friction, **options)
    return fm.Mechanism("light contact", (body, pin), gravity=(0.0, -9.81))


def measured(case: str, changes: Mapping[str, float], repeat: int = 0) -> dict[str, Any]:
    """What a run with the arguments `changes`, by place, says: status, cost, mean and error of each quantity."""
    began = time.process_time()
    found = (_rest if case == "d" else _turns)(case, changes, repeat)
    means = {name: Mean.of(x) for name, x in found.pop("values").items() if len(x) > 1}
    found["values"] = {name: [_short(v) for v in (m.value, m.error, m.effective)] for name, m in means.items()}
    return {**found, "seconds": round(time.process_time() - began, 2)}


def defaults(case: str, mech: fm.Mechanism) -> dict[str, float]:
    """The values that the arguments have where the user gives none."""
    program, _ = compile_with_start(mech)
    step, whole = fm.Adaptive(), CASES[case]
    end = (whole.skip + whole.keep) * whole.period
    run = Run(program, fm.Newmark.generalised_alpha(), step, end, None if case == "d" else whole.period)
    joint = mech.find(whole.joint)
    found = {"rtol": step.rtol, "atol": run.error, "max": run.h_max, "min": run.h_min}
    found = {f"Adaptive.{name}": value for name, value in found.items()}
    found |= {"Adaptive.impact_steps": step.steps_of_an_impact, "generalised_alpha.radius": 0.8}
    for place, law in LAWS.items():
        value = getattr(getattr(joint, law), place.partition(".")[2], None)
        if isinstance(value, float):
            found[place] = value
    return found


def _short(value: float) -> float:
    return float(f"{value:.6g}")


def _given(case: str, mech: fm.Mechanism, changes: Mapping[str, float]) -> tuple[fm.Mechanism, dict[str, Any]]:
    """The mechanism and the arguments of `simulate` with the changed ones."""
    step = {name: changes[f"Adaptive.{name}"] for name in ARGUMENTS if f"Adaptive.{name}" in changes}
    if "impact_steps" in step:
        step["impact_steps"] = max(round(step["impact_steps"]), 1)
    laws = {place: value for place, value in changes.items() if place in LAWS}
    mech = mech.with_({f"{CASES[case].joint}.{LAWS[p]}.{p.partition('.')[2]}": v for p, v in laws.items()})
    radius = changes.get("generalised_alpha.radius", 0.8)
    return mech, {"step": fm.Adaptive(**step), "method": fm.Newmark.generalised_alpha(radius)}


def _turns(case: str, changes: Mapping[str, float], repeat: int) -> dict[str, Any]:
    """Values of each turn of a driven mechanism."""
    whole = CASES[case]
    mech, options = _given(case, model(case, repeat), changes)
    state, kept, steps, found = None, [], 0, None
    for turn in range(1, whole.skip + whole.keep + 1):
        limits = {"t_end": turn * whole.period, "save": "steps", "max_steps": whole.most}
        found = fm.simulate(mech, restart=state, **limits, **options)
        steps += found.stats.steps
        if not found.ok:
            break
        state = found.restart
        if turn > whole.skip:
            kept.append(_turn(found, whole))
    values = {name: _blocks([k[name] for k in kept], whole.block) for name in kept[0]} if kept else {}
    return {"ok": found.ok, "status": found.status, "turns": len(kept), "steps": steps / turn, "values": values}


def _blocks(values: list[float], size: int) -> list[float]:
    """Means of so many values in a row; what is left over at the end is left out."""
    return [sum(values[k : k + size]) / size for k in range(0, len(values) - size + 1, size)]


def _turn(found: fm.Solution, whole: Case) -> dict[str, float]:
    """Values of a turn, weighted by the steps."""
    force, dt = found.array(f"{whole.joint}.normal_force"), np.diff(found.time)
    after, span = force[1:], found.time[-1] - found.time[0]
    return {
        "peak force [N]": float(force.max()),
        "rms force [N]": math.sqrt(after**2 @ dt / span),
        "peak acceleration [m/s2]": float(np.abs(found.array("slider.ax")).max()),
        "flight": float(dt[after == 0.0].sum() / span),
        "impacts": float(((after > 0.0) & (force[:-1] == 0.0)).sum()),
    }


def _rest(case: str, changes: Mapping[str, float], repeat: int) -> dict[str, Any]:
    """Values of the light contact: of falls from heights that differ by micrometres, of seated ones whose mass does."""
    falls = [_fall(light(1e-6 * k), changes) for k in range(8)]
    seated = [_fall(light("seated", LIGHT * (1.0 + 1e-3 * k)), changes) for k in range(4)]
    values = {name: [row["values"][name] for row in falls if row["values"]] for name in FALLEN}
    values |= {f"{name}, seated": [row["values"][name] for row in seated if row["values"]] for name in FALLEN}
    rows = falls + seated
    bad = next((row for row in rows if not row["ok"]), falls[0])
    steps = sum(row["steps"] for row in rows) / len(rows)
    return {"ok": bad["ok"], "status": bad["status"], "turns": len(rows), "steps": steps, "values": values}


FALLEN = (
    "depth",
    "largest depth",
    "time to rest [ms]",
    "impacts",
    "peak force [N]",
    "taken by steps",
    "missing energy",
)


def _fall(mech: fm.Mechanism, changes: Mapping[str, float]) -> dict[str, Any]:
    """A run of the light contact: depths over that at rest, energies over that of the fall; no values if it stopped."""
    mech, options = _given("d", mech, changes)
    found = fm.simulate(mech, t_end=FALL, save="steps", max_steps=CASES["d"].most, **options)
    result = {"ok": found.ok, "status": found.status, "steps": found.stats.steps, "values": {}}
    if found.time[-1] < 0.99 * FALL:
        return result
    depth, force = found.array("P.penetration"), found.array("P.normal_force")
    fast = np.flatnonzero(np.abs(found.array("body.vy")) > AT_REST)
    static, brought = _static_depth(), LIGHT * 9.81 * PLAY
    numbers = (
        depth[-1] / static,
        depth.max() / static,
        1e3 * found.time[fast[-1]] if len(fast) else 0.0,
        ((force[1:] > 0.0) & (force[:-1] == 0.0)).sum(),
        force.max(),
        found.array("energy.dissipated_algorithm")[-1] / brought,
        found.array("energy.residual")[-1] / brought,
    )
    return {**result, "values": dict(zip(FALLEN, map(float, numbers), strict=True))}


def _static_depth() -> float:
    """Depth under the weight [m]."""
    stiffness = light(0.0).find("P").normal.for_radii(BEARING, BEARING - PLAY).stiffness
    return (LIGHT * 9.81 / stiffness) ** (2.0 / 3.0)
