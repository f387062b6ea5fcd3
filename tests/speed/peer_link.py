"""The slider-crank whose rod is a link with eyes for Exudyn: a solid of one cell across its thickness, reduced.

The peer has no plane bodies, so the mesh of the plane body is drawn out to hexahedra with 27 nodes, whose nodes lie
where those of the plane mesh lie.  Its static modes of the second eye and vibrations with held eyes are chosen as a
careful user would: those that leave the plane are left out, so both codes keep the same number of modes in the plane.
Eyes are rigid (RBE2); the frame of the body is that of its first eye.
"""

from functools import lru_cache

import exudyn.itemInterface as item
import models
import numpy as np
import skfem as fem
from exudyn.FEM import FEMinterface, HCBstaticModeSelection, ObjectFFRFreducedOrderInterface
from peer import OUT, System, _crank
from scipy.linalg import eigh
from skfem.models.elasticity import lame_parameters, linear_elasticity

SOUGHT = 40
"""Number of vibrations that are computed, from which those in the plane are taken."""

IN_PLANE = 1e-3
"""Share of displacements across the middle plane, beside all, up to which a mode is one in the plane."""

CORNERS = {(0, 0): 0, (1, 0): 1, (1, 1): 2, (0, 1): 3}
"""Corner of a quadrilateral at the place of a vertex of the reference cell."""


def drawn_out(mesh, thickness):
    """The plane mesh as hexahedra with 27 nodes, symmetric about z = 0."""
    corners = mesh.cells[:, :4]
    used = np.unique(corners)
    number = {node: k for k, node in enumerate(used.tolist())}
    plane = mesh.points[used].T
    points = np.hstack([np.vstack([plane, np.full((1, len(used)), z)]) for z in (-0.5 * thickness, 0.5 * thickness)])
    reference = fem.ElementHex1.doflocs.astype(int)
    cells = np.array(
        [[number[cell[CORNERS[x, y]]] + z * len(used) for x, y, z in reference] for cell in corners.tolist()]
    )
    curved = fem.MeshHex2.from_mesh(fem.MeshHex1(points, cells.T))
    straight = {}  # where the nodes of a cell would lie with straight edges
    for cell in mesh.cells:
        p = mesh.points[cell[:4]]
        middles = 0.5 * (p + np.roll(p, -1, axis=0))
        for node, place in zip(cell, (*p, *middles, p.mean(axis=0)), strict=True):
            straight[tuple(np.round(place, 9))] = node
    nodes = [straight[tuple(np.round(place, 9))] for place in curved.doflocs[:2].T]
    moved = np.vstack([mesh.points[nodes].T, curved.doflocs[2:]])
    return fem.MeshHex2(moved, curved.t)


@lru_cache(maxsize=1)
def solid():
    """Positions (n, 3), stiffness and mass of the solid, with nodes in the order of the positions."""
    grid = drawn_out(models.link_mesh(), models.LINK_THICKNESS)
    element = fem.ElementVector(fem.ElementHex2())
    basis = fem.Basis(grid, element, intorder=4)
    steel = models.PLANE_STEEL
    K = linear_elasticity(*lame_parameters(steel.young, steel.poisson)).assemble(basis)
    mass = fem.BilinearForm(lambda u, v, w: steel.density * (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]))
    M = mass.assemble(basis)
    scalar = fem.Basis(grid, fem.ElementHex2(), intorder=4)
    numbers = np.zeros((scalar.N, 3), dtype=int)  # of the displacements by the places
    for axis in range(3):
        numbers[scalar.element_dofs, axis] = basis.element_dofs[axis::3]
    own = numbers.ravel()
    return scalar.doflocs.T, K[own][:, own].tocsr(), M[own][:, own].tocsr()


@lru_cache(maxsize=4)
def reduced(modes):
    """The reduced body, in-plane static modes of the second eye and so many in-plane vibrations; nodes of both eyes."""
    points, K, M = solid()
    body = FEMinterface()
    body.nodes = {"Position": points}
    body.massMatrix, body.stiffnessMatrix = M, K
    eyes = []
    for x in (0.0, models.ROD):
        away = np.hypot(points[:, 0] - x, points[:, 1])
        eyes.append(np.flatnonzero(np.abs(away - models.LINK_HOLE) < 1e-6 * models.ROD).tolist())
    body.ComputeHurtyCraigBamptonModes(eyes, SOUGHT, computationMode=HCBstaticModeSelection.RBE2)
    shapes = body.modeBasis["matrix"]
    middle = 3 * np.flatnonzero(np.abs(points[:, 2]) < IN_PLANE * models.LINK_THICKNESS)
    across = np.linalg.norm(shapes[middle + 2], axis=0) / np.linalg.norm(shapes, axis=0)
    plane = np.flatnonzero(across < IN_PLANE)
    if len(plane) < 3 + modes:
        raise ValueError(f"{len(plane)} modes in the plane are less than {3 + modes}; raise SOUGHT.")
    body.modeBasis["matrix"] = np.ascontiguousarray(shapes[:, plane[: 3 + modes]])
    return body, eyes


def spread(points, eye):
    """Four nodes around an eye in its middle plane: the eye is rigid, and fewer nodes cost the marker less time."""
    own = points[eye]
    flat = np.flatnonzero(np.abs(own[:, 2]) < IN_PLANE * models.LINK_THICKNESS)
    angle = np.arctan2(own[flat, 1] - own[:, 1].mean(), own[flat, 0] - own[:, 0].mean())
    wanted = 0.5 * np.pi * np.arange(4)
    apart = np.abs(np.angle(np.exp(1j * (angle[:, None] - wanted))))
    return [eye[flat[k]] for k in apart.argmin(axis=0)]


def frequencies(modes, count=4):
    """Lowest frequencies of the free reduced body in the plane, without rigid motions [Hz]."""
    body, _ = reduced(modes)
    points = body.nodes["Position"]
    rigid = np.zeros((points.size, 3))
    rigid[0::3, 0] = rigid[1::3, 1] = 1.0
    rigid[0::3, 2], rigid[1::3, 2] = -points[:, 1], points[:, 0]
    basis = np.hstack([rigid, body.modeBasis["matrix"]])
    squares = eigh(basis.T @ body.stiffnessMatrix @ basis, basis.T @ body.massMatrix @ basis, eigvals_only=True)
    return np.sqrt(squares[3 : 3 + count]) / (2.0 * np.pi)


def slider_crank(modes):
    """The slider-crank with the reduced link."""
    system = System()
    crank = _crank(system)
    body, eyes = reduced(modes)
    w = models.OMEGA
    solid_rod = ObjectFFRFreducedOrderInterface(body)
    made = solid_rod.AddObjectFFRFreducedOrder(
        system.mbs,
        positionRef=[models.CRANK, 0.0, 0.0],
        initialVelocity=[0.0, w * models.CRANK, 0.0],
        initialAngularVelocity=[0.0, 0.0, -w * models.CRANK / models.ROD],
        stiffnessProportionalDamping=models.LINK_DAMPING,
    )
    rod = made["oFFRFreducedOrder"]
    points, ends = body.nodes["Position"], []
    for x, eye in zip((0.0, models.ROD), eyes, strict=True):
        few = spread(points, eye)
        marker = item.MarkerSuperElementRigid(
            bodyNumber=rod,
            meshNodeNumbers=few,
            weightingFactors=[1.0 / len(few)] * len(few),
            offset=(np.array([x, 0.0, 0.0]) - points[few].mean(axis=0)).tolist(),
        )
        ends.append(system.mbs.AddMarker(marker))
    node, slider = system.body(models.SLIDER_MASS, 1e-4, models.CRANK + models.ROD)
    system.hold(node, 1)
    system.hold(node, 2)
    for first, second, axes in (
        (_turning(system, crank), ends[0], [1, 1, 1, 1, 1, 0]),
        (system.at(slider, turning=True), ends[1], [1, 1, 0, 0, 0, 0]),
    ):
        system.mbs.AddObject(item.GenericJoint(markerNumbers=[first, second], constrainedAxes=axes))
    middle = body.GetNodeAtPoint([0.5 * models.ROD, 0.0, 0.0])
    sensor = item.SensorSuperElement(
        bodyNumber=rod, meshNodeNumber=middle, storeInternal=True, writeToFile=False, outputVariableType=OUT.Position
    )
    system.sensors["middle"] = system.mbs.AddSensor(sensor)
    system.watch("slider", node, OUT.Position, node=True)
    return system


def _turning(system, crank):
    """A marker of the crank's pin with its orientation."""
    place = system.mbs.GetMarker(crank)
    return system.at(place["bodyNumber"], *place["localPosition"][:2], turning=True)
