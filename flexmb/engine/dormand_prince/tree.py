"""Accelerations and projections of rigid bodies that hang on pins as a tree: recursion from the tips to the ground.

A body with all that hangs on it needs the force A a + b at its pin to the body before it, whose acceleration is a, and
its angular acceleration is -(w . a + k) / D.  With kappa from this pin to its mass centre, e from there to the pin of a
body j beyond, and n, n_j = kappa, e turned by a right angle,

    w = m n + sum A_j n_j,   D = J + m n . n + sum n_j . A_j n_j,   k = -tau - n . f + sum n_j . (b_j - omega^2 A_j e),
    A = m 1 + sum A_j - w w^T / D,   b = -m omega^2 kappa - f + sum (b_j - omega^2 A_j e) - w k / D.

Angles and angular speeds alone close the pins, without a projection.  Equation (4.22) of docs/theory/integrators.md.

Source: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapter 7 (articulated bodies).
"""

import math
from collections import defaultdict

import numpy as np

from flexmb.engine.compiled.arrays import part_of, row_of
from flexmb.engine.compiled.records import Integers, Matrix, Record
from flexmb.engine.dormand_prince.complement import Complement
from flexmb.engine.system.work import new_from_template
from flexmb.kernels import compiled
from flexmb.places import INERTIA, MASS, PIN
from flexmb.program.program import BEGIN, Program

# Numbers of each pin in `Tree.pins`: first row; 1 if its body is the second one of the joint, or -1; first coordinate
# of its body; places in p of the pin on the body before it, and on its own; of the body before it the number of its
# pin, -1 for the ground, the place of this pin in p, and its first coordinate.
ROW, SIGN, BODY, NEAR, FAR, BEFORE, START, CARRIER, WIDTH = range(9)
# Columns of `Tree.known`: direction of the body, kappa, e; A, w, D, k and b, first their sums; acceleration of the pin.
C, S, KX, KY, EX, EY, AXX, AXY, AYY, WX, WY, D, K, BX, BY, PX, PY, KNOWN = range(18)


class Tree(Record):
    """Pins from the ground outwards, one a body, and the workspace of the recursion."""

    usable: int  # 1 if all joints are pins that make a tree with the ground, else 0
    pins: Integers  # (8 bodies,)
    masses: Matrix  # (bodies, 2) MASS [kg], INERTIA [kg m^2]
    known: Matrix  # (bodies, 17)


def tree(program: Program, masses: Complement) -> Tree:
    """Tree of the bodies of a compiled mechanism; not usable where there is none."""
    found = new_from_template(program, f"tree {masses.usable}", lambda: _of_pins(program, bool(masses.usable)))
    if found.usable:
        own = 1.0 / masses.flexibility[found.pins.reshape(-1, WIDTH)[:, BODY, None] + np.arange(3)]
        found.usable = int((own[:, 0] == own[:, 1]).all())
        found.masses[:] = own[:, 1:]
    return found


def _of_pins(program: Program, usable: bool) -> Tree:
    C = program.tables.constraints
    usable = usable and bool((C.known == PIN).all()) and 3 * len(C.known) == program.n_q
    pins = np.array(grown(program) if usable else [], dtype=np.int64).reshape(-1, WIDTH)
    return Tree(usable=int(len(pins) > 0), pins=pins.ravel(), masses=(len(pins), 2), known=(len(pins), KNOWN))


def grown(program: Program) -> list[tuple[int, ...]]:
    """Numbers of all pins from the ground outwards; none if a body is held twice, or not by the ground."""
    C, found = program.tables.constraints, list[tuple[int, ...]]()
    front, of_body, used = [program.n_q], {program.n_q: (-1, 0)}, set()
    bodies, joints = C.dofs.astype(int).reshape(-1, 6)[:, ::3], defaultdict(list)
    for joint, pair in enumerate(bodies.tolist()):
        for body in pair:
            joints[body].append(joint)
    for carrier in front:
        for joint in joints[carrier]:
            if joint in used:
                continue
            used.add(joint)
            first, second = bodies[joint].tolist()
            at, sign = C.p[joint, BEGIN], 1 if first == carrier else -1
            body, near, far = (second, at, at + 2) if first == carrier else (first, at + 2, at)
            if body in of_body:
                return []
            found.append((C.row[joint], sign, body, near, far, *of_body[carrier], carrier))
            of_body[body] = len(found) - 1, far
            front.append(body)
    return found if len(found) == len(bodies) else []


@compiled
def accelerate_by_tree(tables, trial, work, branches):
    """Set trial.a and trial.lam by the forces -work.r; whether they are finite."""
    find_arms(tables.p, trial.q, branches)
    add_inertias(trial.v, work.r, branches)
    return turn_bodies(trial.v, trial.a, trial.lam, branches)


@compiled
def find_arms(p, q, branches):
    """Directions of all bodies, kappa and e; sums are set to 0."""
    for i in range(branches.masses.shape[0]):
        pin, own = part_of(branches.pins, i * WIDTH, (i + 1) * WIDTH), row_of(branches.known, i, KNOWN)
        near, far, start, angle = pin[NEAR], pin[FAR], pin[START], q[pin[BODY] + 2]
        c, s, x, y = math.cos(angle), math.sin(angle), -p[far], -p[far + 1]
        own[C], own[S], own[KX], own[KY] = c, s, c * x - s * y, s * x + c * y
        if pin[BEFORE] >= 0:
            before = row_of(branches.known, pin[BEFORE], KNOWN)
            c, s, x, y = before[C], before[S], p[near] - p[start], p[near + 1] - p[start + 1]
            own[EX], own[EY] = c * x - s * y, s * x + c * y
        for k in range(AXX, PX):
            own[k] = 0.0


@compiled
def add_inertias(v, r, branches):
    """A, b, w/D and k/D of all bodies, from the tips to the ground."""
    for i in range(branches.masses.shape[0] - 1, -1, -1):
        pin, own = part_of(branches.pins, i * WIDTH, (i + 1) * WIDTH), row_of(branches.known, i, KNOWN)
        body, x, y, m = pin[BODY], own[KX], own[KY], branches.masses[i, MASS]
        wx, wy, way = own[WX] - m * y, own[WY] + m * x, m * v[body + 2] * v[body + 2]
        k = own[K] + r[body + 2] + x * r[body + 1] - y * r[body]
        inverse = 1.0 / (own[D] + branches.masses[i, INERTIA] + m * (x * x + y * y))
        ux, uy = wx * inverse, wy * inverse
        axx, axy, ayy = own[AXX] + m - ux * wx, own[AXY] - ux * wy, own[AYY] + m - uy * wy
        bx, by = own[BX] - way * x + r[body] - ux * k, own[BY] - way * y + r[body + 1] - uy * k
        own[AXX], own[AXY], own[AYY], own[BX], own[BY] = axx, axy, ayy, bx, by
        own[WX], own[WY], own[K] = ux, uy, k * inverse
        if pin[BEFORE] < 0:
            continue
        before, speed, x, y = row_of(branches.known, pin[BEFORE], KNOWN), v[pin[CARRIER] + 2], own[EX], own[EY]
        gx, gy = axy * x - axx * y, ayy * x - axy * y
        speed *= speed
        bx, by = bx - speed * (axx * x + axy * y), by - speed * (axy * x + ayy * y)
        before[AXX] += axx
        before[AXY] += axy
        before[AYY] += ayy
        before[WX] += gx
        before[WY] += gy
        before[D] += gy * x - gx * y
        before[BX] += bx
        before[BY] += by
        before[K] += by * x - bx * y


@compiled
def turn_bodies(v, a, lam, branches):
    """Accelerations (n_q + 3,) and multipliers (n_c,), from the ground to the tips; whether they are finite."""
    total = 0.0
    for i in range(branches.masses.shape[0]):
        pin, own, px, py = (
            part_of(branches.pins, i * WIDTH, (i + 1) * WIDTH),
            row_of(branches.known, i, KNOWN),
            0.0,
            0.0,
        )
        if pin[BEFORE] >= 0:
            before, turn, speed = row_of(branches.known, pin[BEFORE], KNOWN), a[pin[CARRIER] + 2], v[pin[CARRIER] + 2]
            speed *= speed
            px = before[PX] - turn * own[EY] - speed * own[EX]
            py = before[PY] + turn * own[EX] - speed * own[EY]
        own[PX], own[PY], body, row, sign = px, py, pin[BODY], pin[ROW], -1.0 * pin[SIGN]
        turn, speed = -(own[WX] * px + own[WY] * py + own[K]), v[body + 2] * v[body + 2]
        a[body], a[body + 1] = px - turn * own[KY] - speed * own[KX], py + turn * own[KX] - speed * own[KY]
        a[body + 2] = turn
        lam[row] = sign * (own[AXX] * px + own[AXY] * py + own[BX])
        lam[row + 1] = sign * (own[AXY] * px + own[AYY] * py + own[BY])
        total += turn + px + py
    return math.isfinite(total)


@compiled
def place_by_tree(tables, trial, branches):
    """Place the bodies by their angles, and move them by their angular speeds, so that all pins are closed."""
    p, q, v = tables.p, trial.q, trial.v
    for i in range(branches.masses.shape[0]):
        pin, own = part_of(branches.pins, i * WIDTH, (i + 1) * WIDTH), row_of(branches.known, i, KNOWN)
        body, near, far = pin[BODY], pin[NEAR], pin[FAR]
        x, y, vx, vy = p[near], p[near + 1], 0.0, 0.0
        if pin[BEFORE] >= 0:
            before = row_of(branches.known, pin[BEFORE], KNOWN)
            start, c, s = pin[CARRIER], before[C], before[S]
            ax, ay, speed = c * x - s * y, s * x + c * y, v[start + 2]
            x, y, vx, vy = q[start] + ax, q[start + 1] + ay, v[start] - speed * ay, v[start + 1] + speed * ax
        c, s, speed = math.cos(q[body + 2]), math.sin(q[body + 2]), v[body + 2]
        own[C], own[S] = c, s
        ax, ay = c * p[far] - s * p[far + 1], s * p[far] + c * p[far + 1]
        q[body], q[body + 1], v[body], v[body + 1] = x - ax, y - ay, vx + speed * ay, vy - speed * ax
