"""A motion with tangent vectors from point to point, and the record of what they grew by."""

from __future__ import annotations

import numpy as np

from flexmb.dynamics.exponents.exponents import SETTLING, Exponents, Growth
from flexmb.dynamics.exponents.lasting_contact import lasting
from flexmb.dynamics.exponents.schedule import Schedule
from flexmb.dynamics.sections.seen import Seen
from flexmb.dynamics.systems.as_dynamics import clock
from flexmb.jobs.progress import ProgressBar


def carried(plan: Schedule, count: int, seed: int, *, shown: bool) -> Exponents:
    """The exponents of a run with `count` tangent vectors that start in random directions, without a verdict.

    Parameters
    ----------
    plan : when the system is looked at.
    count : number of vectors.
    seed : of their directions.
    shown : whether a progress bar is.
    """
    weights, growth, points = plan.system.weights, Growth(), [np.zeros((0, len(plan.system.names)))]
    progress = ProgressBar(plan.system.name, float(plan.skip + plan.count), shown=shown, of="periods")
    W, began = np.zeros((0, count)), clock(plan.system)
    for number in range(1, plan.skip + plan.count + 1):
        if number == plan.skip + 1:
            W = plan.system.tangent_basis(count, seed)
        began, before = counting(plan, number, began), clock(plan.system)
        logs = plan.one_period(number, W if number > plan.skip else None, weights)
        if logs is None:
            break
        progress.update(1)
        if number > plan.skip:
            points.append(plan.system.observe()[None])
        if number > plan.skip + plan.count // SETTLING:
            growth.logs.append(logs)
            growth.times.append(clock(plan.system) - before)
    progress.close()
    return recorded(plan, growth, began, count, np.concatenate(points))


def counting(plan: Schedule, number: int, began: float) -> float:
    """When counting begins: now, if this is the first period that counts; else `began`.

    Parameters
    ----------
    plan : when the system is looked at.
    number : of the period that comes.
    began : when it began as far as is known.
    """
    return clock(plan.system) if number == plan.skip + plan.count // SETTLING + 1 else began


def recorded(plan: Schedule, growth: Growth, began: float, count: int, points: np.ndarray) -> Exponents:
    """What was found, without a verdict.

    Parameters
    ----------
    plan : when the system was looked at.
    growth : what was measured.
    began : when counting began.
    count : number of exponents.
    points : (n, signals) where the system was.
    """
    system, wanted = plan.system, plan.count - plan.count // SETTLING
    ok = len(growth.times) == wanted
    unit = "1/s" if plan.is_flow or system.unit == "crossings" else "1/iteration"
    status = f"Mean of {wanted} {'points' if plan.is_flow else system.unit}." if ok else plan.trouble or system.status
    if ok:
        status = " ".join([status, *lasting(system, began)])
    period = float(np.mean(growth.times)) if plan.is_section and unit == "1/s" and growth.times else float("nan")
    about = {"name": system.name, "unit": unit, "ok": ok, "status": status, "points": points, "seen": Seen.of(system)}
    return growth.record(began, count, period=period, **about)
