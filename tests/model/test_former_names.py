"""Former names of arguments, fields and signals: taken for one version, with a warning that says the present one."""

import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError
from flexmb.model.signal import Signals, resolved

O, A = (0.0, 0.0), (0.3, 0.0)
ARM = fm.RigidLink("arm", O, A, 1.0, 0.01)
WHEELS = fm.RigidBody("one", O, 1.0, 0.1), fm.RigidBody("two", A, 1.0, 0.1)
SOFT = fm.KelvinVoigt(1e3, 1.0, 1e-4)


def between(kind, **points):
    return kind("part", fm.GROUND, ARM, **points)


FORMER = {
    "mu of a belt": (
        lambda **k: fm.couplings.Belt("b", *WHEELS, radii=(0.1, 0.1), pretension=9.0, creep=0.1, **k),
        {"mu": 0.3}, {"coefficient": 0.3},
    ),
    "mu of a law": (lambda **k: fm.ModifiedCoulomb(v0=1e-3, v1=1e-2, **k), {"mu": 0.3}, {"coefficient": 0.3}),
    "length of a cable": (
        lambda **k: between(fm.couplings.Cable, at=(1.0, 0.0), to=A, normal=SOFT, **k), {"length": 0.5},
        {"free_length": 0.5},
    ),
    "rest_angle": (
        lambda **k: between(fm.TorsionSpring, stiffness=2.0, **k), {"rest_angle": 0.2}, {"free_angle": 0.2},
    ),
    "angle of a body": (lambda **k: fm.RigidBody("b", O, 1.0, 0.1, **k), {"angle": 0.2}, {"theta": 0.2}),
    "points of a spring": (
        lambda **k: between(fm.SpringDamper, stiffness=2.0, **k), {"start": (1.0, 0.0), "end": A},
        {"at": (1.0, 0.0), "to": A},
    ),
    "points of a rod": (
        lambda **k: between(fm.couplings.Distance, **k), {"start": (1.0, 0.0), "end": A}, {"at": (1.0, 0.0), "to": A},
    ),
    "ends of a link": (
        lambda **k: fm.RigidLink("b", mass=1.0, inertia=0.1, **k), {"at": O, "to": A}, {"start": O, "end": A},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", FORMER)
def test_former_arguments_are_taken_with_a_warning_at_the_line_of_the_caller(case):
    make, former, present = FORMER[case]
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        old = make(**former)
    assert [Path(one.filename).name for one in told] == [Path(__file__).name] * len(former)
    assert all(one.category is DeprecationWarning for one in told)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert old == make(**present)
    for name, now in zip(former, present, strict=True):
        with pytest.warns(DeprecationWarning, match=f"{name} is called {now} now"):
            assert getattr(old, name) == getattr(old, now)
    with pytest.raises(InputError, match="are the same; give"):
        make(**former, **present)


def test_former_fields_in_changes():
    spring = fm.TorsionSpring("coil", fm.GROUND, ARM, stiffness=2.0)
    mech = fm.Mechanism("m", [ARM, fm.Revolute("O", fm.GROUND, ARM, at=O), spring])
    with pytest.warns(DeprecationWarning, match="rest_angle is called free_angle now"):
        assert mech.with_({"coil.rest_angle": 0.3}) == mech.with_({"coil.free_angle": 0.3})
    worn = fm.RevoluteClearance(
        "O", fm.GROUND, ARM, at=O, clearance=1e-3, bearing_radius=0.01, normal=SOFT, friction=fm.ModifiedCoulomb(0.1)
    )
    mech = mech.with_part(worn)
    with pytest.warns(DeprecationWarning, match="mu is called coefficient now"):
        assert mech.with_({"O.friction.mu": 0.3}) == mech.with_({"O.friction.coefficient": 0.3})


def test_an_unknown_attribute_is_none_of_the_former_ones():
    with pytest.raises(AttributeError, match="'RigidLink' object has no attribute 'nothing'"):
        ARM.nothing  # noqa: B018
    assert not hasattr(fm.KelvinVoigt(1.0, 1.0), "mu")


def test_former_signals_and_those_of_older_files():
    new = Signals(("bush.angle", "bush.omega", "tip.theta"), ("rad", "rad/s", "rad"))
    old = Signals(("bush.rotation", "bush.rotation_rate", "tip.angle"), ("rad", "rad/s", "rad"))
    for former, present in zip(old.names, new.names, strict=True):
        with pytest.warns(DeprecationWarning, match=f"{former} is called {present} now"):
            assert resolved(former, new, {}) == present
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert resolved(present, old, {}) == former
            assert resolved(former, old, {}) == former


def test_units_of_results():
    found = fm.chaos.power_spectrum(np.sin(np.arange(64.0)))
    assert found.units == "1/iteration"
    with pytest.warns(DeprecationWarning, match="unit is called units now"):
        assert found.unit == found.units
    assert replace(found, units="Hz").units == "Hz"


def test_a_field_of_a_former_name_in_a_law_of_a_user_is_a_field():
    @fm.friction_law
    def rub(p, h, slip, N, z, z_new):
        return -p[0] * N * np.sign(slip)

    @dataclass(frozen=True)
    class Rubbing(fm.FrictionLaw):
        mu: float
        kernel = rub

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Rubbing(mu=0.3).mu == Rubbing(0.3).parameters()[0] == 0.3
    with pytest.raises(InputError, match="mu is missing"):
        Rubbing()
