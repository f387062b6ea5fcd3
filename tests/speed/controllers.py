"""Cost of controllers in a step: the same arm without one, with a PID controller, and with a sampled one.

Run alone on a quiet machine: python tests/speed/controllers.py
"""

import time

import flexmb as fm

STEP, T_END = 1e-4, 20.0
STEPS = round(T_END / STEP)


def arm(*parts):
    """An arm that swings under gravity."""
    link = fm.RigidLink("arm", (0.0, 0.0), (0.5, 0.0), mass=1.0, inertia=1.0 / 48.0)
    hinge = fm.Revolute("hinge", fm.GROUND, link, at=(0.0, 0.0))
    return fm.Mechanism("arm", [link, hinge, fm.Torque("actuator", link, 1.0), *parts], gravity=(0.0, -9.81))


def seconds(mechanism):
    """Least time of some runs [s]."""
    times = []
    for _ in range(5):
        begin = time.perf_counter()
        fm.simulate(mechanism, t_end=T_END, step=STEP, save=10)
        times.append(time.perf_counter() - begin)
    return min(times)


GAINS = {"target": 0.3, "kp": 20.0, "ki": 5.0, "kd": 3.0}
CASES = {
    "without": arm(),
    "P": arm(fm.PID("servo", "arm.theta", "actuator", target=0.3, kp=20.0)),
    "PID, filter": arm(fm.PID("servo", "arm.theta", "actuator", **GAINS)),
    "PID, measured rate": arm(fm.PID("servo", "arm.theta", "actuator", rate="arm.omega", **GAINS)),
}

if __name__ == "__main__":
    fm.simulate(CASES["PID, filter"], t_end=1e-2, step=STEP)  # compiled
    found = {name: seconds(mechanism) for name, mechanism in CASES.items()}
    for name, took in found.items():
        beyond = 1e6 * (took - found["without"]) / STEPS
        print(f"{name:20s} {1e6 * took / STEPS:8.3f} us a step, {beyond:6.3f} us more")
    sampled = arm(fm.PID("servo", "arm.theta", "actuator", sample=0.01, **GAINS))
    print(f"sampled: {1e6 * (seconds(sampled) - found['without']) * 0.01 / T_END:.0f} us an instant")
