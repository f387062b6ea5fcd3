"""Single, double and triple pendulum of Kaheman et al. (2022): fits of the records, and what they leave."""

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

import flexmb as fm
from measured import table
from measured.cases import CASES, DOUBLE, Case
from measured.chains import Bounds, Numbers, arm, chains, with_arguments

RECORDS = True
"""Whether the section needs measured records."""

NOISE = 1e-3
"""Level of the residuals to which standard errors refer [rad]."""

ANGLE, RATE = 0.03, 0.3
"""Bounds of the start of a piece about the recorded one [rad, rad/s]."""

CORRECTIONS = 2
"""Corrections of the start of each piece."""

SPANS = (10.0, 30.0, 69.0)
"""Ends of the spans whose exponents are computed [s]; the first is too short for series."""

TOOLS = fm.chaos.rosenstein, fm.chaos.kantz, fm.chaos.wolf
"""Exponents of series."""

EVERY = 10
"""Samples of the record from one of the series to the next."""

PART, FINE = 400, fm.Adaptive(rtol=1e-5)
"""Samples and steps by which combinations of numbers are judged; coarser steps blur those that move the nodes."""


# Records, residuals, fits


class Record(NamedTuple):
    """Pieces of equal length of a record."""

    time: np.ndarray  # (n,) [s], from the begin of each piece on
    angles: np.ndarray  # (pieces, n, arms) [rad], from hanging
    starts: np.ndarray  # (pieces, 2 arms), recorded angles and rates

    def at(self, chosen: Sequence[int]) -> "Record":
        """Some of the pieces."""
        return Record(self.time, self.angles[list(chosen)], self.starts[list(chosen)])

    @property
    def names(self) -> list[str]:
        """Names of the angles of a model, piece by piece."""
        pieces, _, arms = self.angles.shape
        return [f"{arm(k, piece)}.theta" for piece in range(pieces) for k in range(1, arms + 1)]

    @property
    def rows(self) -> np.ndarray:
        """Angles (n, pieces x arms)."""
        return np.concatenate(list(self.angles), axis=1)


def record(folder: Path, name: str) -> Record:
    """Record of a pendulum from `folder`."""
    with np.load(folder / f"pendulum_{name}_identification.npz") as file:
        count = sum(key.startswith("time") for key in file.files)
        angles = np.stack([file[f"angle{k}"] for k in range(count)]) - math.pi
        rates = np.stack([file[f"rate{k}"][0] for k in range(count)])
        time = file["time0"] - file["time0"][0]
    return Record(time, angles, np.concatenate([angles[:, 0], rates], axis=1))


def residuals(own: Record, found: Numbers, starts: np.ndarray) -> np.ndarray:
    """Computed less measured angles (pieces, n, arms)."""
    pieces, _, arms = own.angles.shape
    sol = fm.simulate(chains(arms, found, starts), t_end=own.time[-1], save=own.time, signals=own.names)
    if not sol.ok:
        raise SystemExit(sol.status)
    rows = np.stack([sol.array(name) for name in own.names], axis=1) - own.rows
    return np.stack(np.split(rows, pieces, axis=1))


def rms(rows: np.ndarray) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(rows))))


def fitted(own: Record, fixed: Numbers, bounds: Bounds, *, free: bool, **how: Any) -> fm.design.Fit:
    """Fit of the numbers within `bounds`; of the start of each piece, too, where it is `free`."""
    pieces, _, arms = own.angles.shape
    names = [[f"start{piece}_{k}" for k in range(2 * arms)] for piece in range(pieces)]
    width = np.repeat([ANGLE, RATE], arms)
    places = zip(itertools.chain(*names), own.starts.ravel(), np.tile(width, pieces), strict=True)
    limits = {name: (x - w, x + w) for name, x, w in places} if free else {}

    def model(given: Numbers) -> fm.Mechanism:
        starts = [[given[name] for name in each] for each in names] if free else own.starts
        return chains(arms, {**fixed, **given}, starts)

    data = xr.Dataset({name: ("time", own.rows[:, k]) for k, name in enumerate(own.names)}, {"time": own.time})
    all_bounds = {**bounds, **limits}
    options = {"signals": own.names, "noise": NOISE, **how}
    return fm.design.fit(with_arguments(model, all_bounds), all_bounds, data, **options)


def settled(own: Record, found: Numbers) -> np.ndarray:
    """Starts (pieces, 2 arms) with the least squares of each piece alone, by derivatives of the run."""
    pieces, _, arms = own.angles.shape
    names = [f"start{k}" for k in range(2 * arms)]
    model = with_arguments(lambda given: chains(arms, found, [[given[name] for name in names]]), names)
    starts = own.starts.copy()
    for piece in range(pieces):
        one = own.at([piece])
        for _ in range(CORRECTIONS):
            values = dict(zip(names, starts[piece].tolist(), strict=True))
            slope = fm.design.sensitivity(model, values, of=one.names, t_end=one.time[-1], save=one.time)
            rows = np.concatenate([one.rows[:, k] - slope.signals[name].values for k, name in enumerate(one.names)])
            J = np.concatenate([slope[name].values.T for name in one.names])
            starts[piece] += np.linalg.lstsq(J, rows, rcond=None)[0]
    return starts


# Numbers of the page


def law(case: Case, own: Record, friction: Bounds) -> dict[str, Any]:
    """Fit of a friction law: numbers, errors, what it leaves from recorded and from estimated starts."""
    bounds = {**case.geometry, **friction}
    result = fitted(own.at(case.pieces), case.fixed, bounds, free=True, step=case.step)
    values = {name: result.parameters[name] for name in bounds}
    found = {**case.fixed, **values}
    left = residuals(own, found, settled(own, found))
    print(case.name, values, rms(left), result.message, flush=True)
    return {
        "values": values,
        "errors": {name: result.errors[name] for name in bounds},
        "runs": result.runs,
        "recorded": rms(residuals(own, found, own.starts)),
        "estimated": rms(left),
        "pieces": [rms(rows) for rows in left],
        "seen": result.message,
    }


def hidden(case: Case, own: Record) -> list[str]:
    """Combinations of masses, lengths and viscous friction that the record does not tell apart."""
    known = {**case.fixed, **case.published}
    bounds = {name: (0.97 * known[name], 1.02 * known[name]) for name in [*case.told, *case.published]}
    one = Record(own.time[:PART], own.angles[:1, :PART], own.starts[:1])
    return list(fitted(one, known, bounds, free=False, step=FINE, most_runs=5).unseen)


def exponents(own: Record, found: Numbers) -> dict[str, Any]:
    """Exponents [1/s] of the measured angles, and of the model over spans of the motion."""
    whole, interval = np.concatenate(list(own.angles))[::EVERY], EVERY * float(own.time[1])
    series, model = [], []
    for span, k, tool in itertools.product(SPANS[1:], range(own.angles.shape[2]), TOOLS):
        one = tool(whole[: round(span / interval), k], interval)
        value = [one.value, one.error] if one.ok else [None, None]
        series.append([span, k + 1, tool.__name__, *value, one.status])
    first = own.at([0])
    mech = chains(own.angles.shape[2], found, settled(first, found))
    for span in SPANS:
        grown = fm.lyapunov(mech, duration=span, period=1.0, confirm=False)
        sol = fm.simulate(mech, t_end=span - interval, save=interval, signals=first.names)
        rows = np.stack([sol.array(name) for name in first.names], axis=1)
        model.append([span, grown.value, grown.error, rms(rows - whole[: len(rows)])])
    return {"series": series, "model": model}


def numbers(folder: Path | None) -> dict[str, Any]:
    """Fits of all pendulums, and pictures."""
    found: dict[str, Any] = {}
    records = {name: record(Path(folder or ""), name) for name in CASES}
    for name, case in CASES.items():
        own = records[name]
        one: dict[str, Any] = {"length": float(own.time[-1]), "fitted": len(case.pieces), "pieces": len(own.angles)}
        for key, known in (("published", case.published), ("refit", case.refit)):
            if known:
                left = residuals(own, {**case.fixed, **known}, own.starts)
                one[key] = {"recorded": rms(left), "pieces": [rms(rows) for rows in left]}
        one |= {"viscous": law(case, own, case.viscous), "ours": law(case, own, case.ours)}
        if case.told:
            one["unseen"] = hidden(case, own)
        found[name] = one
    double = {**DOUBLE.fixed, **found["double"]["ours"]["values"]}
    found["exponents"] = exponents(records["double"], double)
    return found


# Passage and pictures

LAWS = {
    "published": "viscous, published",
    "refit": "viscous, fitted from recorded starts",
    "viscous": "viscous",
    "ours": "dry and air",
}
COLOURS = {"published": "0.6", "viscous": "#d98e04", "ours": "#1b6ca8"}

DIGITS = {("single", "published"): "0.141", ("single", "refit"): "0.0133", ("double", "published"): "0.01120"}
"""Residuals of an independent script with the same numbers [rad]."""

PICTURED = (0, 12)
"""Pieces of the double pendulum in the picture."""


def passage(found: dict[str, Any]) -> str:
    """Tables of residuals, numbers and exponents, and what is not told apart."""
    named = [(name, law, found[name][law]) for name in CASES for law in LAWS if law in found[name]]
    head = [
        "pendulum",
        "friction",
        "rms, recorded starts [rad]",
        "independent script",
        "rms, estimated starts [rad]",
        "worst piece",
    ]
    rows = [
        [
            *(name, LAWS[law], f"{one['recorded']:.5f}", DIGITS.get((name, law), "")),
            *((f"{one['estimated']:.5f}", f"{max(one['pieces']):.5f}") if "estimated" in one else ("", "")),
        ]
        for name, law, one in named
    ]
    values = [
        [name, LAWS[law], key, f"{value:.6g}", f"{one['errors'][key]:.1g}", shown(CASES[name], key)]
        for name, law, one in named
        for key, value in one.get("values", {}).items()
    ]
    numbers_head = ["pendulum", "friction", "number", "fitted", "standard error", "published"]
    unseen = [f"- {name}: {text}." for name in CASES for text in found[name].get("unseen", ())]
    series = [
        [f"{span:g}", str(k), tool, "none" if value is None else f"{value:.2g} ± {error:.1g}", status]
        for span, k, tool, value, error, status in found["exponents"]["series"]
    ]
    model = [
        [f"{span:g}", f"{value:.3f} ± {error:.2f}", f"{left:.3f}"]
        for span, value, error, left in found["exponents"]["model"]
    ]
    return "\n\n".join(
        [
            table(head, rows, left=2),
            table(numbers_head, values, left=3),
            "Combinations that the records do not tell apart, each number relative to its size:",
            "\n".join(unseen),
            table(["span [s]", "exponent of the model [1/s]", "model less record, rms [rad]"], model),
            table(["span [s]", "arm", "estimate", "exponent of the record [1/s]", "reason"], series, left=5),
        ]
    )


def shown(case: Case, key: str) -> str:
    """Published value of a number; "" where there is none."""
    known = {**case.fixed, **case.published} if case.published else {}
    return f"{known[key]:.6g}" if key in known else ""


def pictures(folder: Path, found: dict[str, Any], out: Path) -> None:
    """Measured and computed angles of two pieces, and residuals of all pieces."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - takes long to import

    own = record(folder, "double").at(PICTURED)
    numbers_of = {**DOUBLE.fixed, **found["double"]["ours"]["values"]}
    left = residuals(own, numbers_of, settled(own, numbers_of))
    figure = Figure(figsize=(9.0, 5.0), layout="constrained")
    axes = figure.subplots(2, len(PICTURED), sharex=True, height_ratios=(2, 1))
    for column, piece in enumerate(PICTURED):
        upper, lower = axes[:, column]
        for k, colour in enumerate(("#1b6ca8", "#c0392b")):
            measured = own.angles[column, :, k]
            upper.plot(own.time, measured, color=colour, alpha=0.35, linewidth=4.0, label=f"arm {k + 1}, measured")
            upper.plot(own.time, measured + left[column, :, k], color=colour, linewidth=1.0, label="computed")
            lower.plot(own.time, 1e3 * left[column, :, k], color=colour, linewidth=0.8)
        upper.set_title(f"piece {piece} of {found['double']['pieces']}", fontsize="medium", loc="left")
        lower.set_xlabel("time [s]")
    axes[0, 0].set_ylabel("angle [rad]")
    axes[1, 0].set_ylabel("difference [mrad]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4, fontsize="small")
    figure.savefig(out / "measured_double.png", dpi=110)

    figure = Figure(figsize=(9.0, 3.2), layout="constrained")
    for ax, name in zip(figure.subplots(1, len(CASES)), CASES, strict=True):
        for law, colour in COLOURS.items():
            if law in found[name]:
                ax.semilogy(found[name][law]["pieces"], "o-", color=colour, markersize=3, label=LAWS[law])
        ax.set_title(name, fontsize="medium", loc="left")
        ax.set_xlabel("piece")
        ax.grid(visible=True, color="0.93", which="both", linewidth=0.5)
    figure.axes[0].set_ylabel("rms [rad]")
    figure.axes[0].legend(fontsize="small")
    figure.savefig(out / "measured_pieces.png", dpi=110)
