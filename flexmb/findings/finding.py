"""Findings before, during and after a run, with code, parts, text, remedy and numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

from flexmb import checks
from flexmb.display import cut
from flexmb.fields import field, record

ERROR, WARNING, NOTE = "error", "warning", "note"
SEVERITIES = (ERROR, WARNING, NOTE)  # no right result; a result that is hardly what was meant; worth knowing
CODES: dict[str, tuple[str, str]] = {
    "not-compilable": (ERROR, "a part does not fit its bodies, or a kernel cannot be compiled or returns NaN"),
    "not-solvable": (
        ERROR,
        "equations of the reference configuration have no solution, for a reason that is not known",
    ),
    "open-loop": (ERROR, "a loop of joints cannot close: its links are too short or too long"),
    "contradicting-joints": (ERROR, "joints ask for different things in every pose"),
    "redundant-joints": (ERROR, "joints repeat one another in every pose, so their forces are not unique"),
    "singular-pose": (ERROR, "joints repeat one another in the reference configuration alone: a dead centre"),
    "over-driven": (ERROR, "drives prescribe what joints or other drives prescribe already"),
    "locking-drive": (ERROR, "a loop closes only in a part of the motion of its drives"),
    "no-inertia": (ERROR, "a motion has no inertia"),
    "forbidden-velocity": (ERROR, "no start velocities satisfy joints, drives and declared velocities"),
    "driving-friction": (ERROR, "a friction law drives the surfaces instead of braking them"),
    "pulling-contact": (ERROR, "a normal law pulls, or pushes where the surfaces are apart"),
    "broken-kernel": (ERROR, "a kernel breaks its contract: wrong derivatives, unequal action and reaction, NaN"),
    "wrong-rate": (ERROR, "a prescribed motion has a rate that is not the derivative of its value"),
    "jumping-drive": (ERROR, "a prescribed motion jumps without announcing it"),
    "buckled": (ERROR, "the declared loads alone buckle the structure"),
    "other-branch": (WARNING, "loops are assembled on another branch than the one drawn"),
    "branch-point": (WARNING, "the drives pass a singular pose, where two branches of the motion cross"),
    "free-body": (WARNING, "a body hangs on nothing"),
    "hidden-over-drive": (WARNING, "drives prescribe more than ideal joints would allow; clearances have to yield"),
    "overshooting-table": (WARNING, "a table's spline overshoots between its points"),
    "left-out-link": (WARNING, "a link ends at a joint of other bodies, and is joined to nothing there"),
    "far-joint": (WARNING, "a joint lies far beyond the end of its link"),
    "large-clearance": (WARNING, "a clearance is not small against the parts beside it"),
    "soft-contact": (WARNING, "loads press surfaces into each other by much of the radius"),
    "thick-arc": (WARNING, "the outline of a thick arc's section is unknown: its stress is that of a straight beam"),
    "stubby-beam": (WARNING, "a beam is too short for its height: Euler-Bernoulli theory does not hold"),
    "coarse-cells": (WARNING, "linear cells are too few across a plane body, which is then too stiff in bending"),
    "overload": (WARNING, "the declared loads alone stress a flexible body beyond yield"),
    "near-buckling": (WARNING, "the declared loads are more than half of the buckling load"),
    "odd-units": (WARNING, "a number looks as if it were given in another unit"),
    "far-origin": (WARNING, "the mechanism lies far from the origin of the coordinates, which lose digits"),
    "unstable-reference": (WARNING, "a small motion runs away from the reference configuration"),
    "unstable-loop": (WARNING, "a control loop lets a small motion grow"),
    "stiffness-ratio": (WARNING, "a stiffness is so large that its round-off is felt beside loads or slow vibrations"),
    "coarse-step": (WARNING, "a fixed step is too long for a contact, a vibration or a motion"),
    "thick-film": (NOTE, "a gap is too thick for the theory of thin films"),
    "width-of-wear": (NOTE, "a joint wears whose width is not given"),
    "upward-gravity": (NOTE, "gravity points upwards"),
    "nothing-moves": (NOTE, "no gravity, load, drive or velocity sets the mechanism in motion"),
    "free-motion": (NOTE, "motions that no drive prescribes"),
    "no-frequencies": (NOTE, "natural frequencies cannot be computed"),
    "no-statics": (NOTE, "the equilibrium under the declared loads cannot be computed, so stresses were not examined"),
}
"""Severity and meaning of each code of `check`."""

CODES_OF_RUNS: dict[str, tuple[str, str]] = {  # the same of further codes of runs, of buckling and of inverse dynamics
    "deep-contact": (WARNING, "surfaces are pressed into each other by much of their size; an error beyond it"),
    "large-strain": (WARNING, "a body strains by more than linear elasticity allows, or beyond yield"),
    "large-deformation": (WARNING, "a reduced body deforms by much of its size; an error beyond half of it"),
    "missing-shapes": (WARNING, "the shapes that a reduced body keeps leave out much of its strain energy"),
    "unreal-motion": (WARNING, "a part moves or pulls as no real one could"),
    "short-table": (WARNING, "the table of a part ended before the run, and went on at its last slope"),
    "left-validity": (WARNING, "a contact law left the range that it is made for"),
    "turbulent-film": (NOTE, "an oil film is not laminar"),
    "slow-onset": (NOTE, "contacts began slower than the law's least approach speed"),
    "lasting-contact": (NOTE, "a contact had no onset for a period"),
    "lost-vibration": (WARNING, "the steps lose phase or amplitude of a vibration that carries energy"),
    "passed-contact": (ERROR, "a fixed step went by a contact"),
    "no-number": (ERROR, "a saved signal is no finite number"),
    "failed-step": (ERROR, "a step failed, for a reason outside of the mechanism"),
    "refused-step": (NOTE, "forces and contacts of the step that was refused"),
    "strength": (NOTE, "largest stress of a body, and its safety against yield"),
    "broken-question": (WARNING, "a method of a part that yields findings failed"),
    "bookkeeping": (NOTE, "what a method or a checkpoint has to say on a run"),
    "bending-load": (WARNING, "loads bend a structure before it buckles, so linear load factors cannot be relied on"),
    "ideal-joints": (NOTE, "inverse dynamics takes contacts and elastic joints as ideal joints"),
    "unknown-history": (NOTE, "inverse dynamics knows nothing of the history of a friction law"),
}

NOTHING_MOVES = "Nothing sets the mechanism in motion."
# Sentences on a mechanism that stays at rest.
WHAT_MOVES = "Give gravity=(0, -9.81), a load, a drive such as Drive(..., ConstantSpeed(10.0)), or a start velocity."


@record
class Finding:
    """One finding of `check` or of a run."""

    code: str = field("stable name of the kind, one of `CODES` or `CODES_OF_RUNS`")
    parts: tuple[str, ...] = field("names of the parts concerned")
    text: str = field("a sentence on what is wrong, with numbers")
    remedy: str = field("a sentence on what to do")
    severity: str = field('"error", "warning" or "note"')
    numbers: dict[str, float] = field(
        'numbers of the text by name, in SI units; the one that is passed, if there is one, has the name "limit"',
        default_factory=dict,
    )

    def __post_init__(self) -> None:
        checks.one_of("Finding", "severity", self.severity, SEVERITIES)
        object.__setattr__(self, "parts", tuple(self.parts))
        object.__setattr__(self, "numbers", {name: float(value) for name, value in self.numbers.items()})

    def __repr__(self) -> str:
        return cut(str(self), 3)

    @property
    def sentence(self) -> str:
        """Text and remedy, as notes and the status of a run show them."""
        return f"{self.text} {self.remedy}".rstrip()

    @property
    def is_error(self) -> bool:
        """Whether there can be no right result."""
        return self.severity == ERROR

    def __str__(self) -> str:
        """One line, or two with the remedy."""
        return f"{self.severity} [{self.code}] {self.sentence}"

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {**asdict(self), "parts": list(self.parts)}


def found(
    code: str, parts: Sequence[str], text: str, remedy: str = "", *, wrong: bool = False, **numbers: float
) -> Finding:
    """A finding with the severity of its code, or an error if `wrong`; `numbers` stand in its text."""
    severity = ERROR if wrong else (CODES.get(code) or CODES_OF_RUNS[code])[0]
    return Finding(code, tuple(parts), text, remedy, severity, numbers)


def sentences(findings: Iterable[Finding], *, errors: bool = False) -> tuple[str, ...]:
    """Sentences of the errors among findings, or of all others."""
    return tuple(finding.sentence for finding in findings if finding.is_error == errors)
