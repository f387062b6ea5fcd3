"""Cost of a step with the search for the largest stress over that without, in pairs of runs that take turns.

python tests/speed/stress_time.py          # a connecting rod of beams, reduced, and with all nodes of its mesh
"""

import statistics

import flexmb as fm

ROUNDS = 9
"""Number of pairs."""

O, A, B = (0.0, 0.0), (0.05, 0.0), (0.17, 0.0)
STEEL = fm.Material(young=2.07e11, density=7850.0, poisson=0.3)


def bodies(stress):
    """Connecting rods of one shape by name, each with the number of its steps."""
    section = fm.Rectangle(width=0.01, height=0.014)
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.015, hole=0.008, width=0.014, size=0.003)
    plate = fm.PlaneBody("rod", mesh, start=A, end=B, thickness=0.01, material=STEEL, stress=stress)
    beam = fm.FlexibleLink("rod", A, B, section=section, material=STEEL, elements=4, stress=stress)
    return {
        "4 beams": (beam, 4000),
        f"reduced, 6 modes, {len(mesh.points)} nodes": (fm.Reduced(plate, modes=6), 4000),
        f"all {len(mesh.points)} nodes": (plate, 40),
    }


def time_of_a_step(rod, steps):
    """Time of a step of an engine [us]."""
    crank = fm.RigidLink("crank", O, A, mass=0.3, inertia=1e-4)
    piston = fm.RigidBody("piston", at=B, mass=0.14, inertia=1e-4)
    parts = [
        crank,
        rod,
        piston,
        fm.Revolute("O", fm.GROUND, crank, at=O),
        fm.Revolute("A", crank, rod, at=A),
        fm.Revolute("B", rod, piston, at=B),
        fm.Prismatic("guide", fm.GROUND, piston, along=(1.0, 0.0)),
        fm.Drive("motor", joint="O", motion=fm.ConstantSpeed(100.0)),
    ]
    sol = fm.simulate(fm.Mechanism("engine", parts), t_end=steps * 1e-6, step=1e-6, save=1)
    return 1e6 * sol.stats.wall_time / sol.stats.steps


def main():
    """Print one line for each body."""
    with_it, without = bodies(stress=True), bodies(stress=False)
    for name, (rod, steps) in with_it.items():
        pairs = [(time_of_a_step(rod, steps), time_of_a_step(without[name][0], steps)) for _ in range(ROUNDS + 1)][1:]
        ratios = sorted(a / b for a, b in pairs)
        least = [min(times) for times in zip(*pairs, strict=True)]
        text = f"{name}: {least[0]:.1f} us with, {least[1]:.1f} us without; ratio {statistics.median(ratios):.2f}"
        print(f"{text} ({ratios[0]:.2f} to {ratios[-1]:.2f})", flush=True)


if __name__ == "__main__":
    main()
