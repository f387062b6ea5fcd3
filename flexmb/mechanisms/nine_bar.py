"""Nine-bar mechanism with two cranks, a joint with clearance and flexible links."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from flexmb import arguments, checks, planar
from flexmb.errors import InputError
from flexmb.mechanisms.choices import angles, check_flag, crank_motion, friction_law, pin
from flexmb.mechanisms.geometry import Point, box
from flexmb.mechanisms.nine_bar_data import NineBarData, NineBarPose
from flexmb.model.law import FrictionLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Body, Joint
from flexmb.parts.bodies.flexible_links import FlexibleFrame, FlexibleLink
from flexmb.parts.bodies.rigid import RigidBody, RigidLink
from flexmb.parts.drives.drive import Drive
from flexmb.parts.joints.prismatic import Prismatic
from flexmb.parts.joints.revolute import Revolute

NAME = "nine-bar"
LINKS = {1: "crank1", 2: "link2", 3: "link3", 4: "crank4", 6: "rocker6", 8: "link8"}
ON_THE_FRAME = (1, 4, 6)
SLIDER_SIZE = (0.060, 0.036)  # width and height of the slider in pictures [m]


@arguments.checked
def nine_bar(
    speed: Annotated[float, "rad/s"] = 2.0 * math.pi,
    *,
    clearance: Annotated[float | None, "m"] = None,
    flexible: bool = False,
    friction: str | FrictionLaw | None = "coulomb",
    elements: int = 4,
    start: Annotated[tuple[float, float], "rad"] = (0.0, 0.0),
    ramp: Annotated[float | None, "s"] = None,
    mesh: str | None = None,
    data: NineBarData | None = None,
) -> Mechanism:
    """The nine-bar mechanism with two driven cranks, eight moving bodies and one joint with clearance.

        O1 - crank1 - P1 - link2 - B        P1: ideal joint or joint with clearance
        O4 - crank4 - P4 - link3 - B        B: links 2 and 3 and panel 7 (joints B2 and B3)
        O6 - rocker6 - A                    A: rocker 6 and panel 7
        panel7 = triangle A, B, C
        C - link8 - S - slider              the slider moves along X, and so does gravity

    Bodies: crank1 link2 link3 crank4 rocker6 panel7 link8 slider.  Joints: O1 O4 O6 P1 P4 B2 B3 A C S, guide.
    Drives: motor1, motor4.

    Parameters
    ----------
    speed : speed w; crank 1 turns with -w, crank 4 with +w.
    clearance : radius of the bearing on crank 1 less radius of the journal on link 2; None: ideal joint.
    flexible : whether the links are beams; the slider is always rigid.
    friction : friction at P1: "coulomb" for the modified Coulomb law with the data, a friction law, or None.
    elements : number of beam elements of each link, and of each side of the panel.
    start : angles of cranks 1 and 4 at the start, from +X.
    ramp : time in which the cranks reach their speed from rest; None: they start at full speed.
    mesh : folder of the line meshes crank1.msh, link2.msh, ..., panel7.msh of beams, as in `meshes/` of the repository
        (tag 1: section of the bars, tag 2: of link 3); with it, links are beams and `elements` is not used.  None: no
        files.
    data : data of the mechanism; None: `NineBarData()`.

    Raises
    ------
    InputError : values out of range or of the wrong kind.
    AssemblyError : a loop that cannot close at `start`; the message names the loop and the missing length.

    Notes
    -----
    Rigid and flexible mechanism have the same mass, centre of mass and moment of inertia body by body.  Bosses at the
    ends of a beam, and for the cranks and rocker 6 an inertia on the axis in the frame, make up the difference.
    Source: Chen, Jiang, Deng, Wang, Nonlinear Dynamics (2018); each field of `NineBarData` says whether its number is
    printed there or reconstructed.

    Examples
    --------
    >>> mech = nine_bar(speed=6.28, clearance=0.5e-3, flexible=True)
    >>> mech.find("P1").clearance
    0.0005
    """
    data = NineBarData() if data is None else data
    if not isinstance(data, NineBarData):
        raise InputError(f"nine_bar: data is {data!r}; it must be a NineBarData, e.g. NineBarData(mass7=4.0).")
    check_flag("nine_bar", "flexible", flexible)
    checks.count("nine_bar", "elements", elements)
    speed = checks.number("nine_bar", "speed", speed, "rad/s")
    pose = NineBarPose.at(data, *angles("nine_bar", "start", start))
    as_beams = flexible or mesh is not None
    body = _flexible_bodies(data, pose, elements, mesh) if as_beams else _rigid_bodies(data, pose)
    body["slider"] = RigidBody("slider", pose.S, data.mass9, data.inertia9, outline=box(pose.S, *SLIDER_SIZE))
    law = friction_law("nine_bar", friction, data.coulomb)
    play = pin("P1", body["crank1"], body["link2"], pose.P1, clearance, data.bearing_radius, data.normal, law)
    cranks = ("motor1", "O1", -speed), ("motor4", "O4", speed)
    drives = [Drive(name, joint, crank_motion("nine_bar", w, ramp)) for name, joint, w in cranks]
    return Mechanism(NAME, (*body.values(), *_ideal_joints(data, pose, body), play, *drives), (data.gravity, 0.0))


def _ends(data: NineBarData, pose: NineBarPose) -> dict[int, tuple[Point, Point]]:
    return {
        1: (data.pivot1, pose.P1), 2: (pose.P1, pose.B), 3: (pose.P4, pose.B),
        4: (data.pivot4, pose.P4), 6: (data.pivot6, pose.A), 8: (pose.C, pose.S),
    }  # fmt: skip


def _ideal_joints(data: NineBarData, pose: NineBarPose, body: dict[str, Body]) -> list[Joint]:
    """All joints except P1."""
    return [
        Revolute("O1", GROUND, body["crank1"], at=data.pivot1),
        Revolute("O4", GROUND, body["crank4"], at=data.pivot4),
        Revolute("O6", GROUND, body["rocker6"], at=data.pivot6),
        Revolute("P4", body["crank4"], body["link3"], at=pose.P4),
        Revolute("B2", body["link2"], body["panel7"], at=pose.B),
        Revolute("B3", body["link3"], body["panel7"], at=pose.B),
        Revolute("A", body["rocker6"], body["panel7"], at=pose.A),
        Revolute("C", body["panel7"], body["link8"], at=pose.C),
        Revolute("S", body["link8"], body["slider"], at=pose.S),
        Prismatic("guide", GROUND, body["slider"], at=pose.S, along=(1.0, 0.0)),
    ]


def _rigid_bodies(data: NineBarData, pose: NineBarPose) -> dict[str, Body]:
    ends = _ends(data, pose)
    masses = {k: (getattr(data, f"mass{k}"), data.own_inertia(k)) for k in LINKS}
    bodies: dict[str, Body] = {name: RigidLink(name, *ends[k], *masses[k]) for k, name in LINKS.items()}
    corners = (pose.A, pose.B, pose.C, pose.A)
    bodies["panel7"] = RigidBody("panel7", pose.centre7, data.mass7, data.inertia7, outline=corners)
    return bodies


def _flexible_bodies(data: NineBarData, pose: NineBarPose, elements: int, mesh: str | None) -> dict[str, Body]:
    """Links and panel as beams, with the nodes of the meshes of a folder where one is given."""
    common: dict[str, Any] = {"material": data.material, "damping": data.damping, "mass_damping": data.mass_damping}
    sections = {1: data.section(1), 2: data.section(3)}
    bodies: dict[str, Body] = {}
    for k, name in LINKS.items():
        if mesh is None:
            make = partial(FlexibleLink, name, *_ends(data, pose)[k], section=data.section(k), elements=elements)
        else:
            file = str(Path(mesh) / f"{name}.msh")
            make = partial(FlexibleLink.from_mesh, name, file, *_ends(data, pose)[k], sections=sections)
        bodies[name] = _beam(data, k, partial(make, **common))
    corners = (pose.A, pose.B, pose.C)
    if mesh is None:
        edges = ((0, 1), (1, 2), (2, 0))
        panel = partial(FlexibleFrame, "panel7", corners, edges, section=data.section(7), elements=elements, **common)
    else:
        file, angle = str(Path(mesh) / "panel7.msh"), math.atan2(pose.B[1] - pose.A[1], pose.B[0] - pose.A[0])
        panel = partial(FlexibleFrame.from_mesh, "panel7", file, pose.A, angle=angle, sections=sections, **common)
        _require_corners(panel(), corners, file)
    bodies["panel7"] = panel(mass=data.mass7, inertia=data.inertia7, centre=pose.centre7)
    return bodies


def _require_corners(panel: FlexibleFrame, corners: tuple[Point, ...], file: str) -> None:
    """Refuse a mesh of the panel without a corner at each of its hinges."""
    for name, hinge in zip("ABC", corners, strict=True):
        off = min(planar.distance(hinge, corner) for corner in panel.corner_points)
        if off > 1e-6 * planar.distance(*corners[:2]):
            raise InputError(
                f"nine_bar: {file} has no corner at hinge {name} of the panel, the nearest is {off:.4g} m away. "
                "Its sides and their order must be those of the data, A at (0, 0), B along +x, C below (y < 0)."
            )


def _beam(data: NineBarData, number: int, make: Callable[..., FlexibleLink]) -> FlexibleLink:
    """A link as a beam with the mass and the moment of inertia of the rigid link."""
    mass, inertia = getattr(data, f"mass{number}"), data.own_inertia(number)
    if number not in ON_THE_FRAME:
        return make(mass=mass, inertia=inertia)
    # The inertia that the bar and point masses at its ends lack lies on the axis in the frame, like a shaft or a hub;
    # bosses at the outer end would need a radius of gyration larger than the depth of the link.
    lacking = inertia - make(mass=mass).properties().inertia
    if lacking < 0.0:
        raise InputError(
            f"NineBarData: inertia{number} is too small for {LINKS[number]!r} as a beam with masses at its ends, by "
            f"{-lacking:.4g} kg m^2. Give a larger inertia{number}, a smaller mass{number}, or a lighter section."
        )
    return make(mass=mass, pivot_inertia=lacking)
