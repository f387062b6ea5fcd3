"""Report on a mechanism: degrees of freedom, redundant joints, mass, natural frequencies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.equilibrium.modes import modes
from flexmb.errors import FlexmbError
from flexmb.linalg.rank import row_rank
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.start.assemble import close_loops
from flexmb.start.consistent import degrees_of_freedom
from flexmb.system.state_evaluation import StateEvaluation

LISTED_FREQUENCIES = 10


@dataclass(frozen=True)
class Report:
    """Findings of `check`.

    Parameters
    ----------
    name : the mechanism.
    bodies, joints, contacts : names.
    coordinates : number of coordinates.
    rows : number of constraint rows, drives included.
    freedom : degrees of freedom of the bodies taken as rigid, clearance joints as ideal, without the drives.
    drives : names of the drives.
    free : degrees of freedom that the drives leave.
    redundant : joints that repeat what others say.
    mass : total mass [kg].
    frequencies : lowest natural frequencies [Hz] in the reference configuration, drives held fast.
    notes : what deserves attention.
    """

    name: str
    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    contacts: tuple[str, ...]
    coordinates: int
    rows: int
    freedom: int
    drives: tuple[str, ...]
    free: int
    redundant: tuple[str, ...]
    mass: float
    frequencies: tuple[float, ...]
    notes: tuple[str, ...]

    def __str__(self) -> str:
        """A small table."""
        lines = [
            f"Mechanism {self.name!r}",
            f"  bodies              {len(self.bodies)}: {_list(self.bodies)}",
            f"  mass                {self.mass:.6g} kg",
            f"  ideal joints        {len(self.joints)}: {_list(self.joints)}",
            f"  clearance joints    {len(self.contacts)}: {_list(self.contacts)}",
            f"  equations           {self.coordinates} coordinates, {self.rows} constraint rows",
            f"  degrees of freedom  {self.freedom} (rigid bodies, clearances closed), {len(self.drives)} driven"
            f"{': ' + _list(self.drives) if self.drives else ''}, {self.free} free",
            f"  redundant joints    {_list(self.redundant) if self.redundant else 'none'}",
            f"  frequencies [Hz]    {', '.join(f'{f:.4g}' for f in self.frequencies) or 'none (nothing can vibrate)'}",
        ]
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])


def check(mechanism: Mechanism) -> Report:
    """Look at a mechanism before it moves.

    Parameters
    ----------
    mechanism : the mechanism.

    Raises
    ------
    AssemblyError, KernelError, InputError : a mechanism that cannot be compiled or assembled.
    """
    moving, program = compile_mechanism(mechanism), compile_mechanism(mechanism, closed=True)
    q, _ = close_loops(program, {})
    free, freedom = degrees_of_freedom(program, q)
    system = StateEvaluation(program)
    mass = total_mass(program.n_q, system.mass(q))
    found = row_rank(StateEvaluation(moving).at(q).jacobian)
    redundant = tuple(sorted({moving.names.rows[k].partition("[")[0] for k in found.redundant}))
    notes = []
    try:
        vibrations = modes(mechanism, count=LISTED_FREQUENCIES)
        frequencies = tuple(float(f) for f in vibrations.frequencies)
        if any(f < 0.0 for f in frequencies):
            notes.append("a negative frequency marks a motion that runs away from the reference configuration.")
    except FlexmbError as error:
        frequencies = ()
        notes.append(f"no frequencies: {error}")
    if redundant:
        notes.append(f"over-constrained or singular pose: {', '.join(redundant)} repeat what other joints say.")
    if free > 0:
        notes.append(f"{free} degree(s) of freedom are not driven: they move as the loads want.")
    if free < 0 or freedom < len(program.drives):
        notes.append("more drives than degrees of freedom.")
    joints = dict.fromkeys(row.partition("[")[0] for row in moving.names.rows)
    return Report(
        mechanism.name,
        program.names.bodies,
        tuple(j for j in joints if j not in moving.drives),
        moving.names.contacts,
        moving.n_q,
        moving.n_c,
        freedom,
        moving.drives,
        free,
        redundant,
        mass,
        frequencies,
        tuple(notes),
    )


def total_mass(n_q: int, M) -> float:
    """Mass that a uniform velocity along x carries [kg]."""
    along = np.zeros(n_q)
    along[0::3] = 1.0
    return float(along @ (M @ along))


def _list(names: tuple[str, ...]) -> str:
    return ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
