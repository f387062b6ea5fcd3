"""Table of the claims of the paper: parts, measures, rules."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping

import numpy as np
from nine_bar_study.case import PLAY_MODELS
from nine_bar_study.claims.coincidence import coinciding, equal_landings, same_times
from nine_bar_study.claims.evidence import Evidence, Key, ideal
from nine_bar_study.claims.finding import ASIDE, Claim, Part
from nine_bar_study.claims.kinds import (
    ROUNDING,
    Kind,
    all_of,
    instead,
    is_chaotic,
    kinds_of,
    more_so,
    one_point,
    one_point_through,
    unbroken,
)
from nine_bar_study.claims.response import contrast, curve_off, softened, times_ideal
from nine_bar_study.nine_bar.cases import MACHINE
from nine_bar_study.nine_bar.further import FURTHER
from nine_bar_study.nine_bar.measures import (
    CASES,
    DEPTH,
    FAST,
    FIRST_CHAOTIC,
    FLIGHT,
    FORCE,
    LANDINGS,
    LARGE,
    LAST_PERIODIC,
    MIDDLE,
    NEAREST,
    PEAKS,
    RESPONSES,
    SLOW,
    SMALL,
    SMALLEST,
    TORQUES,
    key,
    text_of,
)
from nine_bar_study.statistics import HIGHER, LOWER

LITTLE_AND_MUCH = {"slider.x": (0.01, 0.05), "slider.vx": (0.10, 0.25)}
"""Relative differences to the ideal mechanism up to which claim 1 agrees, and above which it disagrees, by signal."""

CURVES = {"slider.x": ("displacement", "stroke"), "slider.vx": ("velocity", "largest ideal velocity")}

FAR = 2.0
"""Least ratio of a mean peak to the ideal peak in claim 2."""

CLOUD = 1e-7
"""Least range of the section points of the slider that is counted [m]."""


def at_middle(seen: Evidence) -> Iterator[Key]:
    """Keys of both models and clearances at 2 pi rad/s with settled turns."""
    keys = (key(model, MIDDLE, clearance) for model in PLAY_MODELS for clearance in (SMALL, LARGE))
    return (one for one in keys if seen.has(one))


def pairs(seen: Evidence) -> Iterator[tuple[Key, Key, str]]:
    """Keys of the rigid and the flexible mechanism, and text of the case, for each published case with both."""
    for speed, clearance in CASES:
        rigid, flexible = key("rigid", speed, clearance), key("flexible", speed, clearance)
        if seen.has(rigid, flexible):
            yield rigid, flexible, f"{speed:g} pi rad/s, {1e3 * clearance:g} mm"


def path_of_slider(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 1: displacement and velocity of the slider against the ideal mechanism."""
    for one in at_middle(seen):
        if seen.has(ideal(MIDDLE)):
            for signal, names in CURVES.items():
                yield curve_off(seen, one, text_of(one), signal, names, LITTLE_AND_MUCH[signal])


def far_above(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 2: peaks against the ideal mechanism, growth of peaks with the clearance."""
    for model, measure in itertools.product(PLAY_MODELS, RESPONSES):
        small, large = key(model, MIDDLE, SMALL), key(model, MIDDLE, LARGE)
        for one in (small, large):
            if seen.has(one, ideal(MIDDLE)):
                yield times_ideal(seen, one, text_of(one), measure, FAR)
        if seen.has(small, large):
            yield contrast(seen, f"growth with clearance, {model}", large, small, measure, HIGHER)


def peaks_coincide(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 3: coincidence of the peaks of acceleration and torques with peaks of the contact force."""
    for one, measure in itertools.product(at_middle(seen), RESPONSES):
        yield coinciding(seen.motions[one], f"{measure.text}, {text_of(one)}", measure.signal, FORCE.signal)


def force_grows(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 4: growth of the contact force with clearance and speed."""
    for model in PLAY_MODELS:
        small, large = key(model, MIDDLE, SMALL), key(model, MIDDLE, LARGE)
        if seen.has(small, large):
            yield contrast(seen, f"0.5 against 0.05 mm, {model}", large, small, FORCE, HIGHER)
        there = [speed for speed in (SLOW, MIDDLE, FAST) if seen.has(key(model, speed))]
        for slow, fast in itertools.pairwise(there):
            where = f"{fast:g} against {slow:g} pi rad/s, {model}"
            yield contrast(seen, where, key(model, fast), key(model, slow), FORCE, HIGHER)


def flexible_softens(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 5: peaks of the flexible against the rigid mechanism."""
    for (rigid, flexible, where), measure in itertools.product(pairs(seen), PEAKS):
        yield softened(seen, where, flexible, rigid, measure)


def flexible_holds_on(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 6: free flight and penetration of the flexible against the rigid mechanism."""
    for rigid, flexible, where in pairs(seen):
        aloft = max(seen.mean(one, FLIGHT).value for one in (rigid, flexible)) > 0.0
        for measure in (FLIGHT, DEPTH):
            part = contrast(seen, where, flexible, rigid, measure, LOWER)
            yield part if aloft else Part(part.what, ASIDE, f"{part.numbers}; no flight", part.values)
        yield contrast(seen, where, flexible, rigid, LANDINGS, LOWER).aside


def chaotic_joint(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 7: chaos in the joint at 2 pi rad/s."""
    growths = seen.growths
    models = [m for m in ("flexible", "rigid") if any(k.model == m and k.speed == MIDDLE for k in growths)]
    for number, model in enumerate(models):
        small, large = key(model, MIDDLE, SMALL), key(model, MIDDLE, LARGE)
        found = [is_chaotic(growths, one, text_of(one), MACHINE.joint) for one in (small, large)]
        if small in growths and large in growths:
            a, b = (Kind.of(growths[one], MACHINE.joint) for one in (small, large))
            found.append(more_so(f"more so at 0.5 mm, {model}", (a, "0.05 mm"), (b, "0.5 mm")))
        yield from found if number == 0 else (part.beside for part in found)


def slow_is_periodic(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 8: unbroken contact and one section point at 0.5 pi rad/s."""
    for one in (key("flexible", SLOW), key("rigid", SLOW)):
        if seen.has(one):
            yield unbroken(seen.motions[one], text_of(one))
        if one in seen.growths:
            yield one_point(seen.growths[one], text_of(one), MACHINE.joint, one.clearance)


def _flexible_decides(model: str, found: list[Part]) -> Iterator[Part]:
    """Parts of a claim; the parts of the rigid mechanism are not counted."""
    yield from found if model == "flexible" else (part.beside for part in found)


def threshold_of_chaos(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 9: periodic and chaotic motions over the speed."""
    for model in ("flexible", "rigid"):
        kinds = _over_speed(seen, model)
        if not kinds:
            continue
        below = [item for item in kinds if item[0] <= LAST_PERIODIC + ROUNDING]
        above = [item for item in kinds if item[0] >= FIRST_CHAOTIC - ROUNDING]
        found = [
            all_of(f"periodic up to 1.6 pi rad/s, {model}", below, MACHINE.unit, chaotic=False),
            all_of(f"chaotic from 1.65 pi rad/s on, {model}", above, MACHINE.unit, chaotic=True),
        ]
        yield from _flexible_decides(model, found)


def _over_speed(seen: Evidence, model: str) -> list[tuple[float, Kind]]:
    """Speeds over pi [rad/s], ascending, with the kinds of motion of a model from the diagram and from long runs.

    A long run replaces the value of the diagram.  Without a diagram there are the long runs alone, if there is one on
    each side of the threshold.
    """
    growths = {one.speed: data for one, data in seen.growths.items() if one[::2] == (model, LARGE)}
    long = {speed: Kind.of(data, MACHINE.joint) for speed, data in growths.items()}
    if ("speed", model) in seen.diagrams:
        found = kinds_of(seen.diagrams["speed", model], "speed", MACHINE.joint)
        return [(value / math.pi, instead(kind, value / math.pi, long)) for value, kind in found]
    return sorted(long.items()) if set(NEAREST) <= set(long) else []


def chaos_by_clearance(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 10: periodic and chaotic motions over the clearance."""
    for model in ("flexible", "rigid"):
        kinds = _over_clearance(seen, model)
        if not kinds:
            continue
        periodic, chaotic = (sum(getattr(kind, name) for _, kind in kinds) for name in ("periodic", "chaotic"))
        found = [
            all_of(f"periodic at {kinds[0][0]:.3g} mm, {model}", kinds[:1], "mm", chaotic=False),
            all_of(f"chaotic at {kinds[-1][0]:.3g} mm, {model}", kinds[-1:], "mm", chaotic=True),
        ]
        text = f"{periodic} periodic, {chaotic} chaotic, {len(kinds) - periodic - chaotic} open of {len(kinds)} values"
        yield from _flexible_decides(model, found)
        yield Part(f"all clearances, {model}", ASIDE, text, {"periodic": periodic, "chaotic": chaotic})


def _over_clearance(seen: Evidence, model: str) -> list[tuple[float, Kind]]:
    """Clearances [mm], ascending, with the kinds of motion of a model from the diagram and from long runs.

    A long run replaces the value of the diagram.  Without a diagram the clearances are the smallest and the largest.
    """
    growths = {one.clearance: data for one, data in seen.growths.items() if one[:2] == (model, MIDDLE)}
    long: Mapping[float, Kind] = {value: Kind.of(data, MACHINE.joint) for value, data in growths.items()}
    if ("clearance", model) in seen.diagrams:
        found = kinds_of(seen.diagrams["clearance", model], "clearance", MACHINE.joint)
        return [(1e3 * value, instead(kind, value, long)) for value, kind in found]
    if not {SMALLEST, LARGE} <= set(long):
        return []
    return [(1e3 * value, long[value]) for value in (SMALLEST, LARGE)]


def slider_is_one_point(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 11: sections of the slider."""
    for speed, clearance in CASES:
        keys = [key(model, speed, clearance) for model in ("flexible", "rigid")]
        for one in [one for one in keys if one in seen.growths][:1]:
            yield one_point_through(seen, one, text_of(one), "slider.x")
    for (parameter, model), diagram in sorted(seen.diagrams.items()):
        if model == "flexible" and "slider.x" in diagram:
            sizes = np.ptp(diagram["slider.x"].values, axis=1)
            k = int(np.nanargmax(sizes))
            value = float(diagram[parameter].values[k])
            at = f"{value / math.pi:.4g} pi rad/s" if parameter == "speed" else f"{1e3 * value:.3g} mm"
            many = f"{int((sizes > CLOUD).sum())} of {len(sizes)} above 0.1 um"
            text = f"largest cloud {1e6 * sizes[k]:.3g} um at {at}; {many}"
            yield Part(f"diagram over the {parameter}", ASIDE, text, {"cloud": float(sizes[k])})


def friction_laws(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 12: impact times and peaks with both friction laws."""
    coulomb, lugre = key("rigid", FAST), key("rigid", FAST, LARGE, "lugre")
    if coulomb in seen.starts and lugre in seen.starts:
        first, second = seen.starts[coulomb], seen.starts[lugre]
        yield same_times("first turn", FORCE.signal, second, first)
        yield equal_landings(first, second)
    if not seen.has(coulomb, lugre):
        return
    first, second = seen.motions[coulomb], seen.motions[lugre]
    yield same_times("settled turn", FORCE.signal, second, first)
    yield same_times("control: a turn of Coulomb against the one before", FORCE.signal, first, first, (1, 0)).beside
    for measure in RESPONSES:
        part = contrast(seen, "LuGre against Coulomb", lugre, coulomb, measure, HIGHER)
        yield Part(part.what, part.verdict, part.numbers, {"ratio": part.values["ratio"]})


def torque_rises(seen: Evidence) -> Iterator[Part]:
    """Parts of claim 13: torques at both speeds of the paper."""
    for model, law in itertools.product(PLAY_MODELS, ("coulomb", "none")):
        ends = key(model, FAST, LARGE, law), key(model, SLOW, LARGE, law)
        where = f"{model}, {'friction' if law == 'coulomb' else 'no friction'}"
        for measure in TORQUES if seen.has(*ends) else ():
            yield contrast(seen, f"2.5 against 0.5 pi rad/s, {where}", *ends, measure, HIGHER)


CLAIMS = (
    Claim(
        1,
        "Slider displacement and velocity hardly change with clearance.",
        "9, 10",
        path_of_slider,
        "Rule, at 2 pi rad/s for each model and clearance, over the shown turns: the displacement agrees if its "
        "largest difference to the ideal mechanism is at most 1 % of the stroke, and disagrees above 5 %; the "
        "velocity agrees up to 10 % of the largest ideal velocity, and disagrees above 25 %. Between, it cannot "
        'be decided what "hardly" means.',
    ),
    Claim(
        2,
        "Peaks of slider acceleration and of both torques are far above the ideal mechanism's, and grow from 0.05 "
        "to 0.5 mm.",
        "11-13",
        far_above,
        'Rule, at 2 pi rad/s for each model: "far above" agrees if the whole interval of the mean peak over the '
        'ideal peak is above 2, and disagrees if all of it is below; "grow" is the comparison of the two means '
        "(`compare`).",
    ),
    Claim(
        3,
        "Peaks of acceleration and torque occur at the times of the peaks of the contact force.",
        "11-14",
        peaks_coincide,
        "Rule, at 2 pi rad/s for each model and clearance, over all settled turns together: peaks are maxima of at "
        "least half of the largest one of their turn, and coincide within 0.5 % of a turn. It agrees if at least "
        "80 % of the peaks of the response lie at a peak of the force, which chance does in less than one case of "
        "1000. It disagrees if less than 50 % do, or no more than chance would have it (probability above 5 %, where "
        "chance would not reach half of them anyway).",
    ),
    Claim(
        4,
        "Peaks of the contact force grow with clearance and with speed.",
        "14, 32",
        force_grows,
        "Rule, for each model: the mean peak at 0.5 mm against that at 0.05 mm (2 pi rad/s), and each speed of "
        "the paper at 0.5 mm against the slower one, by `compare`.",
    ),
    Claim(
        5,
        "Flexible links lower the peaks of contact force, slider acceleration and torques.",
        "11-14, 29-32",
        flexible_softens,
        "Rule, for each case and quantity: the mean peak of the flexible mechanism against that of the rigid one, "
        "by `compare`. Where the rigid peak is within 5 % of the ideal one there is nothing to lower, and the "
        "part is not counted, unless the flexible one is higher.",
    ),
    Claim(
        6,
        "Flexible links shorten free flight and lower the penetration.",
        "15, 16, 33",
        flexible_holds_on,
        "Rule, for each case: share of free flight and largest penetration of a turn, flexible against rigid, by "
        "`compare`. Where neither mechanism flies there is nothing to shorten, and the case is not counted.",
    ),
    Claim(
        7,
        "At 2 pi the joint is chaotic at 0.05 and at 0.5 mm, more so at 0.5 mm.",
        "17-23",
        chaotic_joint,
        "Rule, flexible mechanism (the rigid one is shown beside it; where there are exponents of the rigid one "
        "alone, it decides): chaotic is what is called so and has an exponent three errors above zero; it "
        "disagrees if the motion is called periodic, since its points return, with an exponent that is not above "
        'zero by three errors. "More so" agrees if the exponent at 0.5 mm is larger by three errors of the '
        "difference, and disagrees if it is smaller by as much.",
    ),
    Claim(
        8,
        "At 0.5 pi and 0.5 mm contact is unbroken, the phase curve closes and the Poincare map is one point.",
        "33-37",
        slow_is_periodic,
        "Rule, for each model: contact agrees if no settled turn has any free flight, and disagrees if every turn "
        "has; the map agrees if the motion is called periodic-1 through both coordinates of the joint, its points "
        "lie within a thousandth of the clearance and the exponent is not above zero by three errors; it "
        "disagrees if it is called otherwise with an exponent three errors above zero, or periodic of a longer "
        "period.",
    ),
    Claim(
        9,
        "Over the speed the joint is periodic up to 1.6 pi and chaotic from 1.65 pi on.",
        "40",
        threshold_of_chaos,
        "Rule, flexible mechanism (the rigid one is shown beside it), 0.5 mm. Up to 1.6 pi it agrees if every "
        "value is periodic in the sense of claim 7, and disagrees if one is chaotic in that sense. From 1.65 pi "
        "on it agrees if every value is chaotic, and disagrees if one is periodic. Where there is a longer run, "
        "with default steps, it stands in for the point of the diagram.",
    ),
    Claim(
        10,
        "Over the clearance the joint goes from periodic to chaotic between 0.01 and 0.5 mm.",
        "23",
        chaos_by_clearance,
        "Rule, flexible mechanism (the rigid one is shown beside it): the smallest value must be called periodic "
        "and the largest chaotic, in the sense of claims 7 and 9; it disagrees where one of them is the opposite. "
        "Longer runs stand in for points of the diagram, as there.",
    ),
    Claim(
        11,
        "The slider's Poincare map stays one point in all runs.",
        "25, 27, 42, 44",
        slider_is_one_point,
        "Rule, for each case, flexible where there is one: it agrees if the motion is called periodic-1 through "
        "the position of the slider alone, and disagrees if it is called chaotic, quasi-periodic or periodic of a "
        "longer period through it, which are more points than one. The size of the cloud of points is given "
        "beside the stroke: on the scale of the stroke any of them may look like one point. So is the 0-1 test of "
        "the points alone (near 1 chaotic, near 0 regular), which knows nothing of the system's exponent.",
    ),
    Claim(
        12,
        "Modified Coulomb and LuGre give the same impact times; the peaks with LuGre are higher.",
        "6-8",
        friction_laws,
        "Rule, rigid, 2.5 pi rad/s, 0.5 mm. Impact times: the peaks of the contact force of one law lie at those "
        "of the other, by the rule of claim 3, in the first turn after the same start, and in the shown settled "
        "turns. Peaks: means of acceleration and torques with LuGre against modified Coulomb, by `compare`. "
        "Beside it, not counted: the same coincidence of two successive turns of modified Coulomb, which shows "
        "what another start alone would do.",
    ),
    Claim(
        13,
        "Torque peaks are higher at the higher driving speed, with friction and flexibility or without.",
        "30, 31",
        torque_rises,
        "Rule, at 0.5 mm for each model, friction and torque: the mean at 2.5 pi rad/s against that at 0.5 pi, the two "
        "speeds that the paper compares, by `compare`.",
    ),
    *FURTHER,
)
"""Claims of the paper: number, text, figures, parts, rule."""
