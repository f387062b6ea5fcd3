"""Claims on how large the response is: 1, 2, 4, 5, 6 and 13."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from flexmb.paper.claims.evidence import (
    FAST,
    LARGE,
    MIDDLE,
    PEAKS,
    PLAY_MODELS,
    QUANTITIES,
    RESPONSES,
    SLOW,
    SMALL,
    Evidence,
    Key,
    ideal,
    shown,
)
from flexmb.paper.claims.finding import ASIDE, DISAGREES, Finding, Part, by_rule, expect, finding
from flexmb.paper.statistics import ALIKE, HIGHER, LOWER, compare

OFF_PATH = (0.01, 0.05)
"""Largest difference of the slider's position over its stroke: what is hardly any, and what is much."""

OFF_SPEED = (0.10, 0.25)
"""The same of its velocity over the largest velocity."""

FAR = 2.0
"""So many times as high is far above."""

CASES = ((MIDDLE, SMALL), (MIDDLE, LARGE), (SLOW, LARGE), (FAST, LARGE))
"""Speeds over pi and clearances at which the paper compares rigid and flexible links."""

TORQUES = ("peak.motor1.torque", "peak.motor4.torque")
LAWS = {"coulomb": "friction", "none": "no friction"}


def path_of_slider(seen: Evidence) -> Finding:
    """Claim 1: displacement and velocity of the slider hardly change with clearance.

    Rule, at 2 pi rad/s for each model and clearance, over the shown turns: the displacement agrees if its largest
    difference to the ideal mechanism is at most 1 % of the stroke, and disagrees above 5 %; the velocity agrees up to
    10 % of the largest ideal velocity, and disagrees above 25 %.  Between, it cannot be decided what "hardly" means.
    """
    parts = []
    for model in PLAY_MODELS:
        for clearance in (SMALL, LARGE):
            key = Key(model, MIDDLE, clearance)
            if seen.has(key, ideal(MIDDLE)):
                parts += [_off(seen, key, "slider.x", *OFF_PATH), _off(seen, key, "slider.vx", *OFF_SPEED)]
    return finding(parts)


def _off(seen: Evidence, key: Key, signal: str, little: float, much: float) -> Part:
    """Largest difference to the ideal mechanism, over the range of displacements or the size of velocities."""
    found, pure = seen.motions[key], seen.motions[ideal(key.speed)]
    time, period = pure["time"].values, float(pure.attrs["period"])
    whole = period * max(round((time[-1] - time[0]) / period), 1)  # the turns of both need not have the same numbers
    wanted = np.interp(found["time"].values, time, pure[signal].values, period=whole)
    size = float(np.ptp(wanted) if signal == "slider.x" else np.abs(wanted).max())
    part = float(np.abs(found[signal].values - wanted).max()) / size
    what = "displacement" if signal == "slider.x" else "velocity"
    of = "stroke" if signal == "slider.x" else "largest ideal velocity"
    verdict = by_rule(agrees=part <= little, disagrees=part > much)
    return Part(f"{what}, {key.text}", verdict, f"at most {100 * part:.3g} % of the {of} off", {"off": part})


def far_above(seen: Evidence) -> Finding:
    """Claim 2: peaks of acceleration and torques are far above the ideal mechanism's, and grow from 0.05 to 0.5 mm.

    Rule, at 2 pi rad/s for each model: "far above" agrees if the whole interval of the mean peak over the ideal peak is
    above 2, and disagrees if all of it is below; "grow" is the comparison of the two means (`compare`).
    """
    parts = []
    for model in PLAY_MODELS:
        for quantity in RESPONSES:
            small, large = Key(model, MIDDLE, SMALL), Key(model, MIDDLE, LARGE)
            parts += [_far(seen, key, quantity) for key in (small, large) if seen.has(key, ideal(MIDDLE))]
            if seen.has(small, large):
                parts.append(_contrast(seen, f"growth with clearance, {model}", large, small, quantity, HIGHER))
    return finding(parts)


def _far(seen: Evidence, key: Key, quantity: str) -> Part:
    mean, pure = seen.mean(key, quantity), float(seen.motions[ideal(key.speed)][quantity].values.max())
    low, high = (mean.value - mean.interval) / pure, (mean.value + mean.interval) / pure
    text = f"{shown(mean, quantity)}, {mean.value / pure:.3g} times the ideal peak"
    verdict = by_rule(agrees=low > FAR, disagrees=high < FAR)
    return Part(f"{QUANTITIES[quantity][0]}, {key.text}", verdict, text, {"times": mean.value / pure})


def _contrast(seen: Evidence, where: str, first: Key, second: Key, quantity: str, wanted: str) -> Part:
    """A quantity of one case against that of another, and what a claim wants of it."""
    a, b = seen.mean(first, quantity), seen.mean(second, quantity)
    found = compare(a, b)
    text = f"{shown(a, quantity)} against {shown(b, quantity)}, ratio {found.shown}: {found.verdict}"
    values = {"first": a.value, "second": b.value, "ratio": found.ratio, "low": found.low, "high": found.high}
    return Part(f"{QUANTITIES[quantity][0]}, {where}", expect(found, wanted), text, values)


def force_grows(seen: Evidence) -> Finding:
    """Claim 4: peaks of the contact force grow with clearance and with speed.

    Rule, for each model: the mean peak at 0.5 mm against that at 0.05 mm (2 pi rad/s), and each speed of the paper at
    0.5 mm against the slower one, by `compare`.
    """
    parts = []
    for model in PLAY_MODELS:
        small, large = Key(model, MIDDLE, SMALL), Key(model, MIDDLE, LARGE)
        if seen.has(small, large):
            parts.append(_contrast(seen, f"0.5 against 0.05 mm, {model}", large, small, PEAKS[0], HIGHER))
        there = [speed for speed in (SLOW, MIDDLE, FAST) if seen.has(Key(model, speed))]
        for slow, fast in itertools.pairwise(there):
            where = f"{fast:g} against {slow:g} pi rad/s, {model}"
            parts.append(_contrast(seen, where, Key(model, fast), Key(model, slow), PEAKS[0], HIGHER))
    return finding(parts)


def flexible_softens(seen: Evidence) -> Finding:
    """Claim 5: flexible links lower the peaks of contact force, slider acceleration and torques.

    Rule, for each case and quantity: the mean peak of the flexible mechanism against that of the rigid one, by
    `compare`.  Where the rigid peak is within 5 % of the ideal one there is nothing to lower, and the part is not
    counted, unless the flexible one is higher.
    """
    parts = []
    for rigid, flexible in _pairs(seen):
        for quantity in PEAKS:
            part = _contrast(seen, _where(rigid), flexible, rigid, quantity, LOWER)
            if seen.has(ideal(rigid.speed)):
                pure = float(seen.motions[ideal(rigid.speed)][quantity].values.max())
                near = abs(seen.mean(rigid, quantity).value - pure) <= ALIKE * pure
                if near and not part.numbers.endswith(HIGHER):
                    text = f"{part.numbers}; nothing to lower, the ideal peak is {pure:.4g}"
                    part = Part(part.what, ASIDE, text, part.values)
            parts.append(part)
    return finding(parts)


def flexible_holds_on(seen: Evidence) -> Finding:
    """Claim 6: flexible links shorten free flight and lower the penetration.

    Rule, for each case: share of free flight and largest penetration of a turn, flexible against rigid, by `compare`.
    Where neither mechanism flies there is nothing to shorten, and the case is not counted.
    """
    parts = []
    for rigid, flexible in _pairs(seen):
        aloft = max(seen.mean(key, "flight").value for key in (rigid, flexible)) > 0.0
        for quantity in ("flight", "penetration"):
            part = _contrast(seen, _where(rigid), flexible, rigid, quantity, LOWER)
            parts.append(part if aloft else Part(part.what, ASIDE, f"{part.numbers}; no flight", part.values))
        part = _contrast(seen, _where(rigid), flexible, rigid, "landings", LOWER)
        parts.append(Part(part.what, ASIDE, part.numbers, part.values))
    return finding(parts)


def _pairs(seen: Evidence) -> Iterator[tuple[Key, Key]]:
    """Rigid and flexible at each case of the paper for which there are both."""
    for speed, clearance in CASES:
        rigid, flexible = Key("rigid", speed, clearance), Key("flexible", speed, clearance)
        if seen.has(rigid, flexible):
            yield rigid, flexible


def _where(key: Key) -> str:
    return f"{key.speed:g} pi rad/s, {1e3 * key.clearance:g} mm"


def torque_rises(seen: Evidence) -> Finding:
    """Claim 13: torque peaks rise with the driving speed, rigid and flexible, with and without friction.

    Rule, at 0.5 mm for each model, friction and torque.  What the paper shows: the mean at 2.5 pi rad/s against that at
    0.5 pi, by `compare`.  Rising all the way: the means at neighbouring speeds are compared; it agrees if none is lower
    than the one before and the fastest is higher than the slowest, disagrees if one is lower or if the fastest equals
    the slowest, and cannot be decided otherwise.  Beside it, not counted, the ideal mechanism.
    """
    parts = []
    for model, law in ((model, law) for model in PLAY_MODELS for law in ("coulomb", "none")):
        speeds = seen.speeds(model, law)
        for quantity in TORQUES:
            if {SLOW, FAST} <= set(speeds):
                keys = Key(model, FAST, LARGE, law), Key(model, SLOW, LARGE, law)
                parts.append(
                    _contrast(seen, f"2.5 against 0.5 pi rad/s, {model}, {LAWS[law]}", *keys, quantity, HIGHER)
                )
            if len(speeds) > 2:
                parts.append(_rise(seen, model, law, speeds, quantity))
    pure = sorted(key.speed for key in seen.motions if key.model == "ideal")
    for quantity in TORQUES if len(pure) > 1 else ():
        peaks = [float(seen.motions[ideal(speed)][quantity].values.max()) for speed in pure]
        parts.append(Part(f"{QUANTITIES[quantity][0]}, all the way, ideal", ASIDE, _listed(pure, peaks)))
    return finding(parts)


def _rise(seen: Evidence, model: str, law: str, speeds: list[float], quantity: str) -> Part:
    means = [seen.mean(Key(model, speed, LARGE, law), quantity) for speed in speeds]
    falls = [
        f"{speeds[k]:g} to {speeds[k + 1]:g} pi"
        for k in range(len(means) - 1)
        if compare(means[k + 1], means[k]).verdict == LOWER
    ]
    whole = expect(compare(means[-1], means[0]), HIGHER)
    text = _listed(speeds, [mean.value for mean in means])
    text += f"; falls from {', '.join(falls)} rad/s" if falls else ""
    values = {f"{speed:g}pi": mean.value for speed, mean in zip(speeds, means, strict=True)}
    what = f"{QUANTITIES[quantity][0]}, all the way over {len(speeds)} speeds, {model}, {LAWS[law]}"
    return Part(what, DISAGREES if falls else whole, text, values)


def _listed(speeds: list[float], torques: list[float]) -> str:
    values = ", ".join(f"{torque:.3g}" for torque in torques)
    return f"{values} N m at {', '.join(f'{speed:g}' for speed in speeds)} pi rad/s"
