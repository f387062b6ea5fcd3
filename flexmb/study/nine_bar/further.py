"""Claims of sections 5 and 6 of the paper beyond its comparisons of peaks: free flight, order of chaos, slow motion."""

from __future__ import annotations

from collections.abc import Iterator

from flexmb.study.case import PLAY_MODELS
from flexmb.study.claims.evidence import Evidence, Key, ideal
from flexmb.study.claims.finding import Claim, Part, by_rule
from flexmb.study.claims.kinds import Kind, more_so
from flexmb.study.claims.response import contrast, curve_off
from flexmb.study.nine_bar.cases import MACHINE
from flexmb.study.nine_bar.measures import (
    FAST,
    FLIGHT,
    LARGE,
    MIDDLE,
    RESPONSES,
    SLOW,
    SMALL,
    SMALLEST,
    key,
    text_of,
)
from flexmb.study.statistics import HIGHER

ALMOST, FAR = 0.05, 0.2
"""Relative difference to the ideal peak up to which a motion is almost ideal, and above which it is not."""

VISIBLE = 0.1
"""Difference to the ideal velocity over its largest value from which vibrations are visible."""

VELOCITY = ("velocity", "largest ideal velocity")


def flight_grows(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 14: free flight over clearance and speed."""
    for model in PLAY_MODELS:
        for what, more, less in (
            ("0.5 against 0.05 mm", key(model, MIDDLE), key(model, MIDDLE, SMALL)),
            ("2.5 against 0.5 pi rad/s", key(model, FAST), key(model, SLOW)),
        ):
            if seen.has(more, less):
                yield contrast(seen, f"{what}, {model}", more, less, FLIGHT, HIGHER)


def chaos_grows(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 15: exponents of the flexible mechanism over clearance and speed."""
    for more, less in (
        (key("flexible", MIDDLE, SMALL), key("flexible", MIDDLE, SMALLEST)),
        (key("flexible", MIDDLE), key("flexible", MIDDLE, SMALL)),
        (key("flexible", FAST), key("flexible", MIDDLE)),
    ):
        yield from _larger(seen, more, less)


def rigid_is_more_chaotic(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 16: exponents of the rigid against the flexible mechanism."""
    for clearance in (SMALL, LARGE):
        yield from _larger(seen, key("rigid", MIDDLE, clearance), key("flexible", MIDDLE, clearance))


def _larger(seen: Evidence, more: Key, less: Key) -> Iterator[Part]:
    """Part on the larger exponent of one long run; none without both runs."""
    if {more, less} <= set(seen.growths):
        a, b = ((Kind.of(seen.growths[one], MACHINE.joint), text_of(one)) for one in (less, more))
        yield more_so(f"exponent, {b[1]} against {a[1]}", a, b)


def slow_is_almost_ideal(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 17: peaks of the slow flexible mechanism over ideal peaks; velocity slow and fast."""
    slow, fast = key("flexible", SLOW), key("flexible", FAST)
    if seen.has(slow, ideal(SLOW)):
        for measure in RESPONSES:
            ratio = seen.mean(slow, measure).value / seen.peak(SLOW, measure)
            verdict = by_rule(agrees=abs(ratio - 1.0) <= ALMOST, disagrees=abs(ratio - 1.0) > FAR)
            text = f"{ratio:.4g} times the ideal peak"
            yield Part(f"{measure.text}, {text_of(slow)}", verdict, text, {"times": ratio})
        yield curve_off(seen, slow, text_of(slow), "slider.vx", VELOCITY, (ALMOST, FAR))
    if seen.has(fast, ideal(FAST)):
        part = curve_off(seen, fast, f"vibrates, {text_of(fast)}", "slider.vx", VELOCITY, (0.0, 1.0))
        off = part.values["off"]
        verdict = by_rule(agrees=off >= VISIBLE, disagrees=off < 0.5 * VISIBLE)
        yield Part(part.what, verdict, part.numbers, part.values)


FURTHER = (
    Claim(
        14,
        "There is more free flight with the larger clearance, and with the higher speed.",
        "16, 33",
        flight_grows,
        "Rule, for each model: the mean share of free flight at 0.5 mm against 0.05 mm (2 pi rad/s), and at 2.5 pi "
        "against 0.5 pi rad/s (0.5 mm), by `compare`.",
    ),
    Claim(
        15,
        "Chaos of the joint becomes more serious with the clearance and with the speed.",
        "23, 40, section 6",
        chaos_grows,
        "Rule, flexible mechanism: the exponent of the second case is larger by three errors of the difference; it "
        "disagrees if it is smaller by as much. Cases: 0.01, 0.05 and 0.5 mm at 2 pi rad/s; 2 pi and 2.5 pi at 0.5 mm.",
    ),
    Claim(
        16,
        "The path of the shaft is much more chaotic in the rigid than in the flexible mechanism.",
        "16, section 6",
        rigid_is_more_chaotic,
        "Rule, at 2 pi rad/s: the exponent of the rigid mechanism is larger by three errors of the difference; it "
        "disagrees if it is smaller by as much.",
    ),
    Claim(
        17,
        "At 0.5 pi the flexible mechanism with clearance moves almost as the ideal one; at 2.5 pi its slider vibrates.",
        "28-31",
        slow_is_almost_ideal,
        "Rule, at 0.5 mm: peaks agree within 5 % of the ideal ones, and disagree above 20 %; the velocity of the "
        "slider within the same shares of the largest ideal one. It vibrates if it is 10 % off or more, and does not "
        "below 5 %.",
    ),
)
"""Further claims of the paper: number, text, figures, parts, rule."""
