"""`flexmb new` and `flexmb check`: a model file to begin with, and its examination."""

import argparse
import re
import shlex
from keyword import iskeyword
from pathlib import Path

from flexmb.dynamics.jobs.files import write_text
from flexmb.errors import InputError
from flexmb.findings.check import check as examined
from flexmb.model.mechanism import Mechanism
from flexmb.units import quantity

SOUND, WRONG = 0, 1  # exit statuses: no error among the findings, at least one error


def check(mechanism: Mechanism, name: str, options: argparse.Namespace) -> int:
    """`flexmb check`: print degrees of freedom, mass, natural frequencies and all findings.

    Returns 0 without errors among the findings, else 1.  `name` is for files, of which there are none.
    """
    report = examined(mechanism, None if options.step is None else quantity(options.step, "s", "--step"))
    print(report.to_json() if options.json else report)
    return SOUND if report.ok else WRONG


# Text of a model file.
MODEL = '''"""@NAME@: a slider-crank.

Check it:     flexmb check @FILE@
Run it:       flexmb run @FILE@ --speed 300rpm --periods 2
Vary it:      flexmb sweep @FILE@ --speed 10:40:4 --skip 2 --keep 5
Results:      out/@NAME@/@NAME@.nc, pictures, and VTK files for ParaView
In Python:    from @NAME@ import mechanism; sol = fm.simulate(mechanism(), periods=2); print(sol)

All numbers are in SI units. `flexmb run @FILE@ --help` shows the parameters of the function below as options.
"""

import math
from typing import Annotated

import flexmb as fm


def mechanism(speed: Annotated[float, "rad/s"] = 10 * math.pi, *, mass: Annotated[float, "kg"] = 0.5) -> fm.Mechanism:
    """Slider-crank with a constant speed of the crank.

    Parameters
    ----------
    speed : speed of the crank.
    mass : mass of the slider.
    """
    # Joints in the position of the start [m]. Bodies are drawn here, and all joints close in this position.
    O, A, B = (0.0, 0.0), (0.05, 0.0), (0.2, 0.0)

    crank = fm.RigidLink("crank", O, A, mass=0.2, inertia=5e-5)  # inertia about the centre of mass [kg m^2]
    rod = fm.RigidLink("rod", A, B, mass=0.3, inertia=6e-4)
    # A flexible rod: take this one instead. Its mass follows from section and material.
    # rod = fm.FlexibleLink("rod", A, B, section=fm.Rectangle(width=0.01, height=0.015), material=fm.STEEL, elements=4)
    slider = fm.RigidBody("slider", at=B, mass=mass, inertia=1e-4)

    piston_pin = fm.Revolute("B", rod, slider, at=B)
    # A worn pin: take this one instead. The clearance is the difference of the radii [m].
    # contact = fm.LankaraniNikravesh.from_materials(fm.STEEL, fm.STEEL, restitution=0.9)
    # piston_pin = fm.RevoluteClearance("B", rod, slider, at=B, clearance=1e-4, bearing_radius=0.01, normal=contact)

    parts = [
        crank,
        rod,
        slider,
        fm.Revolute("O", fm.GROUND, crank, at=O),
        fm.Revolute("A", crank, rod, at=A),
        piston_pin,
        fm.Prismatic("guide", fm.GROUND, slider, along=(1.0, 0.0)),
        fm.Drive("motor", joint="O", motion=fm.ConstantSpeed(speed)),
        # A spring that pushes the slider back: add it to the list.
        # fm.SpringDamper("spring", fm.GROUND, slider, (0.4, 0.0), B, stiffness=500.0, damping=2.0, free_length=0.25),
        # A load on the slider [N]:
        # fm.Force("load", slider, B, (-100.0, 0.0)),
    ]
    return fm.Mechanism("@NAME@", parts, gravity=(0.0, -9.81))


if __name__ == "__main__":  # python @FILE@
    mech = mechanism()
    print(fm.check(mech))
    sol = fm.simulate(mech, periods=2)
    print(sol)
    fm.plot(sol, ["slider.x", "slider.ax", "motor.torque"]).savefig("@NAME@.png")
'''


def new(options: argparse.Namespace) -> int:
    """`flexmb new`: write a model file, of a name that is free and fits a module, and print the next commands."""
    path = Path(options.file)
    path = path if path.suffix == ".py" else path.with_name(f"{path.name}.py")
    if not path.stem.isidentifier() or iskeyword(path.stem):
        plain = re.sub(r"\W", "_", path.stem) or "model"
        plain = plain if plain.isidentifier() and not iskeyword(plain) else f"m{plain}"
        text = f"{path.stem!r} is no name of a Python file, such as {plain!r}"
        raise InputError(f"{text}. Take letters, digits and underscores, with a letter first.")
    if path.exists() and not options.force:
        raise InputError(f"{str(path)!r} is there already. Take another name, or replace it with --force.")
    write_text(path, MODEL.replace("@NAME@", path.stem).replace("@FILE@", path.name))
    print(f"{path} is a slider-crank with comments on clearances, flexible links, springs and loads. Next:")
    typed = shlex.quote(str(path))
    print(f"  flexmb check {typed}\n  flexmb run {typed} --speed 300rpm")
    return 0
