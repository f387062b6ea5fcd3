"""Mistakes of a person who is new to the library, each with the words that the answer must hold to be of help.

The answer is the text of the error, or what `fm.check` and the notes of a run say, or what the command prints.
"""

import io
import shutil
import subprocess
import sys
from contextlib import chdir, redirect_stderr
from pathlib import Path

import pytest

import flexmb as fm
from flexmb.cli.command_line import main
from flexmb.errors import USER_ERRORS, ArgumentError, AssemblyError
from flexmb.mechanisms import four_bar, slider_crank
from flexmb.results.solution import UnknownSignalError

O, A, B, C, D = (0.0, 0.0), (0.05, 0.0), (0.17, 0.0), (0.3, 0.0), (0.2, 0.0)
LAW, PAD = fm.HuntCrossley(stiffness=1e9), fm.KelvinVoigt(1e5, 10.0, 1e-4)
WIDTH = {"clearance": 1e-4, "bearing_radius": 5e-3}


def crank(**changes):
    return fm.RigidLink("crank", **{"start": O, "end": A, "mass": 0.3, "inertia": 1e-4, **changes})


def rod(**changes):
    return fm.RigidLink("rod", **{"start": A, "end": B, "mass": 0.2, "inertia": 3e-4, **changes})


def slider(**changes):
    return fm.RigidBody("slider", **{"at": B, "mass": 0.14, "inertia": 1e-4, **changes})


def engine(*others, without=(), speed=100.0, gravity=(0.0, 0.0)):
    """A slider-crank, in which other parts take the places of those of their names."""
    parts = [
        crank(), rod(), slider(), fm.Revolute("O", fm.GROUND, crank(), at=O), fm.Revolute("A", crank(), rod(), at=A),
        fm.Revolute("B", rod(), slider(), at=B), fm.Prismatic("guide", fm.GROUND, slider(), along=(1.0, 0.0)),
        fm.Drive("motor", joint="O", motion=fm.ConstantSpeed(speed)),
    ]  # fmt: skip
    replaced = {part.name for part in others} | set(without)
    return fm.Mechanism("engine", [*(part for part in parts if part.name not in replaced), *others], gravity)


def play(**given):
    return fm.RevoluteClearance("B", rod(), slider(), at=B, **given)


def checked(mechanism):
    return str(fm.check(mechanism))


def both(mechanism):
    """What the examination and a run say; both must."""
    examined, sol = fm.check(mechanism), fm.simulate(mechanism, t_end=1e-3)
    notes = " ".join(sol.notes)
    assert any(finding.text in notes for finding in examined.findings), (examined, notes)
    return f"{examined} {notes}"


def command(folder, *arguments):
    said = io.StringIO()
    with chdir(folder), redirect_stderr(said), pytest.raises(SystemExit) as stop:
        sys.exit(main(list(arguments)))
    assert stop.value.code == 2, said.getvalue()
    return said.getvalue()


def installed_command(folder, *arguments):
    flexmb = shutil.which("flexmb", path=str(Path(sys.executable).parent))
    if flexmb is None:
        pytest.skip("the command is not installed")
    said = subprocess.run([flexmb, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert said.returncode == 2, said
    return said.stderr


def model(folder, text):
    (folder / "model.py").write_text(text, encoding="utf-8")
    return command(folder, "run", "model.py")


def saved():
    return fm.simulate(slider_crank(speed=100.0, clearance=1e-4), t_end=1e-3, signals=["slider.*", "B.*"])


def measured(speed):
    return {"x": speed}


HELD = fm.Mechanism("pendulum", [crank(), fm.Revolute("O", fm.GROUND, crank(), at=O)], gravity=(0.0, 9.81))
BIG = [fm.RigidLink("crank", O, (50.0, 0.0), 0.3, 60.0), fm.RigidLink("rod", (50.0, 0.0), (170.0, 0.0), 0.2, 240.0)]

LOCKED = [crank(end=D), rod(start=D, end=C), slider(at=C), fm.Revolute("A", crank(end=D), rod(start=D, end=C), at=D)]
LOCKED += [fm.Revolute("B", rod(start=D, end=C), slider(at=C), at=C)]

MISTAKES = {
    # names and arguments
    "a misspelt argument": (lambda _: crank(mas=1), "RigidLink 'crank'", "'mas'", "mean 'mass'", "inertia, centre"),
    "a misspelt class": (lambda _: fm.RevolutJoint, "RevolutJoint", "Did you mean flexmb.Revolute?"),
    "a misspelt law": (lambda _: fm.contact.HuntCrosley(1e9), "Did you mean flexmb.contact.HuntCrossley?"),
    "a class of a namespace": (lambda _: fm.BrownMcPhee(0.1, 0.1), "It is flexmb.friction.BrownMcPhee."),
    "a misspelt argument of a function": (
        lambda _: fm.simulate(engine(), tend=0.01), "simulate", "'tend'", "mean 't_end'", "periods, save_from",
    ),
    "a misspelt number of a ready mechanism": (lambda _: slider_crank(sped=10.0), "'sped'", "mean 'speed'"),
    "arguments without names": (
        lambda _: fm.RevoluteClearance("B", rod(), slider(), B, 1e-4, 5e-3, LAW),
        "7 arguments were given without names",
        "at most 4 (name, first, second, at)", "clearance=..., bearing_radius=..., normal=...",
    ),
    "a time without its name": (lambda _: fm.simulate(engine(), 0.01), "without names", "(mechanism)", "t_end=..."),
    "a misspelt signal": (lambda _: saved()["B.normal_forse"], "Did you mean 'B.normal_force'?", "B.penetration"),
    "a signal that was not saved": (lambda _: saved()["crank.theta"], "'crank.theta'", "Saved were only", "slider.*"),
    "the peak of an unknown signal": (lambda _: saved().peak("slider.acc"), "'slider.acc'", "slider.ax, slider.ay"),
    "a misspelt option": (
        lambda folder: command(folder, "run", "slider-crank", "--speeed", "9"),
        "--speeed", "mean '--speed'", "--clearance",
    ),
    "a misspelt command": (
        lambda folder: installed_command(folder, "rnu", "slider-crank"), "'rnu'", "Did you mean 'run'?",
    ),
    "a misspelt parameter of a diagram": (
        lambda _: fm.bifurcation(slider_crank, "clearence", [1e-4], skip=1, keep=2), "'clearence'", "mean 'clearance'",
    ),
    "a misspelt parameter of a sweep": (lambda _: fm.sweep(measured, {"sped": [1.0]}), "'sped'", "mean 'speed'"),
    "a misspelt field": (lambda _: engine().with_({"crank.mas": 1.0}), "'crank.mas'", "mean 'mass'"),
    "a clearance in an ideal joint": (lambda _: engine().with_({"B.clearence": 1e-4}), "RevoluteClearance(...)"),
    "an assignment": (lambda _: setattr(crank(), "mass", 3.0), "RigidLink 'crank'", "mech.with_({'crank.mass': 3.0})"),
    # units
    "degrees of a stop": (
        lambda _: both(engine(fm.Stop("end", joint="O", above=60.0, normal=PAD))),
        "Stop 'end': above is 60 rad", "math.radians(60) = 1.047 rad",
    ),
    "degrees of a body": (lambda _: both(engine(slider(theta=90.0))), "RigidBody 'slider'", "math.radians(90)"),
    "degrees of a swing": (
        lambda _: both(engine(fm.Drive("motor", "O", fm.drives.Harmonic(30.0, 2.0)))), "motion.amplitude is 30 rad",
    ),
    "degrees of a target": (
        lambda _: checked(
            engine(fm.Torque("m", crank(), 1.0), fm.PID("s", "O.angle", "m", target=45.0, kp=1.0), without=["motor"])
        ),
        "PID 's': target is 45 rad", "math.radians(45)",
    ),
    "rpm": (lambda _: both(engine(speed=5000.0)), "5000 rad/s, 4.775e+04 rpm", "g.", "5000 rpm are 523.6"),
    "millimetres": (lambda _: checked(fm.Mechanism("m", BIG)), "'rod', is 120 m long", "in mm is divided by 1000"),
    "grams": (lambda _: checked(engine(crank(mass=300.0))), "mass 300 kg", "A slender bar of this mass"),
    "a mass with its unit": (lambda _: crank(mass="300 g"), "RigidLink 'crank': mass is '300 g'", "a number in kg"),
    "GPa": (
        lambda _: checked(
            engine(fm.FlexibleLink("rod", A, B, section=fm.Rectangle(0.01, 0.01), material=fm.Material(207.0, 7850.0)))
        ),
        "Young's modulus 207 Pa", "Steel has 2.1e11 Pa",
    ),
    "N/mm^1.5": (
        lambda _: checked(engine(play(**WIDTH, normal=fm.HuntCrossley(stiffness=1e3)), gravity=(0.0, -9.81))),
        "presses the journal of RevoluteClearance 'B'", "multiply one in N/mm^1.5 by 3.16e4",
    ),
    "gravity upwards": (lambda _: both(HELD), "Gravity points upwards", "gravity=(0, -9.81)"),
    "gravity as a number": (lambda _: fm.Mechanism("m", [crank()], gravity=-9.81), "gravity is -9.81", "a pair (x, y)"),
    # parts and their places
    "no drive": (
        lambda _: both(engine(without=["motor"])), "Nothing sets the mechanism in motion", "Drive(", "crank.theta",
    ),
    "periods without a drive": (
        lambda _: fm.simulate(engine(without=["motor"]), periods=2), "no periodic drive", "t_end= instead of periods=",
    ),
    "no time": (lambda _: fm.simulate(engine()), "t_end= (seconds) or periods="),
    "a joint at a wrong place": (
        lambda _: checked(engine(fm.Revolute("A", crank(), rod(), at=(0.5, 0.0)))),
        "The joint 'A' lies 0.45 m beyond the end of RigidLink 'crank'",
    ),
    "a name twice": (
        lambda _: fm.Mechanism("m", [crank(), fm.Revolute("crank", fm.GROUND, crank(), at=O)]),
        "two parts named 'crank'", "Revolute 'crank' and RigidLink 'crank'", "Rename one",
    ),
    "a body without mass": (
        lambda _: fm.RigidLink("crank", O, A), "mass is missing", "[kg]", "inertia is missing", "[kg m^2]",
    ),
    "a part that is not listed": (
        lambda _: fm.Mechanism("m", [crank(), fm.Revolute("A", crank(), rod(), at=A)]),
        "Revolute 'A' refers to 'rod'", "not in mechanism 'm'", "Add it to the parts",
    ),
    "a body of another mechanism": (
        lambda _: engine(fm.Revolute("A", four_bar()["coupler"], rod(), at=A)), "'coupler'",
        "not in mechanism 'engine'",
    ),
    "a ground of one's own": (
        lambda _: engine(fm.RigidBody("ground", O, 1.0, 1.0)), "RigidBody 'ground'", "there already: fm.GROUND",
    ),
    "the name of a body": (
        lambda _: fm.Revolute("A", "crank", rod(), at=A), "first is 'crank'", "Give the part itself",
    ),
    "the ground forgotten": (
        lambda _: checked(fm.Mechanism("m", [crank(), rod(), fm.Revolute("A", crank(), rod(), at=A)])),
        "'crank', 'rod' are connected to nothing else",
    ),
    "a loop that cannot close": (
        lambda _: checked(engine(*LOCKED)), "The loops close only up to t =", "'motor'", "within their range",
        "Grashof",
    ),
    "parts without a list": (
        lambda _: fm.Mechanism("m", crank()), "Mechanism 'm': parts is", "it must be a list of parts",
    ),
    "a drive of an unknown joint": (
        lambda _: engine(fm.Drive("motor", "0", fm.ConstantSpeed(1.0))), "joint '0'", "can be driven: O, A, B, guide",
    ),
    "a section forgotten": (
        lambda _: fm.FlexibleLink("rod", A, B, material=fm.STEEL), "section is missing", "cross section",
    ),
    # contacts and laws
    "no clearance": (
        lambda _: play(clearance=0.0, bearing_radius=5e-3, normal=LAW), "clearance is 0 m", "use Revolute(...)",
    ),
    "a negative clearance": (lambda _: play(clearance=-1e-4, bearing_radius=5e-3, normal=LAW), "must be > 0"),
    "no radius": (lambda _: play(clearance=1e-4, normal=LAW), "bearing_radius is missing", "radius of the bearing [m]"),
    "no normal law": (lambda _: play(**WIDTH), "normal is missing", "law of the normal force"),
    "laws exchanged": (
        lambda _: play(**WIDTH, normal=fm.ModifiedCoulomb(0.1), friction=LAW), "normal is ModifiedCoulomb",
        "a normal law",
    ),
    "a coefficient as friction": (
        lambda _: play(**WIDTH, normal=LAW, friction=0.1), "friction is 0.1", "ModifiedCoulomb",
    ),
    "a speed as motion": (lambda _: fm.Drive("motor", "O", 100.0), "motion is 100.0", "ConstantSpeed("),
    "a motion as force": (
        lambda _: fm.Force("f", slider(), at=B, force=fm.drives.Ramp(1.0, 0.1)), "force is Ramp", "a pair",
    ),
    "a number for a point": (
        lambda _: fm.RigidLink("crank", 0.0, 0.05, 0.3, 1e-4), "start is 0.0", "a pair (x, y) in m",
    ),
    # runs and files
    "steps too large": (
        lambda _: fm.simulate(engine(gravity=(0.0, -9.81)), t_end=1.0, step=0.05).status, "Not ok", "smaller step",
        "step=Adaptive()",
    ),
    "a file without a mechanism": (lambda folder: model(folder, "x = 3\n"), "no mechanism `mech`", "fm.Mechanism(...)"),
    "a file that is not there": (lambda folder: command(folder, "run", "modle.py"), "no such file", "flexmb list"),
}  # fmt: skip
"""Mistakes: function that makes one in an empty folder, and words of the answer."""


@pytest.mark.parametrize("mistake", MISTAKES)
def test_the_answer_helps(mistake, tmp_path):
    make, *words = MISTAKES[mistake]
    try:
        answer = make(tmp_path)
    except USER_ERRORS as error:
        answer = str(error)
    assert isinstance(answer, str), f"nothing was told: {answer!r}"
    assert all(word in answer for word in words), answer


def test_there_are_enough():
    assert len(MISTAKES) >= 40


def test_what_works_as_a_beginner_writes_it(tmp_path):
    """Lists for pairs, joints for their names, folders that are not there."""
    link = fm.RigidLink("crank", [0.0, 0.0], [0.05, 0.0], mass=0.3, inertia=1e-4)
    assert (link.start, link.end) == (O, A)
    pin = fm.Revolute("O", fm.GROUND, crank(), at=[0.0, 0.0])
    mech = engine(
        fm.Drive("motor", joint=pin, motion=fm.ConstantSpeed(1.0)), fm.Stop("end", pin, above=9.0, normal=PAD)
    )
    assert mech["motor"].joint == mech["end"].joint == "O"
    assert mech[pin] == mech["O"]
    sol = fm.simulate(mech, t_end=1e-3)
    assert sol.ok
    assert sol.to_netcdf(tmp_path / "not" / "there" / "run.nc").is_file()


def test_arguments_that_fit_are_no_mistakes_of_others():
    """An error inside of a function is not taken for a wrong argument."""
    with pytest.raises(TypeError, match="unsupported operand"):
        fm.sweep(measured, {"speed": 3 + None})


def test_wrong_arguments_are_type_errors_too():
    with pytest.raises(TypeError):
        fm.RigidLink("crank", O, A, mass=1.0, inertia=1.0, masse=2.0)
    with pytest.raises(fm.errors.ArgumentError):
        fm.simulate()


def test_names_of_other_packages_are_led_to_their_places():
    """`rtol` belongs to the steps, instants to the solution, `held` to `accuracy`."""
    body = fm.RigidBody("body", (0.0, 0.0), mass=1.0, inertia=1.0)
    mech = fm.Mechanism("free", [body])
    for name, step in (("rtol", "rtol"), ("atol", "atol"), ("max_step", "max")):
        with pytest.raises(
            ArgumentError, match=rf"no argument '{name}'\. It is one of steps: give step=Adaptive\({step}="
        ):
            fm.simulate(mech, t_end=0.1, **{name: 1e-3})
    sol = fm.simulate(mech, t_end=0.1)
    for name in ("time", "t"):
        with pytest.raises(UnknownSignalError, match=rf"no signal '{name}'\. The instants of all rows are sol\.time\."):
            sol[name]
    beam = fm.FlexibleLink("beam", (0, 0), (1, 0), section=fm.Rectangle(0.02, 0.02), material=fm.STEEL, elements=4)
    with pytest.raises(ArgumentError, match=r"frequencies: There is no argument 'held'\. Arguments: count\."):
        fm.Reduced(beam, modes=2).frequencies(held=("start",))


def test_a_velocity_of_a_body_on_a_beam_names_the_beam():
    beam = fm.FlexibleLink("beam", (0, 0), (1, 0), section=fm.Rectangle(0.02, 0.02), material=fm.STEEL, elements=2)
    tip = fm.RigidBody("tip", (1.0, 0.0), mass=1.0, inertia=0.1, velocity=(0.0, 1.0, 1.0))
    parts = [beam, tip, fm.Fixed("O", fm.GROUND, beam, at=(0, 0)), fm.Fixed("weld", beam, tip, at=(1, 0))]
    with pytest.raises(AssemblyError, match=r"Flexible bodies begin as rigid ones: 'beam' without velocity="):
        fm.simulate(fm.Mechanism("thrown", parts), t_end=0.01)
