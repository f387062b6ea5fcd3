"""Natural frequencies and modes of the linearised mechanism."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from flexmb import arguments, checks, display
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError, SolveError
from flexmb.fields import field, record
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import refuse_controllers
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program, resolve
from flexmb.statics.eigen import damped as damped_modes
from flexmb.statics.eigen import free_motions, motion_in_words, moves_most, shapes_of, undamped
from flexmb.statics.equilibrium import left_out_text, open_contacts, refuse_other_forces, refuse_other_names, unpaired
from flexmb.statics.found import Equilibrium, Spin, check_spin
from flexmb.statics.start.assemble import close_loops

ENERGY_ROUND_OFF = 1e-15  # strain energy over the sum of its absolute terms, below which it is round-off
ASYMMETRY_ROUND_OFF = 1e-11  # asymmetry of the stiffness over its largest entry, above which it is no round-off
ASYMMETRY_OF_DIFFERENCES = 1e-7  # the same with controllers, whose laws and measured inputs are differenced
# Sentence on contacts that are left out.
REMEDY = "Give at=fm.static_equilibrium(mechanism) of a pose in which they carry."
SHOWN_MODES = 6  # number of frequencies at most in a text


@record
class Modes:
    """Modes about a pose, drives held fast; `print(modes)` shows a table."""

    frequencies: np.ndarray = field(
        "(n,) natural frequencies [Hz], ascending; 0 for a rigid motion, negative for an unstable one "
        "(-sqrt(|omega^2|)/2 pi). With damping or rotation those of the damped vibration, |Im s|/2 pi, ordered by |s|"
    )
    shapes: np.ndarray = field("(n_q, n) mode shapes, normalised to x^T M x = 1; complex with damping or rotation")
    names: tuple[str, ...] = field("(n_q,) names of the coordinates")
    aliases: dict[str, str] = field("other names of nodes")
    rigid: int = field("number of rigid motions; they come first")
    kinds: tuple[str, ...] = field(
        '(n,) what each mode is: "rigid: rotation of \'rod\'", "elastic", "overdamped", "unstable", or "not '
        'resolved" where the strain energy is lost in the round-off of the stiffness'
    )
    moves: tuple[str, ...] = field("(n,) coordinates that the modes move most, rotations times the size")
    eigenvalues: np.ndarray = field("(n,) complex s [1/s]: motions grow as exp(s t)")
    damping: np.ndarray = field("(n,) damping ratios -Re s/|s|; negative where the motion grows, 0 where s is 0")
    left_out: tuple[str, ...] = field(
        "contacts without a part in these modes: all, about an equilibrium the open ones", default=()
    )

    def shape(self, mode: int, name: str) -> float | complex:
        """Amplitude of a coordinate, `name` "rod.node3.y", in the `mode` of this number, from 0."""
        if not 0 <= checks.count("Modes", "mode", mode, 0) < self.shapes.shape[1]:
            raise InputError(f"Modes: mode is {mode}; there are modes 0 to {self.shapes.shape[1] - 1}.")
        place = resolve(name, self.aliases)
        value = self.shapes[self.names.index(checks.one_of("Modes", "coordinate", place, self.names)), mode]
        return complex(value) if np.iscomplexobj(self.shapes) else float(value)

    def __repr__(self) -> str:
        elastic = [f"{f:.4g}" for f in self.frequencies[self.rigid :][:SHOWN_MODES]]
        more = ", ..." if len(self.frequencies) - self.rigid > SHOWN_MODES else ""
        rigid = f", {self.rigid} rigid" if self.rigid else ""
        shown = f"; {', '.join(elastic)}{more} Hz" if elastic else ""
        return f"Modes: {len(self.kinds)}{rigid}{shown}"

    def _repr_html_(self) -> str:
        columns = zip(self.frequencies, self.damping, self.kinds, self.moves, strict=True)
        rows = [(k, f"{f:.6g}", f"{d:.4g}", kind, moves) for k, (f, d, kind, moves) in enumerate(columns)]
        table = display.table(rows, ("mode", "frequency [Hz]", "damping", "kind", "moves most"))
        left_out = [left_out_text(self.left_out, REMEDY)] if self.left_out else []
        return display.page(repr(self), "", table, display.texts(left_out) if left_out else "")

    def __str__(self) -> str:
        """A table: number, frequency, damping ratio, kind, where it moves most; contacts that are left out."""
        if not self.kinds:
            return "no modes: nothing can move"
        left_out = [left_out_text(self.left_out, REMEDY)] if self.left_out else []
        width = max(4, *(len(kind) for kind in self.kinds))
        rows = [f"mode  frequency [Hz]  damping    {'kind':{width}}  moves most"]
        for k, kind in enumerate(self.kinds):
            ratio = f"{self.damping[k]:.4g}"
            rows.append(f"{k:4d}  {self.frequencies[k]:14.6g}  {ratio:9}  {kind:{width}}  {self.moves[k]}")
        return "\n".join([*rows, *left_out])


@arguments.checked
def modes(mechanism: Mechanism, count: int = 10, at: Equilibrium | None = None, damped: bool = False) -> Modes:
    """Natural frequencies and modes of small motions about the reference configuration or a static equilibrium.

    Drives hold their position.  Stiffness is that of the pose.  Gravity, forces and contacts count with `at` alone,
    since the reference configuration need not be an equilibrium: a taut cable, a pressed stop, a journal under load
    have the tangent stiffness of their laws there, open ones have none (`left_out`).  Without `at` clearance joints are
    ideal ones.  A controller without states that acts at all times, such as a PD law, has the stiffness of its law and,
    if `damped`, its damping.

    Equation (8.2) of docs/theory/equilibrium.md.

    Parameters
    ----------
    mechanism : the mechanism.
    count : number of modes, lowest first.
    at : a static equilibrium of the same mechanism, or of the one with ideal joints; one that spins makes gyroscopic
        modes, as seen from the turning frame.
    damped : with the damping of material and dampers; complex eigenvalues, and the shapes in their phases.

    Raises
    ------
    InputError : an equilibrium of another model; gravity or drives that are not steady in a turning frame.
    SolveError : the eigensolver did not converge; a motion without mass; forces without a potential, when
        `damped` is False.

    Notes
    -----
    Rigid motions are found first, body by body, from G and K alone, and the rest is computed orthogonal to them: no
    frequency is compared with another to tell a rigid motion from a slow one.  In a turning frame nothing is called
    rigid, since every motion has stiffness there.  See `flexmb.statics.found` for its matrices.
    Source: R. D. Cook, D. S. Malkus, M. E. Plesha, R. J. Witt, Concepts and Applications of Finite Element Analysis,
    4th ed., Wiley 2002, chapter 11; rotation: L. Meirovitch, Computational Methods in Structural Dynamics, Sijthoff and
    Noordhoff 1980, chapter 3.
    """
    count = checks.count("modes", "count", count)
    if not isinstance(damped, bool):
        raise InputError(f"modes: damped is {damped!r}; it must be True or False.")
    if at is not None and not isinstance(at, Equilibrium):
        raise InputError(f"modes: at is {at!r}; it must be what static_equilibrium(...) returns, or None.")
    spin = Spin(at.spin, at.about) if at is not None else Spin(0.0, (0.0, 0.0))
    reason = "motions under a controller with states of its own, or a sampled one, are no vibrations of the structure"
    refuse_controllers(mechanism, "modes", reason, with_memory=not spin.speed)
    program = _program_of(mechanism, at)
    system = StateEvaluation(program)
    q, lam = (close_loops(program, {})[0], np.zeros(program.n_c)) if at is None else (at.q, at.lam)
    K, C, M = spin.matrices(system, q, lam)
    G, left_out = system.jacobian, open_contacts(system) if at is not None else unpaired(mechanism)
    check_spin("modes", mechanism, program, system, spin)
    if at is not None:
        refuse_other_forces("modes", program, system, at)
    motions = np.zeros((0, 0)) if spin.speed else free_motions(program, q, K, G)
    rigid = shapes_of(program, q, motions, M) if motions.size else np.zeros((program.n_q, 0))
    left = max(count - rigid.shape[1], 0)
    real = not (damped or spin.speed)
    if not left:
        s, x = np.zeros(0), np.zeros((program.n_q, 0))
    elif real:
        refuse_asymmetry(program, K)
        K = 0.5 * (K + K.T)
        squares, x = undamped(K, M, G, rigid, left, program.symbolic.order)
        s = np.where(squares < 0.0, np.sqrt(np.abs(squares)) + 0j, 1j * np.sqrt(np.abs(squares)))
    else:
        s, x = _with_damping(K, C, M, G, rigid, left)
    kinds = [f"rigid: {motion_in_words(program, motion)}" for motion in motions.T[:count]]
    kinds += _kinds(K, s, x)
    s, shapes = np.append(np.zeros(rigid.shape[1]), s)[:count], np.hstack([rigid, x])[:, :count]
    frequencies = (np.abs(s.imag) - (s.real if real else 0.0)) / (2.0 * np.pi)  # of unstable real modes < 0
    damping = -s.real / np.where(s == 0.0, 1.0, np.abs(s)) + 0.0
    names, others = program.names.coordinates, program.names.aliases
    moves = tuple(moves_most(names, program.length, shape) for shape in shapes.T)
    return Modes(frequencies, shapes, names, others, rigid.shape[1], tuple(kinds), moves, s, damping, left_out)


def _with_damping(K: Any, C: Any, M: Any, G: Any, rigid: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and shapes beside the rigid motions."""
    # Rigid motions that no damper acts on are left out of the problem. Where one does, the problem keeps them: each has
    # s = 0 beside another s of its own, and the lowest |s| are those zeros with their round-off.
    damped_ones = np.abs(C @ rigid) > 1e-12 * (abs(C) @ np.abs(rigid))
    kept = rigid.shape[1] if damped_ones.any() else 0
    s, x = damped_modes(K, C, M, G, rigid, count + kept, kept=kept > 0)
    s, x = s[kept:], x[:, kept:]
    return s, x / np.sqrt(np.abs((x.conj() * (M @ x)).sum(axis=0)))


def _kinds(K: Any, s: np.ndarray, x: np.ndarray) -> list[str]:
    """Kinds of the modes that are not rigid motions."""
    energy = np.abs((x.conj() * (K @ x)).sum(axis=0))
    terms = (np.abs(x) * (abs(K) @ np.abs(x))).sum(axis=0)
    found = []
    for k, value in enumerate(s):
        growth = 1e-9 * np.abs(value)
        if energy[k] <= ENERGY_ROUND_OFF * terms[k] and np.abs(value.imag) > 0.0:
            found.append("not resolved")
        elif value.real > growth:
            found.append("unstable")
        else:
            found.append("elastic" if value.imag else "overdamped")
    return found


def _without_dead_loads(mechanism: Mechanism) -> Mechanism:
    """The mechanism without gravity and forces, whose stiffness would need the forces of the joints, too."""
    if not isinstance(mechanism, Mechanism):
        return mechanism  # compile says what it is
    controlled = {name for controller in mechanism.controllers for name in controller.control().loads}
    dead = {part.name for part in mechanism.parts if part.declared_load} - controlled
    return mechanism.with_loads([part for part in mechanism.parts if part.name not in dead], (0.0, 0.0))


def _program_of(mechanism: Mechanism, at: Equilibrium | None) -> Program:
    """Program about the reference configuration, bare, or about an equilibrium, also of ideal joints, with loads."""
    if at is None:
        return compile_mechanism(_without_dead_loads(mechanism), closed=True, controlled=True)
    program = compile_mechanism(mechanism)
    ideal = any(c.holds == "closed" for c in mechanism.contributions().constraints)
    if ideal and (len(at.q), len(at.lam)) != (program.n_q, program.n_c):
        program = compile_mechanism(mechanism, closed=True, controlled=True, touching=True)
    refuse_other_names("modes", program, at)
    return program


def refuse_asymmetry(program: Program, K: sp.csc_matrix) -> None:
    """`SolveError` for forces without a potential: their modes are complex, and may grow."""
    difference = sp.coo_array(abs(K - K.T))
    worst = int(difference.data.argmax()) if difference.nnz else -1
    allowed = ASYMMETRY_OF_DIFFERENCES if len(program.tables.controls.kernel) else ASYMMETRY_ROUND_OFF
    if worst < 0 or difference.data[worst] <= allowed * abs(K).max():
        return
    row, column = (program.names.coordinates[int(k[worst])] for k in (difference.row, difference.col))
    text = f"modes: the stiffness of mechanism {program.name!r} is not symmetric between {row!r} and {column!r},"
    text += " so it has no real modes. A follower force does this, or a controller that measures elsewhere than"
    raise SolveError(f"{text} it acts: ask for modes(..., damped=True), which shows flutter as growth.")
