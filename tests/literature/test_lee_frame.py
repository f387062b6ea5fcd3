"""Lee's frame: two hinged legs at a right angle, which snap through under a dead load.

Legs of 120, one from the lower hinge up to the corner, one from the corner to the right hinge; E = 720, A = 6, I = 2; a
load downwards on the upper leg, at 24 from the corner.  The load passes a maximum, the limit load.
Source: S. L. Lee, F. S. Manuel, E. C. Rossow, Large deflections and stability of elastic frames, Journal of the
Engineering Mechanics Division, ASCE 94 (1968) 521-547: 1.8552.  Exact digits: the extensible elastica of both legs by
shooting, by an independent script: 1.855672754 at the sinking v = 48.735137 and the place u = 50.880574 of the load
from the first leg.
"""

from record import Curve, Problem, Value
from scipy.optimize import minimize_scalar

import flexmb as fm

LEG, PLACE, YOUNG, AREA, SECOND = 120.0, 24.0, 720.0, 6.0, 2.0
LIMIT, SINKING, ASIDE, PUBLISHED = 1.855672754, 48.735137, 50.880574, 1.8552
HOLD = 10.0
"""Stiffness of the spring under the load; with it the frame is stable on the whole path."""

PROBLEM = Problem(
    title="Lee's frame",
    source="S. L. Lee, F. S. Manuel, E. C. Rossow, J. Engineering Mechanics Division ASCE 94 (1968) 521-547",
    kind="published; exact digits by shooting with an independent script",
    about="""The limit load by statics with a prescribed displacement: a spring holds the load from below and its foot
    is lowered, so that the frame cannot snap; the frame bears the load less the force of the spring.  The limit load is
    the largest one on this path.""",
)


def borne(lowered: float, elements: int) -> tuple[float, float, float]:
    """Load that the frame bears, sinking v and place u of the loaded point; `lowered`: that of the spring's foot."""
    near = max(1, elements // 5)
    corner, loaded, hinge = (0.0, LEG), (PLACE, LEG), (LEG, LEG)
    frame = fm.FlexibleFrame(
        "frame", ((0.0, 0.0), corner, loaded, hinge), ((0, 1), (1, 2), (2, 3)),
        section=fm.GeneralSection(area=AREA, second_moment=SECOND), material=fm.Material(young=YOUNG, density=1.0),
        elements=(elements, near, elements - near),
    )  # fmt: skip
    hinges = [fm.Revolute(f"hinge{k}", fm.GROUND, frame, at=at) for k, at in enumerate(((0.0, 0.0), hinge))]
    spring = fm.Bushing("spring", fm.GROUND, frame, at=loaded, stiffness=(0.0, HOLD))
    foot = fm.Force("foot", frame, at=loaded, force=(0.0, -HOLD * lowered))
    found = fm.static_equilibrium(fm.Mechanism("Lee's frame", [frame, *hinges, spring, foot]))
    sinking = LEG - found["frame.node2.y"]
    return HOLD * (lowered - sinking), sinking, found["frame.node2.x"]


def limit(elements: int) -> tuple[float, float, float]:
    """Limit load, sinking and place there."""
    best = minimize_scalar(
        lambda lowered: -borne(lowered, elements)[0], bounds=(48.0, 50.0), method="bounded", options={"xatol": 1e-6}
    )
    return borne(best.x, elements)


@PROBLEM.case("10 elements a leg")
def ten():
    yield Value("limit load", PUBLISHED, limit(10)[0], 5e-4)


@PROBLEM.case("40 elements a leg", slow=True)
def forty():
    load, sinking, aside = limit(40)
    yield Value("limit load", LIMIT, load, 1e-6)
    yield Value("sinking of the load there", SINKING, sinking, 1e-4)
    yield Value("place of the load there, from the first leg", ASIDE, aside, 1e-4)


@PROBLEM.case("40 elements a leg, at the exact sinking")
def at_the_exact_sinking():
    load, sinking, aside = borne(SINKING + LIMIT / HOLD, 40)
    yield Value("load", LIMIT, load, 1e-6)
    yield Value("sinking", SINKING, sinking, 1e-6)
    yield Value("place of the load, from the first leg", ASIDE, aside, 1e-6)


@PROBLEM.convergence("lee", "Lee's frame: error of the limit load.", "elements a leg, inverse", "relative error")
def elements():
    counts = (10, 20, 40)
    errors = [abs(borne(SINKING + LIMIT / HOLD, n)[0] / LIMIT - 1.0) for n in counts]
    yield Curve("limit load", [1.0 / n for n in counts], errors, order=2.0)


test_case, test_curves = PROBLEM.tests()
