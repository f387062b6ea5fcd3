"""Beam clamped to a hub that is spun up from rest."""

from __future__ import annotations

from dataclasses import dataclass, fields

from flexmb import arguments, checks
from flexmb.beams.section import GeneralSection
from flexmb.bodies.flexible_link import FlexibleLink
from flexmb.drives.ramp import CycloidalRamp
from flexmb.errors import InputError
from flexmb.joints.clamp import Clamp
from flexmb.model.material import Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND

NAME = "spinning beam"


@dataclass(frozen=True, kw_only=True)
class SpinningBeamData:
    """Data of a spun-up beam.

    Parameters
    ----------
    length : length of the beam [m].
    young : Young's modulus [Pa].
    density : density [kg/m^3].
    area : area of the section [m^2].
    second_moment : second moment of the section [m^4].
    speed : final speed of the hub [rad/s].
    time : duration of the spin-up [s].

    Raises
    ------
    InputError : values that are not > 0.

    Notes
    -----
    Source of the default values: J. C. Simo, L. Vu-Quoc, On the dynamics of flexible beams under large overall motions,
    part II, J. Applied Mechanics 53 (1986) 855-863: E A = 2.8e7 N, E I = 1.4e4 N m^2, rho A = 1.2 kg/m.  The source
    gives products only; the area of 1 m^2 is chosen here.
    """

    length: float = 10.0
    young: float = 2.8e7
    density: float = 1.2
    area: float = 1.0
    second_moment: float = 5e-4
    speed: float = 6.0
    time: float = 15.0

    def __post_init__(self) -> None:
        for name in (f.name for f in fields(self)):
            checks.positive("SpinningBeamData", name, getattr(self, name))


WU_HAUG = SpinningBeamData(
    length=8.0, young=6.895e10, density=2766.67, area=7.2986e-5, second_moment=8.2189e-9, speed=4.0
)
"""Data of S. C. Wu, E. J. Haug, Geometric non-linear substructuring for dynamics of flexible mechanical systems.

Int. J. Numerical Methods in Engineering 26 (1988) 2211-2226."""


@arguments.checked
def spinning_beam(data: SpinningBeamData | None = None, *, elements: int = 8) -> Mechanism:
    """A straight beam along +X, clamped to a hub at the origin that is spun up from rest by a `CycloidalRamp`.

    Body: beam.  Joint: hub, a rotating `Clamp` on the ground.

    Parameters
    ----------
    data : data of the beam; None: the data of Simo and Vu-Quoc, `SpinningBeamData()`.
    elements : number of beam elements of equal length.

    Raises
    ------
    InputError : values out of range or of the wrong kind.

    Examples
    --------
    >>> spinning_beam(elements=4).names
    ('beam', 'hub')
    """
    data = SpinningBeamData() if data is None else data
    if not isinstance(data, SpinningBeamData):
        raise InputError(f"spinning_beam: data is {data!r}; it must be a SpinningBeamData, e.g. SpinningBeamData().")
    # depth of a rectangle with this area and second moment; it is used for stresses in pictures only
    depth = (12.0 * data.second_moment / data.area) ** 0.5
    section = GeneralSection(area=data.area, second_moment=data.second_moment, outer_fibre=0.5 * depth)
    beam = FlexibleLink(
        "beam", (0.0, 0.0), (data.length, 0.0), section=section, material=Material(data.young, data.density),
        elements=elements,
    )  # fmt: skip
    hub = Clamp("hub", GROUND, beam, at=(0.0, 0.0), angle=CycloidalRamp(data.speed, data.time))
    return Mechanism(NAME, (beam, hub))
