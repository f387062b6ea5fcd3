"""Random linkages: cranks with dyads, chains, sliders; rigid and flexible links, clearance, friction, loads.

A linkage is drawn as numbers first and built afterwards, so that it can be built turned, shifted, mirrored, renumbered
or in other units.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace

import numpy as np

import flexmb as fm

STEEL = fm.STEEL


@dataclass(frozen=True)
class Link:
    """A bar between two points, by their names."""

    name: str
    start: str
    end: str
    mass: float
    flexible: bool = False


@dataclass(frozen=True)
class Pin:
    """A revolute joint of two bodies at a point; `clearance` > 0: with clearance, `friction` > 0: with friction."""

    name: str
    first: str
    second: str
    at: str
    clearance: float = 0.0
    friction: float = 0.0


@dataclass(frozen=True)
class Linkage:
    """Numbers of a linkage: points [m], links, pins, sliders along a direction, speed of the drive, loads."""

    points: dict[str, complex]
    links: tuple[Link, ...]
    pins: tuple[Pin, ...]
    sliders: tuple[tuple[str, str, complex], ...] = ()
    speed: float | None = None
    gravity: complex = 0.0
    spring: tuple[str, str, float] | None = None
    width: float = 0.02
    order: tuple[int, ...] = field(default=())


@dataclass(frozen=True)
class View:
    """How a linkage is looked at: turned, shifted, mirrored, with its parts in another order."""

    turn: float = 0.0
    shift: complex = 0.0
    mirror: bool = False
    order: int = 0

    def point(self, z: complex) -> tuple[float, float]:
        """A point in this view."""
        w = self.direction(z) + self.shift
        return (w.real, w.imag)

    def direction(self, z: complex) -> complex:
        """A direction in this view."""
        return (z.conjugate() if self.mirror else z) * complex(math.cos(self.turn), math.sin(self.turn))


def drawn(seed: int) -> Linkage:
    """A random linkage: a crank or a pendulum, then dyads and sliders, then a chain at times."""
    rng = np.random.default_rng(seed)
    points: dict[str, complex] = {"O": 0.0}
    driven = rng.random() < 0.7
    size = float(10.0 ** rng.uniform(-1.5, 0.5))
    points["A"] = size * _polar(0.3, rng.uniform(0.0, 2.0 * math.pi))
    links, pins = [Link("l0", "O", "A", _mass(rng, size))], [Pin("p0", "ground", "l0", "O")]
    ends, sliders = [("l0", "A")], []
    for k in range(int(rng.integers(0, 4))):
        owner, tip = ends[int(rng.integers(len(ends)))]
        if rng.random() < 0.25:
            _add_slider(rng, size, k, owner, tip, points, links, pins, sliders)
        else:
            _add_dyad(rng, size, k, owner, tip, points, links, pins, ends)
    for k in range(int(rng.integers(0, 3))):
        owner, tip = ends[int(rng.integers(len(ends)))]
        name = f"c{k}"
        points[name] = points[tip] + size * _polar(rng.uniform(0.1, 0.4), rng.uniform(0.0, 2.0 * math.pi))
        links.append(Link(name, tip, name, _mass(rng, size)))
        pins.append(Pin(f"pc{k}", owner, name, tip))
    if rng.random() < 0.3:
        place = int(rng.integers(len(links)))
        links[place] = replace(links[place], flexible=True)
    if rng.random() < 0.3:
        place = int(rng.integers(1 if driven else 0, len(pins))) if len(pins) > 1 else 0
        if not (driven and place == 0):
            pins[place] = replace(pins[place], clearance=float(size * 10.0 ** rng.uniform(-4.0, -3.0)))
    if rng.random() < 0.2:
        place = int(rng.integers(len(pins)))
        if pins[place].clearance == 0.0:
            pins[place] = replace(pins[place], friction=float(rng.uniform(0.02, 0.2)))
    spring = (links[-1].name, links[-1].end, float(rng.uniform(1.0, 50.0))) if rng.random() < 0.3 else None
    speed = float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(0.0, 1.5)) if driven else None
    gravity = complex(0.0, -9.81) if not driven or rng.random() < 0.5 else 0.0
    return Linkage(
        points, tuple(links), tuple(pins), tuple(sliders), speed, gravity, spring, width=0.03 * size
    )  # fmt: skip


def _polar(length: float, angle: float) -> complex:
    return complex(length * math.cos(angle), length * math.sin(angle))


def _mass(rng: np.random.Generator, size: float) -> float:
    return float(size * 10.0 ** rng.uniform(-0.7, 0.7))


def _add_dyad(rng, size, k, owner, tip, points, links, pins, ends):
    """Two bars from a moving tip to a new fixed point."""
    middle, base = f"B{k}", f"G{k}"
    points[middle] = points[tip] + size * _polar(rng.uniform(0.8, 1.4), rng.uniform(0.0, 2.0 * math.pi))
    points[base] = points[middle] + size * _polar(rng.uniform(0.8, 1.4), rng.uniform(0.0, 2.0 * math.pi))
    links += [Link(f"a{k}", tip, middle, _mass(rng, size)), Link(f"b{k}", base, middle, _mass(rng, size))]
    pins += [
        Pin(f"pa{k}", owner, f"a{k}", tip), Pin(f"pb{k}", f"a{k}", f"b{k}", middle),
        Pin(f"pg{k}", "ground", f"b{k}", base)
    ]  # fmt: skip
    ends.append((f"b{k}", middle))


def _add_slider(rng, size, k, owner, tip, points, links, pins, sliders):
    """A rod from a moving tip to a block on a line."""
    foot = f"S{k}"
    away = _polar(1.0, rng.uniform(0.0, 2.0 * math.pi))
    points[foot] = points[tip] + size * rng.uniform(0.9, 1.5) * away
    links.append(Link(f"r{k}", tip, foot, _mass(rng, size)))
    pins += [Pin(f"pr{k}", owner, f"r{k}", tip), Pin(f"ps{k}", f"r{k}", f"s{k}", foot)]
    sliders.append((f"s{k}", foot, away * _polar(1.0, rng.uniform(-0.5, 0.5))))


def damaged(mechanism: Callable[[], fm.Mechanism], seed: int) -> fm.Mechanism:
    """A mechanism with one or two random faults: parts missing, doubled, moved or with numbers out of range."""
    rng = np.random.default_rng(seed)
    mech = mechanism()
    for _ in range(int(rng.integers(1, 3))):
        parts = list(mech.parts)
        part = parts[int(rng.integers(len(parts)))]
        kind = int(rng.integers(5))
        if kind == 0:
            mech = fm.Mechanism(mech.name, [p for p in parts if p is not part], gravity=mech.gravity)
        elif kind == 1:
            mech = fm.Mechanism(mech.name, [*parts, part], gravity=mech.gravity)
        elif kind == 2:
            joints = [p.name for p in parts if isinstance(p, fm.Revolute | fm.Prismatic)]
            joint = joints[int(rng.integers(len(joints)))] if joints else "none"
            mech = mech.with_part(fm.Drive(f"drive{seed}", joint, fm.ConstantSpeed(float(rng.normal()))))
        else:
            mech = mech.with_(dict([_changed(part, rng)]))
    return mech


EXTREMES = (0.0, -1.0, math.nan, math.inf, 1e-300, 1e-12, 1e12, 1e300)


def _changed(part: fm.Part, rng: np.random.Generator) -> tuple[str, object]:
    """A random field of a part with an extreme number in it."""
    numbers = [f.name for f in fields(part) if isinstance(getattr(part, f.name), float | tuple) and f.init]
    if not numbers:
        return f"{part.name}.nothing", 1.0
    name = numbers[int(rng.integers(len(numbers)))]
    value, extreme = getattr(part, name), float(rng.choice(EXTREMES))
    if isinstance(value, tuple) and value and all(isinstance(x, float) for x in value):
        place = int(rng.integers(len(value)))
        return f"{part.name}.{name}", tuple(extreme if k == place else x for k, x in enumerate(value))
    return f"{part.name}.{name}", extreme


def built(linkage: Linkage, view: View = View()) -> fm.Mechanism:
    """The mechanism of a linkage, as it is seen in a view."""
    at = {name: view.point(z) for name, z in linkage.points.items()}
    bodies: dict[str, fm.Part] = {"ground": fm.GROUND}
    for link in linkage.links:
        length = math.dist(at[link.start], at[link.end])
        inertia = link.mass * length**2 / 12.0
        if link.flexible:
            bar = fm.Rectangle(width=linkage.width, height=linkage.width)
            bodies[link.name] = fm.FlexibleLink(
                link.name, at[link.start], at[link.end], section=bar, material=STEEL, elements=2
            )
        else:
            bodies[link.name] = fm.RigidLink(link.name, at[link.start], at[link.end], mass=link.mass, inertia=inertia)
    for name, point, _ in linkage.sliders:
        mass = linkage.links[0].mass
        bodies[name] = fm.RigidBody(name, at[point], mass, 0.01 * mass * abs(linkage.points["A"]) ** 2)
    joints = [_joint(pin, bodies, at) for pin in linkage.pins]
    for name, point, along in linkage.sliders:
        way = view.direction(along)
        joints.append(fm.Prismatic(f"guide_{name}", fm.GROUND, bodies[name], at=at[point], along=(way.real, way.imag)))
    if linkage.speed is not None:
        joints.append(fm.Drive("motor", "p0", fm.ConstantSpeed(-linkage.speed if view.mirror else linkage.speed)))
    if linkage.spring:
        body, point, stiffness = linkage.spring
        anchor = view.point(linkage.points[point] + 2.0 * abs(linkage.points["A"]))
        joints.append(
            fm.SpringDamper("spring", fm.GROUND, bodies[body], anchor, at[point], stiffness=stiffness, damping=0.0)
        )
    parts = [*(body for name, body in bodies.items() if name != "ground"), *joints]
    if view.order:
        parts = [parts[k] for k in np.random.default_rng(view.order).permutation(len(parts))]
    g = view.direction(linkage.gravity)
    return fm.Mechanism("linkage", parts, gravity=(g.real, g.imag))


def _joint(pin: Pin, bodies: dict[str, fm.Part], at: dict[str, tuple[float, float]]) -> fm.Part:
    first, second = bodies[pin.first], bodies[pin.second]
    if pin.clearance:
        law = fm.LankaraniNikravesh(1e8, restitution=0.9)
        radius = 50.0 * pin.clearance
        return fm.RevoluteClearance(
            pin.name, first, second, at=at[pin.at], clearance=pin.clearance, bearing_radius=radius, normal=law
        )
    if pin.friction:
        law = fm.friction.SmoothCoulomb(pin.friction, v0=1e-2)
        return fm.Revolute(pin.name, first, second, at=at[pin.at], friction=law, radius=0.01)
    return fm.Revolute(pin.name, first, second, at=at[pin.at])
