"""Normal laws with hysteresis damping: what they deliver on paper and in motion, and what they must never do."""

import math
import runpy
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

import flexmb as fm
from flexmb.errors import InputError, RestitutionWarning
from flexmb.parts.contact.hysteresis import delivered_restitution, exact_chi
from flexmb.parts.contact.onset import HISTORY, approach_speed

drops = runpy.run_path(str(Path(__file__).with_name("drops.py")))
thrown, returned, stiffness = drops["thrown"], drops["returned"], drops["stiffness"]

ASKED = (0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95)

DELIVERED = {
    fm.LankaraniNikravesh: (0.672, 0.684, 0.725, 0.796, 0.847, 0.913, 0.954),
    fm.HuntCrossley: (0.547, 0.581, 0.663, 0.768, 0.833, 0.909, 0.952),
    fm.contact.HerbertMcWhannell: (0.501, 0.520, 0.594, 0.723, 0.807, 0.901, 0.950),
    fm.contact.LeeWang: (0.712, 0.739, 0.799, 0.869, 0.909, 0.952, 0.976),
    fm.contact.ZhiyingQishao: (0.266, 0.327, 0.483, 0.680, 0.787, 0.896, 0.949),
    fm.contact.Flores: (0.156, 0.256, 0.470, 0.683, 0.789, 0.894, 0.947),
    fm.contact.HuGuo: (0.166, 0.271, 0.488, 0.697, 0.799, 0.900, 0.950),
}
"""What comes out, to three digits, computed once outside this package; the relation on paper and the impacts below must
both give it."""

EXACT_CHI = {
    0.1: 9.9981593975, 0.2: 4.91916671579, 0.3: 3.08708198113, 0.5: 1.43275053327, 0.7: 0.634828281266,
    0.9: 0.166481950685, 0.95: 0.0789266052874,
}  # fmt: skip

DAMPED = (*DELIVERED, fm.contact.Gonthier, fm.contact.CarvalhoMartins, fm.contact.ExactRestitution)


def quiet(kind, **numbers):
    """A law that may miss what it is asked for."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RestitutionWarning)
        return kind(**numbers)


# -- on paper --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", DELIVERED)
def test_delivered_on_paper(kind):
    law = quiet(kind, stiffness=1.0)
    assert [law.delivered_restitution(e) for e in ASKED] == pytest.approx(DELIVERED[kind], abs=5.1e-4)


@pytest.mark.parametrize(
    "e", [0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.7, 0.7499, 0.75, 0.8, 0.9, 0.95, 0.99, 1.0 - 1e-9, 1.0]
)
def test_exact_restitution_on_paper(e):
    assert fm.contact.ExactRestitution(stiffness=1.0, restitution=e).delivered_restitution() == pytest.approx(
        e, abs=1e-12
    )


@pytest.mark.parametrize("e", EXACT_CHI)
def test_exact_factor(e):
    assert fm.contact.ExactRestitution.chi(e) == pytest.approx(EXACT_CHI[e], rel=3e-12)


def test_exact_factor_at_both_ends():
    """Near e = 1: chi = 3 x/2 (1 + x + ...), x = 1 - e, from the series of the logarithms; near 0: chi e = 1 - tiny."""
    x = 2.0**-30
    assert exact_chi(1.0 - x) == pytest.approx(1.5 * x * (1.0 + x), rel=1e-14)
    assert exact_chi(1.0) == 0.0
    assert exact_chi(0.01) == pytest.approx(100.0, rel=1e-14)  # 1 - chi e = 101 exp(-101)
    e, chi = 0.05, exact_chi(0.05)
    assert 1.0 - chi * e == pytest.approx(21.0 * math.exp(-21.0), rel=1e-6)


def test_both_forms_meet_where_the_series_begins():
    """Either side of the change from one form to the other the exact factor goes on smoothly."""
    values = [exact_chi(0.75 + k * 1e-6) for k in range(-3, 3)]
    assert abs(np.diff(values, 3)).max() < 1e-14  # third differences: 1e-17 of the curve, the rest is round-off
    back = [delivered_restitution(0.5 + k * 1e-6) for k in range(-3, 3)]
    assert abs(np.diff(back, 3)).max() < 1e-14  # third differences: 1e-17 of the curve, the rest is round-off


@settings(max_examples=30)
@given(chi=st.floats(1e-6, 6.0))
def test_balance_of_work(chi):
    """Both sides of m v dv/(1 + chi v) = -F d(depth), by quadrature: in with the speed 1, out with e."""
    e = delivered_restitution(chi)
    way_in = quad(lambda v: v / (1.0 + chi * v), 0.0, 1.0, epsabs=1e-13)[0]
    way_out = quad(lambda v: v / (1.0 - chi * v), 0.0, e, epsabs=1e-13, limit=200)[0]
    assert way_out == pytest.approx(way_in, rel=1e-6)


@pytest.mark.parametrize("e", ASKED)
def test_gonthier_and_carvalho_martins_deliver_what_they_claim(e):
    """Gonthier: never off by 5 %; Carvalho and Martins: a fit, 0.2 % from e = 0.5 on."""
    assert fm.contact.Gonthier(stiffness=1.0).delivered_restitution(e) == pytest.approx(e, rel=0.05)
    assert fm.contact.CarvalhoMartins(stiffness=1.0).delivered_restitution(e) == pytest.approx(
        e, rel=0.06 if e < 0.5 else 2e-3
    )


def test_the_table_of_the_documentation(root, capsys):
    runpy.run_path(str(root / "docs" / "contact_table.py"), run_name="__main__")
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == 12
    assert set(printed) <= set((root / "docs" / "contact.md").read_text(encoding="utf-8").splitlines())


def test_hertz_returns_everything():
    assert fm.contact.Hertz(stiffness=1.0).delivered_restitution() == 1.0
    assert not thrown([fm.contact.Hertz(stiffness=1.0)], t_end=0.1, step=0.01).notes


# -- in motion -------------------------------------------------------------------------------------------------------


@pytest.mark.quick(4)
@pytest.mark.parametrize("exponent", [1.0, 10.0 / 9.0, 1.5])
@pytest.mark.parametrize("kind", DELIVERED)
def test_delivered_in_motion(kind, exponent):
    K = stiffness(exponent)
    laws = [quiet(kind, stiffness=K, exponent=exponent, restitution=e, least_approach=0.0) for e in ASKED]
    sol = thrown(laws, t_end=6e-4, step=1e-7)
    assert returned(sol, len(laws)) == pytest.approx(DELIVERED[kind], abs=1e-3)


@pytest.mark.parametrize("exponent", [1.5, 3.0])
def test_exact_restitution_in_motion(exponent):
    asked = (0.3, 0.5, 0.8, 0.95)
    laws = [fm.contact.ExactRestitution(stiffness=stiffness(exponent), exponent=exponent, restitution=e) for e in asked]
    sol = thrown(laws, t_end=4.5e-4, step=1e-8)
    assert returned(sol, len(laws)) == pytest.approx(asked, abs=1e-6)


def test_mass_and_speed_do_not_matter():
    law = fm.contact.ExactRestitution(stiffness=3e8, restitution=0.4)
    sol = thrown([law], t_end=6e-4, step=2e-8, mass=0.037, speed=4.1)
    assert returned(sol, 1, 4.1) == pytest.approx([0.4], abs=1e-5)


@pytest.mark.parametrize(
    ("law", "depth", "duration", "peak"),
    [
        # exact: (5/4)^(2/5), and twice that times the integral of 1/sqrt(1 - s^(5/2))
        (fm.contact.Hertz(stiffness=1.0), 1.0933620739, 3.21806546, 1.0933620739**1.5),
        # an independent code, converged
        (fm.LankaraniNikravesh(stiffness=1.0, least_approach=0.0), 1.0547874, 3.2498833, 1.0916121),
    ],
)
def test_depth_duration_and_peak_force(law, depth, duration, peak):
    sol = thrown([law], t_end=5.0, step=2e-4, play=1.0, radius=10.0)
    found = sol.array("J0.penetration")
    inside = np.flatnonzero(found > 0.0)
    first, last = inside[0] - 1, inside[-1]
    ends = [sol.time[k] - found[k] * (sol.time[k + 1] - sol.time[k]) / (found[k + 1] - found[k]) for k in (first, last)]
    assert found.max() == pytest.approx(depth, rel=1e-7)
    assert ends[1] - ends[0] == pytest.approx(duration, rel=1e-7)
    assert sol.peak("J0.normal_force").value == pytest.approx(peak, rel=1e-7)


@fm.normal_law
def plain_kernel(p, h, gap, gap_rate, z, z_new):
    K, n, e, least = p
    approach, by_gap, by_rate = approach_speed(h, gap, gap_rate, least, z, z_new)
    if gap >= 0.0:
        return 0.0, 0.0, 0.0
    chi = 0.75 * (1.0 - e * e)
    elastic = K * (-gap * math.sqrt(-gap))  # n = 3/2
    ratio = -gap_rate / approach
    factor = 1.0 + chi * ratio
    if factor <= 0.0:
        return 0.0, 0.0, 0.0
    by_approach = -elastic * chi * ratio / approach
    return (
        elastic * factor,
        n * elastic / gap * factor + by_approach * by_gap,
        -elastic * chi / approach + by_approach * by_rate,
    )


class Plain(fm.NormalLaw):
    """The law of Lankarani and Nikravesh without a memory of extremes."""

    kernel = plain_kernel

    def parameters(self):
        return 1e9, 1.5, 0.7, 1e-3

    def history(self):
        return HISTORY


@pytest.mark.slow
def test_memory_of_extremes_changes_nothing():
    """Bit for bit, over two impacts."""
    laws = quiet(fm.LankaraniNikravesh, stiffness=1e9, restitution=0.7), Plain()
    first, second = (thrown([law], t_end=4e-3, step=5e-7) for law in laws)
    assert np.count_nonzero(np.diff(first.array("J0.mode")) > 0.0) >= 2
    assert np.array_equal(first.values, second.values)


# -- what must never happen ------------------------------------------------------------------------------------------

STEEL = (fm.STEEL, fm.STEEL)
EVERY = [
    *(quiet(kind, stiffness=1e9, restitution=e) for kind in DAMPED for e in (0.05, 0.6, 1.0)),
    fm.contact.Hertz(stiffness=1e9),
    fm.KelvinVoigt(1e6, 300.0),
    fm.KelvinVoigt(1e6, 300.0, ramp=1e-5),
    *(
        kind(0.02, STEEL, restitution=0.3).for_radii(0.01, 0.0098)
        for kind in (
            fm.contact.Johnson,
            fm.contact.Radzimovsky,
            fm.contact.Goldsmith,
            fm.contact.DubowskyFreudenstein,
            fm.contact.ESDU78035,
        )
    ),
]


def force(law, depth, rate, approach):
    """N in a contact that began with `approach`."""
    history = (approach, -depth, -rate, approach, *law.history()[4:])
    return law.kernel(law.parameters(), 1e-6, -depth, -rate, np.array(history), np.zeros(len(history)))[0]


@given(
    law=st.sampled_from(EVERY), depth=st.floats(1e-12, 1e-3), approach=st.floats(1e-3, 1e3), share=st.floats(-5.0, 5.0)
)
def test_never_pulls_and_never_gives_energy(law, depth, approach, share):
    """(N - N at rest) rate >= 0 everywhere, so no closed path of the depth gains anything."""
    rate = share * approach
    N, still = force(law, depth, rate, approach), force(law, depth, 0.0, approach)
    assert N >= 0.0
    assert still > 0.0
    assert (N - still) * rate >= -1e-12 * still * abs(rate)


def test_a_contact_that_begins_at_rest():
    """It is elastic until it moves, and then within what a free impact has: not damped without limit."""
    law = fm.contact.ExactRestitution(stiffness=1e9, restitution=0.5, least_approach=0.0)
    chi = exact_chi(0.5)
    for rate, factor in ((0.0, 1.0), (1e-3, 1.0 - 0.5 * chi), (-1e-3, 1.0 + chi)):  # at rest, parting, pressed
        z, z_new = np.array((0.0, -1e-6, rate, *[0.0] * 6)), np.zeros(9)
        found = law.kernel(law.parameters(), 0.0, -1e-6, rate, z, z_new)
        assert found == pytest.approx((factor, -1.5e6 * factor, 0.0))
        assert np.isfinite(z_new).all()


@given(
    law=st.sampled_from(EVERY),
    swings=st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3),
    size=st.sampled_from([1e-7, 1e-5, 1e-4]),
)
def test_an_episode_never_gains(law, swings, size):
    """Work taken from the bodies over any path from touch to touch, by the trapezoidal rule."""
    t = np.linspace(0.0, 1.0, 401)
    shape = sum(a * np.sin((k + 2) * np.pi * t) for k, a in enumerate(swings))
    depth = size * (4.0 * t * (1.0 - t) * (1.5 + 0.3 * shape))
    depth[0] = depth[-1] = 0.0
    rate = np.gradient(depth, t) * 1e3
    N = np.array([force(law, d, r, 1e3 * size) if d > 0.0 else 0.0 for d, r in zip(depth, rate, strict=True)])
    work = np.sum(0.5 * (N[1:] + N[:-1]) * np.diff(depth))
    assert work >= -1e-3 * N.max() * size


# -- warnings --------------------------------------------------------------------------------------------------------


def test_a_miss_is_told_at_the_line_that_asked():
    text = r"LankaraniNikravesh\(restitution=0.5\) delivers 0.725; ExactRestitution\(restitution=0.5\) delivers 0.5\."
    for make in (
        lambda: fm.LankaraniNikravesh(stiffness=1.0, restitution=0.5),
        lambda: fm.LankaraniNikravesh.from_materials(fm.STEEL, fm.STEEL, restitution=0.5),
    ):
        with pytest.warns(RestitutionWarning, match=text) as caught:
            make()
        assert [(w.filename, w.lineno) for w in caught] == [(__file__, make.__code__.co_firstlineno)]


@pytest.mark.parametrize(
    ("kind", "e"), [(fm.LankaraniNikravesh, 0.82), (fm.contact.Flores, 0.54), (fm.contact.Gonthier, 0.05)]
)
def test_a_near_miss_is_not_told(kind, e):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        kind(stiffness=1.0, restitution=e)


def test_a_simulation_does_not_warn_again():
    law = quiet(fm.LankaraniNikravesh, materials=STEEL, restitution=0.4)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert thrown([law], t_end=1e-5, step=1e-6).ok


def test_ready_mechanisms_do_not_warn():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for make in (fm.mechanisms.slider_crank, fm.mechanisms.four_bar, fm.mechanisms.nine_bar):
            fm.compile(make(clearance=1e-4))


# -- bad input -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", DAMPED)
@pytest.mark.parametrize(
    ("e", "text"),
    [(0.0, "is 0; it must be > 0"), (-0.1, "must be > 0"), (1.01, "is 1.01; it must lie between 0 and 1")],
)
def test_restitution_out_of_range(kind, e, text):
    with pytest.raises(InputError, match=f"{kind.__name__}: restitution .*{text}"):
        kind(stiffness=1.0, restitution=e)
    with pytest.raises(InputError, match=f"{kind.__name__}: e .*{text}"):
        quiet(kind, stiffness=1.0).delivered_restitution(e)


def test_hertz_takes_no_restitution():
    with pytest.raises(TypeError, match="restitution"):
        fm.contact.Hertz(stiffness=1.0, restitution=0.5)


def test_a_stiffness_is_needed():
    with pytest.raises(InputError, match=r"Flores: stiffness is missing; .*Flores.from_materials"):
        fm.contact.Flores()
    with pytest.raises(InputError, match="HuGuo: the stiffness depends on radii"):
        fm.contact.HuGuo.from_materials(fm.STEEL, fm.STEEL).parameters()


def test_laws_in_the_wrong_place():
    ball = fm.RigidBody("ball", (0.0, 0.0), 1.0, 1.0)
    given_ = {"clearance": 1e-4, "bearing_radius": 1e-2}
    with pytest.raises(InputError, match=r"'J': normal is ModifiedCoulomb\(.*must be a normal law"):
        fm.RevoluteClearance("J", fm.GROUND, ball, (0.0, 0.0), normal=fm.ModifiedCoulomb(0.1), **given_)
    law = fm.contact.Hertz(stiffness=1.0)
    with pytest.raises(InputError, match=r"'J': friction is Hertz\(.*must be a friction law"):
        fm.RevoluteClearance("J", fm.GROUND, ball, (0.0, 0.0), normal=law, friction=law, **given_)
