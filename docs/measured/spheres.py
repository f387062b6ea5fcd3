"""Impacts of spheres: two equal ones head-on, one obliquely on a plate."""

import math
from pathlib import Path
from typing import Any

import flexmb as fm
from measured import compared, table

RECORDS = False
"""Whether the section needs measured records."""

MATERIALS = {"glass": fm.Material(48e9, 2800.0, 0.2), "limestone": fm.Material(20e9, 2500.0, 0.25)}
RADIUS, SPEED = 10e-3, 10.0
"""Radius [m] of the equal spheres, and speed of each [m/s]."""

PLATE, ALUMINA = fm.Material(70e9, 2500.0, 0.25), fm.Material(380e9, 4000.0, 0.23)
SMALL, THROWN, FRICTION, RESTITUTION = 2.5e-3, 3.9, 0.092, 0.98
"""Radius [m] and speed [m/s] of the sphere on the plate, coefficients of friction and restitution."""

ANGLES = (45.0, 60.0)
"""Angles between path and normal of the plate [degrees]."""

GAP = 1e-3
"""Gap at the start over the radius."""

HARD, STEPS, FINE = 1e20, 1e-8, fm.Adaptive(rtol=1e-8)
"""Stiffness of a contact whose depth is small beside the radius [N/m^1.5]; steps head-on [s], and on the plate."""


def sphere(name: str, at: tuple[float, float], radius: float, density: float, way: tuple[float, float]) -> fm.RigidBody:
    """A full sphere that moves with the velocity `way`."""
    mass = 4.0 / 3.0 * math.pi * radius**3 * density
    return fm.RigidBody(name, at, mass, 0.4 * mass * radius**2, velocity=(*way, 0.0))


def outline(at: tuple[float, float], radius: float) -> fm.ClosedCurve:
    """Circle as a closed curve."""
    return fm.ClosedCurve.from_function(lambda u: (at[0] + radius * math.cos(u), at[1] + radius * math.sin(u)))


def head_on(material: fm.Material) -> fm.Mechanism:
    """Two equal spheres with Hertz's law."""
    left, right = (-(1.0 + 0.5 * GAP) * RADIUS, 0.0), ((1.0 + 0.5 * GAP) * RADIUS, 0.0)
    one = sphere("one", left, RADIUS, material.density, (SPEED, 0.0))
    two = sphere("two", right, RADIUS, material.density, (-SPEED, 0.0))
    curves = outline(left, RADIUS), fm.cams.CircularCurve(right, RADIUS)
    law = fm.contact.Hertz.from_materials(material, material)
    pair = fm.CurveOnCurve("impact", one, curves[0], two, curves[1], normal=law, start="open")
    return fm.Mechanism("spheres", [one, two, pair], gravity=(0.0, 0.0))


def hertz(material: fm.Material) -> tuple[float, float, float]:
    """Largest approach [m], largest force [N] and duration [s] of the closed form."""
    reduced, speed = 2.0 / 3.0 * math.pi * RADIUS**3 * material.density, 2.0 * SPEED
    K = 2.0 / 3.0 / material.compliance * math.sqrt(0.5 * RADIUS)
    depth = (1.25 * reduced * speed**2 / K) ** 0.4
    shape = 0.8 * math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9)
    return depth, K * depth**1.5, shape * depth / speed


def thrown(degrees: float, stiffness: float | None) -> dict[str, float]:
    """Restitution along the normal and the plate, and spin [rad/s], of a sphere on a plate."""
    angle, at = math.radians(degrees), (0.0, (1.0 + GAP) * SMALL)
    fall = THROWN * math.cos(angle)
    ball = sphere("ball", at, SMALL, ALUMINA.density, (THROWN * math.sin(angle), -fall))
    made = {"materials": (PLATE, ALUMINA)} if stiffness is None else {"stiffness": stiffness}
    laws = {
        "normal": fm.contact.ExactRestitution(restitution=RESTITUTION, **made),
        "friction": fm.ModifiedCoulomb(FRICTION, 1e-6, 1e-5),
    }
    plate = fm.Line((-1.0, 0.0), (1.0, 0.0))
    pair = fm.CurveOnCurve("impact", ball, outline(at, SMALL), fm.GROUND, plate, **laws, start="open")
    mech = fm.Mechanism("sphere on a plate", [ball, pair], gravity=(0.0, 0.0))
    sol = fm.simulate(mech, t_end=GAP * SMALL / fall + 5e-5, save=1, step=FINE)
    first, last = ({name: float(sol.array(f"ball.{name}")[k]) for name in ("vx", "vy", "omega")} for k in (0, -1))
    return {"e_n": -last["vy"] / first["vy"], "e_t": last["vx"] / first["vx"], "spin": -last["omega"]}


def sliding(degrees: float) -> tuple[float, float]:
    """Restitution along the plate and spin [rad/s] of a sphere that slides all the time."""
    angle = math.radians(degrees)
    turned = FRICTION * (1.0 + RESTITUTION)
    return 1.0 - turned / math.tan(angle), 2.5 * turned * THROWN * math.cos(angle) / SMALL


def numbers(_: Path | None) -> dict[str, Any]:
    """Computed and closed values."""
    found: dict[str, Any] = {"head on": {}, "oblique": {}}
    for name, material in MATERIALS.items():
        sol = fm.simulate(head_on(material), t_end=7e-5, save="steps", step=STEPS)
        contact = sol.episodes("impact")
        ours = [sol.peak(f"impact.{each}").value for each in ("penetration", "force")]
        ours.append(float(contact.end[0] - contact.start[0]))
        found["head on"][name] = {"known": hertz(material), "ours": ours}
    for degrees in ANGLES:
        own = {"known": sliding(degrees), "ours": thrown(degrees, HARD), "soft": thrown(degrees, None)}
        found["oblique"][f"{degrees:g}"] = own
    return found


def passage(found: dict[str, Any]) -> str:
    """Two tables."""
    head = ["spheres", "quantity", "closed form", "ours", "error"]
    names = (("approach [um]", 1e6), ("force [N]", 1.0), ("duration [us]", 1e6))
    rows = [
        [name, *compared(quantity, factor * known, factor * ours)]
        for name, one in found["head on"].items()
        for (quantity, factor), known, ours in zip(names, one["known"], one["ours"], strict=True)
    ]
    more = []
    for degrees, one in found["oblique"].items():
        angle = f"{degrees}°"
        ours, soft = one["ours"], one["soft"]
        more.append([angle, *compared("e_n", RESTITUTION, ours["e_n"]), f"{soft['e_n']:.7g}"])
        for quantity, key, known in zip(("e_t", "spin [rad/s]"), ("e_t", "spin"), one["known"], strict=True):
            more.append([angle, *compared(quantity, known, ours[key]), f"{soft[key]:.7g}"])
    oblique = ["angle", *head[1:3], "ours, hard", "error", "ours, alumina on glass"]
    return f"{table(head, rows, left=2)}\n\n{table(oblique, more, left=2)}"
