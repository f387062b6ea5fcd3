"""Scripts as users write them are correct for mypy: parts, points and numbers in lists, joints as parts or by name."""

import subprocess
import sys

import pytest

SCRIPT = """
import flexmb as fm

O, A = (0.0, 0.0), (0.3, 0.0)
arm = fm.RigidLink("arm", O, A, mass=1.0, inertia=0.01)
hinge = fm.Revolute("hinge", fm.GROUND, arm, at=O)
motion = fm.drives.Table([0.0, 1.0, 2.0], [0.0, 0.5, 1.0])
parts = [arm, hinge]
frame = fm.FlexibleFrame("frame", [O, A], [(0, 1)], section=fm.Rectangle(0.01, 0.01), material=fm.STEEL)
mech = fm.Mechanism("m", [*parts, fm.Drive("motor", joint=hinge, motion=motion)])
other = fm.Mechanism("m", parts).with_part(fm.Drive("motor", "hinge", fm.ConstantSpeed(1.0)))
stopped = mech.with_part(fm.Stop("end", hinge, above=1.0, normal=fm.KelvinVoigt(1e4, 1.0)))
body = fm.RigidBody("body", O, 1.0, 0.1, outline=[O, A])
sol = fm.simulate(mech, t_end=1.0, signals=["arm.*"])
print(sol["arm.x"], sol.peak("arm.x"), mech[hinge], mech.without_part("motor"))
"""


def types_of(path):
    pytest.importorskip("mypy")
    made = [sys.executable, "-m", "mypy", str(path)]  # with what `make lint` keeps of the package
    return subprocess.run(made, capture_output=True, text=True, check=False).stdout


def test_a_script_is_correct_and_wrong_names_are_not(tmp_path):
    script, wrong = tmp_path / "script.py", 'fm.RigidLink("a", O, A, mas=1.0, inertia=0.1)\narm.nothing\n'
    script.write_text(SCRIPT + wrong, encoding="utf-8")
    first = len(SCRIPT.splitlines()) + 1
    told = [line for line in types_of(script).splitlines() if ": error:" in line]
    assert len(told) == 2, told
    assert f"script.py:{first}:" in told[0]
    assert 'did you mean "mass"' in told[0]
    assert f"script.py:{first + 1}:" in told[1]
    assert '"RigidLink" has no attribute "nothing"' in told[1]
