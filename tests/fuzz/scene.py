"""What combinations of parts are built in: random numbers, a view of the world, and its units.

A scene draws the same numbers for the same seed in every view, so one mechanism is had as a mirror image, in other
units, or with masses that are off by a hair.
"""

import cmath
import math
from dataclasses import dataclass

import numpy as np

import flexmb as fm


@dataclass(frozen=True)
class Units:
    """A view of a scene: x -> -x, units of length and mass over m and kg, and relative errors of masses."""

    mirror: bool = False
    length: float = 1.0
    mass: float = 1.0
    error: float = 0.0

    def of(self, mass: int = 0, length: int = 0) -> float:
        """Factor of a quantity kg^mass m^length s^any."""
        return self.mass**mass * self.length**length


@dataclass(frozen=True)
class Body:
    """A body that other parts may be hung on: part, a point of it [m], mass [kg]."""

    part: fm.Part
    at: complex
    mass: float


class Scene:
    """Parts of a mechanism while it is drawn; all arguments have SI units and are those before the mirror."""

    def __init__(self, seed: int, units: Units) -> None:
        self.rng, self.units = np.random.default_rng(seed), units
        self._errors = np.random.default_rng(seed + 1)
        self.parts: list[fm.Part] = []
        self.bodies: list[Body] = []
        self.words: list[str] = []
        self.sign = -1.0 if units.mirror else 1.0

    def add(self, part: fm.Part) -> fm.Part:
        """A part, added."""
        self.parts.append(part)
        return part

    def between(self, low: float, high: float) -> float:
        """A number between two, evenly by its logarithm where both are > 0."""
        if low > 0.0:
            return float(math.exp(self.rng.uniform(math.log(low), math.log(high))))
        return float(self.rng.uniform(low, high))

    def chance(self, share: float) -> bool:
        """Whether what happens with this probability happens."""
        return bool(self.rng.random() < share)

    def one(self, *choices):
        """One of the choices."""
        return choices[int(self.rng.integers(len(choices)))]

    def name(self, kind: str) -> str:
        """A name that is not taken."""
        return f"{kind}{len(self.parts)}"

    # Quantities of the view.
    def p(self, z: complex) -> tuple[float, float]:
        """A point."""
        return (self.sign * self.units.length * z.real, self.units.length * z.imag)

    def d(self, z: complex) -> tuple[float, float]:
        """A direction."""
        return (self.sign * z.real, z.imag)

    def a(self, angle: float) -> float:
        """An angle, or what is odd in the mirror."""
        return self.sign * angle

    def s(self, x: float) -> float:
        """A length or speed: a number in m or m/s."""
        return self.units.length * x

    def m(self, x: float) -> float:
        """A mass, with its error."""
        return self.units.mass * x * (1.0 + self.units.error * float(self._errors.normal()))

    def j(self, x: float) -> float:
        """A moment of inertia, torque, energy or stiffness of a torsion spring."""
        return self.units.of(1, 2) * x

    def f(self, x: float) -> float:
        """A force."""
        return self.units.of(1, 1) * x

    def k(self, x: float) -> float:
        """A stiffness or damping of a spring."""
        return self.units.mass * x

    # Parts that many kinds share.
    def block(self, at: complex, mass: float, radius: float = 0.05, velocity: tuple | None = None) -> Body:
        """A rigid body."""
        moving = None
        if velocity:
            moving = (*(self.s(1.0) * x for x in self.d(complex(velocity[0], velocity[1]))), self.a(velocity[2]))
        inertia = self.j(0.5 * mass * radius**2)
        part = self.add(fm.RigidBody(self.name("body"), self.p(at), self.m(mass), inertia, velocity=moving))
        self.bodies.append(Body(part, at, mass))
        return self.bodies[-1]

    def bar(self, start: complex, end: complex, mass: float, kind: str = "rigid") -> Body:
        """A rigid, flexible, reduced or plane bar."""
        name, length = self.name(f"{kind}_bar"), abs(end - start)
        steel = fm.Material(young=self.units.of(1, -1) * 7e10, density=self.units.of(1, -3) * 2700.0)
        if kind == "rigid":
            inertia = self.j(mass * length**2 / 12.0)
            part = fm.RigidLink(name, self.p(start), self.p(end), mass=self.m(mass), inertia=inertia)
        elif kind == "plane":
            mesh = fm.meshes.link_with_eyes(*(self.s(x * length) for x in (1.0, 0.12, 0.05, 0.16, 0.2)))
            part = fm.PlaneBody(
                name, mesh, start=self.p(start), end=self.p(end), thickness=self.s(0.01), material=steel, damping=1e-4
            )
        else:
            section = fm.Rectangle(width=self.s(0.05 * length), height=self.s(0.03 * length))
            part = fm.FlexibleLink(
                name, self.p(start), self.p(end), section=section, material=steel, elements=2, damping=1e-4
            )
            part = fm.Reduced(part, modes=3) if kind == "reduced" else part
        self.add(part)
        self.bodies.append(Body(part, end, mass))
        self.words.append(kind)
        return self.bodies[-1]

    def law(self, mass: float) -> fm.NormalLaw:
        """A law of a contact whose vibrations with a mass have some hundreds of rad/s."""
        k, depth, restitution = mass * self.between(300.0, 1500.0) ** 2, 1e-4, self.between(0.5, 0.95)
        damped = ("HuntCrossley", "LankaraniNikravesh", "Flores", "ExactRestitution", "Gonthier")
        kind = self.one("KelvinVoigt", "ramped", "Hertz", *damped)
        self.words.append(kind)
        if kind == "KelvinVoigt":
            return fm.KelvinVoigt(self.k(k), self.k(0.2 * math.sqrt(k * mass)))
        if kind == "ramped":
            return fm.KelvinVoigt(self.k(k), self.k(0.2 * math.sqrt(k * mass)), ramp=self.s(1e-5))
        stiffness = self.units.mass * self.units.length**-0.5 * k / math.sqrt(depth)
        if kind == "Hertz":
            return fm.contact.Hertz(stiffness, 1.5)
        classes = {"HuntCrossley": fm.HuntCrossley, "LankaraniNikravesh": fm.LankaraniNikravesh}
        law = classes.get(kind) or getattr(fm.contact, kind)
        return law(stiffness, 1.5, restitution, self.s(1e-6))

    def rubbing(self, none: bool = True) -> fm.FrictionLaw | None:
        """A law of friction, or none."""
        mu, kinds = self.between(0.05, 0.3), ["SmoothCoulomb", "ModifiedCoulomb", "Stribeck", "Threlfall", "LuGre"]
        kind = self.one(*kinds, *(["none"] * 3 if none else []))
        self.words += [] if kind == "none" else [kind]
        if kind == "SmoothCoulomb":
            return fm.friction.SmoothCoulomb(mu, v0=self.s(1e-2))
        if kind == "ModifiedCoulomb":
            return fm.ModifiedCoulomb(mu, self.s(1e-3), self.s(1e-2))
        if kind == "Stribeck":
            return fm.friction.Stribeck(1.3 * mu, mu, stribeck_speed=self.s(0.05), v0=self.s(1e-2))
        if kind == "Threlfall":
            return fm.friction.Threlfall(mu, v0=self.s(1e-2))
        if kind == "LuGre":
            one = 1.0 / self.units.length
            return fm.friction.LuGre(1.3 * mu, mu, self.s(0.05), stiffness=self.k(1e4), damping=5.0 * one)
        return None

    def motion(self, scale: float) -> fm.Motion:
        """A motion of an angle (odd in the mirror) or, with scale < 0, a history of a load (a factor)."""
        s = self.a(scale) if scale > 0.0 else 1.0
        w, time = self.between(2.0, 12.0), self.between(0.05, 0.3)
        moving = ("ConstantSpeed", "Ramp", "CycloidalRamp", "Harmonic", "Polynomial")
        kind = self.one(*(moving if scale > 0.0 else ("Harmonic", "Pulse", "PiecewiseLinear")))
        self.words.append(kind)
        drives, mean = fm.drives, -s * 0.4 * math.sin(0.3) if scale > 0.0 else 0.0  # begins at 0
        return {
            "ConstantSpeed": lambda: fm.ConstantSpeed(s * w),
            "Ramp": lambda: drives.Ramp(s * w, time),
            "CycloidalRamp": lambda: drives.CycloidalRamp(s * w, time),
            "Harmonic": lambda: drives.Harmonic(s * 0.4, w / 2.0 if scale > 0.0 else w, phase=0.3, mean=mean),
            "Polynomial": lambda: drives.Polynomial([0.0, s * 0.5 * w, s * w, -s * 0.5 * w]),
            "Pulse": lambda: drives.Pulse(1.0, start=0.3 * time, end=time),
            "PiecewiseLinear": lambda: drives.PiecewiseLinear([0.0, time, 2 * time, 4 * time], [0.0, 1.0, -0.5, 0.2]),
        }[kind]()

    def polar(self, length: float, low: float = -math.pi, high: float = math.pi) -> complex:
        """A vector of a length in a random direction between two angles."""
        return cmath.rect(length, float(self.rng.uniform(low, high)))
