"""Cantilever: a clamped beam with loads on its tip, as in many textbook solutions."""

from typing import Annotated

from flexmb.elastic.beams.section import Section
from flexmb.model.law import Material
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND
from flexmb.parts.bodies.flexible import Elements
from flexmb.parts.bodies.flexible_links import FlexibleLink
from flexmb.parts.joints.revolute import Fixed
from flexmb.parts.loads.force import Force, Torque


def cantilever(
    length: Annotated[float, "m"], section: Section, material: Material, *, elements: Elements = 16,
    force: Annotated[tuple[float, float], "N"] = (0.0, 0.0), moment: Annotated[float, "N m"] = 0.0,
    gravity: Annotated[tuple[float, float], "m/s^2"] = (0.0, 0.0),
) -> Mechanism:  # fmt: skip
    """A beam along +X, clamped to the ground at the origin, with a dead force and a moment on its tip.

    Parts: link `beam`, joint `clamp`, loads `P` and `M` (also if they are zero).

    Parameters
    ----------
    length : distance from clamp to tip, > 0.
    section : cross section, from clamp to tip.
    material : material.
    elements : number of equal elements, or increasing positions of the inner nodes over the length.
    force : force (fx, fy) on the tip, constant in direction.
    moment : moment on the tip, counter-clockwise.
    gravity : acceleration (gx, gy) of gravity.

    Raises
    ------
    InputError : a length, section, material or number of elements that `FlexibleLink` refuses.

    Notes
    -----
    Slender beams with small strains and any rotation, see `FlexibleLink`.
    """
    tip = (length, 0.0)
    beam = FlexibleLink("beam", (0.0, 0.0), tip, section=section, material=material, elements=elements)
    loads = (Force("P", beam, tip, force), Torque("M", beam, moment, tip))
    return Mechanism("cantilever", (beam, Fixed("clamp", GROUND, beam, (0.0, 0.0)), *loads), gravity=gravity)
