"""Claims on what kind of motion it is: 7 to 11."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexmb.paper.claims.evidence import FAST, LARGE, MIDDLE, SLOW, SMALL, SMALLEST, Evidence, Key
from flexmb.paper.claims.finding import ASIDE, UNDECIDED, Finding, Part, by_rule, finding
from flexmb.series.zero_one import zero_one_test

if TYPE_CHECKING:
    import xarray as xr

SURE = 3.0
"""So many of its errors an exponent must be away from zero, or from another."""

LAST_PERIODIC, FIRST_CHAOTIC = 1.6, 1.65
"""Speeds over pi between which the paper sees chaos begin [rad/s]."""

NEAR = (1.55, 1.575, 1.6, 1.65, 1.7, 1.975)
"""Speeds over pi [rad/s] at which long runs look again: where chaos begins, and where the diagram was not sure."""

JOURNAL = ("P1.ex", "P1.ey")

POINT = 1e-3
"""Part of the clearance within which points of the journal are one point to the eye."""

ROUNDING = 1e-9
NOISE = 1e-8
"""Differences of positions that may be errors of the integration [m]."""


class Kind(NamedTuple):
    """What a motion is.

    Parameters
    ----------
    verdict : "periodic-1", "chaotic", ...
    exponent, error : of the system [1/s].
    cloud : side of the square that holds the journal's points, one a turn [m].
    """

    verdict: str
    exponent: float
    error: float
    cloud: float = math.nan

    @classmethod
    def of(cls, data: xr.Dataset) -> Kind:
        """Of a `Growth` or an `Attractor`."""
        cloud = max(float(np.ptp(data[f"section.{name}"].values)) for name in JOURNAL)
        return cls(str(data.attrs["verdict"]), float(data["exponent"]), float(data["exponent_error"]), cloud)

    @property
    def chaotic(self) -> bool:
        """Called so, with an exponent (where there is one) above zero by three errors."""
        return self.verdict == "chaotic" and not self.exponent <= SURE * self.error

    @property
    def periodic(self) -> bool:
        """Called so, with an exponent (where there is one) that is not above zero by three errors."""
        return self.verdict.startswith("periodic") and not self.exponent > SURE * self.error

    @property
    def text(self) -> str:
        """For tables."""
        exponent = f", exponent {self.exponent:.3g} ± {self.error:.1g} 1/s" if math.isfinite(self.exponent) else ""
        points = f", points within {1e6 * self.cloud:.2g} um" if math.isfinite(self.cloud) else ""
        return f"{self.verdict}{exponent}{points}"

    @property
    def values(self) -> dict[str, float]:
        """The numbers."""
        return {"exponent": self.exponent, "error": self.error, "cloud": self.cloud}


def chaotic_joint(seen: Evidence) -> Finding:
    """Claim 7: at 2 pi rad/s the joint is chaotic at 0.05 and at 0.5 mm, more so at 0.5 mm.

    Rule, flexible mechanism (the rigid one is shown beside it; where there are exponents of the rigid one alone, it
    decides): chaotic is what is called so and has an exponent three errors above zero; it disagrees if the motion is
    called periodic, since its points return, with an exponent that is not above zero by three errors.  "More so" agrees
    if the exponent at 0.5 mm is larger by three errors of the difference, and disagrees if it is smaller by as much.
    """
    models = [m for m in ("flexible", "rigid") if any(k.model == m and k.speed == MIDDLE for k in seen.growths)]
    parts = []
    for number, model in enumerate(models):
        small, large = Key(model, MIDDLE, SMALL), Key(model, MIDDLE, LARGE)
        found = [
            _is_chaotic(key, Kind.of(seen.growths[key]))
            if key in seen.growths
            else Part(f"chaotic, {key.text}", UNDECIDED, "no run")
            for key in (small, large)
        ]
        if small in seen.growths and large in seen.growths:
            found.append(_more(model, Kind.of(seen.growths[small]), Kind.of(seen.growths[large])))
        parts += found if number == 0 else [_aside(part) for part in found]
    return finding(parts)


def _aside(part: Part) -> Part:
    return Part(part.what, ASIDE, f"{part.numbers}: {part.verdict}", part.values)


def _is_chaotic(key: Key, kind: Kind) -> Part:
    verdict = by_rule(agrees=kind.chaotic, disagrees=kind.periodic)
    return Part(f"chaotic, {key.text}", verdict, kind.text, kind.values)


def _more(model: str, small: Kind, large: Kind) -> Part:
    difference, error = large.exponent - small.exponent, math.hypot(large.error, small.error)
    verdict = by_rule(agrees=difference > SURE * error, disagrees=difference < -SURE * error)
    text = (
        f"{large.exponent:.3g} ± {large.error:.1g} 1/s at 0.5 mm, {small.exponent:.3g} ± {small.error:.1g} at 0.05 mm"
    )
    return Part(f"more so at 0.5 mm, {model}", verdict, text, {"difference": difference, "error": error})


def slow_is_periodic(seen: Evidence) -> Finding:
    """Claim 8: at 0.5 pi rad/s and 0.5 mm contact is unbroken, the phase curve closes, the Poincare map is one point.

    Rule, for each model: contact agrees if no settled turn has any free flight, and disagrees if every turn has; the
    map agrees if the motion is called periodic-1 through both coordinates of the joint, its points lie within a
    thousandth of the clearance and the exponent is not above zero by three errors; it disagrees if it is called
    otherwise with an exponent three errors above zero, or periodic of a longer period.
    """
    parts = []
    for model in ("flexible", "rigid"):
        key = Key(model, SLOW)
        if seen.has(key):
            flight = seen.motions[key]["flight"].values
            text = f"{100 * flight.max():.2g} % of free flight at most in {len(flight)} turns"
            verdict = by_rule(agrees=bool(flight.max() == 0.0), disagrees=bool(flight.min() > 0.0))
            parts.append(Part(f"contact, {key.text}", verdict, text, {"flight": float(flight.max())}))
        if key in seen.growths:
            data = seen.growths[key]
            kind = Kind.of(data)
            through = {str(data.attrs[f"verdict.{name}"]) for name in JOURNAL}
            closed = through == {"periodic-1"} and kind.periodic and kind.cloud <= POINT * key.clearance
            longer = kind.periodic and any(t.startswith("periodic") and t != "periodic-1" for t in through)
            open_ = longer or (through != {"periodic-1"} and kind.exponent > SURE * kind.error)
            text = f"{kind.text}; through the joint: {', '.join(sorted(through))}"
            parts.append(Part(f"one point, {key.text}", by_rule(agrees=closed, disagrees=open_), text, kind.values))
    return finding(parts)


def kinds_of(diagram: xr.Dataset, parameter: str) -> list[tuple[float, Kind]]:
    """What the motion is at each value of a diagram, by rising value; points that failed are inconclusive."""
    clouds = [np.ptp(diagram[name].values, axis=1) for name in JOURNAL if name in diagram]
    table = zip(
        diagram[parameter].values,
        diagram["verdict"].values,
        diagram["exponent"].values,
        diagram["exponent_error"].values,
        np.max(clouds, axis=0) if clouds else np.full(len(diagram[parameter]), np.nan),
        diagram["ok"].values,
        strict=True,
    )
    return sorted(
        (float(value), Kind(str(text) if ok else "inconclusive", *(float(number) for number in numbers)))
        for value, text, *numbers, ok in table
    )


def threshold_of_chaos(seen: Evidence) -> Finding:
    """Claim 9: over the speed the joint is periodic up to 1.6 pi and chaotic from 1.65 pi rad/s on.

    Rule, flexible mechanism (the rigid one is shown beside it), 0.5 mm.  Up to 1.6 pi it agrees if every value is
    periodic in the sense of claim 7, and disagrees if one is chaotic in that sense.
    From 1.65 pi on it agrees if every value is chaotic, and disagrees if one is periodic.  Where there is a longer run,
    with default steps, it stands in for the point of the diagram.
    """
    parts = []
    for model in ("flexible", "rigid"):
        kinds = _over_speed(seen, model)
        if not kinds:
            continue
        below = [item for item in kinds if item[0] <= LAST_PERIODIC + ROUNDING]
        above = [item for item in kinds if item[0] >= FIRST_CHAOTIC - ROUNDING]
        found = [
            _all_of(f"periodic up to 1.6 pi rad/s, {model}", below, "pi rad/s", chaotic=False),
            _all_of(f"chaotic from 1.65 pi rad/s on, {model}", above, "pi rad/s", chaotic=True),
        ]
        parts += found if model == "flexible" else [_aside(part) for part in found]
    return finding(parts)


def _over_speed(seen: Evidence, model: str) -> list[tuple[float, Kind]]:
    """What the motion is at speeds over pi, from the diagram, or from a longer run where there is one.

    Without a diagram it is the long runs about the threshold alone.
    """
    long = {key.speed: Kind.of(seen.growths[key]) for key in seen.growths if key[::2] == (model, LARGE)}
    if ("speed", model) in seen.diagrams:
        found = [(value / math.pi, kind) for value, kind in kinds_of(seen.diagrams["speed", model], "speed")]
        return [(value, _instead(kind, value, long)) for value, kind in found]
    return sorted((speed, kind) for speed, kind in long.items() if speed in NEAR)


def _instead(kind: Kind, value: float, long: Mapping[float, Kind]) -> Kind:
    """What a longer run at the same value says, if there is one."""
    return next((other for at, other in long.items() if math.isclose(at, value, rel_tol=ROUNDING)), kind)


def _all_of(what: str, kinds: list[tuple[float, Kind]], unit: str, *, chaotic: bool) -> Part:
    """Whether all values are as a claim has them; names the first that are not."""
    fits = [kind.chaotic if chaotic else kind.periodic for _, kind in kinds]
    against = [(value, kind) for value, kind in kinds if (kind.periodic if chaotic else kind.chaotic)]
    open_ = [(value, kind) for value, kind in kinds if not (kind.periodic or kind.chaotic)]
    text = f"{sum(fits)} of {len(kinds)} values"
    if against:
        text += f"; against it {len(against)}, such as {against[0][0]:.4g} {unit} ({against[0][1].text})"
    if open_:
        text += f"; open {len(open_)}, such as {open_[0][0]:.4g} {unit} ({open_[0][1].text})"
    verdict = by_rule(agrees=bool(kinds) and all(fits), disagrees=bool(against))
    values = {"values": len(kinds), "fit": sum(fits), "against": len(against), "open": len(open_)}
    return Part(what, verdict, text, values)


def chaos_by_clearance(seen: Evidence) -> Finding:
    """Claim 10: over the clearance, from 0.01 to 0.5 mm at 2 pi rad/s, the joint goes from periodic to chaotic.

    Rule, flexible mechanism (the rigid one is shown beside it): the smallest value must be called periodic and the
    largest chaotic, in the sense of claims 7 and 9; it disagrees where one of them is the opposite.  Longer runs stand
    in for points of the diagram, as there.
    """
    parts = []
    for model in ("flexible", "rigid"):
        kinds = _over_clearance(seen, model)
        if not kinds:
            continue
        periodic, chaotic = (sum(getattr(kind, name) for _, kind in kinds) for name in ("periodic", "chaotic"))
        found = [
            _all_of(f"periodic at {kinds[0][0]:.3g} mm, {model}", kinds[:1], "mm", chaotic=False),
            _all_of(f"chaotic at {kinds[-1][0]:.3g} mm, {model}", kinds[-1:], "mm", chaotic=True),
        ]
        text = f"{periodic} periodic, {chaotic} chaotic, {len(kinds) - periodic - chaotic} open of {len(kinds)} values"
        parts += found if model == "flexible" else [_aside(part) for part in found]
        parts.append(Part(f"all clearances, {model}", ASIDE, text, {"periodic": periodic, "chaotic": chaotic}))
    return finding(parts)


def _over_clearance(seen: Evidence, model: str) -> list[tuple[float, Kind]]:
    """What the motion is at clearances [mm], from the diagram, or from a longer run where there is one.

    Without a diagram it is the long runs at both of its ends.
    """
    long = {key.clearance: Kind.of(seen.growths[key]) for key in seen.growths if key[:2] == (model, MIDDLE)}
    if ("clearance", model) in seen.diagrams:
        found = kinds_of(seen.diagrams["clearance", model], "clearance")
        return [(1e3 * value, _instead(kind, value, long)) for value, kind in found]
    if not {SMALLEST, LARGE} <= set(long):
        return []
    return [(1e3 * value, long[value]) for value in (SMALLEST, LARGE)]


def slider_is_one_point(seen: Evidence) -> Finding:
    """Claim 11: the Poincare map of the slider stays one point in all runs.

    Rule, for each case, flexible where there is one: it agrees if the motion is called periodic-1 through the position
    of the slider alone, and disagrees if it is called chaotic, quasi-periodic or periodic of a longer period through
    it, which are more points than one.  The size of the cloud of
    points is given beside the stroke: on the scale of the stroke any of them may look like one point.  So is the 0-1
    test of the points alone (near 1 chaotic, near 0 regular), which knows nothing of the system's exponent.
    """
    parts = []
    for speed, clearance in ((MIDDLE, SMALL), (MIDDLE, LARGE), (SLOW, LARGE), (FAST, LARGE)):
        keys = [Key(model, speed, clearance) for model in ("flexible", "rigid")]
        there = [key for key in keys if key in seen.growths]
        if there:
            parts.append(_cloud(seen, there[0]))
    for (parameter, model), diagram in sorted(seen.diagrams.items()):
        if model == "flexible" and "slider.x" in diagram:
            parts.append(_clouds(diagram, parameter))
    return finding(parts)


def _cloud(seen: Evidence, key: Key) -> Part:
    data = seen.growths[key]
    through, size = str(data.attrs["verdict.slider.x"]), float(np.ptp(data["section.slider.x"].values))
    stroke = seen.stroke(key.speed)
    text = f"{through}; cloud {1e6 * size:.3g} um, {size / stroke:.1e} of the stroke of {1e3 * stroke:.4g} mm"
    test = zero_one_test(data["section.slider.x"].values) if size > NOISE else None
    if test is not None and test.ok:
        text += f"; 0-1 test of the points alone {test.value:.2f}"
    apart = through in ("chaotic", "quasi-periodic") or (through.startswith("periodic") and through != "periodic-1")
    verdict = by_rule(agrees=through == "periodic-1", disagrees=apart)
    return Part(key.text, verdict, text, {"cloud": size, "stroke": stroke})


def _clouds(diagram: xr.Dataset, parameter: str) -> Part:
    """The largest cloud of a diagram; whether it is one point is decided by the cases."""
    sizes = np.ptp(diagram["slider.x"].values, axis=1)
    k = int(np.nanargmax(sizes))
    value = float(diagram[parameter].values[k])
    at = f"{value / math.pi:.4g} pi rad/s" if parameter == "speed" else f"{1e3 * value:.3g} mm"
    text = f"largest cloud {1e6 * sizes[k]:.3g} um at {at}; {int((sizes > 1e-7).sum())} of {len(sizes)} above 0.1 um"
    return Part(f"diagram over the {parameter}", ASIDE, text, {"cloud": float(sizes[k])})
