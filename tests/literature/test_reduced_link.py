"""A link with eyes by its pins and few modes, against all nodes: alone, and as the rod of a slider-crank."""

from functools import lru_cache

import numpy as np
from record import Problem, Value

import flexmb as fm

STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
MODES = (0, 3, 6, 9, 12, 18, 24, 36)
STEP, T_END = 1e-5, 0.018

PROBLEM = Problem(
    title="Link with eyes, reduced",
    source="R. R. Craig, M. C. C. Bampton, AIAA J. 6 (1968) 1313",
    kind=(
        "computed once by scikit-fem on a mesh of Gmsh with 9,356 unknowns (frequencies); computed here with all nodes "
        "of the mesh (motion)"
    ),
    about=(
        "Two eyes of 40 mm around holes of 20 mm, a shank of 20 mm, 120 mm from hole to hole, 10 mm thick, held at one "
        "hole; and a thinner link, 6 mm square with eyes of 24 mm, as the rod of a slider-crank that reaches 5000 rpm "
        "in 6 ms and bends by 6 mrad. Its rotation at the pins against their connection is compared over 18 ms."
    ),
)


@lru_cache(maxsize=1)
def link():
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.02, size=0.0025)
    return fm.PlaneBody("rod", mesh, thickness=0.01, material=STEEL)


@lru_cache(maxsize=32)
def accuracy(modes):
    return fm.Reduced(link(), modes=modes).accuracy(held=("start",))


@lru_cache(maxsize=1)
def thin_rod():
    """The slider-crank, and its rod with all nodes."""
    mechanism = fm.mechanisms.slider_crank(ramp=6e-3)
    rigid = mechanism.find("rod")
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.012, hole=0.006, width=0.006, size=0.004)
    ends = {"start": rigid.start, "end": rigid.end}
    return mechanism, fm.PlaneBody("rod", mesh, **ends, thickness=0.006, material=STEEL, damping=1e-6)


def bending(body):
    """(2, t) rotations of both pins against their connection [rad], and the instants [s]."""
    sol = fm.simulate(thin_rod()[0].with_part(body), t_end=T_END, step=STEP, save="steps")
    assert sol.ok, sol.status
    (x1, y1, first), (x2, y2, last) = (
        [sol.array(f"rod.{pin}.{axis}") for axis in ("x", "y", "theta")] for pin in ("start", "end")
    )
    found = np.stack([first, last]) - np.unwrap(np.arctan2(y2 - y1, x2 - x1))
    return found - found[:, :1], sol.time


@lru_cache(maxsize=1)
def all_nodes():
    return bending(thin_rod()[1])


@lru_cache(maxsize=32)
def error(**options):
    """Largest difference of the rotations from those of all nodes, over their largest [1]."""
    full = all_nodes()[0]
    return float(np.abs(bending(fm.Reduced(thin_rod()[1], **options))[0] - full).max() / np.abs(full).max())


@PROBLEM.case("frequencies, all nodes")
def full():
    found = accuracy(0).held[:, 0]
    return [Value(f"{k + 1} [Hz]", f, found[k], 3e-5) for k, f in enumerate((913.9364, 5327.25, 9488.96))]


@PROBLEM.case("frequencies, static shapes alone")
def static_shapes():
    found = accuracy(0).held[:, 1]
    return [Value(f"{k + 1} [Hz]", f, found[k], 5e-5) for k, f in enumerate((914.5488, 6021.07, 9779.30))]


@PROBLEM.case("frequencies, 24 modes")
def many_modes():
    found = accuracy(24).held[:, 1]
    return [Value(f"{k + 1} [Hz]", f, found[k], 5e-4) for k, f in enumerate((913.9364, 5327.25, 9488.96))]


@PROBLEM.case("slider-crank, 3 modes", slow=True)
def three_modes():
    return [Value("rotation of the pins, error [1]", 0.0, error(modes=3), 1e-3, scale=1.0)]


@PROBLEM.case("slider-crank, 3 modes and shapes of inertia", slow=True)
def with_inertia():
    return [Value("rotation of the pins, error [1]", 0.0, error(modes=3, inertia_shapes=True), 3e-4, scale=1.0)]


@PROBLEM.picture("link_modes", "Link with eyes held at one hole: errors over the number of modes")
def over_modes(figure):
    axes = figure.add_subplot()
    found = [accuracy(modes) for modes in MODES]
    for k in range(3):
        axes.semilogy(MODES, [one.held_errors[k] for one in found], "o-", label=f"frequency {k + 1}")
    for name, style in (("acceleration along y", "s--"), ("rotation", "^--")):
        axes.semilogy(MODES, [one.loads[name].deflection_error for one in found], style, label=f"deflection, {name}")
        axes.semilogy(
            MODES, [one.loads[name].stress_error for one in found], style, mfc="none", label=f"stress, {name}"
        )
    axes.set_xlabel("modes")
    axes.set_ylabel("relative error [1]")
    axes.grid(visible=True, color="0.9")
    axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))


@PROBLEM.picture(
    "link_slider_crank", "Rod of a slider-crank: rotation of its pins by all nodes, and errors of reduced rods"
)
def in_motion(figure):
    above, below = figure.subplots(2, 1)
    (start, end), time = all_nodes()
    above.plot(1e3 * time, 1e3 * start, label="start")
    above.plot(1e3 * time, 1e3 * end, label="end")
    above.set_xlabel("time [ms]")
    above.set_ylabel("rotation [mrad]")
    above.legend(fontsize=8)
    shown = MODES[:7]
    below.semilogy(shown, [error(modes=k) for k in shown], "o-", label="modes")
    below.semilogy(
        shown, [error(modes=k, inertia_shapes=True) for k in shown], "s-", label="modes and shapes of inertia"
    )
    below.set_xlabel("modes")
    below.set_ylabel("largest error [1]")
    below.grid(visible=True, color="0.9")
    below.legend(fontsize=8)


test_case, test_curves = PROBLEM.tests()
