"""Parts of claims on kinds of motion: chaotic or periodic, one section point or several."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from nine_bar_study.claims.evidence import Evidence, Key
from nine_bar_study.claims.finding import UNDECIDED, Part, by_rule

from flexmb.dynamics.series.samples import zero_one_test

if TYPE_CHECKING:
    import xarray as xr

SURE = 3.0
"""Distance of an exponent from zero or from another exponent, in standard deviations, that is significant."""

POINT = 1e-3
"""Side of the square that holds one section point, over the clearance."""

ROUNDING = 1e-9
NOISE = 1e-8
"""Differences of positions within the errors of the integration [m]."""


def journal(joint: str) -> tuple[str, str]:
    """Signals of the coordinates of the journal in the bearing of a joint."""
    return f"{joint}.ex", f"{joint}.ey"


class Kind(NamedTuple):
    """Kind of a motion: verdict, exponent, size of the section.

    Parameters
    ----------
    verdict : "periodic-1", "chaotic", ...
    exponent, error : largest Lyapunov exponent of the system and its standard deviation [1/s].
    cloud : side of the square that holds the section points of the journal [m].
    """

    verdict: str
    exponent: float
    error: float
    cloud: float = math.nan

    @classmethod
    def of(cls, data: xr.Dataset, joint: str) -> Kind:
        """Kind of the motion of a long run; `joint` is the name of the joint with clearance."""
        cloud = max(float(np.ptp(data[f"section.{name}"].values)) for name in journal(joint))
        return cls(str(data.attrs["verdict"]), float(data["exponent"]), float(data["exponent_error"]), cloud)

    @property
    def chaotic(self) -> bool:
        """Whether the verdict is chaotic, and a known exponent exceeds three standard deviations."""
        return self.verdict == "chaotic" and not self.exponent <= SURE * self.error

    @property
    def periodic(self) -> bool:
        """Whether the verdict is periodic, and a known exponent does not exceed three standard deviations."""
        return self.verdict.startswith("periodic") and not self.exponent > SURE * self.error

    @property
    def text(self) -> str:
        """Text of verdict, exponent and cloud for tables."""
        exponent = f", exponent {self.exponent:.3g} ± {self.error:.1g} 1/s" if math.isfinite(self.exponent) else ""
        points = f", points within {1e6 * self.cloud:.2g} um" if math.isfinite(self.cloud) else ""
        return f"{self.verdict}{exponent}{points}"

    @property
    def values(self) -> dict[str, float]:
        """Numbers of the kind by name [1/s, m]."""
        return {"exponent": self.exponent, "error": self.error, "cloud": self.cloud}


def is_chaotic(growths: Mapping[Key, xr.Dataset], key: Key, where: str, joint: str) -> Part:
    """Part of a claim that a long run is chaotic; UNDECIDED without a run."""
    if key not in growths:
        return Part(f"chaotic, {where}", UNDECIDED, "no run")
    kind = Kind.of(growths[key], joint)
    return Part(f"chaotic, {where}", by_rule(agrees=kind.chaotic, disagrees=kind.periodic), kind.text, kind.values)


def more_so(what: str, small: tuple[Kind, str], large: tuple[Kind, str]) -> Part:
    """Part of a claim that the exponent of the second kind is larger; each kind has the text of its case."""
    (a, where_a), (b, where_b) = small, large
    difference, error = b.exponent - a.exponent, math.hypot(b.error, a.error)
    verdict = by_rule(agrees=difference > SURE * error, disagrees=difference < -SURE * error)
    text = f"{b.exponent:.3g} ± {b.error:.1g} 1/s at {where_b}, {a.exponent:.3g} ± {a.error:.1g} at {where_a}"
    return Part(what, verdict, text, {"difference": difference, "error": error})


def unbroken(data: xr.Dataset, where: str) -> Part:
    """Part of a claim that no settled turn has free flight."""
    flight = data["flight"].values
    text = f"{100 * flight.max():.2g} % of free flight at most in {len(flight)} turns"
    verdict = by_rule(agrees=bool(flight.max() == 0.0), disagrees=bool(flight.min() > 0.0))
    return Part(f"contact, {where}", verdict, text, {"flight": float(flight.max())})


def one_point(data: xr.Dataset, where: str, joint: str, clearance: float) -> Part:
    """Part of a claim that the section of the journal is one point."""
    kind = Kind.of(data, joint)
    through = {str(data.attrs[f"verdict.{name}"]) for name in journal(joint)}
    closed = through == {"periodic-1"} and kind.periodic and kind.cloud <= POINT * clearance
    longer = kind.periodic and any(t.startswith("periodic") and t != "periodic-1" for t in through)
    open_ = longer or (through != {"periodic-1"} and kind.exponent > SURE * kind.error)
    text = f"{kind.text}; through the joint: {', '.join(sorted(through))}"
    return Part(f"one point, {where}", by_rule(agrees=closed, disagrees=open_), text, kind.values)


def kinds_of(diagram: xr.Dataset, parameter: str, joint: str) -> list[tuple[float, Kind]]:
    """Values of the parameter of a diagram, ascending, with the kinds of motion; failed values are inconclusive."""
    clouds = [np.ptp(diagram[name].values, axis=1) for name in journal(joint) if name in diagram]
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


def instead(kind: Kind, value: float, long: Mapping[float, Kind]) -> Kind:
    """Kind of the longer run at the same value of the parameter; `kind` without a longer run."""
    return next((other for at, other in long.items() if math.isclose(at, value, rel_tol=ROUNDING)), kind)


def all_of(what: str, kinds: list[tuple[float, Kind]], unit: str, *, chaotic: bool) -> Part:
    """Part of a claim that the motions at all values of a parameter are chaotic, or all periodic."""
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


def one_point_through(seen: Evidence, key: Key, where: str, signal: str) -> Part:
    """Part of a claim that the section of one signal is one point."""
    data = seen.growths[key]
    through, size = str(data.attrs[f"verdict.{signal}"]), float(np.ptp(data[f"section.{signal}"].values))
    stroke = seen.range_of(signal, key.speed)
    text = f"{through}; cloud {1e6 * size:.3g} um, {size / stroke:.1e} of the stroke of {1e3 * stroke:.4g} mm"
    test = zero_one_test(data[f"section.{signal}"].values) if size > NOISE else None
    if test is not None and test.ok:
        text += f"; 0-1 test of the points alone {test.value:.2f}"
    apart = through in ("chaotic", "quasi-periodic") or (through.startswith("periodic") and through != "periodic-1")
    verdict = by_rule(agrees=through == "periodic-1", disagrees=apart)
    return Part(where, verdict, text, {"cloud": size, "stroke": stroke})
