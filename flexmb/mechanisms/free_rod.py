"""Free-flying flexible rod, thrown by a force and a moment on one end."""

from __future__ import annotations

from dataclasses import dataclass, fields

from flexmb import arguments, checks
from flexmb.beams.section import GeneralSection
from flexmb.bodies.flexible_link import FlexibleLink
from flexmb.drives.pulse import Pulse
from flexmb.errors import InputError
from flexmb.loads.force import Force
from flexmb.loads.torque import Torque
from flexmb.model.material import Material
from flexmb.model.mechanism import Mechanism

NAME = "free rod"
LOWER, UPPER = (6.0, 0.0), (0.0, 8.0)
"""Ends of the rod at the start [m]."""


@dataclass(frozen=True, kw_only=True)
class FreeRodData:
    """Data of the free-flying rod.

    Parameters
    ----------
    axial, bending : stiffnesses E A [N] and E I [N m^2].
    mass : mass per length, rho A [kg/m].
    rotary_inertia : rotary inertia of the sections per length, rho I [kg m].
    force : force on the lower end along +X [N].
    torque : moment on the lower end [N m].
    time : duration of force and moment [s].

    Raises
    ------
    InputError : values out of range.

    Notes
    -----
    Source: J. C. Simo, L. Vu-Quoc, On the dynamics of flexible beams under large overall motions, part II, J. Applied
    Mechanics 53 (1986) 855-863.  The rod of the source also has the shear stiffness G A = 1e4 N; a slender beam has no
    shear deformation.
    """

    axial: float = 1e4
    bending: float = 500.0
    mass: float = 1.0
    rotary_inertia: float = 10.0
    force: float = 8.0
    torque: float = -80.0
    time: float = 2.5

    def __post_init__(self) -> None:
        for name in (f.name for f in fields(self)):
            value = getattr(self, name)
            if name in ("force", "torque"):
                checks.number("FreeRodData", name, value)
            elif name == "rotary_inertia":
                checks.not_negative("FreeRodData", name, value, "kg m")
            else:
                checks.positive("FreeRodData", name, value)


@arguments.checked
def free_rod(data: FreeRodData | None = None, *, elements: int = 16) -> Mechanism:
    """A free rod of 10 m between (6, 0) and (0, 8), thrown from rest by a force and a moment on its lower end.

    Body: rod.  Loads: push, twist.

    Parameters
    ----------
    data : data of the rod; None: `FreeRodData()`.
    elements : number of beam elements of equal length.

    Raises
    ------
    InputError : values out of range or of the wrong kind.

    Examples
    --------
    >>> free_rod(elements=4).names
    ('rod', 'push', 'twist')
    """
    data = FreeRodData() if data is None else data
    if not isinstance(data, FreeRodData):
        raise InputError(f"free_rod: data is {data!r}; it must be a FreeRodData, e.g. FreeRodData(bending=100.0).")
    # the source gives products only: with an area of 1 m^2, Young's modulus is E A and the density rho A
    section = GeneralSection(area=1.0, second_moment=data.bending / data.axial, outer_fibre=0.5)
    rod = FlexibleLink(
        "rod", LOWER, UPPER, section=section, material=Material(data.axial, data.mass), elements=elements,
        rotary_inertia=data.rotary_inertia,
    )  # fmt: skip
    on_off = Pulse(end=data.time)
    push = Force("push", rod, at=LOWER, force=(data.force, 0.0), history=on_off)
    return Mechanism(NAME, (rod, push, Torque("twist", rod, data.torque, at=LOWER, history=on_off)))
