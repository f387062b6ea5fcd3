"""Parts that do not fit together: the message names part, value and remedy."""

import re

import pytest

import flexmb as fm
from flexmb.errors import AssemblyError, InputError, ModelError

O, A, B = (0.0, 0.0), (0.2, 0.0), (0.5, 0.1)
LAW = fm.LankaraniNikravesh(stiffness=1e9)
CRANK = fm.RigidLink("crank", O, A, mass=0.5, inertia=2e-3)
ARM = fm.RigidLink("arm", A, B, mass=0.4, inertia=3e-3)
PIN = fm.Revolute("O", fm.GROUND, CRANK, at=O)
TURN = fm.ConstantSpeed(6.0)
BEAM = fm.FlexibleLink("beam", O, A, section=fm.Circle(0.01), material=fm.STEEL)


def of(*parts, **keywords):
    return fm.Mechanism("m", parts, **keywords)


def slider_crank(pin, end, *parts):
    """Crank from the origin to `pin`, rod to `end`, slider along X."""
    crank = fm.RigidLink("crank", O, pin, mass=0.5, inertia=2e-3)
    rod = fm.RigidLink("rod", pin, end, mass=0.4, inertia=3e-3)
    slider = fm.RigidBody("slider", end, mass=0.4, inertia=3e-3)
    joints = [
        fm.Revolute("O", fm.GROUND, crank, at=O),
        fm.Revolute("A", crank, rod, at=pin),
        fm.Revolute("B", rod, slider, at=end),
        fm.Prismatic("guide", fm.GROUND, slider),
    ]
    return fm.Mechanism("slider-crank", [crank, rod, slider, *joints, *parts])


REFUSED = [
    (lambda: of(CRANK, CRANK), ModelError, "two parts named 'crank': RigidLink 'crank' and RigidLink 'crank'. Rename"),
    (
        lambda: of(CRANK, fm.Revolute("crank", fm.GROUND, CRANK, at=O)),
        ModelError,
        "Mechanism 'm' has two parts named 'crank': Revolute 'crank' and RigidLink 'crank'. Rename one.",
    ),
    (
        lambda: of(fm.RigidBody("energy", O, 1.0, 1.0)),
        ModelError,
        "RigidBody 'energy' and the signals of the energies. Rename",
    ),
    (
        lambda: of(fm.RigidBody("ground", O, 1.0, 1.0)),
        ModelError,
        "RigidBody 'ground' and the ground, which is there already: fm.GROUND. Rename",
    ),
    (
        lambda: of(CRANK, fm.RigidBody("art", B, 1.0, 1.0), fm.Revolute("A", CRANK, ARM, at=A)),
        ModelError,
        "Revolute 'A' refers to 'arm', which is not in mechanism 'm'. Add it to the parts. Did you mean 'art'?",
    ),
    (lambda: of(CRANK, 3), InputError, "Mechanism 'm': 3 is not a part."),
    (lambda: fm.Mechanism("m", CRANK), InputError, "it must be a list of parts."),
    (lambda: fm.Mechanism("", [CRANK]), InputError, "Mechanism: name is ''; it must be a non-empty string"),
    (lambda: of(CRANK, gravity=9.81), InputError, "Mechanism 'm': gravity is 9.81; it must be a pair (x, y) in m/s^2."),
    # drives
    (
        lambda: of(CRANK, PIN, fm.Drive("motor", "Q", TURN)),
        ModelError,
        "Drive 'motor' drives joint 'Q', but mechanism 'm' has no such part. Joints that can be driven: O.",
    ),
    (lambda: of(CRANK, PIN, fm.Drive("motor", CRANK, TURN)), ModelError, "'motor': RigidLink 'crank' cannot be driven"),
    (lambda: of(CRANK, PIN, fm.Drive("motor", "ground", TURN)), ModelError, "Ground 'ground' cannot be driven."),
    (
        lambda: of(CRANK, ARM, fm.Fixed("A", CRANK, ARM, at=A), fm.Drive("motor", "A", TURN)),
        ModelError,
        "Drive 'motor': Fixed 'A' cannot be driven. Drive the angle of a Revolute or the travel of a Prismatic.",
    ),
    (
        lambda: of(
            CRANK, ARM, fm.RevoluteClearance("A", CRANK, ARM, at=A, clearance=1e-4, bearing_radius=5e-3, normal=LAW),
            fm.Drive("motor", "A", TURN),
        ),
        ModelError,
        "Drive 'motor': RevoluteClearance 'A' cannot be driven. Drive the angle of a Revolute or the travel of a Pris",
    ),
    (
        lambda: of(CRANK, PIN, fm.Drive("motor", "O", TURN), fm.Drive("brake", "O", TURN)),
        ModelError,
        "Drive 'motor' and Drive 'brake' both drive joint 'O'. Keep one of them.",
    ),
    # places
    (
        lambda: fm.compile(of(CRANK, fm.Revolute("O", fm.GROUND, CRANK, at=(0.1, 0.05)))),
        InputError,
        "Revolute 'O': the point (0.1, 0.05) lies 0.05 m off the axis of RigidLink 'crank'. Move the point onto the",
    ),
    (
        lambda: fm.compile(of(BEAM, fm.Revolute("O", fm.GROUND, BEAM, at=(0.03, 0.0)))),
        InputError,
        "Revolute 'O': the point (0.03, 0) is no node of FlexibleLink 'beam'; it lies 0.02 m from the nearest. "
        "Nodes nearby: node1 at (0.05, 0), node0 at (0, 0)",
    ),
    (
        lambda: fm.compile(of(CRANK, PIN, ARM, fm.Revolute("A", PIN, ARM, at=A))),
        ModelError,
        "Revolute 'A': Revolute 'O' is not a body; give a body or GROUND.",
    ),
    (
        lambda: fm.compile(of(CRANK, PIN, fm.TorsionSpring("coil", PIN, CRANK, stiffness=1.0))),
        ModelError,
        "TorsionSpring 'coil': Revolute 'O' is not a body; give a body or GROUND.",
    ),
    (
        lambda: fm.compile(of(CRANK, PIN, fm.Force("load", PIN, O, (1.0, 0.0)))),
        ModelError,
        "Force 'load': Revolute 'O' is not a body; give a body or GROUND.",
    ),
    (lambda: fm.compile(of()), ModelError, "Mechanism 'm' has no bodies; add at least one."),
    (lambda: fm.compile(CRANK), InputError, "is not a Mechanism."),
]  # fmt: skip


@pytest.mark.parametrize(("make", "kind", "message"), REFUSED, ids=[message[:60] for _, _, message in REFUSED])
def test_refused_with_its_name_value_and_remedy(make, kind, message):
    with pytest.raises(kind, match=re.escape(message)):
        make()


# -- loops, redundancy, singular poses -------------------------------------------------------------------------------

PIN_AT, END = (0.1, 0.15), (0.45, 0.0)
PULLED = fm.Drive("pull", "guide", fm.ConstantSpeed(0.1))


def test_loop_that_cannot_close_says_which_joint_and_by_how_much():
    """Fully stretched, the slider stands at |crank| + |rod| = 0.1803 + 0.3808 = 0.5611 m, 0.111 m from its place."""
    mechanism = slider_crank(PIN_AT, END, PULLED)
    assert fm.assemble(mechanism, {"pull": 0.11})["slider.x"] == pytest.approx(0.56, abs=1e-12)
    with pytest.raises(AssemblyError) as caught:
        fm.assemble(mechanism, {"pull": 0.2})
    message = str(caught.value)
    assert message.startswith("Mechanism 'slider-crank' cannot be assembled: joints stay open, ")
    opened = [float(x) for x in re.findall(r"'(?:O|A|B|guide|pull)' by ([0-9.e-]+)", message)]
    assert max(opened) > 1e-3, message
    assert (
        "Check the lengths of the links in that loop, or choose positions of the drives that it can reach." in message
    )


def test_unknown_drive_of_assemble():
    with pytest.raises(InputError, match=r"drive is 'pul'. Did you mean 'pull'\? Known: pull"):
        fm.assemble(slider_crank(PIN_AT, END, PULLED), {"pul": 0.1})


def run(mechanism):
    return fm.simulate(mechanism, t_end=0.01, step=1e-3)


def test_two_welds_in_parallel():
    welds = [fm.Fixed(f"weld{i}", CRANK, ARM, at=A) for i in (1, 2)]
    with pytest.raises(ModelError, match=r"over-constrained by 3 row\(s\).*'weld[12]' repeat.*Remove one"):
        run(of(CRANK, ARM, PIN, *welds))


def test_slider_with_two_guides():
    mechanism = slider_crank(PIN_AT, END)
    second = fm.Prismatic("second guide", fm.GROUND, mechanism.find("slider"))
    with pytest.raises(
        ModelError, match=r"over-constrained by 2 row\(s\).*guide.*replace a Prismatic or Fixed by a Rev"
    ):
        run(mechanism.with_part(second))


def test_slider_driven_at_its_dead_centre():
    with pytest.raises(AssemblyError, match=r"starts in a singular pose.*Start a little beside it"):
        run(slider_crank(A, (0.5, 0.0), PULLED))
    with pytest.raises(AssemblyError, match=r"make a link flexible; redundant='least-norm' is for joints that repeat"):
        fm.simulate(slider_crank(A, (0.5, 0.0), PULLED), t_end=0.1, redundant="least-norm")


def test_parallelogram_drawn_flat():
    points = [O, (0.1, 0.0), (0.4, 0.0), (0.3, 0.0)]
    links = [
        fm.RigidLink(name, points[i], points[i + 1], mass=1.0, inertia=1e-3) for i, name in enumerate(("a", "b", "c"))
    ]
    ends = [(fm.GROUND, links[0]), (links[0], links[1]), (links[1], links[2]), (fm.GROUND, links[2])]
    joints = [fm.Revolute(n, *pair, at=p) for n, pair, p in zip("OABC", ends, points, strict=True)]
    flat = of(*links, *joints, fm.Drive("motor", "O", fm.ConstantSpeed(1.0)))
    with pytest.raises(AssemblyError, match=r"starts in a singular pose"):
        run(flat)


def test_declared_velocity_that_a_joint_forbids():
    crank = fm.RigidLink("crank", O, A, mass=0.5, inertia=2e-3, velocity=(1.0, 0.0, 0.0))
    with pytest.raises(AssemblyError, match=r"no start velocities satisfy.*'O'.*Correct the declared velocities"):
        run(of(crank, fm.Revolute("O", fm.GROUND, crank, at=O)))


def test_free_body_flies():
    """y = vy t - g t^2 / 2 and theta = omega t: (2 - 5) m and 3 rad after 1 s."""
    body = fm.RigidBody("stone", O, mass=1.0, inertia=1.0, velocity=(1.0, 2.0, 3.0))
    free = of(body, gravity=(0.0, -10.0))
    sol = fm.simulate(free, t_end=1.0, step=1e-2)
    assert sol.ok
    assert [float(sol[f"stone.{axis}"][-1]) for axis in ("x", "y", "theta")] == pytest.approx(
        [1.0, -3.0, 3.0], abs=1e-9
    )
    report = fm.check(free)
    assert (report.freedom, report.free) == (3, 3)
