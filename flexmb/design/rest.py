"""Derivatives of equilibria and of natural frequencies about them by parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.design.derivatives import Measures, measures_of, places_of
from flexmb.design.parameters import Model, ParameterModel, directions, neighbour
from flexmb.engine.newmark.method import Newmark
from flexmb.engine.sensitivity.linearise import Tangents, linearise, new_tangents
from flexmb.engine.sensitivity.parameter_run import ParameterRun
from flexmb.engine.sensitivity.parameters import parameter_rates
from flexmb.engine.sensitivity.signal_rows import signal_rows
from flexmb.engine.step.method import FixedStep
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError
from flexmb.fields import field, record_with
from flexmb.late import xr
from flexmb.program.program import Program
from flexmb.statics.equilibrium import static_equilibrium
from flexmb.statics.found import Equilibrium
from flexmb.statics.modes import Modes, modes
from flexmb.statics.start.consistent import Start

EQUAL = 1e-6  # relative difference of the squares of two frequencies below which these are one, repeated
SECOND = 1.0  # step of the run that evaluates signals at rest, which takes none [s]


@record_with(repr=False)
class StaticSensitivity(Measures):
    """Derivatives of signals in an equilibrium, and of natural frequencies about it."""

    measures: xr.Dataset = field(
        "`amount`, `derivative` and `relative` derivative (NaN or infinite of an amount of 0) of each signal and of "
        'each frequency, "frequency 1" [Hz] the lowest'
    )
    equilibrium: Equilibrium = field("the equilibrium")

    def __repr__(self) -> str:
        return self._below("StaticSensitivity about an equilibrium")


@arguments.checked
def static_sensitivity(
    model: Model, parameters: Iterable[str] | Mapping[str, float], *, of: Sequence[str] = (), frequencies: int = 0
) -> StaticSensitivity:
    """Derivatives of an equilibrium, and of natural frequencies about it, by parameters.

    The equilibrium moves with the parameters: coordinates and joint forces follow from one more solution with the
    stiffness at rest, frequencies from the change of stiffness, mass and constraints along this motion.

    Parameters
    ----------
    model, parameters : as in `sensitivity`.
    of : names of signals at rest, "rod.end.y" or "O.force".
    frequencies : number of natural frequencies without damping, from the lowest.

    Raises
    ------
    InputError : unknown parameters and signals; neither signals nor frequencies; a frequency of 0, as of a rigid
        motion, whose derivative is not finite; see also `sensitivity`.
    SolveError : no equilibrium; see `static_equilibrium` and `modes`.

    Notes
    -----
    Frequencies that are equal split along a parameter: each has the derivative of one of the branches, in ascending
    order.  Equations (14.12) and (14.13) of docs/theory/design.md.

    Examples
    --------
    The tip of a cantilever of the length l sinks by F l^3/(3 E I), so by 3/l more for each unit of l:

    >>> import flexmb as fm
    >>> def cantilever(length: float, force: float) -> fm.Mechanism:
    ...     beam = fm.FlexibleLink("beam", (0.0, 0.0), (length, 0.0), section=fm.Rectangle(0.01, 0.01),
    ...                            material=fm.Material(2e11, 7800.0, 0.3), elements=4)
    ...     parts = [beam, fm.Fixed("wall", fm.GROUND, beam, at=(0.0, 0.0))]
    ...     return fm.Mechanism("cantilever", [*parts, fm.Force("F", beam, (length, 0.0), (0.0, -force))])
    >>> s = fm.design.static_sensitivity(cantilever, {"length": 0.5, "force": 0.1}, of=["beam.end.y"])
    >>> [round(float(x), 3) for x in s.measures.relative.values[0]]
    [3.0, 1.0]
    """
    label = "static_sensitivity"
    held = ParameterModel(label, model, parameters)
    names = list(checks.sequence(label, "of", of, "names of signals"))
    if any(not isinstance(name, str) for name in names):
        raise InputError(f"{label}: of is {names!r}; what stands still has no mean or peak; give names of signals.")
    count = checks.count(label, "frequencies", frequencies, 0)
    if not names and not count:
        raise InputError(f"{label}: give names of signals, of=[...], or a number of frequencies.")
    mechanism = held.at(held.values)
    rest, here = static_equilibrium(mechanism), neighbour(mechanism)
    run = _run_at(here.program, rest)
    places = places_of(label, here.program, names)
    found = directions(held, here, 0.0)
    by = parameter_rates(here.program, found.numbers, found.steps)
    rows_by = signal_rows(here.program, len(by.step), places)
    run.stepper.tangents = T = new_tangents(here.program, len(found.q), by, rows_by)
    _move_rest(run, T)
    run.find_slopes(T)
    units, signals = here.program.names.signals.units, run.record.signals[places]
    named = zip(names, places, signals, T.rows.now.T, strict=True)
    rows = [(name, units[k], y, slope) for name, k, y, slope in named]
    if count:
        rows += _frequencies(label, here.program, rest, modes(mechanism, count, at=rest), T)
    return StaticSensitivity(measures_of(held, rows), rest)


def _run_at(program: Program, rest: Equilibrium) -> ParameterRun:
    """A run that has begun at rest in an equilibrium."""
    run = ParameterRun(program, Newmark.generalised_alpha(), FixedStep(SECOND), SECOND, None)
    none = np.zeros(program.n_q)
    run.begin(Start(rest.q, none, none, rest.lam))
    return run


def _move_rest(run: ParameterRun, T: Tangents) -> None:
    """Set T.q, T.z and the multipliers in T.u to the motion of the equilibrium; equation (14.12)."""
    program, flow = run.program, run.flow
    n, now = program.n_q, (flow.q, flow.v, flow.a, flow.lam, flow.z)
    tables, address, work = program.tables, program.addresses, run.stepper.second
    T.U[:], T.X[:], T.Y[:] = 0.0, 0.0, 0.0
    linearise(tables, address, 0.0, 0.0, *now, 0.0, 0.0, T, work)
    b = np.hstack([T.F[:, :n], -T.by.g])
    system = StateEvaluation(program).at(flow.q[:n], lam=flow.lam, z=flow.z, weights=(1.0, 0.0, 0.0))
    T.u[:] = system.solve(b.T, f"Motion of the equilibrium of {program.name!r}").T
    T.q[:, :n] = T.u[:, :n]


def _frequencies(
    label: str, program: Program, rest: Equilibrium, found: Modes, T: Tangents
) -> list[tuple[str, str, float, np.ndarray]]:
    """Rows of the natural frequencies; equation (14.13)."""
    n, squares = program.n_q, (2.0 * np.pi * found.frequencies) ** 2 * np.sign(found.frequencies)
    if found.rigid or not squares.all():
        text = f"{label}: {program.name!r} has a frequency of 0 at rest"
        raise InputError(f"{text}, whose derivative is not finite. Hold its rigid motions fast.")
    system = StateEvaluation(program)
    K, M = _pencil(system, rest.q, rest.lam)
    x = found.shapes.real
    left = np.vstack([(K[:n, :n] @ x - (M[:n, :n] @ x) * squares), np.zeros((program.n_c, len(squares)))])
    system.at(rest.q, lam=rest.lam, weights=(0.0, 0.0, 1.0))
    both = np.vstack([x, -system.solve(left, f"Joint forces of the modes of {program.name!r}")[n:]])
    slopes = np.zeros((len(T.q), len(squares)))
    cuts = np.flatnonzero(np.diff(squares) > EQUAL * np.abs(squares[1:])) + 1  # between groups of equal squares
    for j, eps in enumerate(T.by.step):
        sides = []
        for e in (eps, -eps):
            own, p = slice(*T.by.first[j : j + 2]), np.array(program.tables.p)
            p[T.by.number[own]] += e * T.by.rate[own]
            moved = StateEvaluation(replace(program, tables=program.tables.replaced(p=p)))
            sides.append(_pencil(moved, rest.q + e * T.q[j, :n], rest.lam + e * T.u[j, n:]))
        dK, dM = ((upper - lower) / (2.0 * eps) for upper, lower in zip(*sides, strict=True))
        for group in np.split(np.arange(len(squares)), cuts):
            X = both[:, group]
            S = X.T @ (dK @ X) - squares[group[0]] * (X.T @ (dM @ X))
            slopes[j, group] = np.linalg.eigvalsh(0.5 * (S + S.T))
    slopes /= 8.0 * np.pi**2 * np.abs(found.frequencies)
    return [(f"frequency {k + 1}", "Hz", float(f), slopes[:, k]) for k, f in enumerate(found.frequencies)]


def _pencil(system: StateEvaluation, q: np.ndarray, lam: np.ndarray) -> tuple[Any, Any]:
    """[[K, G^T], [G, 0]] and [[M, 0], [0, 0]]."""
    whole = system.at(q, lam=lam, weights=(1.0, 0.0, 0.0)).matrix
    mass = system.at(q, lam=lam, weights=(0.0, 0.0, 1.0)).matrix
    return whole, mass - system.at(q, lam=lam).matrix
