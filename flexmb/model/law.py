"""Bases of laws, and materials.

The parameters of a law are its fields in the order of declaration; a law that computes them overrides `parameters`.
"""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from numbers import Real
from typing import Any, ClassVar

import numpy as np

from flexmb import kernels
from flexmb.display import Shown
from flexmb.errors import USER_ERRORS, InputError, KernelError
from flexmb.fields import Input, field, instance, positive, record
from flexmb.findings.finding import Finding


@record
class Material(Input, Shown):
    """Linear elastic, isotropic material.

    Without a yield stress a run does not say where a contact yields.

    Raises
    ------
    InputError : a value out of its range.

    Examples
    --------
    >>> aluminium = Material(young=71.7e9, density=2710.0, poisson=0.333)
    >>> aluminium.young
    71700000000.0
    """

    young: float = field("Young's modulus E", "Pa", positive, hint="Young's modulus of steel is 207e9 Pa.")
    density: float = field("rho", "kg/m^3", positive)
    poisson: float = field("Poisson's ratio nu, -1 < nu < 0.5; of contacts, and of beams with shear", default=0.3)
    yield_stress: float | None = field("uniaxial yield stress Y; None: not known", "Pa", positive, default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not -1.0 < self.poisson < 0.5:
            text = f"Material: poisson is {self.poisson:g}; it must lie between -1 and 0.5, both excluded."
            raise InputError(f"{text} For rubber take 0.499.")

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G = E/(2 (1 + nu)) [Pa]."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa], the share of one body in the compliance of a Hertz contact.

        Source: K. L. Johnson, Contact Mechanics, Cambridge University Press 1985, eq. (4.20): 1/E* is its sum of both.
        """
        return (1.0 - self.poisson**2) / self.young


STEEL = Material(207e9, 7801.0, 0.29)
"""Carbon steel: 207 GPa, 7801 kg/m^3 (76.5 kN/m^3), 0.29.

Source: J. E. Shigley, C. R. Mischke, Mechanical Engineering Design, appendix A, physical constants of materials.
"""

# Largest deviation of chords over the swing of a motion; the number of such chords in a cycle of a sine.
CHORD, CHORDS_OF_A_SINE = 0.0123, 20.0
SAMPLES, GOLDEN = 64, 0.6180339887498949  # of a motion of unknown course; their distance modulo 1, of no period
HALVINGS = 60  # number of halvings by which the depth under a force is found


def values_of(kernel: kernels.Kernel, *arguments: Any) -> np.ndarray:
    """Numbers that a kernel returns, in plain Python; NaN where it raises an exception."""
    try:
        with np.errstate(all="ignore"):
            return np.atleast_1d(np.array(kernel(*arguments), dtype=float))
    except USER_ERRORS:
        return np.full(3, np.nan)


def require_kernel(cls: type, contract: kernels.Contract, name: str = "kernel") -> None:
    """Check, when a class is made, that its attribute `name` is a kernel of the right contract."""
    kernel = getattr(cls, name, None)
    if kernel is None:
        return  # an abstract base in between, or a kernel that may be left out
    if not isinstance(kernel, kernels.Kernel) or kernel.contract is not contract:
        text = f"{cls.__name__}.{name} is {kernel!r};"
        raise KernelError(f"{text} it must be a function decorated as a {contract.name} kernel.")


def number_fields(owner: Any, skip: tuple[str, ...] = ()) -> tuple[float, ...]:
    """The numeric fields of a dataclass instance, in order of declaration."""
    values = ((f.name, getattr(owner, f.name)) for f in fields(owner) if f.name not in skip)
    # most are floats: asking an abstract base class takes longer
    return tuple([float(v) for _, v in values if type(v) is float or (isinstance(v, Real) and not isinstance(v, bool))])


@record
class Law(Input, Shown, ABC):
    """Base of all laws: a kernel, its parameters, the start values of its history."""

    kernel: ClassVar[kernels.Kernel]
    contract: ClassVar[kernels.Contract]

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        if "contract" not in cls.__dict__:
            require_kernel(cls, cls.contract)

    def __post_init__(self) -> None:
        if getattr(type(self), "kernel", None) is None:
            raise KernelError(f"{type(self).__name__} has no kernel; it cannot be used as a law.")
        super().__post_init__()

    def parameters(self) -> tuple[float, ...]:
        """Parameters p of the kernel."""
        return number_fields(self)

    def history(self) -> tuple[float, ...]:
        """Start values of the law's history z."""
        return ()

    def findings(self, part: str) -> Iterable[Finding]:  # noqa: ARG002 - of tables alone
        """Findings on the numbers of the law, which belongs to a `part`."""
        return ()


@record
class NormalLaw(Law):
    """Base of normal contact laws; the kernel returns N >= 0 and its derivatives by gap and gap rate."""

    contract = kernels.NORMAL

    def for_radii(self, bearing_radius: float, journal_radius: float) -> NormalLaw:  # noqa: ARG002 - seldom asked
        """The law for `bearing_radius` and `journal_radius` [m]; overridden where the stiffness depends on them."""
        return self

    def lasting_history(self) -> tuple[float, ...]:
        """History of a contact at rest that has lasted for long, in which a run can begin."""
        return self.history()

    def depth_under(self, force: float, most: float) -> float:
        """Depth at which the law carries a `force` [m]; inf where a depth of `most` is not enough."""
        p, z = np.array(self.parameters(), dtype=float), np.array(self.history(), dtype=float)
        low, high = 0.0, most
        if values_of(self.kernel, p, 1e-5, -high, 0.0, z.copy(), z.copy())[0] < force:
            return math.inf
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            less = values_of(self.kernel, p, 1e-5, -middle, 0.0, z.copy(), z.copy())[0] < force
            low, high = (middle, high) if less else (low, middle)
        return high

    def remarks(self, history: Sequence[float]) -> tuple[str, ...]:  # noqa: ARG002 - seldom asked
        """Remarks on the validity of the law, from its `history` at the end of a run; empty if it held."""
        return ()

    def remarks_on(
        self, intervals: Mapping[str, np.ndarray], history: Sequence[float], since: float  # noqa: ARG002 - seldom asked
    ) -> Iterable[tuple[str, str]]:  # fmt: skip
        """Codes and texts of remarks on the contact `intervals` of a run, by the names of their columns.

        `history` is that at the end; contacts that began before the instant `since` [s] count as lasting.
        """
        return ()

    def damped_since_onset(self, history: Sequence[float]) -> str:  # noqa: ARG002 - seldom asked
        """Sentence on the speed that scales the damping of a lasting contact of that `history`; "" without damping."""
        return ""


NORMAL_LAW = instance(NormalLaw, "a normal law, e.g. LankaraniNikravesh")  # rule of a field that holds a normal law


@record
class FrictionLaw(Law):
    """Base of friction laws; the kernel returns the force T on the second body along the slip direction."""

    contract = kernels.FRICTION
    formerly = (("mu", "coefficient", "0.3"),)


FRICTION_LAW = instance(FrictionLaw, "a friction law, e.g. ModifiedCoulomb")  # rule of a field that holds one


@record
class Motion(Law):
    """Base of prescribed motions; the kernel returns s, s_dot, s_ddot from the reference configuration.

    The same records are time functions s of loads.  At a jump, a motion has the values just after it.
    """

    contract = kernels.MOTION
    is_smooth: ClassVar[bool] = True
    """Whether s and s_dot are continuous, which a joint needs; otherwise it can only be the history of a load."""
    swings: ClassVar[bool] = True
    """Whether s may go to and fro between two breaks, so that steps can miss it."""

    def breaks(self, t_end: float) -> tuple[float, ...]:  # noqa: ARG002 - most motions have none
        """Instants in (0, `t_end`] at which s, s_dot or s_ddot jumps [s]; a run restarts there."""
        return ()

    @property
    def period(self) -> float | None:
        """Period of the motion [s]; None for a motion without a period."""
        return None

    def findings_beyond(self, part: str, t: float) -> Iterable[Finding]:  # noqa: ARG002 - of tables alone
        """Findings on the motion of a load or other `part` in a run that came to the instant `t` [s]."""
        return ()

    def longest_chord(self, begin: float, end: float) -> float:
        """Longest distance of instants in `begin` to `end` [s] whose chords keep to `CHORD` of the swing; or inf."""
        if not self.swings:
            return math.inf
        p, d = np.array(self.parameters(), dtype=float), 1e-6 * (end - begin)
        times = begin + d + (end - begin - 2.0 * d) * (np.arange(SAMPLES) * GOLDEN % 1.0)
        try:
            before, now, after = (np.array([self.kernel(p, float(t))[0] for t in times + x]) for x in (-d, 0.0, d))
        except USER_ERRORS:
            return math.inf  # told by other checks
        bend, swing = np.abs(before - 2.0 * now + after).max() / d**2, swing_of(times, now)
        found = math.sqrt(8.0 * CHORD * swing / bend) if bend > 0.0 else math.inf
        # longer ones are slow, or round-off of straight lines
        return found if found < 0.1 * (end - begin) else math.inf


def swing_of(times: np.ndarray, values: np.ndarray) -> float:
    """Half of the range of values about their straight line; at least 1e-3 of the largest, below which none counts."""
    rest = values - np.polyval(np.polyfit(times, values, 1), times)
    return float(max(0.5 * np.ptp(rest), 1e-3 * np.abs(values).max()))
