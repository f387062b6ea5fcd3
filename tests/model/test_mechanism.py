"""Declarations: changes by name, replaced parts, names that are nearly right."""

import pickle

import pytest

import flexmb as fm
from flexmb.errors import InputError, ModelError

O, A, B = (0.0, 0.0), (0.2, 0.0), (0.5, 0.1)
CRANK = fm.RigidLink("crank", O, A, mass=0.5, inertia=2e-3)
ARM = fm.RigidLink("arm", A, B, mass=0.4, inertia=3e-3)
PIN = fm.Revolute("O", fm.GROUND, CRANK, at=O)
PLAY = fm.RevoluteClearance(
    "A", CRANK, ARM, at=A, clearance=1e-4, bearing_radius=5e-3, normal=fm.LankaraniNikravesh(stiffness=1e9)
)
MOTOR = fm.Drive("motor", "O", fm.ConstantSpeed(6.0))


@pytest.fixture
def mechanism():
    return fm.Mechanism("pair", [CRANK, ARM, PIN, PLAY, MOTOR], gravity=(0.0, -9.81))


def test_with_changes_fields_by_name(mechanism):
    changed = mechanism.with_(
        {
            "A.clearance": 2e-4,
            "A.normal.restitution": 0.8,
            "motor.motion.speed": 7.0,
            "gravity": (0.0, 0.0),
            "name": "new",
        }
    )
    assert changed.find("A").clearance == 2e-4
    assert changed.find("A").normal.restitution == 0.8
    assert changed.find("motor").motion.speed == 7.0
    assert (changed.gravity, changed.name) == ((0.0, 0.0), "new")


def test_with_leaves_the_original_and_the_other_parts(mechanism):
    changed = mechanism.with_({"A.clearance": 2e-4})
    assert mechanism.find("A").clearance == 1e-4
    assert [p for p in mechanism.parts if p is not PLAY] == [p for p in changed.parts if p.name != "A"]
    assert changed.names == mechanism.names
    assert mechanism.with_({}) == mechanism


def test_with_reaches_the_program(mechanism):
    """The gap in the drawn pose is the clearance."""
    assert fm.compile(mechanism.with_({"A.clearance": 3e-4})).least_clearance == 3e-4


@pytest.mark.parametrize(
    ("changes", "kind", "message"),
    [
        ({"cranck.mass": 1.0}, ModelError, "has no part 'cranck'. Did you mean 'crank'"),
        ({"crank.mas": 1.0}, InputError, "field is 'mas'. Did you mean 'mass'"),
        ({"motor.motion.sped": 1.0}, InputError, "'motor.motion.sped': field is 'sped'. Did you mean 'speed'"),
        ({"crank.mass.unit": 1.0}, InputError, "'mass' has no fields of its own"),
        ({"crank.name": "x"}, InputError, "field is 'name'"),
        ({"gravty": (0.0, 0.0)}, InputError, "field is 'gravty'. Did you mean 'gravity'"),
        ({"crank.mass": -1.0}, InputError, "RigidLink 'crank': mass is -1 kg; it must be > 0"),
        ({"A.normal.restitution": 2.0}, InputError, "restitution is 2; it must lie between 0 and 1"),
        ({"ground.name": "x"}, ModelError, "'ground.name' cannot be changed; the ground has no values"),
        (3, InputError, "changes are 3; they must be a dictionary such as {'crank.mass': 0.5}"),
    ],
)
def test_with_refuses(mechanism, changes, kind, message):
    with pytest.raises(kind, match=message.replace("(", r"\(")):
        mechanism.with_(changes)


def test_with_does_not_leave_joints_behind(mechanism):
    """A link made longer takes its joint along, or is refused: the joint would lie within the link."""
    with pytest.raises(ModelError, match=r"moves its point \(0.2, 0\), but 'A' would stay there.*'A.at'"):
        mechanism.with_({"crank.end": (0.3, 0.0)})
    with pytest.raises(ModelError, match="'A' would stay there"):
        mechanism.with_({"crank.end": (0.3, 0.0), "arm.start": (0.3, 0.0)})
    longer = mechanism.with_({"crank.end": (0.3, 0.0), "arm.start": (0.3, 0.0), "A.at": (0.3, 0.0)})
    assert longer.find("A").at == longer.find("crank").end
    assert mechanism.with_({"arm.end": (0.6, 0.2)}).find("arm").end == (0.6, 0.2)  # nothing lies there


def test_all_errors_of_a_mechanism_are_told_at_once():
    lost = fm.Revolute("B", ARM, fm.RigidBody("slider", B, 1.0, 0.1), at=B)
    with pytest.raises(ModelError) as caught:
        fm.Mechanism("wrong", [CRANK, ARM, PIN, PIN, lost])
    for text in ("has 2 errors", "1. Mechanism 'wrong' has two parts named 'O'", "2. Revolute 'B' refers to 'slider'"):
        assert text in str(caught.value)
    drives = [fm.Drive("one", "none", fm.ConstantSpeed(1.0)), fm.Drive("two", "A", fm.ConstantSpeed(1.0))]
    with pytest.raises(ModelError, match=r"(?s)has 2 errors.*'one'.*no such part.*'two'.*cannot be driven"):
        fm.Mechanism("wrong", [CRANK, ARM, PIN, PLAY, *drives])


def test_a_part_of_the_same_name_takes_the_place_of_the_old_one(mechanism):
    """A joint is switched from clearance to ideal in one line; the others keep their places."""
    ideal = mechanism.with_part(fm.Revolute("A", CRANK, ARM, at=A))
    assert isinstance(ideal.find("A"), fm.Revolute)
    assert ideal.names == mechanism.names
    assert fm.compile(ideal).least_clearance is None
    assert ideal.with_part(PLAY) == mechanism


def test_a_rigid_link_becomes_flexible_under_its_joints(mechanism):
    """Joints hold a body by its name: they find the new one."""
    flexible = mechanism.with_part(fm.FlexibleLink("arm", A, B, section=fm.Circle(0.01), material=fm.STEEL, elements=3))
    assert flexible.find("A").second is ARM
    assert [node.name for part, node in flexible.nodes() if part == "arm"] == ["node0", "node1", "node2", "node3"]
    assert fm.compile(flexible).n_q == 3 * (1 + 4)


def test_a_new_part_is_added_at_the_end(mechanism):
    spring = fm.TorsionSpring("coil", CRANK, ARM, stiffness=1.0)
    assert mechanism.with_part(spring).names == (*mechanism.names, "coil")
    assert mechanism.with_part(spring).without_part("coil") == mechanism


def test_a_part_that_others_need_cannot_be_taken_out(mechanism):
    with pytest.raises(ModelError, match=r"refers to 'arm', which is not in mechanism 'pair'"):
        mechanism.without_part("arm")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("cranck", "Mechanism 'pair' has no part 'cranck'. Did you mean 'crank'? Known: crank, arm, O, A, motor."),
        ("zzz", "Mechanism 'pair' has no part 'zzz'. Known: crank, arm, O, A, motor."),
    ],
)
def test_find_helps(mechanism, name, message):
    with pytest.raises(ModelError) as caught:
        mechanism.find(name)
    assert str(caught.value) == message


def test_find(mechanism):
    assert mechanism.find("arm") is ARM
    assert mechanism.find("ground") is fm.GROUND
    assert mechanism.bodies == (CRANK, ARM)
    assert mechanism.body("crank") is CRANK
    with pytest.raises(ModelError, match=r"Revolute 'O' is not a body; give a body or GROUND"):
        mechanism.body("O")


def test_nodes_of_a_beam_by_name():
    beam = fm.FlexibleLink("beam", O, (0.3, 0.4), section=fm.Circle(0.01), material=fm.STEEL, elements=2)
    assert (beam.node("end").x, beam.node("end").y) == (0.3, 0.4)
    assert beam.node("start") == beam.node("node0")
    with pytest.raises(InputError, match=r"FlexibleLink 'beam' has no node 'nod1'. Did you mean 'node1'\?"):
        beam.node("nod1")


def test_mechanisms_are_values(mechanism):
    same = fm.Mechanism("pair", (CRANK, ARM, PIN, PLAY, MOTOR), gravity=(0.0, -9.81))
    assert same == mechanism
    assert pickle.loads(pickle.dumps(mechanism)) == mechanism  # noqa: S301 - written on this line
    with pytest.raises(AttributeError):
        mechanism.name = "other"
