"""Inverse dynamics: the drive forces that a prescribed motion of a rigid mechanism takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmb import arguments, checks, display
from flexmb.display import counted, cut, listed
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError
from flexmb.findings.finding import Finding, found, sentences
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import refuse_controllers
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import resolve
from flexmb.statics.equilibrium import reactions
from flexmb.statics.start.consistent import accelerations, close_loops, degrees_of_freedom, rigid_velocities


@dataclass(frozen=True, repr=False)
class DrivenMotion:
    """Positions, velocities, accelerations, drive and joint forces at given instants."""

    time: np.ndarray  # (n,) instants [s]
    q: np.ndarray  # q, v, a: (n, n_q) coordinates and their derivatives
    v: np.ndarray
    a: np.ndarray
    names: tuple[str, ...]  # (n_q,) names of the coordinates
    aliases: dict[str, str]  # other names of nodes
    # for every joint and drive (n, 3): fx, fy on the second body [N] and moment or drive torque [N m, N]
    forces: dict[str, np.ndarray]
    # on parts that a run may show in another way: contacts taken as closed, laws with a history
    findings: tuple[Finding, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences of the findings."""
        return sentences(self.findings)

    def __repr__(self) -> str:
        span = f", {self.time[0]:.6g} to {self.time[-1]:.6g} s" if len(self.time) else ""
        head = f"Driven motion: {counted(len(self.time), 'instant')}{span}; {counted(len(self.names), 'coordinate')}"
        return "\n".join([cut(f"{head}; forces of {listed(self.forces) or 'no part'}", 3), *self.notes])

    def _repr_html_(self) -> str:
        peaks = [(name, *(f"{x:.6g}" for x in np.abs(found).max(axis=0))) for name, found in self.forces.items()]
        head, _, sizes = repr(self).partition("\n")[0].partition(": ")
        heads = ("largest of", "fx [N]", "fy [N]", "moment or drive force [N m, N]")
        folded = display.folded("coordinates", display.texts(self.names))
        return display.page(head, sizes, display.table(peaks, heads), display.texts(self.notes), folded)

    def position(self, name: str) -> np.ndarray:
        """(n,) a coordinate [m, rad], such as "slider.x"."""
        place = resolve(name, self.aliases)
        return self.q[:, self.names.index(checks.one_of("DrivenMotion", "coordinate", place, self.names))]

    def torque(self, drive: str) -> np.ndarray:
        """(n,) torque of a drive on the second body of its joint [N m], or force [N]."""
        return self.forces[checks.one_of("DrivenMotion", "drive", drive, self.forces)][:, 2]


@arguments.checked
def inverse_dynamics(mechanism: Mechanism, times: Sequence[float] | np.ndarray) -> DrivenMotion:
    """Motion and forces of a mechanism whose drives prescribe every motion; joints are ideal, bodies rigid.

    Positions, velocities and accelerations follow from the joints and drives alone, one instant at a time, without any
    integration in time; then the forces follow from the equations of motion.  Friction acts in ideal joints and in
    clearance joints, which are taken as ideal.  Cables, stops and other contacts that no ideal joint replaces push and
    pull as their laws say.  `notes` name contacts taken as closed.  Declared start velocities play no part.

    Parameters
    ----------
    mechanism : as many drives as degrees of freedom; clearance joints are taken as ideal.
    times : increasing instants [s].

    Raises
    ------
    InputError : flexible bodies, too few drives.
    AssemblyError : a loop that cannot close on the way.
    """
    refuse_controllers(mechanism, "inverse_dynamics", "the motion is given, and a controller would ask for another")
    program = compile_mechanism(mechanism, start=True, touching=True)
    label = f"inverse_dynamics {mechanism.name!r}"
    if program.n_q != 3 * len(program.names.bodies):
        raise InputError(f"{label}: flexible bodies have motions of their own; make them rigid for inverse dynamics.")
    q, _ = close_loops(program, {})
    if free := degrees_of_freedom(program, q)[0]:
        raise InputError(f"{label}: {free} degree(s) of freedom are not driven; add drives or use simulate.")
    system = StateEvaluation(program)
    given = checks.sequence(label, "times", times, "instants [s]")
    instants = np.array([checks.number(label, f"times[{k}]", t, "s") for k, t in enumerate(given)])
    # drives prescribe all velocities; what bodies declare holds at the start alone
    program = replace(program, reference=replace(program.reference, v=np.full(program.n_q, np.nan)))
    rows = []
    for t in instants:
        q, _ = close_loops(program, {}, start=q, t=float(t))
        v = rigid_velocities(program, q, float(t))
        a, lam = accelerations(program, q, v, float(t))
        rows.append((q, v, a, reactions(program, system.at(q, v, a, lam, t=float(t)), q, lam, driving=True)))
    forces = {name: np.array([row[3][name] for row in rows]) for name in (rows[0][3] if rows else {})}
    q_all, v_all, a_all = (np.array([row[k] for row in rows]) for k in range(3))
    parts, findings, names = mechanism.contributions(), list[Finding](), program.names
    ideal = tuple(dict.fromkeys(c.part for c in parts.constraints if c.holds != "always"))
    if ideal:
        text = f"Taken as ideal joints, which neither slip, yield nor lift off, and have no ends: {listed(ideal)}."
        findings.append(found("ideal-joints", ideal, f"{text} Where a run shows otherwise, its forces differ."))
    rubbing = [(c.part, c.joint_friction.friction) for c in parts.constraints if c.joint_friction]
    rubbing += [(c.part, c.friction) for c in parts.contacts]
    remembering = tuple(dict.fromkeys(part for part, law in rubbing if law.history()))
    if remembering:
        text = f"Friction of {listed(remembering)} follows from a history, of which single instants know nothing: it is"
        findings.append(found("unknown-history", remembering, f"{text} that of the start of a run."))
    return DrivenMotion(instants, q_all, v_all, a_all, names.coordinates, names.aliases, forces, tuple(findings))
