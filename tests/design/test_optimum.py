"""Better designs and spreads: closed forms, limits, designs that cannot be assembled, stores, refusals."""

import functools
import json

import numpy as np
import pytest
from designs import four_bar

import flexmb as fm
from flexmb.design import Normal, Uniform, at_end, mean, peak
from flexmb.errors import InputError, ModelError, SolveError
from flexmb.mechanisms import slider_crank
from flexmb.mechanisms.slider_crank import SliderCrankData


def pushed(mass: float = 1.0, force: float = 1.0) -> fm.Mechanism:
    """A mass that a force pushes along a guide: x = F t^2 / (2 m)."""
    body = fm.RigidBody("body", (0.0, 0.0), mass, 1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(1.0, 0.0))
    return fm.Mechanism("pushed", [body, guide, fm.Force("push", body, at=(0.0, 0.0), force=(force, 0.0))])


@pytest.mark.slow
def test_least_value_at_a_limit():
    """Least travel x = 1 / (2 m) under the limit that the speed 1 / m stays above .8."""
    found = fm.design.optimise(
        pushed, {"mass": (0.5, 4.0)}, objective=at_end("body.x"), subject_to=[at_end("body.vx") >= 0.8], t_end=1.0
    )
    assert found.ok
    assert found.parameters["mass"] == pytest.approx(1.25, rel=1e-6)
    assert found.objective == pytest.approx(0.4, rel=1e-6)
    assert abs(found.limits["end of body.vx >= 0.8"]) < 1e-6
    assert max(found.check) < 1e-6
    assert found.history.sizes["design"] >= 3
    assert "Converged" in repr(found)


@pytest.mark.slow
@pytest.mark.parametrize("force", [1e-6, pytest.param(1e6, marks=pytest.mark.slow)])
def test_limits_hold_whatever_their_units(force):
    """x = F t^2/(2 m), v = F t/m: the heaviest mass with v(1 s) >= .8 F has 1.25 kg, and x = .4 F."""
    found = fm.design.optimise(
        functools.partial(pushed, force=force),
        {"mass": (0.5, 4.0)},
        objective=at_end("body.x"),
        subject_to=[at_end("body.vx") >= 0.8 * force],
        start={"mass": 4.0},
        t_end=1.0,
        step=0.1,
    )
    assert found.ok
    assert found.parameters["mass"] == pytest.approx(1.25, rel=1e-5)


def test_function_of_parameters_as_a_limit():
    def light(mass):
        return 2.0 - mass

    found = fm.design.optimise(
        pushed, {"mass": (0.5, 4.0)}, objective=at_end("body.x"), subject_to=[light], t_end=1.0, search="trust-constr"
    )
    assert found.parameters["mass"] == pytest.approx(2.0, rel=1e-3)


def balanced(counterweight: float) -> fm.Mechanism:
    mech = slider_crank(speed=100.0)
    back = fm.RigidBody("counterweight", at=(-0.02, 0.0), mass=counterweight, inertia=1e-6)
    bolt = fm.Fixed("bolt", mech["crank"], back, at=(-0.02, 0.0))
    return fm.Mechanism("balanced", [*mech.parts, back, bolt], mech.gravity)


def test_counterweight_of_a_crank_beside_a_scan():
    measure = peak("O.force", norm=16)
    start = {"counterweight": 0.1}
    found = fm.design.optimise(balanced, {"counterweight": (0.01, 2.0)}, objective=measure, periods=1, start=start)
    assert found.ok
    assert max(found.check) < 1e-3
    best = found.parameters["counterweight"]
    around = [
        fm.design.sensitivity(balanced, {"counterweight": value}, of=[measure], periods=1).measures.amount.item()
        for value in (0.98 * best, best, 1.02 * best)
    ]
    assert around[1] < min(around[0], around[2])
    assert around[1] == pytest.approx(found.objective, rel=1e-9)
    assert found.objective < 0.7 * found.first


def jammed(coupler: float) -> fm.Mechanism:
    """A four-bar whose coupler does not reach the rocker below .112 m."""
    if not 0.12 < coupler < 0.7:
        raise ModelError(f"four-bar: a coupler of {coupler:.3g} m does not reach the rocker.")
    return four_bar(0.1, coupler, 12.0)


@pytest.mark.slow
def test_designs_that_cannot_be_assembled_do_not_end_the_search():
    """A coupler that does not reach the rocker: these designs are kept with their status."""
    found = fm.design.optimise(
        jammed,
        {"coupler": (0.05, 0.6)},
        objective=mean("coupler.theta"),
        start={"coupler": 0.35},
        t_end=0.02,
        everywhere=True,
        most_designs=30,
    )
    status = found.history.status.values
    assert (status == "done").any()
    assert (status != "done").any()
    assert np.isfinite(found.objective)


@pytest.mark.slow
def test_store_of_designs_is_continued(tmp_path):
    store = tmp_path / "designs.json"
    how = {"objective": at_end("body.x"), "subject_to": [at_end("body.vx") >= 0.8], "t_end": 1.0, "store": store}
    short = fm.design.optimise(pushed, {"mass": (0.5, 4.0)}, most_designs=2, **how)
    assert not short.ok
    assert "2 designs" in short.message
    with pytest.raises(InputError, match="resume=True"):
        fm.design.optimise(pushed, {"mass": (0.5, 4.0)}, **how)
    whole = fm.design.optimise(pushed, {"mass": (0.5, 4.0)}, resume=True, **how)
    assert whole.ok
    fresh = fm.design.optimise(pushed, {"mass": (0.5, 4.0)}, **how | {"store": None})
    assert whole.parameters == fresh.parameters
    with pytest.raises(InputError, match="another search"):
        fm.design.optimise(pushed, {"mass": (0.5, 5.0)}, resume=True, **how)
    store.write_text(json.dumps({"designs": 3}))
    with pytest.raises(InputError, match="no file of designs"):
        fm.design.optimise(pushed, {"mass": (0.5, 4.0)}, resume=True, **how)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"objective": peak("body.x")}, "norm=16"),
        ({"objective": {"body.x": 1.0}}, "no measure"),
        ({"objective": at_end("body.z")}, "body.x"),
        ({"objective": {}}, "no measure"),
        ({"objective": None}, "no measure"),
        ({"objective": {at_end("body.x"): np.nan}}, "weight"),
        ({"objective": "body.x"}, "dictionary"),
        ({"subject_to": 3.0}, "list of limits"),
        ({"subject_to": [3.0]}, "limits of measures or functions"),
        ({"start": {"mas": 1.0}}, "mass"),
        ({"start": {"mass": 9.0}}, "between 0.5 and 4"),
        ({"search": "simplex"}, "SLSQP"),
        ({"t_end": None}, "t_end= "),
        ({"most_designs": 0}, "at least 1"),
    ],
)
def test_wrong_searches_are_refused(changes, message):
    given = {"objective": at_end("body.x"), "t_end": 1.0} | changes
    with pytest.raises(InputError, match=message):
        fm.design.optimise(pushed, {"mass": (0.5, 4.0)}, **given)


def test_limit_function_of_an_unknown_parameter_is_refused():
    with pytest.raises(ModelError, match="missing 1 required positional argument: 'mas'"):
        fm.design.optimise(
            pushed, {"mass": (0.5, 4.0)}, objective=at_end("body.x"), subject_to=[lambda mas: mas], t_end=1.0
        )


def test_functions_of_one_name_are_different_limits():
    limits = [lambda mass: mass - 0.6, lambda mass: 3.0 - mass]
    found = fm.design.optimise(
        pushed, {"mass": (0.5, 4.0)}, objective=at_end("body.x"), subject_to=limits, t_end=1.0, step=0.1
    )
    assert list(found.limits.values()) == pytest.approx([2.4, 0.0], abs=1e-6)


def test_a_chain_of_limits_is_refused():
    with pytest.raises(InputError, match="two limits"):
        assert 1.0 <= mean("body.x") <= 2.0


def test_failure_of_the_first_design_is_an_error():
    with pytest.raises(SolveError, match="Give another start"):
        fm.design.optimise(jammed, {"coupler": (0.05, 0.06)}, objective=mean("B.force"), t_end=0.1)


# Spread


@pytest.mark.slow
def test_spread_of_a_product():
    """x = F / (2 m), F and m uniform: mean, deviation and Sobol's indices by integrals."""
    laws = {"mass": Uniform(0.5, 1.5), "force": Uniform(0.5, 1.5)}
    found = fm.design.spread(pushed, laws, of=[at_end("body.x")], t_end=1.0, samples=64, sobol=True, step=0.05)
    of_inverse, of_square = np.log(3.0), 1.0 / 0.5 - 1.0 / 1.5  # means of 1/m and 1/m^2
    force_square = 1.0 + 1.0 / 12.0
    deviation = 0.5 * np.sqrt(of_square * force_square - of_inverse**2)
    assert found.statistics["mean"].item() == pytest.approx(0.5 * of_inverse, rel=0.02)
    assert found.statistics["deviation"].item() == pytest.approx(deviation, rel=0.08)
    by_mass = 0.25 * (of_square - of_inverse**2) / deviation**2
    by_force = 0.25 * of_inverse**2 / 12.0 / deviation**2
    assert found.indices["first"].values[0] == pytest.approx([by_mass, by_force], abs=0.1)
    assert found.first_order["amount"].item() == pytest.approx(0.5)
    assert found.first_order["deviation"].item() == pytest.approx(0.5 * np.sqrt(2.0 / 12.0), rel=1e-6)
    assert found.first_order["share"].values[0] == pytest.approx([0.5, 0.5], rel=1e-6)


def cranked(crank: float, rod: float) -> fm.Mechanism:
    return slider_crank(speed=523.5987755982989, data=SliderCrankData(crank=crank, rod=rod))


@pytest.mark.slow
def test_one_number_has_all_of_the_variance_of_one_measure():
    laws = {"force": Uniform(1.0, 2.0)}
    found = fm.design.spread(pushed, laws, of=[at_end("body.x")], t_end=1.0, samples=32, sobol=True, step=0.1)
    assert found.indices["total"].values == pytest.approx(np.ones((1, 1)), abs=0.1)


def test_peak_acceleration_of_cranks_that_scatter():
    """Largest acceleration r w^2 (1 + r/l), r = .05 and l = .12 m within 1 %: deviation 148.797 m/s^2."""
    laws = {"crank": Uniform(0.0495, 0.0505), "rod": Uniform(0.1188, 0.1212)}
    found = fm.design.spread(cranked, laws, of=[peak("slider.ax")], periods=1, samples=0)
    assert found.first_order["amount"].item() == pytest.approx(19419.741, rel=1e-4)
    assert found.first_order["deviation"].item() == pytest.approx(148.797113415, rel=2e-3)
    assert found.first_order["share"].values[0] == pytest.approx([0.950869374, 0.049124077], abs=2e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"parameters": {"mass": (0.5, 1.0)}}, "Normal\\(mean, deviation\\)"),
        ({"of": ["body.x"]}, "measures such as"),
        ({"samples": 48, "sobol": True}, "power of 2"),
        ({"samples": -1}, "at least 0"),
        ({"samples": 1}, "two or more"),
        ({"of": [mean("body.x"), mean("body.x")]}, "each of them once"),
    ],
)
def test_wrong_spreads_are_refused(changes, message):
    given = {"parameters": {"mass": Normal(1.0, 0.1)}, "of": [at_end("body.x")], "t_end": 1.0} | changes
    with pytest.raises(InputError, match=message):
        fm.design.spread(pushed, given.pop("parameters"), **given)


@pytest.mark.parametrize("make", [lambda: Normal(1.0, 0.0), lambda: Uniform(2.0, 1.0), lambda: peak("x", norm=0.5)])
def test_wrong_laws_are_refused(make):
    with pytest.raises(InputError):
        make()


def alone(mass: float = 1.0) -> fm.Mechanism:
    """A model without neighbours beyond the differences of its derivatives."""
    if abs(mass - 1.0) > 1e-4:
        raise ValueError("no such mass")
    return pushed(mass)


def test_derivatives_that_no_neighbour_checks_are_not_known():
    found = fm.design.optimise(alone, {"mass": (0.5, 4.0)}, objective=at_end("body.x"), t_end=1.0, most_designs=5)
    assert np.isnan(found.check).all()
    assert "no neighbour succeeded" in repr(found)


@pytest.mark.parametrize("name", ["status", "objective"])
def test_parameters_with_names_of_columns_are_refused_by_searches(name):
    model = {"status": lambda status=1.0: pushed(status), "objective": lambda objective=1.0: pushed(objective)}[name]
    with pytest.raises(InputError, match=f"'{name}' is the name of a column"):
        fm.design.optimise(model, {name: (0.5, 4.0)}, objective=at_end("body.x"), t_end=1.0)


def test_parameters_with_names_of_columns_are_refused_by_batches():
    with pytest.raises(InputError, match="'machine' is the name of a column"):
        fm.design.spread(pushed, {"machine": Normal(1.0, 0.1)}, of=[at_end("body.x")], t_end=1.0)
