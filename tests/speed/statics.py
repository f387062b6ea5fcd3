"""Time and memory of statics, modes, buckling and reduction at size: `python tests/speed/statics.py [MODEL ...]`.

The rows are kept in out/speed for `python docs/performance.py --collect`.  Times are of the processor; each model has a
process of its own, whose peak memory is shown.  `reduce` reduces a link of 200,000 nodes to 6 modes.
"""

import multiprocessing
import resource
import sys
import time

from duel import keep

import flexmb as fm

STEEL = fm.Material(young=2.07e11, density=7850.0, poisson=0.3)
UNKNOWNS, NODES = 20_000, 200_000
HEADS = ("model", "unknowns", "compile", "statics", "modes", "buckling", "MB")


def bar() -> fm.Mechanism:
    """A slender bar of quad9 cells, clamped on the left, pressed on the right."""
    across = round((UNKNOWNS / 64.0) ** 0.5)  # two unknowns a node, 8 times as long as high
    mesh = fm.meshes.rectangle(0.8, 0.1, 8 * across, across)
    body = fm.PlaneBody("bar", mesh, at=(0.0, 0.0), thickness=0.01, material=STEEL, pins=("left", "right"))
    left, right = ((pin.x, pin.y) for pin in body.pin_nodes)
    load = fm.Force("P", body, at=right, force=(-1e3, -10.0))
    return fm.Mechanism("bar", [body, fm.Fixed("O", fm.GROUND, body, at=left), load], gravity=(0.0, -9.81))


def frame() -> fm.Mechanism:
    """A square lattice of beams of 5 elements, clamped at two corners."""
    k = round((UNKNOWNS / 30.0) ** 0.5)
    corners = [(float(i), float(j)) for j in range(k) for i in range(k)]
    edges = [(j * k + i, j * k + i + 1) for j in range(k) for i in range(k - 1)]
    edges += [(j * k + i, j * k + i + k) for j in range(k - 1) for i in range(k)]
    section = fm.Rectangle(width=0.02, height=0.04)
    body = fm.FlexibleFrame("frame", corners, edges, section=section, material=STEEL, elements=5)
    parts = [body, fm.Force("P", body, at=(k - 1.0, k - 1.0), force=(-10.0, -100.0))]
    parts += [fm.Fixed(name, fm.GROUND, body, at=at) for name, at in (("O", (0.0, 0.0)), ("Q", (k - 1.0, 0.0)))]
    return fm.Mechanism("frame", parts, gravity=(0.0, -9.81))


def chain() -> fm.Mechanism:
    """Links of 4 beams on a line, hinged and clamped by turns, each on a spring, pressed along the line."""
    section, length, parts, before = fm.Rectangle(width=0.01, height=0.01), 0.1, [], fm.GROUND
    for k in range(UNKNOWNS // 14):
        start, end = (length * k, 0.0), (length * (k + 1), 0.0)
        link = fm.FlexibleLink(f"link{k}", start, end, section=section, material=STEEL, elements=4)
        joint = (fm.Revolute if k % 2 else fm.Fixed)(f"J{k}", before, link, at=start)
        parts += [link, joint, fm.SpringDamper(f"s{k}", fm.GROUND, link, (end[0], -0.1), end, stiffness=1e5)]
        before = link
    return fm.Mechanism("chain", [*parts, fm.Force("P", before, at=end, force=(-1.0, 0.0))], gravity=(0.0, -9.81))


def masses() -> fm.Mechanism:
    """A square lattice of point masses and springs, with diagonals, on a row of springs."""
    k, step, stiff = round((UNKNOWNS / 2.0) ** 0.5), 0.1, {"stiffness": 1e4}
    places = [(i, j) for i in range(k) for j in range(k)]
    found = {(i, j): fm.bodies.PointMass(f"m{i}_{j}", (i * step, j * step), mass=0.01) for i, j in places}
    parts = list(found.values())
    for (i, j), mass in found.items():
        for a, b in ((1, 0), (0, 1), (1, 1), (1, -1)):
            other = found.get((i + a, j + b))
            if other is not None:
                name = f"s{i}_{j}_{a}_{b + 1}"
                parts.append(fm.SpringDamper(name, mass, other, mass.at, other.at, **stiff))
    for i in range(k):
        foot, head = found[i, 0], found[i, 0].at
        for a in (0, 1):
            at = (head[0] - a * step, -step)
            parts.append(fm.SpringDamper(f"g{i}_{a}", fm.GROUND, foot, at, head, **stiff))
    corner = found[k - 1, k - 1]
    parts.append(fm.Force("P", corner, at=corner.at, force=(0.0, -1.0)))
    return fm.Mechanism("masses", parts, gravity=(0.0, -9.81))


MODELS = {"frame": frame, "chain": chain, "bar": bar, "masses": masses}


def link(nodes: int) -> fm.PlaneBody:
    """A link with eyes whose mesh has about so many nodes."""
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.02, size=0.131 / nodes**0.5)
    return fm.PlaneBody("rod", mesh, start=(0.0, 0.0), end=(0.12, 0.0), thickness=0.01, material=STEEL)


def seconds(work: object) -> float:
    """Time of the processor [s]."""
    began = time.process_time()
    work()
    return time.process_time() - began


def megabytes() -> float:
    """Peak memory of this process."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def measured(name: str) -> list:
    """A row of the table, after a small model by which everything compiled is loaded."""
    global UNKNOWNS  # noqa: PLW0603 - the size of the models
    work = fm.compile, fm.static_equilibrium, fm.modes, fm.buckling
    unknowns, UNKNOWNS = UNKNOWNS, 1000
    small = MODELS[name]()
    for one in work:
        one(small)
    UNKNOWNS = unknowns
    large = MODELS[name]()
    times = [seconds(lambda one=one: one(large)) for one in work]
    return [name, fm.compile(large).n_q, *times, megabytes()]


def reduced(nodes: int) -> list:
    """Seconds of mesh and declaration, and of the reduction to 6 modes."""
    fm.Reduced(link(2000), modes=6).frequencies(1)
    large = []
    declared = seconds(lambda: large.append(link(nodes)))
    time_ = seconds(lambda: fm.Reduced(large[0], modes=6).frequencies(1))
    return ["reduce", len(large[0].mesh.points), declared, time_, megabytes()]


def apart(function: object, argument: object) -> list:
    """What `function` finds in a new process."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, (argument,))


def main() -> None:
    """Measure and keep, row by row."""
    record = {"rows": [], "reduced": []}
    print("".join(f"{head:>10}" for head in HEADS), flush=True)
    for name in sys.argv[1:] or ["reduce", *MODELS]:
        if name == "reduce":
            record["reduced"] = found = apart(reduced, NODES)
            text = f"{found[1]} nodes, {found[2]:.1f} s declared, {found[3]:.1f} s reduced, {found[4]:.0f} MB"
            print(text, flush=True)
        else:
            record["rows"].append(found := apart(measured, name))
            print("".join(f"{v:>10}" if isinstance(v, str) else f"{v:10.4g}" for v in found), flush=True)
        keep("statics", dict(record))


if __name__ == "__main__":
    main()
