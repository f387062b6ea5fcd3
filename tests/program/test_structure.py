"""Structures: what mechanisms share that differ in their numbers only, and that the numbers reach their places."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.compiled.records import Record
from flexmb.errors import KernelError
from flexmb.model.contributions import ElementContribution
from flexmb.program import compiler as smoke
from flexmb.program import structure
from flexmb.program.compiler import chosen_contributions, compile_with_start
from flexmb.program.numbering import Numbering


def with_friction():
    """A pendulum with friction in its ideal pin, a spring, a damped slider and a harmonic force."""
    friction = fm.friction.Stribeck(static=0.2, kinetic=0.1, stribeck_speed=1e-2, v0=1e-3)
    rod = fm.RigidLink("rod", (0.0, 0.0), (0.4, 0.0), mass=0.5, inertia=1e-3)
    block = fm.RigidBody("block", (1.0, 0.0), mass=1.0, inertia=0.1)
    parts = (
        fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0), friction=friction, radius=0.01),
        fm.Prismatic("guide", fm.GROUND, block),
        fm.SpringDamper("spring", rod, block, (0.4, 0.0), (1.0, 0.0), stiffness=200.0, damping=1.0),
        fm.Force("push", block, (1.0, 0.0), (3.0, 0.0), history=fm.drives.Harmonic(1.0, 5.0)),
    )
    return fm.Mechanism("with_friction", (rod, block, *parts), gravity=(0.0, -9.81))


def crank(**options):
    return fm.mechanisms.slider_crank(clearance=2e-4, friction="coulomb", **options)


MECHANISMS = {
    "worn": (crank(), {"B.clearance": 4e-4, "rod.mass": 0.3, "B.friction.v0": 2e-4}),
    "flexible": (crank(flexible=True, elements=3), {"B.clearance": 4e-4, "rod.material.young": 1e11}),
    "ideal": (fm.mechanisms.four_bar(), {"gravity": (0.0, -1.0)}),
    "nine-bar": (fm.mechanisms.nine_bar(2.0 * math.pi), {"gravity": (0.0, -1.0)}),
    "with_friction": (
        with_friction(),
        {"O.friction.static": 0.3, "spring.stiffness": 150.0, "push.history.amplitude": 2.0},
    ),
}


def arrays(value):
    """All arrays in nested tuples and records, and the plain numbers between them."""
    if isinstance(value, Record):
        value = tuple(value.as_dict().values())
    if isinstance(value, tuple):
        return [leaf for item in value for leaf in arrays(item)]
    return [np.asarray(value)]


@pytest.fixture
def forgotten(monkeypatch):
    """No structure is remembered, and none of this test stays."""
    monkeypatch.setattr(structure, "_LATEST", type(structure._LATEST)())
    return structure._LATEST


@pytest.mark.parametrize("name", MECHANISMS)
@pytest.mark.parametrize("start", [False, True], ids=["in motion", "at the start"])
def test_a_remembered_structure_makes_the_same_program_as_a_new_one(name, start, forgotten):
    mechanism, changes = MECHANISMS[name]
    changed = mechanism.with_(changes)
    fm.compile(mechanism, start=start)
    assert len(forgotten) == 1
    again = fm.compile(changed, start=start)
    assert len(forgotten) == 1
    forgotten.clear()
    anew = fm.compile(changed, start=start)
    assert again.symbolic is not anew.symbolic
    for one, other in zip(arrays(again.tables), arrays(anew.tables), strict=True):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(again.reference.z, anew.reference.z)
    np.testing.assert_array_equal(again.reference.q, anew.reference.q)
    assert again.names == anew.names
    assert again.kernels == anew.kernels


@pytest.mark.parametrize("name", MECHANISMS)
def test_numbers_stand_where_the_tables_look_for_them(name):
    mechanism, _ = MECHANISMS[name]
    program, found = fm.compile(mechanism), chosen_contributions(mechanism.contributions(), closed=False, start=False)
    T, p, z = program.tables, program.tables.p, program.reference.z
    laws = [(c.p, c.normal.parameters(), c.friction.parameters()) for c in found.contacts]
    rubbing = [(c, c.joint_friction) for c in found.constraints]
    groups = [
        (T.elements.p, [e.p for e in found.elements]),
        (T.elements.factor_p, [e.factor.parameters() if e.factor else () for e in found.elements]),
        (T.constraints.p, [c.p for c in found.constraints]),
        (T.constraints.joint_friction_p[:, :2], [one.p if one else () for _, one in rubbing]),
        (T.constraints.joint_friction_p[:, 2:], [one.friction.parameters() if one else () for _, one in rubbing]),
        *((T.contacts.p[:, 2 * k : 2 * k + 2], [own[k] for own in laws]) for k in range(3)),
        (T.measured.p, [signal.p for signal in found.signals]),
    ]
    for bounds, wanted in groups:
        assert [p[begin:end].tolist() for begin, end in bounds] == [list(numbers) for numbers in wanted]
    assert [z[a:b].tolist() for a, b in T.contacts.z[:, 1:3]] == [list(c.normal.history()) for c in found.contacts]
    assert [z[a:b].tolist() for a, b in T.elements.z] == [list(e.history) for e in found.elements]


def test_other_numbers_share_the_arrays_and_other_kernels_do_not(forgotten):
    mechanism = crank()
    first = fm.compile(mechanism)
    second = fm.compile(mechanism.with_({"B.clearance": 3e-4}))
    assert second.symbolic is first.symbolic
    assert second.tables.constraints is first.tables.constraints
    assert second.tables.p is not first.tables.p
    law = fm.compile(mechanism.with_({"B.friction": fm.friction.SmoothCoulomb(0.1, v0=1e-3)}))
    assert law.kernels != first.kernels
    elsewhere = fm.compile(mechanism.with_part(replace(mechanism.find("A"), first=mechanism.find("slider"))))
    assert elsewhere.tables.constraints.dofs.tolist() != first.tables.constraints.dofs.tolist()
    named = fm.compile(
        fm.Mechanism("m", tuple(replace(p, name="pin") if p.name == "A" else p for p in mechanism.parts))
    )
    assert "pin.fx" in [signal.name for signal in named.names.signals]


def test_what_is_shared_cannot_be_written_to(forgotten):
    fm.compile(crank())
    again = fm.compile(crank())
    assert not [a for a in arrays(again.tables) if a.ndim and a.flags.writeable]
    assert not again.symbolic.places.flags.writeable


def test_only_the_latest_structures_are_kept(forgotten):
    for k in range(structure.REMEMBERED_STRUCTURES + 3):
        fm.compile(fm.Mechanism(f"m{k}", (fm.RigidBody(f"b{k}", (0.0, 0.0), mass=1.0, inertia=1.0),)))
    assert len(forgotten) == structure.REMEMBERED_STRUCTURES
    assert not any("b0" in str(key) for key in forgotten)


def test_large_structures_push_others_out(forgotten, monkeypatch):
    monkeypatch.setattr(structure, "REMEMBERED_UNKNOWNS", 7)
    for k in range(3):  # two of three unknowns fit, a third does not
        fm.compile(fm.Mechanism("m", (fm.RigidBody(f"b{k}", (0.0, 0.0), mass=1.0, inertia=1.0),)))
    assert [key[0] for key in forgotten] == [(("b1", ""),), (("b2", ""),)]
    fm.compile(fm.mechanisms.four_bar())
    assert len(forgotten) == 1  # the latest one always stays


def test_both_programs_from_one_reading():
    mechanism = crank()
    program, closed = compile_with_start(mechanism)
    for found, wanted in ((program, fm.compile(mechanism)), (closed, fm.compile(mechanism, start=True))):
        assert found.names == wanted.names
        for one, other in zip(arrays(found.tables), arrays(wanted.tables), strict=True):
            np.testing.assert_array_equal(one, other)
    assert closed.n_c == program.n_c + 2  # the pin takes two freedoms
    same, start = compile_with_start(fm.mechanisms.four_bar())
    assert start is same


CALLS = []


@fm.element_kernel
def counted_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """A mass on a spring along x that counts how often it is called in Python."""
    CALLS.append(p[0])
    m, k = p
    r[0] = k * q[0] + m * a[0]
    K[0, 0] = k
    M[0, 0] = m / (1.0 - m)  # not finite for m = 1


@dataclass(frozen=True)
class Counted(fm.Element):
    """Mass [kg] and stiffness [N/m] along x."""

    body: fm.RigidBody
    m: float
    k: float
    kernel = counted_kernel
    coords = ("body.x",)

    def contributions(self, mechanism):
        """Like that of every element, its coordinates in a list: nothing that could be compared quickly."""
        (contribution,) = super().contributions(mechanism)
        return [
            ElementContribution(contribution.part, contribution.kernel, list(contribution.coordinates), contribution.p)
        ]


def counted(m, x=0.0):
    body = fm.RigidBody("body", (x, 0.0), mass=1.0, inertia=1.0)
    return fm.Mechanism("counted", (body, Counted("element", body, m, 2.0)))


def test_a_kernel_is_tried_once_for_the_same_numbers_and_pose(monkeypatch):
    monkeypatch.setattr(smoke, "_GOOD", {})
    contributions = [
        (counted(m, x).contributions(), Numbering(counted(m, x))) for m, x in ((0.5, 0.0), (0.25, 0.0), (0.5, 1.0))
    ]
    CALLS.clear()
    for _ in range(2):
        for both in contributions:
            smoke.call_each_kernel(*both)
    assert CALLS == [0.5, 0.25, 0.5]


def test_a_bad_call_is_refused_every_time(monkeypatch):
    monkeypatch.setattr(smoke, "_GOOD", {})
    mechanism = counted(1.0)
    for _ in range(2):
        with pytest.raises(KernelError, match=r"reference configuration|not finite"), np.errstate(all="ignore"):
            smoke.call_each_kernel(mechanism.contributions(), Numbering(mechanism))


def test_pieces_that_cannot_be_compared_are_packed_anew(forgotten):
    mechanism = counted(0.5)
    contributions, number = mechanism.contributions(), Numbering(mechanism)
    first, second = (structure.structure_of(contributions, number, structure.numbers(contributions)) for _ in range(2))
    assert not forgotten
    assert first.tables.elements.dofs.tolist() == second.tables.elements.dofs.tolist()


def made(constant):
    """A kernel of one name whose code differs in a constant alone, as from a cell that was run again."""
    space = {}
    exec(f"def force(p, h, slip, N, z, z_new):\n    return -{constant} * N * slip, -{constant} * N, -slip\n", space)
    return fm.friction_law(space["force"])


def test_kernels_that_differ_in_a_constant_are_two(forgotten):
    assert made(0.5) == made(0.5)
    assert made(0.5) != made(0.25)
    assert hash(made(0.5)) == hash(made(0.5))


def test_numbers_of_tables_stand_in_p_alone():
    """Mechanisms with other floats share a structure, so nothing else in it may depend on one."""

    def floats(record, path=""):
        for name, value in record.as_dict().items():
            if isinstance(value, Record):
                yield from floats(value, f"{path}{name}.")
            elif isinstance(value, float) or (isinstance(value, np.ndarray) and value.dtype.kind == "f"):
                yield path + name

    mechanism = fm.mechanisms.nine_bar(2.0 * np.pi, clearance=1e-4, flexible=True, friction="coulomb")
    assert list(floats(fm.compile(mechanism).tables)) == ["p"]
