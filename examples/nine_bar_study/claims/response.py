"""Parts of claims on the size of the response: differences to the ideal mechanism, ratios of means."""

from __future__ import annotations

import numpy as np
from nine_bar_study.claims.evidence import Evidence, Key, Measure, ideal
from nine_bar_study.claims.finding import ASIDE, Part, by_rule, expect
from nine_bar_study.statistics import ALIKE, HIGHER, LOWER, compare


def curve_off(
    seen: Evidence, key: Key, where: str, signal: str, names: tuple[str, str], limits: tuple[float, float]
) -> Part:
    """Part on the largest difference of a signal to the ideal mechanism, over the range or the largest ideal value.

    Parameters
    ----------
    seen, key : evidence, and key of the case.
    where : text of the case.
    signal : name of the signal.
    names : text of the signal, and text of the reference size: "stroke" for the range, any other text for the largest
        absolute value.
    limits : relative difference up to which the part agrees, and above which the part disagrees.
    """
    found, pure = seen.motions[key], seen.motions[ideal(key.speed)]
    time, period = pure["time"].values, float(pure.attrs["period"])
    whole = period * max(round((time[-1] - time[0]) / period), 1)  # the turns of both need not have the same numbers
    wanted = np.interp(found["time"].values, time, pure[signal].values, period=whole)
    size = float(np.ptp(wanted) if names[1] == "stroke" else np.abs(wanted).max())
    part = float(np.abs(found[signal].values - wanted).max()) / size
    verdict = by_rule(agrees=part <= limits[0], disagrees=part > limits[1])
    return Part(f"{names[0]}, {where}", verdict, f"at most {100 * part:.3g} % of the {names[1]} off", {"off": part})


def times_ideal(seen: Evidence, key: Key, where: str, measure: Measure, least: float) -> Part:
    """Part of a claim that the mean peak exceeds `least` ideal peaks, with the whole interval of the mean."""
    mean, pure = seen.mean(key, measure), seen.peak(key.speed, measure)
    low, high = (mean.value - mean.interval) / pure, (mean.value + mean.interval) / pure
    text = f"{measure.shown(mean)}, {mean.value / pure:.3g} times the ideal peak"
    verdict = by_rule(agrees=low > least, disagrees=high < least)
    return Part(f"{measure.text}, {where}", verdict, text, {"times": mean.value / pure})


def contrast(seen: Evidence, where: str, first: Key, second: Key, measure: Measure, wanted: str) -> Part:
    """Part of a claim that the mean of a measure in the first case is HIGHER or LOWER than in the second."""
    a, b = seen.mean(first, measure), seen.mean(second, measure)
    found = compare(a, b)
    text = f"{measure.shown(a)} against {measure.shown(b)}, ratio {found.shown}: {found.verdict}"
    values = {"first": a.value, "second": b.value, "ratio": found.ratio, "low": found.low, "high": found.high}
    return Part(f"{measure.text}, {where}", expect(found, wanted), text, values)


def softened(seen: Evidence, where: str, flexible: Key, rigid: Key, measure: Measure) -> Part:
    """Part of a claim that the mean of the flexible mechanism is lower than the mean of the rigid mechanism.

    The part is not counted if the rigid mean is within 5 % of the ideal peak and the flexible mean is not higher.
    """
    part = contrast(seen, where, flexible, rigid, measure, LOWER)
    if not seen.has(ideal(rigid.speed)):
        return part
    pure = seen.peak(rigid.speed, measure)
    near = abs(seen.mean(rigid, measure).value - pure) <= ALIKE * pure
    if not near or part.numbers.endswith(HIGHER):
        return part
    text = f"{part.numbers}; nothing to lower, the ideal peak is {pure:.4g}"
    return Part(part.what, ASIDE, text, part.values)


def equals(what: str, found: float, wanted: float, unit: str, near: float) -> Part:
    """Part of a claim that a number equals a reference number.

    Parameters
    ----------
    what : name of the number.
    found, wanted : number and reference number [unit].
    unit : unit of both numbers.
    near : relative difference up to which the part agrees; above 3 `near` the part disagrees.
    """
    off = abs(found - wanted) / abs(wanted)
    text = f"{found:.6g} against {wanted:.6g} {unit}".rstrip() + f", {100.0 * off:.2g} % off"
    verdict = by_rule(agrees=off <= near, disagrees=off > 3.0 * near)
    return Part(what, verdict, text, {"found": found, "wanted": wanted})
