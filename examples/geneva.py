"""A Geneva wheel with four slots: speed and acceleration against the closed form, ideal and as contact in the slots.

With lambda = sin(pi/4), the crank angle a from the line of centres and a crank at constant speed w,

    wheel speed / w = lambda (cos a - lambda) / (1 - 2 lambda cos a + lambda^2),

whose maximum is 1 + sqrt 2 at a = 0.  The largest angular acceleration, 5.4069810346 w^2, is reached at 11.463746
degrees.
"""

import math

import numpy as np

import flexmb as fm

distance, w = 0.1, 2 * math.pi
arm = distance * math.sin(math.pi / 4)
start = math.radians(-44)


def machine(*parts, centre=start, friction=None):
    pin = (arm * math.cos(centre), arm * math.sin(centre))
    wheel_angle = math.atan2(pin[1], pin[0] - distance)
    crank = fm.RigidBody("crank", at=(0.0, 0.0), mass=0.2, inertia=1e-4)
    wheel = fm.RigidBody("wheel", at=(distance, 0.0), mass=0.5, inertia=5e-4)
    bearing = {"friction": friction, "radius": 0.01, "preload": 50.0} if friction else {}
    fixed = [
        crank, wheel,
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
        fm.Revolute("Q", fm.GROUND, wheel, at=(distance, 0.0), **bearing),
        fm.Drive("motor", "O", fm.ConstantSpeed(w)),
    ]  # fmt: skip
    return fm.Mechanism("geneva", [*fixed, *(make(crank, wheel, pin, wheel_angle) for make in parts)])


def slot(crank, wheel, pin, angle):
    return fm.PinSlot("pin", wheel, crank, at=pin, along=(math.cos(angle), math.sin(angle)))


def rim(radius=0.004, clearance=2e-5):
    """Contact of the pin with a wheel of four slots, hollow between the slots."""

    def make(crank, wheel, pin, angle):
        half, tip, bottom = radius + clearance, distance * math.cos(math.pi / 4), distance - arm - 1e-3
        reach = math.sqrt(tip**2 - half**2)
        points, bulges = [], []
        for k in range(4):
            direction = 0.25 * math.pi + 0.5 * math.pi * k
            c, s = math.cos(direction), math.sin(direction)
            for x, y, bulge in ((reach, -half, 0.0), (bottom, -half, -1.0), (bottom, half, 0.0), (reach, half, -0.2)):
                points.append((distance + c * x - s * y, s * x + c * y))
                bulges.append(bulge)
        law = fm.KelvinVoigt(stiffness=1e7, damping=3e3, ramp=1e-6)
        circle = fm.cams.CircularCurve(pin, radius)
        return fm.cams.OutlineContact("pin", wheel, fm.cams.Outline(points, bulges), crank, circle, normal=law)

    return make


def exact(angle):
    lam = math.sin(math.pi / 4)
    return lam * (np.cos(angle) - lam) / (1 - 2 * lam * np.cos(angle) + lam**2)


ideal = fm.simulate(machine(slot), t_end=-2 * start / w, method=fm.RungeKutta4(), step=-2 * start / w / 4000)
angle = start + w * ideal.time
speed, acceleration = -ideal["wheel.omega"].values / w, -ideal["wheel.alpha"].values / w**2
k = int(np.abs(acceleration).argmax())
print(f"ideal: largest speed ratio {speed.max():.10f} (1 + sqrt 2 = {1 + math.sqrt(2):.10f})")
print(
    f"       largest acceleration {abs(acceleration[k]):.7f} w^2 (5.4069810) "
    f"at {abs(math.degrees(angle[k])):.2f} degrees (11.46)"
)
print(f"       speed against the closed form: largest error {np.abs(speed - exact(angle)).max():.1e}")

before = math.radians(-60)
rubbing = fm.ModifiedCoulomb(0.1, v0=1e-4, v1=1e-3)
contact = fm.simulate(machine(rim(), centre=before, friction=rubbing), t_end=1.0 + 15.0 / 360.0)
angle = before + w * contact.time
inside = np.abs(angle) < math.radians(40)
error = np.abs(-contact["wheel.omega"].values[inside] / w - exact(angle[inside])).max()
turned = math.degrees(contact["wheel.theta"].values[-1])
print(f"contact: {contact.status}")
print(f"         largest difference of the speed ratio {error:.4f} of {1 + math.sqrt(2):.4f}")
print(f"         the wheel has turned by {turned:.3f} degrees (-90, and what play and friction leave)")
