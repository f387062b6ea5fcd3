"""A chain of nine hinged elastic links that falls from the horizontal, against another code's beams.

Links of 0.4 m, 20 x 4 mm, steel, straight along +x and at rest; 9.81 m/s^2 for 0.5 s.  The other code's elements are
absolute nodal coordinate cables, four a link, as here.
"""

import numpy as np
from record import Problem, Value

import flexmb as fm

PROBLEM = Problem(
    title="Falling chain of elastic links",
    source="Exudyn 1.13, ANCFCable2D, generalised-alpha of spectral radius 0.9, index 3, 5000 steps",
    kind="computed once by Exudyn 1.13",
    about=(
        "Corotational beams against absolute nodal coordinates: nine links hinged to one another, four elements each. "
        "Both codes' tips still move with the mesh."
    ),
)

LINK, G, END = 0.4, 9.81, 0.5
WIDTH, HEIGHT, YOUNG, DENSITY = 0.020, 0.004, 2.1e11, 7850.0
TIP = (3.08548, -1.22543)

BAND = 2e-5
"""[m]; its tolerances move the other code by 5e-6 m, and rigid links end 1e-4 m away."""


def chain(elements, links=9):
    """The chain from rest along +x."""
    options = {
        "section": fm.Rectangle(width=WIDTH, height=HEIGHT),
        "material": fm.Material(young=YOUNG, density=DENSITY),
        "elements": elements,
    }
    parts, last = [], fm.GROUND
    for k in range(links):
        link = fm.FlexibleLink(f"L{k}", (LINK * k, 0.0), (LINK * (k + 1), 0.0), **options)
        parts += [link, fm.Revolute(f"J{k}", last, link, (LINK * k, 0.0))]
        last = link
    return fm.Mechanism("chain", tuple(parts), gravity=(0.0, -G))


def tip(elements, step=1e-4):
    sol = fm.simulate(chain(elements), t_end=END, step=step, save=1, method=fm.Newmark.generalised_alpha(0.9))
    assert sol.ok, sol.status
    return np.array([sol.array("L8.end.x")[-1], sol.array("L8.end.y")[-1]])


def _mesh(elements, slow=False):
    @PROBLEM.case(f"{elements} elements a link", slow=slow)
    def case():
        x, y = tip(elements)
        yield Value("tip x [m]", TIP[0], x, BAND, scale=1.0)
        yield Value("tip y [m]", TIP[1], y, BAND, scale=1.0)


for _elements in (4, 8):
    _mesh(_elements)


test_case, _ = PROBLEM.tests()


def test_rigid_links_do_not_end_there():
    """The band is narrow enough to tell elastic links from rigid ones."""
    parts, last, mass = [], fm.GROUND, DENSITY * WIDTH * HEIGHT * LINK
    for k in range(9):
        link = fm.RigidLink(f"L{k}", (LINK * k, 0.0), (LINK * (k + 1), 0.0), mass, mass * LINK**2 / 12)
        parts += [link, fm.Revolute(f"J{k}", last, link, (LINK * k, 0.0))]
        last = link
    sol = fm.simulate(fm.Mechanism("chain", tuple(parts), gravity=(0.0, -G)), t_end=END, step=1e-4, save=1)
    angle = sol.array("L8.theta")[-1]
    x, y = sol.array("L8.x")[-1] + 0.5 * LINK * np.cos(angle), sol.array("L8.y")[-1] + 0.5 * LINK * np.sin(angle)
    assert np.hypot(x - TIP[0], y - TIP[1]) > 2.0 * BAND
