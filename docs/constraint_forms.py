"""Which form of the constraints: the measurement behind docs/decisions/017-form-of-the-constraints.md.

    python docs/constraint_forms.py

The slider-crank with a worn piston pin (crank 50 mm, rod 120 mm, 5000 rpm, clearance 0.5 mm) runs for two turns with
the three forms of the constraints that `Newmark` knows.  Columns: largest drive torque [N m] (converged: 985; a larger
one is a spike of the multipliers), largest gap of an ideal joint [m] and largest violation of its velocity [m/s], cost
of a step.  Then the order of the drive torque with an ideal pin, whose torque is known in closed form.
"""

from __future__ import annotations

import statistics

import numpy as np

import flexmb as fm

OMEGA = 2.0 * np.pi * 5000.0 / 60.0
R, L = 0.05, 0.12
FORMS = ("gear-gupta-leimkuhler", "position", "velocity")


def slider_crank(*, clearance: bool) -> fm.Mechanism:
    """Crank, rod, slider; data of the worn piston pin."""
    steel = fm.Material(207e9, 7850.0, 0.3)
    crank = fm.RigidLink("crank", (0.0, 0.0), (R, 0.0), mass=0.30, inertia=1e-5)
    rod = fm.RigidLink("rod", (R, 0.0), (R + L, 0.0), mass=0.21, inertia=2.5e-4)
    slider = fm.RigidBody("slider", (R + L, 0.0), mass=0.14, inertia=1e-4)
    pin: fm.Part = fm.Revolute("B", rod, slider, at=(R + L, 0.0))
    if clearance:
        pin = fm.RevoluteClearance(
            "B",
            rod,
            slider,
            at=(R + L, 0.0),
            clearance=5e-4,
            bearing_radius=1e-2,
            normal=fm.LankaraniNikravesh.from_materials(steel, steel, restitution=0.9, least_approach=0.0),
            friction=fm.ModifiedCoulomb(0.03, v0=0.0, v1=1e-3),
        )
    joints = [
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
        fm.Revolute("A", crank, rod, at=(R, 0.0)),
        fm.Prismatic("guide", fm.GROUND, slider),
        fm.Drive("motor", "O", fm.ConstantSpeed(OMEGA)),
    ]
    return fm.Mechanism("slider-crank", [crank, rod, slider, pin, *joints])


def violations(sol: fm.Solution) -> tuple[float, float]:
    """Largest gap and largest velocity violation of joint A, between crank and rod."""
    gap = speed = 0.0
    for axis, turn in (("x", np.cos), ("y", np.sin)):
        crank, rod = turn(sol["crank.theta"]), turn(sol["rod.theta"])
        gap = max(gap, float(abs(sol[f"rod.{axis}"] - L / 2 * rod - sol[f"crank.{axis}"] - R / 2 * crank).max()))
    for axis, turn, sign in (("vx", np.sin, -1.0), ("vy", np.cos, 1.0)):
        crank = sign * turn(sol["crank.theta"]) * sol["crank.omega"]
        rod = sign * turn(sol["rod.theta"]) * sol["rod.omega"]
        speed = max(speed, float(abs(sol[f"rod.{axis}"] - L / 2 * rod - sol[f"crank.{axis}"] - R / 2 * crank).max()))
    return gap, speed


def exact_torque(theta: np.ndarray) -> np.ndarray:
    """Drive torque of the ideal slider-crank: the derivative of its kinetic energy by the crank angle."""
    h = 5e-4
    return (8 * (energy(theta + h) - energy(theta - h)) - (energy(theta + 2 * h) - energy(theta - 2 * h))) / (12 * h)


def energy(theta: np.ndarray) -> np.ndarray:
    """Kinetic energy of rod and slider."""
    sine = -R * np.sin(theta) / L
    cosine = np.sqrt(1.0 - sine**2)
    spin = -R * OMEGA * np.cos(theta) / (L * cosine)
    vx, vy = -R * OMEGA * np.sin(theta), R * OMEGA * np.cos(theta)
    rod = 0.21 * ((vx - L / 2 * spin * sine) ** 2 + (vy + L / 2 * spin * cosine) ** 2) + 2.5e-4 * spin**2
    return 0.5 * (rod + 0.14 * (vx - L * spin * sine) ** 2)


def order(form: str) -> float:
    """Measured order of the drive torque on the ideal mechanism."""
    errors = []
    for h in (4e-5, 2e-5):
        method = fm.Newmark.generalised_alpha(0.8, form)
        sol = fm.simulate(slider_crank(clearance=False), t_end=0.012, step=h, save="steps", method=method)
        late = sol.time > 0.002
        errors.append(abs(sol["motor.torque"].values - exact_torque(OMEGA * sol.time))[late].max())
    return float(np.log2(errors[0] / errors[1]))


def main() -> None:
    """Print the table."""
    print("| form | steps | largest torque | gap [m] | velocity [m/s] | us a step | order of torque |")
    print("|---|---|---|---|---|---|---|")
    for form in FORMS:
        rate = order(form)
        for label, step in (("fixed 1e-6 s", fm.FixedStep(1e-6)), ("changing", fm.Adaptive(atol=2e-8))):
            method = fm.Newmark.generalised_alpha(0.8, form)
            runs = [
                fm.simulate(slider_crank(clearance=True), t_end=0.024, step=step, method=method, save="steps")
                for _ in range(5)
            ]
            cost = statistics.median(1e6 * s.stats.wall_time / s.stats.steps for s in runs)
            gap, speed = violations(runs[0])
            torque = runs[0].peak("motor.torque").value
            ending = "" if runs[0].ok else f" ({runs[0].status})"
            print(
                f"| {form} | {label}, {runs[0].stats.steps} | {torque:.1f} | {gap:.1e} | {speed:.1e} "
                f"| {cost:.1f} | {rate:.2f} |{ending}"
            )


if __name__ == "__main__":
    main()
