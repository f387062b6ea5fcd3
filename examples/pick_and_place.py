"""A gantry picks and places: two axes with PID controllers follow a path; a DC motor drives one of them.

The carriage follows X(t) by a force, the arm below it turns by a motor whose voltage a controller sets.
Expected: both stand on their targets at the end; the motor then holds the weight of the arm, so its current is
m g d sin(angle) / (k n).
"""

import math

import flexmb as fm

MASS, LENGTH, CENTRE, G = 0.8, 0.4, 0.2, 9.81  # the arm [kg, m, m], gravity [m/s^2]
CONSTANT, RATIO = 0.05, 60.0  # motor constant [N m/A], gear ratio
ANGLE, WAY = math.radians(35.0), 0.6  # targets

carriage = fm.RigidBody("carriage", at=(0.0, 0.0), mass=2.0, inertia=1e-2)
arm = fm.RigidLink("arm", (0.0, 0.0), (0.0, -LENGTH), mass=MASS, inertia=MASS * LENGTH**2 / 12.0)
path = fm.drives.PiecewiseLinear((0.0, 0.2, 1.0, 3.0), (0.0, 0.0, WAY, WAY))
machine = fm.Mechanism(
    "gantry",
    [
        carriage,
        arm,
        fm.Prismatic("rail", fm.GROUND, carriage, along=(1.0, 0.0)),
        fm.Revolute("pivot", carriage, arm, at=(0.0, 0.0)),
        fm.Marker("tool", arm, at=(0.0, -LENGTH), trace=True),
        fm.Force("belt", carriage, at=(0.0, 0.0), force=(1.0, 0.0)),
        fm.Torque("shaft", arm, 1.0),
        fm.PID(
            "x", "carriage.x", "belt", target=path, kp=2000.0, ki=10000.0, kd=200.0, derivative_of="error", limit=150.0,
        ),
        fm.PID(
            "angle", "tool.theta", target=ANGLE - math.pi / 2.0, kp=80.0, ki=600.0, kd=8.0, limit=24.0, sample=0.002,
        ),
        fm.controllers.DCMotor(
            "motor", "tool.omega", "shaft", voltage="angle.output", resistance=1.5, inductance=1e-3,
            torque_constant=CONSTANT, gear_ratio=RATIO,
        ),
    ],
    gravity=(0.0, -G),
)  # fmt: skip

sol = fm.simulate(machine, t_end=3.0)
print(sol.status)
print(f"carriage at   {float(sol['carriage.x'][-1]):9.5f} m    (target {WAY})")
print(f"arm turned by {math.degrees(float(sol['tool.theta'][-1])) + 90.0:9.4f} deg  (target {math.degrees(ANGLE):.4f})")
print(f"tool at       ({float(sol['tool.x'][-1]):.5f}, {float(sol['tool.y'][-1]):.5f}) m  ", end="")
print(f"(expected ({WAY + LENGTH * math.sin(ANGLE):.5f}, {-LENGTH * math.cos(ANGLE):.5f}))")
holding = MASS * G * CENTRE * math.sin(ANGLE) / (CONSTANT * RATIO)
print(f"current       {float(sol['motor.current'][-1]):9.5f} A    (expected {holding:.5f}: it holds the weight)")
print(f"largest voltage {float(abs(sol['motor.voltage']).max()):.3g} V (limit 24), largest force ", end="")
print(f"{float(abs(sol['x.output']).max()):.3g} N (limit 150)")
