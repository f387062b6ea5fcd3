"""Error that a run accumulates in free vibrations: phase and amplitude that the steps lose."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.errors import FlexmbError
from flexmb.joints.bushing import Bushing
from flexmb.loads.spring_damper import SpringDamper
from flexmb.loads.torsion_spring import TorsionSpring
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Element
from flexmb.program.program import Program
from flexmb.run.watch import Saved
from flexmb.step.newmark.method import Newmark
from flexmb.system.state_evaluation import StateEvaluation

if TYPE_CHECKING:
    from flexmb.equilibrium.modes import Modes

ELASTIC = (FlexibleBody, SpringDamper, TorsionSpring, Bushing, Element)
"""Parts that can hold a vibration."""

MODES = 8
"""Number of modes that are looked at."""

MOST_UNKNOWNS = 400
"""Number of coordinates above which modes would take too long."""

LEAST_INSTANTS = 30
"""Number of saved instants below which amplitudes are not known."""

ENERGY_SHARE = 0.01
"""Share of the energy of vibration above which a mode matters."""

SMALL = 0.1
"""Displacement up to which a vibration is small [rad, or relative to the size of the mechanism]."""

DECAY = 0.3
"""Amplitude in the last third of a run over that in the first one, below which a vibration has died out."""

LOST_PHASE, LOST_AMPLITUDE = 0.1, 2e-3
"""Phase [rad] and share of the amplitude that may be lost without a remark."""


class Loss(NamedTuple):
    """Loss of a vibration in a run.

    Parameters
    ----------
    phase : lag behind the exact vibration at the end [rad].
    amplitude : lost share of the amplitude.
    """

    phase: float
    amplitude: float


def vibration_remarks(mechanism: Mechanism, program: Program, saved: Saved, method: object, steps: int) -> list[str]:
    """Remarks on the fastest vibration that carries energy, where the steps lose a part of it that matters.

    For structures and springs without contacts, drives or free rigid motions, whose vibrations are small.

    Parameters
    ----------
    mechanism, program : the mechanism, and its program.
    saved : results of the run.
    method : method of integration.
    steps : number of steps.
    """
    if not isinstance(method, Newmark) or not _may_vibrate_freely(mechanism, program, saved):
        return []
    from flexmb.equilibrium.modes import modes

    try:
        found = modes(mechanism, count=MODES)
    except FlexmbError:
        return []
    mode, share = energetic_mode(program, saved, found)
    if mode < 0 or steps < 1:
        return []
    omega, span = 2.0 * np.pi * float(found.frequencies[mode]), float(saved.time[-1])
    loss = loss_of(method, omega, span / steps, steps)
    if abs(loss.phase) < LOST_PHASE and loss.amplitude < LOST_AMPLITUDE:
        return []
    return [
        f"The vibration of {found.frequencies[mode]:.4g} Hz (mostly {found.moves[mode]}) carries {100.0 * share:.3g} % "
        f"of the energy of vibration; until the end the steps lose some {abs(loss.phase):.2g} rad of its phase and "
        f"{100.0 * loss.amplitude:.2g} % of its amplitude. A smaller rtol or step, or RadauIIA(), loses less."
    ]


def _may_vibrate_freely(mechanism: Mechanism, program: Program, saved: Saved) -> bool:
    """Whether there are springs or beams, no drives and no contacts, and few coordinates that were all saved."""
    whole = saved.kept is None and len(saved.time) >= LEAST_INSTANTS and program.n_q <= MOST_UNKNOWNS
    if not whole or len(program.names.contacts) or program.drives:
        return False
    return any(isinstance(part, ELASTIC) for part in mechanism.parts)


def energetic_mode(program: Program, saved: Saved, found: Modes) -> tuple[int, float]:
    """Number of the fastest mode that carries energy, and its share; -1 where no small vibration goes on.

    Parameters
    ----------
    program : the compiled mechanism.
    saved : results of the run.
    found : natural modes.
    """
    places = [saved.signals.places.get(name, -1) for name in program.names.coordinates]
    if min(places) < 0 or found.rigid or len(found.frequencies) == 0 or found.frequencies[0] <= 0.0:
        return -1, 0.0
    x = saved.values[:, places] - saved.values[:, places].mean(axis=0)
    sizes = np.where(np.asarray(program.tables.kind) == 1, 1.0, program.length)
    if np.abs(x / sizes).max() > SMALL:
        return -1, 0.0
    y = x @ (StateEvaluation(program).mass(program.reference.q) @ np.real(found.shapes))
    energies = (2.0 * np.pi * found.frequencies) ** 2 * (y * y).mean(axis=0)
    if energies.sum() <= 0.0:
        return -1, 0.0
    shares = energies / energies.sum()
    third = len(y) // 3
    lasting = np.sqrt((y[-third:] ** 2).mean(axis=0)) > DECAY * np.sqrt((y[:third] ** 2).mean(axis=0))
    chosen = np.flatnonzero((shares > ENERGY_SHARE) & lasting)
    return (int(chosen[-1]), float(shares[chosen[-1]])) if len(chosen) else (-1, 0.0)


def loss_of(method: Newmark, omega: float, h: float, steps: int) -> Loss:
    """Loss of an undamped vibration in a number of equal steps.

    From the eigenvalues of the method's amplification matrix.

    Parameters
    ----------
    method : method of the Newmark family.
    omega : angular frequency [rad/s].
    h : size of the steps [s].
    steps : their number.

    Notes
    -----
    Source: J. Chung, G. M. Hulbert, A time integration algorithm for structural dynamics with improved numerical
    dissipation: the generalized-alpha method, Journal of Applied Mechanics 60 (1993) 371-375.
    """
    am, af, beta, gamma = method.alpha_m, method.alpha_f, method.beta, method.gamma
    k = (omega * h) ** 2  # with a = -k q / h^2, in the unknowns q, h v, h^2 x at both ends of a step
    after = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1.0 - af) * k, 0.0, 1.0 - am]])
    before = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1.0 - gamma], [-af * k, 0.0, -am]])
    values = np.linalg.eigvals(np.linalg.solve(after, before))
    principal = values[np.argmin(np.abs(values - np.exp(1j * omega * h)))]
    return Loss(steps * (omega * h - float(np.angle(principal))), 1.0 - float(np.abs(principal)) ** steps)
