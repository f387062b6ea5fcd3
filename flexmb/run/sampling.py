"""Sampled controllers: `Run` stops at each of `Program.instants` and calls `act`.

In between `evaluate_controls` of engine/system/elements.py keeps their outputs.
"""

from collections.abc import Sequence

import numpy as np

from flexmb.errors import USER_ERRORS, KernelError
from flexmb.model.contributions import MotionInput
from flexmb.program.program import Sampler

# Number of iterations, differences of states, and last correction, for states that begin where their rates are 0.
MOST_ITERATIONS, DIFFERENCE, SETTLED = 30, 1e-6, 1e-12


def act(samplers: Sequence[Sampler], time: float, signals: np.ndarray, z: np.ndarray, *, every: bool = False) -> None:
    """Let the sampled controllers of a mechanism act at one of their instants."""
    # All read the same signals, so that the order of several controllers does not matter. A state x becomes x + sample
    # dx; outputs are held until the next instant. Signals (n_y,) are those just before the instant [s]; histories z
    # (n_z,) are changed in place. With `every` all controllers act, for the start of a run. A law that raises, or gives
    # numbers that are not finite, is a `KernelError` with controller, time, inputs.
    acting = [sampler for sampler in samplers if every or sampler.acts_at(time)]
    for sampler in acting if every else ():
        # States that begin where their rates are 0, by Newton's method with differences.
        own, u = list(sampler.settled), _inputs(sampler, time, signals)
        x = z[sampler.z : sampler.z + sampler.states]  # a view
        for _ in range(MOST_ITERATIONS if own else 0):
            rate, slopes = _law(sampler, time, u, x)[0][own], []
            for k in own:
                shift, other = DIFFERENCE * max(abs(x[k]), 1.0), x.copy()
                other[k] += shift
                slopes.append((_law(sampler, time, u, other)[0][own] - rate) / shift)
            change = np.linalg.lstsq(np.array(slopes).T, rate, rcond=None)[0]
            x[own] -= change
            if np.abs(change).max() <= SETTLED * np.abs(x[own]).max():
                break
        else:
            if own:
                text = f"controller {sampler.name!r}: no start values of its states number {own} make their rates 0"
                raise KernelError(f"The {text}. Give start values.")
    histories = []
    for sampler in acting:
        x = z[sampler.z : sampler.z + sampler.states].copy()
        dx, y = _law(sampler, time, _inputs(sampler, time, signals), x)
        histories.append(np.concatenate([x + sampler.sample * dx, y]))
    for sampler, history in zip(acting, histories, strict=True):
        z[sampler.z : sampler.z + len(history)] = history


def _law(sampler: Sampler, t: float, u: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rates and outputs of a law."""
    dx, y = np.zeros(sampler.states), np.zeros(sampler.outputs)
    reason = "gave numbers that are not finite"
    try:
        sampler.kernel.dispatcher(sampler.numbers[0], t, u, x, dx, y)
    except USER_ERRORS as error:
        y[:], reason = np.nan, f"raised {type(error).__name__}: {str(error).rstrip('.')}"
    if np.isfinite(dx).all() and np.isfinite(y).all():
        return dx, y
    text = f"The law {sampler.kernel.name!r} of controller {sampler.name!r} {reason},"
    raise KernelError(f"{text} at t = {t:.6g} s with the inputs u = {u.tolist()} and the states x = {x.tolist()}.")


def _inputs(sampler: Sampler, t: float, signals: np.ndarray) -> np.ndarray:
    """Inputs of a controller at an instant."""
    found = np.zeros(len(sampler.inputs))
    for k, (wanted, own) in enumerate(zip(sampler.inputs, sampler.numbers[1:], strict=True)):
        if isinstance(wanted, MotionInput):
            s, speed, _ = wanted.motion.kernel(own, t)
            found[k] = speed if wanted.rate else s
        else:
            found[k] = signals[wanted]
    return found
