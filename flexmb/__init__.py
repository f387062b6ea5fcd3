"""Planar flexible multibody dynamics with imperfect joints.

Declare a `Mechanism` of parts, `simulate` it, ask questions of the motion.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "beams.section": "Circle GeneralSection Rectangle Section Tapered Tube",
    "bodies.flexible_frame": "FlexibleFrame",
    "bodies.flexible_link": "FlexibleLink",
    "bodies.rigid_body": "RigidBody",
    "bodies.rigid_link": "RigidLink",
    "contact.friction.frictionless": "Frictionless",
    "contact.friction.modified_coulomb": "ModifiedCoulomb",
    "contact.normal.lankarani_nikravesh": "LankaraniNikravesh",
    "drives.constant_speed": "ConstantSpeed",
    "drives.cycloidal_ramp": "CycloidalRamp",
    "drives.drive": "Drive",
    "drives.harmonic": "Harmonic",
    "drives.piecewise_linear": "PiecewiseLinear",
    "drives.polynomial": "Polynomial",
    "drives.pulse": "Pulse",
    "drives.ramp": "Ramp",
    "drives.table": "Table",
    "errors": (
        "FlexmbError InputError ModelError KernelError AssemblyError SolveError FileFormatError MissingPackageError"
    ),
    "integrate.episodes": "Episode Episodes",
    "integrate.method": "Newmark RungeKutta4",
    "integrate.momentum": "Momentum momentum",
    "integrate.netcdf": "load",
    "integrate.simulate": "simulate",
    "integrate.solution": "Solution",
    "integrate.steps": "Adaptive FixedStep",
    "io.vtk": "write_vtk",
    "joints.bushing": "Bushing",
    "joints.clamp": "Clamp",
    "joints.pin_slot": "PinSlot PinSlotClearance",
    "joints.prismatic": "Prismatic",
    "joints.prismatic_clearance": "PrismaticClearance",
    "joints.revolute": "Fixed Revolute",
    "joints.revolute_clearance": "RevoluteClearance",
    "kernels": (
        "constraint_kernel drive_kernel element_kernel energy_kernel friction_law gap_kernel normal_law signal_kernel"
    ),
    "loads.force": "Force",
    "loads.spring_damper": "SpringDamper",
    "loads.torque": "Torque",
    "loads.torsion_spring": "TorsionSpring",
    "mechanisms.andrews": "andrews andrews_angles",
    "mechanisms.four_bar": "FourBarData four_bar",
    "mechanisms.free_rod": "FreeRodData free_rod",
    "mechanisms.n_four_bar": "n_four_bar",
    "mechanisms.nine_bar": "nine_bar",
    "mechanisms.nine_bar_data": "NineBarData",
    "mechanisms.simeon": "SimeonData simeon",
    "mechanisms.slider_crank": "SliderCrankData slider_crank",
    "mechanisms.spinning_beam": "SpinningBeamData spinning_beam",
    "model.law": "FrictionLaw Motion NormalLaw",
    "model.material": "Material STEEL",
    "model.mechanism": "Mechanism",
    "model.part": "GROUND Element Part",
    "program.compiler": "compile",
    "solve.assemble": "assemble",
    "solve.buckling": "Buckling buckling",
    "solve.inverse_dynamics": "inverse_dynamics",
    "solve.modal": "Modes modes",
    "solve.report": "check",
    "solve.statics": "Equilibrium static_equilibrium",
    "view.plot": "plot",
    "view.render": "render",
    "view.screenshot": "screenshot_vtk",
}
_WHERE = {name: module for module, names in _HOME.items() for name in names.split()}

__all__ = [*sorted(_WHERE), "testing"]  # noqa: PLE0604 - all of them are strings


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that `import flexmb` is fast."""
    if name == "testing":
        return import_module("flexmb.testing")
    if name not in _WHERE:
        raise AttributeError(f"module 'flexmb' has no attribute {name!r}")
    value = getattr(import_module(f"flexmb.{_WHERE[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
