"""The models of models.py for Exudyn, from the same numbers, and its solver with what of its settings matters.

Three settings have to be known; found by trying, and stated here because the times depend on them.
- With the default settings every model with play stops at the first impact: the error that decides over the step is the
  gap times the stiffness, as if the force were linear.  "fixed" keeps the steps as given.  "located" lets the steps end
  where a contact begins: a larger tolerance of that iteration and a smaller least step.
- The default tolerances of Newton's method lie below the round-off of stiff beams; the chain and the flexible nine-bar
  take others.
- The sparse linear solver pays from some forty coordinates on.
"""

import math
import time
from dataclasses import dataclass
from itertools import pairwise

import exudyn as exu
import exudyn.itemInterface as item
import models
import numpy as np

ALPHA = exu.DynamicSolverType.GeneralizedAlpha  # spectral radius 0.9, index 3
TRAPEZOIDAL = exu.DynamicSolverType.TrapezoidalIndex2
OUT = exu.OutputVariableType
BEAM_TOLERANCES = (1e-4, 1e-2)  # relative, absolute

exu.config.printToConsole = False


class PeerError(Exception):
    """The peer's solver gave up."""


@dataclass(frozen=True)
class Stepping:
    """How the peer steps: number of steps, what it does at contacts, solvers, tolerances of Newton's method."""

    steps: int
    contacts: str = "none"  # "fixed", "located"
    solver: object = ALPHA
    sparse: bool = False
    tolerances: tuple[float, float] | None = None
    full_newton: bool = False

    def settings(self, t_end: float, *, watched: bool):
        """The simulation settings."""
        chosen = exu.SimulationSettings()
        march = chosen.timeIntegration
        march.endTime, march.numberOfSteps, march.verboseMode = t_end, self.steps, 0
        chosen.solution.file.write = False
        chosen.solution.solverInformationFileName = ""
        chosen.solution.sensors.active = watched
        chosen.solution.sensors.writePeriod = 1e-12  # every step
        march.newton.useModifiedNewton = not self.full_newton
        if self.contacts == "fixed":
            march.discontinuous.useRecommendedStepSize = False
        elif self.contacts == "located":
            march.minimumStepSize, march.discontinuous.iterationTolerance = 1e-13, 1e4
        if self.sparse:
            chosen.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        if self.tolerances:
            march.newton.relativeTolerance, march.newton.absoluteTolerance = self.tolerances
        return chosen


class System:
    """A planar system of the peer; sensors are kept by name."""

    def __init__(self):
        self.owner = exu.SystemContainer()  # the system lives no longer than it
        self.mbs = self.owner.AddSystem()
        self.sensors = {}
        self.ground = self.mbs.AddObject(item.ObjectGround())
        self.origin = self.mbs.AddMarker(
            item.MarkerNodeCoordinate(nodeNumber=self.mbs.AddNode(item.NodePointGround()), coordinate=0)
        )

    def body(self, mass, inertia, x, y=0.0, velocity=(0.0, 0.0, 0.0)):
        """Node and body of a rigid body with its centre of mass at (x, y)."""
        node = self.mbs.AddNode(
            item.NodeRigidBody2D(referenceCoordinates=[x, y, 0.0], initialVelocities=list(velocity))
        )
        return node, self.mbs.AddObject(item.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))

    def cable(self, begin, length, section, count, rise=0.0, spin=0.0):
        """Nodes and elements of a straight ANCF cable along +x from x = begin; velocity rise + spin s across it."""
        stations = np.linspace(0.0, length, count + 1)
        nodes = [
            self.mbs.AddNode(
                item.NodePoint2DSlope1(
                    referenceCoordinates=[begin + s, 0.0, 1.0, 0.0],
                    initialVelocities=[0.0, rise + spin * s, 0.0, spin],
                )
            )
            for s in stations
        ]
        width, height = section
        steel, area = models.BEAM_STEEL, width * height
        numbers = {
            "length": length / count,
            "massPerLength": steel.density * area,
            "axialStiffness": steel.young * area,
            "bendingStiffness": steel.young * area * height**2 / 12.0,
        }
        made = [self.mbs.AddObject(item.ObjectANCFCable2D(nodeNumbers=list(two), **numbers)) for two in pairwise(nodes)]
        return nodes, made

    def at(self, body, x=0.0, y=0.0, *, turning=False):
        """Marker of a point of a body; `turning` with its orientation."""
        kind = item.MarkerBodyRigid if turning else item.MarkerBodyPosition
        return self.mbs.AddMarker(kind(bodyNumber=body, localPosition=[x, y, 0.0]))

    def at_node(self, node, *, turning=False):
        """Marker of a node."""
        kind = item.MarkerNodeRigid if turning else item.MarkerNodePosition
        return self.mbs.AddMarker(kind(nodeNumber=node))

    def pin(self, first, second):
        """An ideal revolute joint between two markers."""
        self.mbs.AddObject(item.ObjectJointRevolute2D(markerNumbers=[first, second]))

    def hold(self, node, coordinate, **motion):
        """Keep a coordinate of a node where it is, or move it."""
        marker = self.mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        return self.mbs.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[self.origin, marker], **motion))

    def weigh(self, body, gravity):
        """Gravity [m/s^2] on a body."""
        marker = self.mbs.AddMarker(item.MarkerBodyMass(bodyNumber=body))
        self.mbs.AddLoad(item.LoadMassProportional(markerNumber=marker, loadVector=[*gravity, 0.0]))

    def play(self, journal, bearing, radii, stiffness, mu):
        """The contact object for a journal in a bearing, with the law of Lankarani and Nikravesh.

        The peer's Hunt-Crossley factor 1.5 (1 - e) is 0.75 (1 - RESTITUTION^2) for the e given here.
        """
        outer, inner = radii
        state = self.mbs.AddNode(
            item.NodeGenericData(initialCoordinates=[outer - inner, 0.0, 0.0, 0.0], numberOfDataCoordinates=4)
        )
        contact = item.ObjectContactSphereSphere(
            markerNumbers=[journal, bearing],
            nodeNumber=state,
            spheresRadii=[inner, outer],
            isHollowSphere1=True,
            contactStiffness=stiffness,
            contactStiffnessExponent=1.5,
            impactModel=1,
            restitutionCoefficient=1.0 - 0.5 * (1.0 - models.RESTITUTION**2),
            minimumImpactVelocity=models.LEAST_APPROACH,
            dynamicFriction=mu,
            frictionProportionalZone=models.SLIDING_ZONE,
        )
        number = self.mbs.AddObject(contact)
        self.watch("force", number, OUT.Force)
        return number

    def watch(self, name, number, quantity, *, node=False):
        """Record a quantity of an object or a node."""
        kind, place = (item.SensorNode, "nodeNumber") if node else (item.SensorObject, "objectNumber")
        sensor = kind(storeInternal=True, writeToFile=False, outputVariableType=quantity, **{place: number})
        self.sensors[name] = self.mbs.AddSensor(sensor)

    def record(self, name):
        """(n, 1 + components) time and what was recorded."""
        return np.array(self.mbs.GetSensorStoredData(self.sensors[name]))

    def solve(self, t_end, stepping, *, watched=False):
        """CPU time of the solver [s] and the steps it took."""
        self.mbs.Assemble()
        chosen = stepping.settings(t_end, watched=watched)
        began = time.process_time()
        try:
            self.mbs.SolveDynamic(chosen, solverType=stepping.solver, storeSolver=True, showHints=False)
        except exu.SolverError as error:
            raise PeerError(" ".join(str(error).split())) from error
        took = time.process_time() - began
        return took, self.mbs.sys["dynamicSolver"].it.currentStepIndex - 1


# Slider-cranks.


def _crank(system):
    """The driven crank; returns the marker of its pin."""
    half, w = 0.5 * models.CRANK, models.OMEGA
    node, body = system.body(models.CRANK_MASS, models.CRANK_INERTIA, half, velocity=(0.0, w * half, w))
    system.pin(system.at(system.ground), system.at(body, -half))
    system.watch("torque", system.hold(node, 2, velocityLevel=True, offset=w), OUT.Force)
    return system.at(body, half)


def _rod_and_slider(system):
    """Rigid rod on the crank, slider in its guide; returns both bodies, not joined to one another."""
    half, w = 0.5 * models.ROD, models.OMEGA
    turning = -w * models.CRANK / models.ROD
    velocity = (0.0, 0.5 * w * models.CRANK, turning)
    pin = _crank(system)
    _, rod = system.body(models.ROD_MASS, models.ROD_INERTIA, models.CRANK + half, velocity=velocity)
    system.pin(pin, system.at(rod, -half))
    node, slider = system.body(models.SLIDER_MASS, 1e-4, models.CRANK + models.ROD)
    system.hold(node, 1)
    system.hold(node, 2)
    system.watch("position", node, OUT.Position, node=True)
    return rod, slider


def ideal():
    """The slider-crank with ideal joints."""
    system = System()
    rod, slider = _rod_and_slider(system)
    system.pin(system.at(rod, 0.5 * models.ROD), system.at(slider))
    return system


def worn(mu=0.03, clearance=models.CLEARANCE):
    """The slider-crank with play, its contact the peer's built-in object."""
    system = System()
    rod, slider = _rod_and_slider(system)
    bearing = system.at(rod, 0.5 * models.ROD, turning=True)
    radii = (models.BEARING, models.BEARING - clearance)
    system.play(system.at(slider, turning=True), bearing, radii, models.hertz(), mu)
    return system


class PythonLaw:
    """The same contact as Python functions: one for the force, one at the begin of every step for the approach speed.

    What the peer hands over are displacement u and velocity of the bearing against the journal.
    """

    def __init__(self, mu):
        self.mu, self.stiffness, self.approach = mu, models.hertz(), 0.0
        self.damping = 0.75 * (1.0 - models.RESTITUTION**2)

    def force(self, mbs, t, number, u, turn, rate, spin, *_):
        """Force and moment on the journal."""
        size = math.hypot(u[0], u[1])
        depth = size - models.CLEARANCE
        if depth <= 0.0:
            return [0.0] * 6
        nx, ny = u[0] / size, u[1] / size
        closing = rate[0] * nx + rate[1] * ny
        first = self.approach or max(closing, models.LEAST_APPROACH)
        N = self.stiffness * depth**1.5 * (1.0 + self.damping * closing / first)
        arm = models.BEARING + 0.5 * depth
        slip = rate[1] * nx - rate[0] * ny - spin[2] * arm
        T = self.mu * N * min(max(slip / models.SLIDING_ZONE, -1.0), 1.0)
        return [N * nx - T * ny, N * ny + T * nx, 0.0, 0.0, 0.0, -T * arm]

    def keep_approach(self, joint):
        """The function for the begin of a step, which keeps the speed at which a contact began."""

        def before_step(mbs, t):
            ux, uy, _ = mbs.GetObjectOutput(joint, OUT.DisplacementLocal)
            size = math.hypot(ux, uy)
            if size <= models.CLEARANCE:
                self.approach = 0.0
            elif self.approach == 0.0:
                vx, vy, _ = mbs.GetObjectOutput(joint, OUT.VelocityLocal)
                self.approach = max((ux * vx + uy * vy) / size, models.LEAST_APPROACH)
            return True

        return before_step


def user_law(mu=0.03):
    """The slider-crank with play whose contact is a Python function."""
    system, law = System(), PythonLaw(mu)
    rod, slider = _rod_and_slider(system)
    nothing = np.zeros((6, 6))
    spring = item.ObjectConnectorRigidBodySpringDamper(
        markerNumbers=[system.at(slider, turning=True), system.at(rod, 0.5 * models.ROD, turning=True)],
        stiffness=nothing,
        damping=nothing,
        springForceTorqueUserFunction=law.force,
    )
    joint = system.mbs.AddObject(spring)
    system.mbs.SetPreStepUserFunction(law.keep_approach(joint))
    system.watch("force", joint, OUT.ForceLocal)
    return system


def flexible_rod(section="heavy", elements=8):
    """The slider-crank with a rod of ANCF cables and a slider that is a point mass."""
    system = System()
    pin = _crank(system)
    end = system.mbs.AddNode(item.NodePoint2D(referenceCoordinates=[models.CRANK + models.ROD, 0.0]))
    system.mbs.AddObject(item.ObjectMassPoint2D(mass=models.SLIDER_MASS, nodeNumber=end))
    rise, spin = models.OMEGA * models.CRANK, -models.OMEGA * models.CRANK / models.ROD
    nodes, _ = system.cable(models.CRANK, models.ROD, models.SECTIONS[section], elements, rise, spin)
    system.pin(pin, system.at_node(nodes[0]))
    system.pin(system.at_node(nodes[-1]), system.at_node(end))
    system.hold(end, 1)
    for name, k in (("begin", 0), ("middle", elements // 2), ("end", elements)):
        system.watch(name, nodes[k], OUT.Position, node=True)
    return system


def chain(links, elements):
    """The falling chain of ANCF cables."""
    system = System()
    last = system.at(system.ground)
    for k in range(links):
        nodes, made = system.cable(k * models.LINK, models.LINK, models.LINK_SECTION, elements)
        for element in made:
            system.weigh(element, (0.0, -models.GRAVITY))
        system.pin(last, system.at_node(nodes[0]))
        last = system.at_node(nodes[-1])
    system.watch("tip", nodes[-1], OUT.Position, node=True)
    return system
