"""Normal law of Lankarani and Nikravesh."""

from __future__ import annotations

from dataclasses import dataclass, replace

from flexmb import checks
from flexmb.contact.hertz import hertz_stiffness
from flexmb.contact.onset import HISTORY, approach_speed
from flexmb.errors import InputError
from flexmb.kernels import normal_law
from flexmb.model.law import NormalLaw
from flexmb.model.material import Material


@normal_law
def lankarani_nikravesh_kernel(p, h, gap, gap_rate, z, z_new):
    """N = K depth^n (1 + chi depth_rate / approach), chi = 3 (1 - e^2) / 4, never pulling."""
    K, n, e, least = p
    approach, by_gap, by_rate = approach_speed(h, gap, gap_rate, least, z, z_new)
    if gap >= 0.0:
        return 0.0, 0.0, 0.0
    chi = 0.75 * (1.0 - e * e)
    elastic = K * (-gap) ** n
    ratio = -gap_rate / approach
    factor = 1.0 + chi * ratio
    if factor <= 0.0:
        return 0.0, 0.0, 0.0
    by_approach = -elastic * chi * ratio / approach
    return (
        elastic * factor,
        n * elastic / gap * factor + by_approach * by_gap,
        -elastic * chi / approach + by_approach * by_rate,
    )


@dataclass(frozen=True)
class LankaraniNikravesh(NormalLaw):
    """Hertzian contact with hysteresis damping, N = K depth^n [1 + 3 (1 - e^2)/4 depth_rate/approach].

    `approach` is the closing speed where the contact began, located inside the step.

    Parameters
    ----------
    stiffness : K [N/m^n], > 0; None with `materials`: Hertz, from the radii of the joint.
    exponent : n, > 0.
    restitution : e asked for, in (0, 1].
    least_approach : lower bound of the approach speed [m/s], which keeps contacts that begin at rest from being
        damped without limit; 0 switches it off.
    materials : materials of bearing and journal, when `stiffness` is None.

    Raises
    ------
    InputError : values out of range; neither stiffness nor materials.

    Notes
    -----
    For restitution near 1; at low restitution the law returns far more than it is asked for.  The force is cut at zero,
    so it never pulls.
    Source: H. M. Lankarani, P. E. Nikravesh, A contact force model with hysteresis damping for impact analysis of
    multibody systems, Journal of Mechanical Design 112 (1990) 369-376.
    """

    stiffness: float | None = None
    exponent: float = 1.5
    restitution: float = 0.9
    least_approach: float = 1e-3
    materials: tuple[Material, Material] | None = None

    kernel = lankarani_nikravesh_kernel

    def __post_init__(self) -> None:
        super().__post_init__()
        name = type(self).__name__
        if self.stiffness is None and self.materials is None:
            raise InputError(f"{name}: stiffness is missing; give stiffness=..., or use {name}.from_materials(...).")
        if self.materials is not None:
            pair = checks.sequence(name, "materials", self.materials, "two materials")
            if len(pair) != 2 or not all(isinstance(m, Material) for m in pair):
                raise InputError(f"{name}: materials are {pair!r}; they must be two Material(...), bearing first.")
        if self.stiffness is not None:
            checks.positive(name, "stiffness", self.stiffness, "N/m^n")
        checks.positive(name, "exponent", self.exponent)
        checks.positive(name, "restitution", self.restitution)
        checks.between(name, "restitution", self.restitution, 0.0, 1.0)
        checks.not_negative(name, "least_approach", self.least_approach, "m/s")

    @classmethod
    def from_materials(
        cls, bearing: Material, journal: Material, *, restitution: float = 0.9, least_approach: float = 1e-3
    ) -> LankaraniNikravesh:
        """The law with Hertz's stiffness for n = 3/2, from the materials here and the radii of the joint.

        Parameters
        ----------
        bearing, journal : materials.
        restitution : e asked for, in (0, 1].
        least_approach : lower bound of the approach speed [m/s].
        """
        return cls(restitution=restitution, least_approach=least_approach, materials=(bearing, journal))

    def for_radii(self, bearing_radius: float, journal_radius: float) -> LankaraniNikravesh:
        """The law with its stiffness for these radii [m]."""
        if self.stiffness is not None or self.materials is None:
            return self
        return replace(self, stiffness=hertz_stiffness(*self.materials, bearing_radius, journal_radius))

    def parameters(self) -> tuple[float, ...]:
        """K, n, e, least approach speed."""
        if self.stiffness is None:
            raise InputError("LankaraniNikravesh: the stiffness depends on radii; use it in a clearance joint.")
        return self.stiffness, self.exponent, self.restitution, self.least_approach

    def history(self) -> tuple[float, ...]:
        """Approach speed, gap and gap rate."""
        return HISTORY
