"""Statics of a lattice of point masses and springs: sparse, and no part is looked at once for each body."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.linalg.large import KeptFactors
from flexmb.engine.system import state_evaluation
from flexmb.parts.bodies.rigid import PointMass
from flexmb.parts.loads.force import SpringDamper

PITCH, MASS, STIFFNESS, G = 0.1, 0.01, 1e4, 9.81


def lattice(n, *, held):
    """n x n masses with springs to eight neighbours; the left column hangs on springs along x and y if `held`."""
    masses = {
        (i, j): fm.bodies.PointMass(f"m{i}_{j}", (PITCH * i, PITCH * j), MASS) for i in range(n) for j in range(n)
    }
    springs = [
        SpringDamper(f"s{i}_{j}_{di}_{1 + dj}", body, masses[i + di, j + dj], stiffness=STIFFNESS, at=body.at,
                     to=masses[i + di, j + dj].at)
        for (i, j), body in masses.items() for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1)) if (i + di, j + dj) in masses
    ]  # fmt: skip
    supports = []
    for j in range(n) if held else ():
        x, y = at = masses[0, j].at
        for axis, to in (("x", (x - PITCH, y)), ("y", (x, y + PITCH))):
            supports.append(SpringDamper(f"w{j}_{axis}", fm.GROUND, masses[0, j], stiffness=STIFFNESS, at=to, to=at))
    return fm.Mechanism("lattice", [*masses.values(), *springs, *supports], gravity=(0.0, -G if held else 0.0))


def test_supports_carry_the_weight():
    n = 13
    mech = lattice(n, held=True)
    balance = fm.static_equilibrium(mech)
    lift = 0.0
    for j in range(n):
        for point in ((-PITCH, PITCH * j), (0.0, PITCH * (j + 1))):
            x, y = balance[f"m0_{j}.x"], balance[f"m0_{j}.y"]
            length = np.hypot(x - point[0], y - point[1])
            lift += STIFFNESS * (length - PITCH) * (point[1] - y) / length
    assert lift == pytest.approx(n * n * MASS * G, rel=1e-9)
    assert balance.stable


def test_a_lattice_without_supports_is_refused_by_name():
    with pytest.raises(fm.errors.SolveError, match=r"a motion that moves 'm\d+_\d+\.[xy]' most is resisted by nothing"):
        fm.static_equilibrium(lattice(13, held=False))


def test_parts_are_asked_once_whatever_the_number_of_masses(monkeypatch):
    asked = []
    own = SpringDamper.contributions
    monkeypatch.setattr(SpringDamper, "contributions", lambda part, mech: asked.append(1) or own(part, mech))
    mech = lattice(6, held=True)
    springs = sum(isinstance(part, SpringDamper) for part in mech.parts)
    assert len(asked) <= 2 * springs


def test_a_large_model_is_factored_once(monkeypatch):
    mech = lattice(13, held=True)
    plain = fm.static_equilibrium(mech)
    made, own = [], KeptFactors._make_factors
    monkeypatch.setattr(KeptFactors, "_make_factors", lambda one: made.append(not one._is_own) or own(one))
    monkeypatch.setattr(state_evaluation, "LARGE_UNKNOWNS", 500)
    large = fm.static_equilibrium(mech)
    assert 1 <= sum(made) <= 3
    assert large.q == pytest.approx(plain.q, abs=1e-12)
    assert large.stable is plain.stable is True
    assert abs(large.iterations - plain.iterations) <= 3


def test_loads_are_left_out_without_a_look_at_the_bodies(monkeypatch):
    mech = lattice(6, held=True)
    loaded = mech.with_part(fm.Force("P", mech["m5_5"], at=mech["m5_5"].at, force=(0.0, -1.0)))
    monkeypatch.setattr(PointMass, "validate", lambda *_: pytest.fail("a particle is checked again"))
    fm.modes(loaded, count=2)
    fm.buckling(loaded, count=1)
    fm.static_equilibrium(loaded)
