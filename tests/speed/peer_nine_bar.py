"""The nine-bar mechanism of models.py for Exudyn: its parts one by one, rigid or of beams.

Beams are the peer's geometrically exact ones with two nodes of (x, y, angle), because bosses, corners of the panel and
pins then share nodes, without further constraints: fewer unknowns than with ANCF cables.  Shear stiffness and rotary
inertia are those of the section, stiffness-proportional damping and bosses those of the flexmb model.  The mass in the
middle of the panel is carried by its three corners through a constant mass matrix.
"""

import itertools
import math

import exudyn as exu
import exudyn.itemInterface as item
import models
import numpy as np
from peer import OUT, System

import flexmb as fm
from flexmb.statics.start.consistent import consistent_start

SHEAR_FACTOR = 5.0 / 6.0
LINKS = ("crank1", "link2", "link3", "crank4", "rocker6", "link8")


def start_rates(mechanism):
    """(vx, vy, omega) and centre of every body of the rigid mechanism at the start."""
    program = fm.compile(mechanism)
    v = consistent_start(mechanism, program).v
    found = {}
    for body in ("slider", "panel7", *LINKS):
        node = mechanism.find(body).nodes()[0]
        found[body] = ((node.x, node.y), [v[program.coordinate(f"{body}.{c}")] for c in ("x", "y", "theta")])
    return found


def velocity_at(rates, point):
    """(vx, vy, omega) of a rigid body at a point."""
    (x, y), (vx, vy, omega) = rates
    return [vx - omega * (point[1] - y), vy + omega * (point[0] - x), omega]


class NineBar(System):
    """The mechanism under construction: where a body's points are depends on whether it bends."""

    def __init__(self, *, flexible, elements):
        super().__init__()
        self.mechanism = models.nine_bar(flexible=flexible, elements=elements)
        rigid = models.nine_bar()
        self.rates = start_rates(rigid)
        self.gravity = self.mechanism.gravity
        self.bodies, self.nodes = {}, {}
        for name in LINKS:
            (self.bar if flexible else self.stiff)(self.mechanism.find(name))
        panel = self.mechanism.find("panel7")
        (self.frame if flexible else self.stiff)(panel)
        self.stiff(self.mechanism.find("slider"))
        self.join()

    def stiff(self, part):
        """A rigid body."""
        (x, y), velocity = self.rates[part.name]
        node, body = self.body(part.mass, part.inertia, x, y, velocity)
        self.weigh(body, self.gravity)
        self.bodies[part.name] = (body, (x, y))
        self.nodes[part.name] = [(node, (x, y))]

    def node(self, name, point):
        """A node of a beam, moving as the rigid body does."""
        rates = velocity_at(self.rates[name], point)
        number = self.mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=[*point, 0.0], initialVelocities=rates))
        self.nodes[name].append((number, point))
        return number

    def boss(self, node, mass, inertia):
        """A rigid mass on a node."""
        if mass or inertia:
            self.weigh(
                self.mbs.AddObject(item.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node)), self.gravity
            )

    def beam(self, part, nodes, length):
        """Elements between the nodes."""
        section, steel = part.section, part.material
        area, bending = section.width * section.height, section.width * section.height**3 / 12.0
        shear = SHEAR_FACTOR * area * steel.young / (2.0 * (1.0 + steel.poisson))
        stiffness = {"axial": steel.young * area, "bending": steel.young * bending, "shear": shear}
        numbers = {f"{name}Stiffness": value for name, value in stiffness.items()}
        numbers |= {f"{name}Damping": part.damping * value for name, value in stiffness.items()}
        for two in itertools.pairwise(nodes):
            element = item.ObjectBeamGeometricallyExact2D(
                nodeNumbers=list(two),
                length=length / (len(nodes) - 1),
                massPerLength=steel.density * area,
                crossSectionInertia=steel.density * bending,
                **numbers,
            )
            self.weigh(self.mbs.AddObject(element), self.gravity)

    def bar(self, part):
        """A link of beams with bosses at its ends."""
        self.nodes[part.name] = []
        nodes = [self.node(part.name, (n.x, n.y)) for n in part.nodes()]
        self.beam(part, nodes, math.dist(part.start, part.end))
        bosses = part._bosses  # the fit belongs to the model, not to the code that moves it
        for node, mass, pivot in zip((nodes[0], nodes[-1]), bosses.masses, (part.pivot_inertia, 0.0), strict=True):
            self.boss(node, mass, bosses.inertia + pivot)

    def frame(self, part):
        """The panel: three beams that share corners, bosses, and a mass carried by the corners."""
        self.nodes[part.name] = []
        places = {n.name: (n.x, n.y) for n in part.nodes()}
        numbers = {name: self.node(part.name, point) for name, point in places.items()}
        for beam in part.beams:
            self.beam(part, [numbers[n] for n in beam.nodes], math.dist(beam.start, beam.end))
        bosses = part._bosses
        corners = [numbers[n] for n in part.corners]
        for node, mass in zip(corners, bosses.masses, strict=True):
            self.boss(node, mass, bosses.inertia)
        carried = np.zeros((9, 9))
        for i, j in itertools.product(range(3), repeat=2):
            for c in range(2):
                carried[3 * i + c, 3 * j + c] = bosses.mean_mass / 9.0
        pull = bosses.mean_mass / 3.0 * np.tile([*self.gravity, 0.0], 3)
        self.mbs.AddObject(item.ObjectGenericODE2(nodeNumbers=corners, massMatrix=carried, forceVector=pull))

    def marker(self, name, point, *, turning=False):
        """Marker of a body at a point of the start pose."""
        if name == "ground":
            return self.at(self.ground, *point)
        if name in self.bodies:
            body, (x, y) = self.bodies[name]
            return self.at(body, point[0] - x, point[1] - y, turning=turning)
        distance, node = min((math.dist(place, point), number) for number, place in self.nodes[name])
        if distance > 1e-9:
            raise ValueError(f"{name} has no node at {point}")
        return self.at_node(node, turning=turning)

    def join(self):
        """All joints and drives."""
        for joint in ("O1", "O4", "O6", "P4", "B2", "B3", "A", "C", "S"):
            part = self.mechanism.find(joint)
            self.pin(self.marker(part.first.name, part.at), self.marker(part.second.name, part.at))
        slider = self.nodes["slider"][0][0]
        self.hold(slider, 1)
        self.hold(slider, 2)
        for name, crank, speed in (
            ("torque1", "crank1", -models.NINE_BAR_SPEED),
            ("torque4", "crank4", models.NINE_BAR_SPEED),
        ):
            drive = self.hold(self.nodes[crank][0][0], 2, velocityLevel=True, offset=speed)
            self.watch(name, drive, OUT.Force)
        play = self.mechanism.find("P1")
        markers = [self.marker(body.name, play.at, turning=True) for body in (play.second, play.first)]
        radii = (play.bearing_radius, play.journal_radius)
        law = play.normal.for_radii(*radii)
        if play.friction.v0 != 0.0 or play.friction.v1 != models.SLIDING_ZONE:
            raise ValueError("the peer's friction rises from slip zero to SLIDING_ZONE")
        self.play(*markers, radii, law.stiffness, play.friction.coefficient)
        self.watch("slider", slider, OUT.Acceleration, node=True)


def nine_bar(*, flexible=False, elements=4):
    """The mechanism, ready to be solved."""
    return NineBar(flexible=flexible, elements=elements)


def sizes(system):
    """Numbers of coordinates and of constraints."""
    data = system.mbs.systemData
    return len(data.GetODE2Coordinates(configuration=exu.ConfigurationType.Initial)), len(data.GetAECoordinates())
