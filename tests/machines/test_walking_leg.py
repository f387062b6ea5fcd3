"""Walking leg of Theo Jansen: the foot by circle intersections, the torque of the motor by energy.

Source: lengths of the "holy numbers" of T. Jansen, The Great Pretender, 010 Publishers 2007.  All points are periodic
functions of the crank angle, so their derivatives are those of their Fourier series.
"""

import numpy as np
import pytest

import flexmb as fm

MM = 1e-3
PIVOT, CRANK = np.array((-38.0, -7.8)) * MM, 15.0 * MM
SPEED, DENSITY = 6.0, 0.8  # [rad/s], [kg/m]
G = 9.81


def meet(p, q, rp, rq, side):
    """The point at distance rp from p and rq from q, to the left (side 1) or right (-1) of the way from p to q."""
    way = q - p
    d = np.hypot(way[..., 0], way[..., 1])[..., None]
    along = (d**2 + rp**2 - rq**2) / (2.0 * d)
    across = np.sqrt(rp**2 - along**2)
    left = np.stack([-way[..., 1], way[..., 0]], axis=-1)
    return p + (along * way + side * across * left) / d


def points(angle):
    """Crank pin P, corners T and D of the upper triangle, C, E and the foot F of the lower one."""
    p = CRANK * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    b = np.broadcast_to(PIVOT, p.shape)
    t = meet(p, b, 50.0 * MM, 41.5 * MM, -1)
    d = meet(b, t, 40.1 * MM, 55.8 * MM, 1)
    c = meet(p, b, 61.9 * MM, 39.3 * MM, 1)
    e = meet(d, c, 39.4 * MM, 36.7 * MM, -1)
    f = meet(e, c, 65.7 * MM, 49.0 * MM, -1)
    return {"P": p, "T": t, "D": d, "C": c, "E": e, "F": f, "B": b}


def rod(name, start, end):
    length = float(np.hypot(*(end - start)))
    return fm.RigidLink(name, tuple(start), tuple(end), mass=DENSITY * length, inertia=DENSITY * length**3 / 12.0)


def plate(name, *corners):
    """A body whose mass is at its corners, 20 g each."""
    centre = sum(corners) / 3.0
    inertia = 0.02 * sum(float((c - centre) @ (c - centre)) for c in corners)
    return fm.RigidBody(name, at=tuple(centre), mass=0.06, inertia=inertia, outline=[tuple(c) for c in corners])


def leg():
    at = points(np.array(0.0))
    crank = fm.RigidLink("crank", (0.0, 0.0), tuple(at["P"]), mass=0.1, inertia=1e-5, centre=0.0)
    j, k = rod("j", at["P"], at["T"]), rod("k", at["P"], at["C"])
    c, f = rod("c", at["B"], at["C"]), rod("f", at["D"], at["E"])
    upper, lower = plate("upper", at["B"], at["T"], at["D"]), plate("lower", at["C"], at["E"], at["F"])
    pairs = {
        "O": (fm.GROUND, crank, (0.0, 0.0)), "P1": (crank, j, at["P"]), "P2": (crank, k, at["P"]),
        "T": (j, upper, at["T"]), "B1": (fm.GROUND, upper, at["B"]), "B2": (fm.GROUND, c, at["B"]),
        "C1": (k, c, at["C"]), "C2": (c, lower, at["C"]), "D": (upper, f, at["D"]), "E": (f, lower, at["E"]),
    }  # fmt: skip
    pins = [fm.Revolute(name, one, other, at=tuple(place)) for name, (one, other, place) in pairs.items()]
    parts = [crank, j, k, c, f, upper, lower, *pins, fm.Drive("motor", "O", fm.ConstantSpeed(SPEED))]
    return fm.Mechanism("leg", [*parts, fm.Marker("foot", lower, at=tuple(at["F"]))], gravity=(0.0, -G))


def rate(values):
    """Time derivative of a periodic function on an even grid of one turn."""
    n = len(values)
    waves = np.fft.fftfreq(n, 1.0 / n)
    return np.fft.ifft(1j * SPEED * waves[:, None] * np.fft.fft(values, axis=0), axis=0).real


def energy(at):
    """Kinetic and potential energy of all rods and plates over one turn; the crank is balanced."""
    total = np.zeros(len(at["P"]))
    for one, other in ("PT", "PC", "BC", "DE"):
        length = np.hypot(*(at[one][0] - at[other][0]))
        u, v = rate(at[one]), rate(at[other])
        total += DENSITY * length * (((u * u + u * v + v * v).sum(axis=1)) / 6.0)
        total += DENSITY * length * G * (at[one] + at[other])[:, 1] / 2.0
    for corner in "BTDCEF":
        total += 0.02 * ((rate(at[corner]) ** 2).sum(axis=1) / 2.0 + G * at[corner][:, 1])
    return total


@pytest.fixture(scope="module")
def turn():
    times = np.linspace(0.0, 2.0 * np.pi / SPEED, 257)
    return fm.simulate(leg(), t_end=times[-1], save=times, step=fm.Adaptive(rtol=1e-7)).require()


def test_the_foot_walks_on_the_path_of_the_circles(turn):
    exact = points(SPEED * turn.time)["F"]
    assert turn["foot.x"].values == pytest.approx(exact[:, 0], abs=1e-9)
    assert turn["foot.y"].values == pytest.approx(exact[:, 1], abs=1e-9)
    assert 0.06 < np.ptp(exact[:, 0]) < 0.09  # a step of about 7 cm
    below = exact[exact[:, 1] < exact[:, 1].min() + 2e-3]
    assert np.ptp(below[:, 0]) > 0.5 * np.ptp(exact[:, 0])  # level for more than half of it


def test_the_motor_gives_what_the_energy_of_the_links_takes(turn):
    at = points(SPEED * turn.time[:-1])
    torque = rate(energy(at)[:, None])[:, 0] / SPEED
    assert turn["motor.torque"].values[:-1] == pytest.approx(torque, abs=1e-5 * np.abs(torque).max())


def test_inverse_dynamics_needs_the_same_torque(turn):
    times = turn.time[::32]
    needed = fm.inverse_dynamics(leg(), times).torque("motor")
    assert np.asarray(needed) == pytest.approx(turn["motor.torque"].values[::32], abs=1e-6)
