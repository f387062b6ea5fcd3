"""Claims of sections 5 and 6 of the paper beyond its comparisons of peaks: free flight, order of chaos, slow motion."""

from __future__ import annotations

from collections.abc import Iterator

from nine_bar_study.case import PLAY_MODELS
from nine_bar_study.claims.evidence import Evidence, Key, ideal
from nine_bar_study.claims.finding import Claim, Part, by_rule
from nine_bar_study.claims.kinds import Kind, more_so
from nine_bar_study.claims.response import contrast, curve_off
from nine_bar_study.nine_bar import measures as at
from nine_bar_study.nine_bar.cases import MACHINE
from nine_bar_study.nine_bar.measures import key
from nine_bar_study.statistics import HIGHER

ALMOST, VISIBLE, FAR = 0.05, 0.1, 0.2
"""Relative differences to the ideal mechanism: almost ideal up to, visible from, far above."""

PLAYS = tuple(key("flexible", at.MIDDLE, clearance) for clearance in (at.SMALLEST, at.SMALL, at.LARGE))
STIFF = tuple(key("rigid", at.MIDDLE, clearance) for clearance in (at.SMALL, at.LARGE))
FASTER = ((PLAYS[1], PLAYS[0]), (PLAYS[2], PLAYS[1]), (key("flexible", at.FAST), PLAYS[2]))
"""Pairs of cases of claim 15, the more chaotic first."""


def flight_grows(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 14: free flight over clearance and speed."""
    for model in PLAY_MODELS:
        large, small = key(model, at.MIDDLE), key(model, at.MIDDLE, at.SMALL)
        fast, slow = key(model, at.FAST), key(model, at.SLOW)
        if seen.has(large, small):
            yield contrast(seen, f"0.5 against 0.05 mm, {model}", large, small, at.FLIGHT, HIGHER)
        if seen.has(fast, slow):
            yield contrast(seen, f"2.5 against 0.5 pi rad/s, {model}", fast, slow, at.FLIGHT, HIGHER)


def more_chaotic(seen: Evidence, pairs: tuple[tuple[Key, Key], ...]) -> Iterator[Part]:
    """Parts on a larger exponent of the first case of each pair with long runs."""
    for pair in pairs:
        if set(pair) <= set(seen.growths):
            more, less = ((Kind.of(seen.growths[one], MACHINE.joint), at.text_of(one)) for one in pair)
            yield more_so(f"exponent, {more[1]} against {less[1]}", less, more)


def slow_is_almost_ideal(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 17: peaks and velocity of the slow flexible mechanism, velocity of the fast one."""
    slow, fast, name = key("flexible", at.SLOW), key("flexible", at.FAST), ("velocity", "largest ideal velocity")
    if seen.has(slow, ideal(at.SLOW)):
        for measure in at.RESPONSES:
            ratio = seen.mean(slow, measure).value / seen.peak(at.SLOW, measure)
            verdict = by_rule(agrees=abs(ratio - 1.0) <= ALMOST, disagrees=abs(ratio - 1.0) > FAR)
            text = f"{ratio:.4g} times the ideal peak"
            yield Part(f"{measure.text}, {at.text_of(slow)}", verdict, text, {"times": ratio})
        yield curve_off(seen, slow, at.text_of(slow), "slider.vx", name, (ALMOST, FAR))
    if seen.has(fast, ideal(at.FAST)):
        part = curve_off(seen, fast, f"vibrates, {at.text_of(fast)}", "slider.vx", name, (0.0, 1.0))
        verdict = by_rule(agrees=part.values["off"] >= VISIBLE, disagrees=part.values["off"] < ALMOST)
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
        lambda seen: more_chaotic(seen, FASTER),
        "Rule, flexible mechanism: the exponent of the second case is larger by three errors of the difference; it "
        "disagrees if it is smaller by as much. Cases: 0.01, 0.05 and 0.5 mm at 2 pi rad/s; 2 pi and 2.5 pi at 0.5 mm.",
    ),
    Claim(
        16,
        "The path of the shaft is much more chaotic in the rigid than in the flexible mechanism.",
        "16, section 6",
        lambda seen: more_chaotic(seen, tuple(zip(STIFF, PLAYS[1:], strict=True))),
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
