"""Planar flexible multibody dynamics with imperfect joints.

Declare a `Mechanism` of parts, `simulate` it, ask questions of the motion.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "series.correlation": "CorrelationDimension correlation_dimension",
    "series.embedding": "Embedding embed embedding false_neighbours mutual_information",
    "series.exponent": "SeriesExponent",
    "series.kantz": "kantz",
    "series.recurrence": "Recurrence recurrence",
    "series.rosenstein": "rosenstein",
    "series.spectrum": "PowerSpectrum power_spectrum",
    "series.wolf": "wolf",
    "series.zero_one": "ZeroOne zero_one_test",
    "dynamics.verdict.verdict": "Verdict judge",
    "dynamics.systems.dynamics": "Dynamics",
    "dynamics.exponents.exponents": "Exponents",
    "dynamics.systems.impact_ode": "ImpactODE",
    "dynamics.exponents.benettin": "benettin",
    "dynamics.exponents.lyapunov": "lyapunov",
    "dynamics.systems.map": "Map",
    "dynamics.systems.mechanism_flow": "MechanismFlow",
    "dynamics.systems.ode": "ODE",
    "dynamics.sections.points": "section stroboscopic",
    "dynamics.sections.section_map": "SectionMap",
    "dynamics.sections.stroboscopic": "StroboscopicMap",
    "dynamics.basins.basin": "Basin basin",
    "dynamics.orbits.branch": "Branch BranchPoint",
    "dynamics.orbits.continuation": "follow",
    "dynamics.orbits.periodic_orbit": "PeriodicOrbit periodic_orbit",
    "beams.section": "Circle GeneralSection Rectangle Section Tapered Tube",
    "bodies.flexible_frame": "FlexibleFrame",
    "bodies.flexible_link": "FlexibleLink",
    "bodies.rigid_body": "RigidBody",
    "bodies.rigid_link": "RigidLink",
    "contact.friction.bengisu_akay": "BengisuAkay",
    "contact.friction.brown_mcphee": "BrownMcPhee",
    "contact.friction.frictionless": "Frictionless",
    "contact.friction.lugre": "LuGre",
    "contact.friction.modified_coulomb": "ModifiedCoulomb",
    "contact.friction.smooth_coulomb": "SmoothCoulomb",
    "contact.friction.stribeck": "Stribeck",
    "contact.friction.threlfall": "Threlfall",
    "contact.normal.cylinder_laws": "DubowskyFreudenstein ESDU78035 Goldsmith Johnson Radzimovsky",
    "contact.normal.hertz": "Hertz",
    "contact.normal.hysteresis": "HysteresisLaw",
    "contact.normal.hysteresis_laws": (
        "CarvalhoMartins ExactRestitution Flores Gonthier HerbertMcWhannell HuGuo HuntCrossley LankaraniNikravesh "
        "LeeWang ZhiyingQishao"
    ),
    "contact.normal.kelvin_voigt": "KelvinVoigt",
    "drives.constant_speed": "ConstantSpeed",
    "drives.drive": "Drive",
    "drives.harmonic": "Harmonic",
    "drives.piecewise_linear": "PiecewiseLinear",
    "drives.polynomial": "Polynomial",
    "drives.pulse": "Pulse",
    "drives.ramp": "CycloidalRamp Ramp",
    "drives.table": "Table",
    "errors": (
        "FlexmbError InputError ModelError KernelError AssemblyError SolveError FileFormatError MissingPackageError "
        "RestitutionWarning WorkerError"
    ),
    "results.contact_intervals": "Episode Episodes",
    "step.method": "Method",
    "step.newmark.method": "Newmark",
    "results.momentum": "Momentum momentum",
    "results.netcdf": "load",
    "step.radau.method": "RadauIIA",
    "step.runge_kutta": "RungeKutta4",
    "run.simulate": "simulate",
    "results.solution": "Solution",
    "study.nine_bar.staggered.method": "Staggered",
    "run.steps": "StepState steps",
    "step.step_size": "Adaptive FixedStep",
    "results.vtk": "write_vtk",
    "joints.bushing": "Bushing",
    "joints.clamp": "Clamp",
    "joints.pin_slot": "PinSlot PinSlotClearance",
    "joints.prismatic": "Prismatic",
    "joints.prismatic_clearance": "PrismaticClearance",
    "joints.revolute": "Fixed Revolute",
    "joints.revolute_clearance": "RevoluteClearance",
    "kernels": (
        "account_kernel constraint_kernel drive_kernel element_kernel energy_kernel force_kernel friction_law "
        "gap_kernel normal_law signal_kernel tangent_kernel"
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
    "start.assemble": "assemble",
    "equilibrium.buckling": "Buckling buckling",
    "equilibrium.inverse_dynamics": "inverse_dynamics",
    "equilibrium.modes": "Modes modes",
    "equilibrium.mechanism_report": "check",
    "equilibrium.statics": "Equilibrium static_equilibrium",
    "view.orbits": "plot_basin plot_branch",
    "sweeps.bifurcation": "bifurcation",
    "sweeps.datasets": "load_sweep",
    "sweeps.sweep": "sweep",
    "view.bifurcation": "plot_bifurcation",
    "view.plot": "plot",
    "view.portrait": "plot_exponents plot_phase plot_section",
    "view.render": "render",
    "view.spectrum": "plot_spectrum",
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
