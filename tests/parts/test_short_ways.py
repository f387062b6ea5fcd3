"""Force, tangent and account kernels say what element and energy kernel say: in `check_part`, and in the loop."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.system.evaluate import evaluate, evaluate_accepted
from flexmb.engine.system.work import workspace
from flexmb.errors import KernelError
from flexmb.model.contributions import ElementContribution
from flexmb.testing import check_part

O, A, B, C = (0.0, 0.0), (0.1, 0.17), (0.5, 0.1), (0.7, -0.1)
BAR = fm.Rectangle(width=0.01, height=0.02)


def crank():
    return fm.RigidLink("crank", O, A, mass=0.4, inertia=2e-3, centre=0.4)


def arm():
    return fm.RigidLink("arm", A, B, mass=0.8, inertia=8e-3)


@fm.element_kernel
def coil_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = p[0] * (q[0] - q[1])
    r[1] = -r[0]
    K[0, 0] = K[1, 1] = p[0]
    K[0, 1] = K[1, 0] = -p[0]
    z_new[0] = q[0]


@fm.kernels.energy_kernel
def coil_energy(p, t, q, v):
    return 0.5 * p[0] * (q[0] - q[1]) ** 2, 0.0, 0.0


@fm.kernels.force_kernel
def coil_force(p, t, h, q, v, a, z, r, z_new):
    r[0] = p[0] * (q[0] - q[1])
    r[1] = -r[0]
    z_new[0] = q[0]


@fm.kernels.tangent_kernel
def coil_tangent(p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new):
    r[0] = p[0] * (q[0] - q[1])
    r[1] = -r[0]
    A[0, 0] = A[1, 1] = kq * p[0]
    A[0, 1] = A[1, 0] = -kq * p[0]
    z_new[0] = q[0]


@fm.kernels.force_kernel
def weaker(p, t, h, q, v, a, z, r, z_new):
    r[0] = 0.999 * p[0] * (q[0] - q[1])
    r[1] = -r[0]
    z_new[0] = q[0]


@fm.kernels.force_kernel
def forgetful(p, t, h, q, v, a, z, r, z_new):
    r[0] = p[0] * (q[0] - q[1])
    r[1] = -r[0]


@fm.kernels.tangent_kernel
def unweighted(p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new):
    r[0] = p[0] * (q[0] - q[1])
    r[1] = -r[0]
    A[0, 0] = A[1, 1] = p[0]
    A[0, 1] = A[1, 0] = -p[0]
    z_new[0] = q[0]


@fm.kernels.account_kernel
def with_mass(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    r[0] = p[0] * (q[0] - q[1])
    r[1] = -r[0]
    My[0] = y[0]
    z_new[0] = q[0]
    return 0.5 * p[0] * (q[0] - q[1]) ** 2, 0.0, 0.0


@fm.kernels.account_kernel
def half_energy(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    r[0] = p[0] * (q[0] - q[1])
    r[1] = -r[0]
    z_new[0] = q[0]
    return 0.25 * p[0] * (q[0] - q[1]) ** 2, 0.0, 0.0


@fm.kernels.damping_kernel
def lossy(p, t, q, v, w):
    return 0.0, p[0] * v[0] * w[0]


@dataclass(frozen=True)
class Coil(fm.Element):
    """A torsion spring of a user, with both short ways that a class may name."""

    first: fm.Part
    second: fm.Part
    k: float
    kernel = coil_kernel
    force_kernel = coil_force
    tangent_kernel = coil_tangent
    coords = ("first.theta", "second.theta")

    def history(self):
        return (0.0,)


@dataclass(frozen=True)
class Altered(Coil):
    """The same with one kernel of its piece replaced."""

    which: str = ""

    def contributions(self, mechanism):
        change = {
            "weaker": {"force": weaker},
            "forgetful": {"force": forgetful},
            "unweighted": {"tangent": unweighted},
            "with_mass": {"energy": coil_energy, "account": with_mass},
            "half_energy": {"energy": coil_energy, "account": half_energy},
            "lossy": {"energy": coil_energy, "damping": lossy},
        }[self.which]
        return [replace(contribution, **change) for contribution in super().contributions(mechanism)]


def two_links(*parts):
    pin = fm.Revolute("O", fm.GROUND, crank(), at=O)
    return fm.Mechanism("two links", [crank(), arm(), pin, *parts], gravity=(1.3, -9.81))


def test_a_users_short_ways_pass_and_are_named_in_the_report():
    names = [check.name for check in check_part(two_links(Coil("s", crank(), arm(), 20.0)), "s").checks]
    assert "coil_force: as coil_kernel" in names
    assert "coil_tangent: as coil_kernel" in names


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    ("which", "place"),
    [
        ("weaker", r"r\[0\]"),
        ("forgetful", "z_new"),
        ("unweighted", r"A\[0, 0\]"),
        ("with_mass", r"My\[0\]"),
        ("half_energy", "strain"),
        ("lossy", "mixed_power"),
    ],
)
def test_a_short_way_that_says_something_else_is_found(which, place):
    mechanism = two_links(Altered("s", crank(), arm(), 20.0, which))
    with pytest.raises(KernelError, match=f"(?s)^Part 's'.*{which}.*{place} is .*'coil_kernel' gives .*say the same"):
        check_part(mechanism, "s")


def test_a_kernel_of_the_wrong_contract_is_refused_when_the_class_is_made():
    with pytest.raises(KernelError, match=r"Wrong\.force_kernel is .*must be a function decorated as a force kernel"):
        type("Wrong", (Coil,), {"force_kernel": coil_kernel})


@pytest.mark.parametrize(("given", "kind"), [({"account": with_mass}, "an account"), ({"damping": lossy}, "a damping")])
def test_an_account_and_a_damping_without_energies_are_refused(given, kind):
    with pytest.raises(KernelError, match=rf"has {kind} kernel and no energy kernel.*Give it the energy kernel"):
        ElementContribution("s", coil_kernel, (("arm", "", 2), ("crank", "", 2)), (1.0,), (0.0,), **given)


def zoo():
    """Every kind of element of the library, with beams under gravity, both dampings and a load that varies."""
    options = {"section": BAR, "material": fm.STEEL, "elements": 2, "damping": 1e-4}
    link = fm.FlexibleLink("link", B, C, mass_damping=3.0, **options)
    corners = ((0.9, 0.0), (1.2, 0.0), (1.0, 0.3))
    frame = fm.FlexibleFrame("frame", corners, ((0, 1), (1, 2), (2, 0)), mass=2.5, inertia=0.04, **options)
    rubber = {"stiffness": (1e4, 3e4), "damping": (3.0, 1.0), "torsion": 5.0, "torsion_damping": 0.1}
    parts = (
        fm.Revolute("O", fm.GROUND, crank(), at=O),
        fm.Revolute("B", arm(), link, at=B),
        fm.Bushing("A", crank(), arm(), A, along=(1.0, 0.3), **rubber),
        fm.SpringDamper("spring", link, frame, C, (0.9, 0.0), stiffness=3e3, damping=7.0, free_length=0.1),
        fm.TorsionSpring("twist", crank(), frame, stiffness=11.0, damping=0.3),
        fm.Force("pull", link, C, (3.0, -8.0), history=fm.drives.Harmonic(0.3, 5.0)),
        Coil("coil", crank(), arm(), 20.0),
    )
    return fm.Mechanism("zoo", [crank(), arm(), link, frame, *parts], gravity=(1.3, -9.81))


def results(program, seed):
    """Matrix, forces with it and without it, histories, what is accepted, at a random state."""
    n, rng, work = program.n_q, np.random.default_rng(seed), workspace(program)
    q = np.append(program.reference.q + 0.03 * rng.uniform(-1.0, 1.0, n), np.zeros(3))
    v, a, x, y = np.append(rng.uniform(-1.0, 1.0, (4, n)) * [[3.0], [50.0], [1.0], [1.0]], np.zeros((4, 3)), axis=1)
    lam, z = rng.uniform(-1.0, 1.0, program.n_c), program.reference.z.copy()
    common = (program.tables, program.addresses, 0.11, 1e-3, q, v, a, lam, z)
    evaluate(*common, 1.0, 40.0, 900.0, True, work)
    found = {"matrix": work.lu[:-1].copy(), "r": work.r.copy(), "z": work.z_new.copy()}
    work.lu[:] = 7.0
    evaluate(*common, 1.0, 40.0, 900.0, False, work)
    found |= {"left": work.lu.copy(), "bare r": work.r.copy(), "bare z": work.z_new.copy()}
    evaluate_accepted(*common, x, y, work)
    return found | {"accepted r": work.r.copy(), "accepted z": work.z_new.copy(), "power": work.power.numbers()}


def test_the_loop_finds_the_same_by_short_and_by_long_ways(monkeypatch):
    quick = fm.compile(zoo())
    own = fm.Mechanism.contributions

    def long_ways(mechanism):
        contributions = own(mechanism)
        slow = tuple(replace(e, force=None, tangent=None, account=None) for e in contributions.elements)
        return replace(contributions, elements=slow)

    monkeypatch.setattr(fm.Mechanism, "contributions", long_ways)
    slow = fm.compile(zoo())
    assert max(quick.tables.elements.account) >= 0
    assert max(slow.tables.elements.account) == max(slow.tables.elements.force) == -1
    for seed in range(5):
        by_short, by_long = results(quick, seed), results(slow, seed)
        for found in (by_short, by_long):
            size = np.abs(found["r"]).max()
            for name in ("bare r", "accepted r"):
                np.testing.assert_allclose(found[name], found["r"], atol=1e-12 * size, rtol=0.0)
            for name in ("bare z", "accepted z"):
                np.testing.assert_array_equal(found[name], found["z"])
            assert np.all(found["left"] == 7.0)
        for name, value in by_long.items():
            scale = np.abs(value) if name == "power" else np.abs(value).max()
            assert np.all(np.abs(by_short[name] - value) <= 1e-12 * scale), name
