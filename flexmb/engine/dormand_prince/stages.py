"""Work arrays of the method of Dormand and Prince: its stages, the start of a step, powers, coefficients between."""

from __future__ import annotations

from flexmb.engine.compiled.records import Matrix, Record, Vector
from flexmb.engine.dormand_prince.complement import Complement, complement
from flexmb.engine.dormand_prince.tableau import ALL_STAGES, DENSE_WEIGHTS, ERRORS, A, C
from flexmb.engine.radau.collocation import OldState, Works
from flexmb.engine.system.work import new_from_template
from flexmb.program.program import Program

LEDGER = 11  # number of the energies of a ledger
DENSE = 7  # number of coefficients of the dense output


class Span(Record):
    """Start and size of the last step [s]; 1 with its dense output, 1 where the state is of another method."""

    start: float
    size: float
    dense: int
    foreign: int


class Stages(Record):
    """Stages of a step, and its workspace."""

    span: Span
    complement: Complement
    works: Works
    old: OldState  # old, between: start of the last step, and an instant within it
    between: OldState
    tableau: Matrix  # tableau, instants, errors, weights: `A`, `C`, `ERRORS` and `DENSE_WEIGHTS` of the method
    instants: Vector
    errors: Matrix
    weights: Matrix
    Q: Matrix  # Q, V, A: (16, n_q + 3) positions, velocities and accelerations of the stages
    V: Matrix
    A: Matrix
    L: Matrix  # (16, n_c) multipliers
    rates: Matrix  # (16, 11) rates of the ledger at the stages [W]
    of_q: Matrix  # of_q, of_v, of_ledger: (7, ...) coefficients of the dense output
    of_v: Matrix
    of_ledger: Matrix
    error_q: Vector  # error_q, error_v: (n_q + 3,) errors, and other sums over the stages
    error_v: Vector
    x: Vector  # x, y: (n_q + n_c,), pair : (2 (n_q + n_c),)
    y: Vector
    pair: Vector
    losses: Matrix  # (0, 2) none, since there are no contacts
    zero: Vector  # (n_q + 3,)
    signals: Vector  # (n_y,) at an instant within


def new_stages(program: Program) -> Stages:
    """Work arrays for a compiled mechanism."""
    return new_from_template(program, "stages", lambda: _zero_stages(program), complement=complement(program))


def _zero_stages(program: Program) -> Stages:
    n, m = program.n_q + 3, program.n_c
    return Stages(
        span=Span.zeros(),
        complement=complement(program),
        works=Works.zeros(),
        **{name: _old(program) for name in ("old", "between")},
        tableau=A,
        instants=C,
        errors=ERRORS,
        weights=DENSE_WEIGHTS,
        **dict.fromkeys(("Q", "V", "A"), (ALL_STAGES, n)),
        L=(ALL_STAGES, m),
        rates=(ALL_STAGES, LEDGER),
        **dict.fromkeys(("of_q", "of_v"), (DENSE, n)),
        of_ledger=(DENSE, LEDGER),
        **dict.fromkeys(("error_q", "error_v", "zero"), n),
        **dict.fromkeys(("x", "y"), program.n_q + m),
        pair=2 * (program.n_q + m),
        losses=(0, 2),
        signals=program.tables.sizes.n_y,
    )


def _old(program: Program) -> OldState:
    n = program.n_q + 3
    return OldState(q=n, v=n, a=n, z=program.tables.sizes.n_z, lam=program.n_c, ledger=LEDGER)
