"""Error that a run accumulates in vibrations: phase and amplitude that the steps lose, also under driving.

The modes about some states say how much of the energy is that of a vibration (`flexmb.statics.vibrations`), and
the method's own factor how much of it the steps shift.  The states are those that the run keeps, whatever is saved.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexmb.engine.newmark.method import Newmark
from flexmb.engine.radau.method import RadauIIA
from flexmb.engine.step.method import Method
from flexmb.engine.step.runge_kutta import RungeKutta4
from flexmb.errors import FlexmbError
from flexmb.findings.finding import Finding, found
from flexmb.model.part import WatchedMotion
from flexmb.program.program import Program

if TYPE_CHECKING:
    from flexmb.run.run import Run
    from flexmb.statics.vibrations import LinearModes, State, Vibrations


class Loss(NamedTuple):
    """Loss of a vibration in a number of steps."""

    phase: float  # lag behind the exact vibration at the end [rad]
    amplitude: float  # lost share of the amplitude; below 0 where it grows


def loss_of(method: Method, omega: float, h: float, steps: float, *, first_order: bool = False) -> Loss | None:
    """Loss of an undamped vibration in a number of equal steps; None for a method whose factor is not known."""
    factor = amplification(method, omega * h, first_order=first_order)
    if factor is None:
        return None
    with np.errstate(over="ignore"):
        kept = float(np.abs(factor) ** steps)
    return Loss(steps * (omega * h - float(np.angle(factor))), 1.0 - kept)


def amplification(method: Method, angle: float, *, first_order: bool = False) -> complex | None:
    """Factor by which a step multiplies a vibration exp(i omega t); exact is exp(i omega h).

    Of Newmark's family the principal eigenvalue of the amplification matrix, of Runge-Kutta methods R(i omega h).

    Notes
    -----
    Sources: J. Chung, G. M. Hulbert, A time integration algorithm for structural dynamics with improved numerical
    dissipation: the generalized-alpha method, Journal of Applied Mechanics 60 (1993) 371-375; E. Hairer, G. Wanner,
    Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, IV.3.
    """
    z = 1j * angle
    if isinstance(method, RungeKutta4):
        return 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))
    if isinstance(method, RadauIIA):
        return (1.0 + 0.4 * z + z**2 / 20.0) / (1.0 - 0.6 * z + 0.15 * z**2 - z**3 / 60.0)
    if not isinstance(method, Newmark):
        return None
    am, af, beta, gamma = method.alpha_m, method.alpha_f, method.beta, method.gamma
    if first_order:  # x1 = x + (1 - gamma) x' + gamma x1', in the unknowns x, h x'
        after = np.array([[1.0, -gamma], [-(1.0 - af) * z, 1.0 - am]])
        before = np.array([[1.0, 1.0 - gamma], [af * z, -am]])
        values = np.linalg.eigvals(np.linalg.solve(after, before))
        return complex(values[np.argmin(np.abs(values - np.exp(z)))])
    k = angle**2  # with a = -k q / h^2, in the unknowns q, h v, h^2 x at both ends of a step
    after = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1.0 - af) * k, 0.0, 1.0 - am]])
    before = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1.0 - gamma], [-af * k, 0.0, -am]])
    values = np.linalg.eigvals(np.linalg.solve(after, before))
    return complex(values[np.argmin(np.abs(values - np.exp(z)))])


# Number of coordinates above which modes would take too long, and of coordinates and states of control loops.
MOST_UNKNOWNS, MOST_CONTROLLED = 20_000, 150
FEWEST_STEPS = 2000  # steps of a run with contacts from which the estimate is made, which costs some hundred steps
# Number of poses that are looked at, also of large models; states from each on, and their distance over the run.
POSES, POSES_OF_LARGE, AROUND, DISTANCE = 6, 2, 4, 1e-3
# Number of coordinates from which there are fewer states from each pose on, and of a large model; these states.
MANY, LARGE, AROUND_OF_MANY = 40, 150, 2
FEWEST_INSTANTS, FEWEST_STATES = 12, 3  # kept states, all and those of the same contacts, that energies need
ENERGY_SHARE = 0.01  # share of the elastic energy, or of the square of a controller's state, from which a mode matters
DECAY = 0.1  # energy in the last third of a run over that in the first one, below which a vibration has died out
PART_OF_STEP = 0.1  # time of the differences along the motion, relative to a step
UNRESOLVED = 1.0  # angular frequency times step above which a vibration is not resolved
LOST_PHASE, LOST_AMPLITUDE = 0.1, 2e-3  # phase [rad] and share of the amplitude that may be lost without a remark
SAME = 0.05  # relative difference of angular frequencies up to which modes under other contacts are one vibration


class Mode(NamedTuple):
    """Mode that carries energy: angular frequency [rad/s], share of the energy, loss, and words for both."""

    omega: float
    share: float
    lost: Loss
    moves: str
    kind: str
    energy: str


def vibration_findings(run: Run, motion: WatchedMotion, begun: float) -> Iterator[Finding]:
    """Findings on the fastest vibration with energy of which steps lose a part; the run began at `begun` [s]."""
    program, method, steps = run.program, run.method, int(run.record.count.steps)
    states, span = _states(program, motion), float(run.flow.clock.t) - begun
    short = steps < (FEWEST_STEPS if program.names.contacts else 1)
    if short or not states or loss_of(method, 1.0, 1.0, 1.0) is None:
        return
    if program.n_q > MOST_UNKNOWNS:
        text = f"With {program.n_q} coordinates nothing is known of the phase that vibrations lose in the steps."
        yield found("bookkeeping", (), text)
        return
    from flexmb.statics.vibrations import vibrations_of

    try:
        groups = vibrations_of(program, states, PART_OF_STEP * span / steps)
        largest = run.flow.largest_states
        modes = [*_modes(program, groups, method, motion, span)]
        modes += _loops(program, states[-1], method, motion, span, largest)
    except (FlexmbError, np.linalg.LinAlgError, ValueError):  # no modes: the run has said why
        return
    for mode in sorted(modes, key=lambda one: -one.omega):
        same = [one.lost for one in modes if abs(one.omega - mode.omega) < SAME * mode.omega]
        lost = Loss(sum(one.phase for one in same), 1.0 - math.prod(1.0 - one.amplitude for one in same))
        if abs(lost.phase) >= LOST_PHASE or abs(lost.amplitude) >= LOST_AMPLITUDE:
            yield _of_mode(mode._replace(lost=lost))
            return
    if motion.fixed_step is not None and groups and groups[0].states[0].t == begun:
        yield from _unresolved_start(program, groups[0], motion.fixed_step)


def _modes(
    program: Program, found: list[Vibrations], method: Method, motion: WatchedMotion, span: float
) -> Iterator[Mode]:
    """Modes that carry energy, with the loss of each in the steps while the same contacts are closed."""
    from flexmb.statics.vibrations import closed_contacts

    closed = closed_contacts(program, motion.z)
    energy = "elastic energy of the motion" if program.drives or program.motions else "energy of vibration"
    for states, energies, modes in found:
        rows = (closed == closed_contacts(program, states[0].z)).all(axis=-1)
        for k, omega in enumerate(modes.omega.tolist()) if len(states) >= FEWEST_STATES else ():
            alike = modes.elastic == modes.elastic[k]
            share, decayed = share_of(energies[:, :, alike], int(alike[:k].sum()))
            if share > ENERGY_SHARE:
                lost = _loss(method, omega, float(modes.decay[k]), motion, span, rows)
                words = ("vibration", energy) if modes.elastic[k] else ("swing under its loads", "energy of swings")
                if not decayed or lost.amplitude >= 0.5:
                    yield Mode(omega, share, lost, _moves(program, modes, k), *words)


def _loops(
    program: Program, state: State, method: Method, motion: WatchedMotion, span: float, largest: np.ndarray
) -> Iterator[Mode]:
    """Vibrations of the states of controllers, with the loss of each in the steps."""
    if not len(largest) or program.n_q > MOST_CONTROLLED:
        return
    from flexmb.statics.vibrations import loop_modes

    names = program.names.coordinates[program.tables.sizes.n_b :]
    for s, amplitudes in zip(*loop_modes(program, state), strict=True):
        shares = (amplitudes / np.maximum(largest, 1e-300)) ** 2
        k = int(np.argmax(shares))
        if shares[k] > ENERGY_SHARE:
            lost = _loss(method, float(s.imag), -float(s.real), motion, span, motion.even, first_order=True)
            words = names[k], "vibration of a controller", f"square of {names[k]}"
            yield Mode(float(s.imag), float(shares[k]), lost, *words)


def _loss(
    method: Method,
    omega: float,
    decay: float,
    motion: WatchedMotion,
    span: float,
    rows: np.ndarray,
    *,
    first_order: bool = False,
) -> Loss:
    """Loss of a mode while contacts and damping let it remember; the lost phase grows with h^2."""
    h = motion.sizes * motion.even
    size = float(np.sqrt((h[rows] ** 3).sum() / h[rows].sum()))
    memory = min(span * float(h[rows].sum() / h.sum()), 1.0 / max(decay, 1e-300))
    return loss_of(method, omega, size, memory / size, first_order=first_order) or Loss(0.0, 0.0)


def _unresolved_start(program: Program, group: Vibrations, h: float) -> Iterator[Finding]:
    """Finding on a vibration with which a run begins, where fixed steps of size h [s] are too long for its period."""
    whole = float(group.energies[:, 0].sum(axis=1).mean())
    begun = 0.5 * group.energies[0, 2]  # y less what slow loads give is -y''/omega^2
    coarse = np.flatnonzero((group.modes.omega * h > UNRESOLVED) & (begun > ENERGY_SHARE * whole))
    if not len(coarse):
        return
    k = int(coarse[np.argmax(begun[coarse])])
    period = 2.0 * np.pi / float(group.modes.omega[k])
    moves = _moves(program, group.modes, k)
    text = (
        f"The run begins with a vibration of {1.0 / period:.4g} Hz (mostly {moves}), {h / period:.2g} of whose period "
        f"is one step of {h:.3g} s: its peaks are not resolved."
    )
    remedy = f"Take steps of {period / 20.0:.1g} s, Adaptive(), or a drive that starts softly."
    yield found("coarse-step", (moves.partition(".")[0],), text, remedy, step=h, period=period)


def _of_mode(mode: Mode) -> Finding:
    """Finding on a vibration."""
    verb = "lose" if mode.lost.amplitude >= 0.0 else "add"
    text = (
        f"The {mode.kind} of {mode.omega / (2.0 * np.pi):.4g} Hz (mostly {mode.moves}) carries "
        f"{100.0 * min(mode.share, 1.0):.3g} % of the {mode.energy}; until the end the steps lose some "
        f"{abs(mode.lost.phase):.2g} rad of its phase and {verb} {100.0 * abs(mode.lost.amplitude):.3g} % of its "
        "amplitude."
    )
    remedy, part = "A smaller rtol or step, or RadauIIA(), loses less.", mode.moves.partition(".")[0]
    phase, amplitude = mode.lost
    return found("lost-vibration", (part,), text, remedy, phase=phase, amplitude=amplitude, share=mode.share)


def _moves(program: Program, modes: LinearModes, k: int) -> str:
    """Name of the coordinate that mode k moves most."""
    from flexmb.statics.eigen import moves_most

    shape = modes.shapes[:, k]
    return moves_most(program.names.coordinates[: len(shape)], program.length, shape)


def _states(program: Program, motion: WatchedMotion) -> list[State]:
    """States at uneven distances; none where nothing is free to move, or where too few are kept."""
    n, kept = program.n_q, np.flatnonzero(motion.even)
    if n == program.n_c or len(kept) < FEWEST_INSTANTS:
        return []
    from flexmb.statics.vibrations import State

    times, poses = motion.times[kept], np.arange(POSES_OF_LARGE if n >= LARGE or program.names.contacts else POSES)
    later = np.arange(AROUND_OF_MANY if MANY <= n < LARGE else AROUND)[:, None]
    wanted = (poses + poses * 0.618034 % 1.0) / len(poses) + later * DISTANCE
    found = np.searchsorted(times, times[0] + wanted * (times[-1] - times[0]))
    found = np.maximum(found, found[0] + later)
    rows = kept[np.unique(np.minimum(found, len(kept) - 1))]
    q, v, a = (motion.values[:, k * n : (k + 1) * n] for k in range(3))
    return [State(float(motion.times[k]), q[k], v[k], a[k], motion.z[k]) for k in rows]


def share_of(energies: np.ndarray, k: int) -> tuple[float, bool]:
    """Largest share of mode k of `energies` (states, 3, modes) in a third of the run, and whether it dies out."""
    whole = float(energies[:, 0].sum(axis=1).mean())
    thirds = [float(third[:, :, k].mean(axis=0).min()) for third in np.array_split(energies, 3)]
    return max(thirds) / whole if whole > 0.0 else 0.0, thirds[-1] < DECAY * thirds[0]
