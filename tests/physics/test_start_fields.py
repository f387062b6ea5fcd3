"""Beams that start bent, stretched or vibrating: fields of displacement and velocity."""

import math
import pickle

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import AssemblyError, InputError
from flexmb.statics.start.consistent import consistent_start

YOUNG, DENSITY, SIDE, LENGTH, N = 2e9, 1000.0, 0.02, 1.2, 4
AREA, SECOND = SIDE**2, SIDE**4 / 12.0
OPTIONS = {"section": fm.Rectangle(width=SIDE, height=SIDE), "material": fm.Material(YOUNG, DENSITY), "elements": N}
S = np.linspace(0.0, 1.0, N + 1)


def rod(**fields):
    return fm.FlexibleLink("rod", (0.0, 0.0), (LENGTH, 0.0), **{**OPTIONS, **fields})


def start_of(*parts):
    mech = fm.Mechanism("start", parts)
    program = fm.compile(mech)
    start = consistent_start(mech, program)
    return program, start.q.reshape(-1, 3), start.v.reshape(-1, 3)


def wave(s):
    """A field that is no rigid motion."""
    return 0.3 * s * s, math.sin(math.pi * s) - 0.2, 2.0 * math.cos(math.pi * s)


def test_a_velocity_field_holds_exactly_as_function_and_as_list():
    expected = np.array([wave(s) for s in S])
    for given in (wave, expected, expected.tolist(), tuple(map(tuple, expected))):
        _, _, v = start_of(rod(velocity=given))
        np.testing.assert_allclose(v, expected, rtol=0, atol=1e-15)


def test_a_link_on_a_vibrating_rod_follows_with_least_kinetic_energy():
    """Pin velocity u, centre of mass at r from the pin.

    d/dw [m (u + w x r)^2 + J w^2] = 0, so w = m (r_y u_x - r_x u_y) / (J + m r^2).
    """
    mass, inertia, r = 0.7, 0.02, (0.15, 0.2)
    hanger = fm.RigidLink("hanger", (LENGTH, 0.0), (LENGTH + 2.0 * r[0], 2.0 * r[1]), mass, inertia)
    moving = rod(velocity=wave)
    _, _, v = start_of(moving, hanger, fm.Revolute("P", moving, hanger, at=(LENGTH, 0.0)))
    ux, uy, _ = wave(1.0)
    w = mass * (r[1] * ux - r[0] * uy) / (inertia + mass * (r[0] ** 2 + r[1] ** 2))
    np.testing.assert_allclose(v[:-1], [wave(s) for s in S], atol=1e-14)
    np.testing.assert_allclose(v[-1], [ux - w * r[1], uy + w * r[0], w], atol=1e-12)


def test_a_field_that_a_joint_forbids_is_refused_with_the_joint_and_the_size():
    moving = rod(velocity=lambda s: (0.0, 0.25 + s, 1.0))
    with pytest.raises(AssemblyError, match=r"largest violation 0\.25 m/s or rad/s at 'O'"):
        start_of(moving, fm.Revolute("O", fm.GROUND, moving, at=(0.0, 0.0)))


def test_a_rigid_start_velocity_still_is_rigid_where_loops_move_the_link():
    """Drawn 30 degrees away from where the drive puts it: the middle node moves as declared, the link turns rigidly."""
    turned = rod(velocity=(-2.0 * 0.6 * math.sin(0.5), 2.0 * 0.6 * math.cos(0.5), 2.0))
    drive = fm.Drive("motor", "O", fm.drives.Polynomial((0.5, 2.0)))
    _, q, v = start_of(turned, fm.Revolute("O", fm.GROUND, turned, at=(0.0, 0.0)), drive)
    np.testing.assert_allclose(v, np.stack([-2.0 * q[:, 1], 2.0 * q[:, 0], 0.0 * S + 2.0], axis=1), atol=1e-12)
    np.testing.assert_allclose(q[-1], [LENGTH * math.cos(0.5), LENGTH * math.sin(0.5), 0.5], atol=1e-12)


def test_a_stretched_rod_holds_the_energy_of_its_stretch():
    """Uniform strain e: E A e^2 L / 2; its axial mass then vibrates freely, first mode omega = pi/L sqrt(E/rho)."""
    strain = 1e-5
    sol = fm.simulate(
        fm.Mechanism("stretched", [rod(displacement=lambda s: (strain * s * LENGTH, 0.0, 0.0))]), t_end=1e-3, step=1e-6
    )
    energy = YOUNG * AREA * strain**2 * LENGTH / 2.0
    assert sol.array("energy.strain")[0] == pytest.approx(energy, rel=1e-9)
    assert sol.array("energy.kinetic")[0] == 0.0
    assert sol.array("energy.strain").min() < 0.2 * energy


def test_a_bent_rod_holds_the_energy_of_its_curvature_and_starts_with_the_moment_balance_of_a_free_end():
    """Arc of curvature k without stretch: E I k^2 L / 2, whatever the rotation."""
    k = 0.5
    arc = lambda s: (math.sin(k * s * LENGTH) / k - s * LENGTH, (1.0 - math.cos(k * s * LENGTH)) / k, k * s * LENGTH)  # noqa: E731
    mech = fm.Mechanism("bent", [rod(displacement=arc, elements=16)])
    sol = fm.simulate(mech, t_end=1e-5, step=1e-6, save="steps")
    assert sol.array("energy.strain")[0] == pytest.approx(YOUNG * SECOND * k**2 * LENGTH / 2.0, rel=1e-3)
    assert sol.array("rod.end.y")[0] == pytest.approx((1.0 - math.cos(k * LENGTH)) / k, abs=1e-15)
    assert sol.array("rod.end.theta")[0] == pytest.approx(k * LENGTH, abs=1e-15)


def test_loops_close_with_links_in_their_bent_shape():
    """The rod's chord is drawn 1 % short by its displacement; the rigid follower closes the loop where it then ends."""
    short = rod(displacement=lambda s: (-0.01 * s * LENGTH, 0.02 * math.sin(math.pi * s), 0.0))
    follower = fm.RigidLink("follower", (LENGTH, -0.5), (LENGTH, 0.0), 1.0, 0.1)
    crank = fm.Revolute("A", fm.GROUND, short, at=(0.0, 0.0))
    joints = (crank, fm.Revolute("B", short, follower, at=(LENGTH, 0.0)))
    _, q, _ = start_of(short, follower, *joints, fm.Revolute("C", fm.GROUND, follower, at=(LENGTH, -0.5)))
    assert math.dist(q[0, :2], q[N, :2]) == pytest.approx(0.99 * LENGTH, abs=1e-12)
    assert math.dist(q[N, :2], (LENGTH, -0.5)) == pytest.approx(0.5, abs=1e-12)
    middle, chord = q[N // 2, :2] - q[0, :2], (q[N, :2] - q[0, :2]) / (0.99 * LENGTH)
    assert chord[0] * middle[1] - chord[1] * middle[0] == pytest.approx(0.02, abs=1e-12)


def test_frames_take_one_triple_per_node():
    corners, edges = ((0.0, 0.0), (0.4, 0.05), (0.1, 0.3)), ((0, 1), (1, 2), (2, 0))
    values = np.random.default_rng(1).uniform(-1.0, 1.0, (6, 3))
    options = {**OPTIONS, "elements": 2}
    frame = fm.FlexibleFrame("frame", corners, edges, velocity=values, displacement=1e-3 * values, **options)
    _, q, v = start_of(frame)
    np.testing.assert_allclose(v, values, atol=1e-15)
    np.testing.assert_allclose(q[:3, :2], np.array(corners) + 1e-3 * values[:3, :2], atol=1e-15)
    with pytest.raises(InputError, match="velocity is a function, but a frame has no coordinate along it"):
        fm.FlexibleFrame("frame", corners, edges, velocity=wave, **options)


def test_a_declaration_with_functions_is_numbers_and_can_be_pickled_changed_and_restarted():
    mech = fm.Mechanism("waving", [rod(velocity=wave, displacement=lambda s: (0.0, 0.01 * s, 0.0))])
    assert pickle.loads(pickle.dumps(mech)) == mech  # noqa: S301 - written on the same line
    other = mech.with_({"rod.velocity": wave, "rod.displacement": None})
    assert other.find("rod").velocity == mech.find("rod").velocity
    with pytest.raises(InputError, match="velocity has 5 entries, but the body has 9 nodes"):
        mech.with_({"rod.elements": 8})
    step = 2.0**-17  # a power of two, so that the half ends with a whole step
    whole = fm.simulate(mech, t_end=64 * step, step=step)
    half = fm.simulate(mech, t_end=32 * step, step=step)
    rest = fm.simulate(mech, t_end=64 * step, step=step, restart=half.restart)
    np.testing.assert_array_equal(rest.restart["q"], whole.restart["q"])


def test_files_show_the_bent_start(tmp_path):
    import meshio

    bend = lambda s: (0.0, 0.05 * s * s, 0.1 * s / LENGTH)  # noqa: E731
    sol = fm.simulate(fm.Mechanism("bent", [rod(displacement=bend)]), t_end=1e-5, step=1e-5)
    fm.write_vtk(sol, tmp_path)
    first = sorted(tmp_path.rglob("*.vtu"))[0]
    points = meshio.read(first).points
    end = points[np.argmax(points[:, 0])]
    np.testing.assert_allclose(end[:2], [LENGTH, 0.05], atol=1e-9)


@pytest.mark.parametrize(
    ("field", "message"),
    [
        ({"velocity": [(0.0, 0.0, 0.0)] * 4}, "velocity has 4 entries, but the body has 5 nodes"),
        ({"velocity": [(0.0, 0.0, math.nan)] * 5}, r"velocity\[0\]\[2\] is nan; it must be finite in rad/s"),
        ({"velocity": lambda s: (s, 1.0)}, r"the function returns \(0.0, 1.0\) at s = 0; it must be \(vx, vy, omega\)"),
        ({"velocity": lambda s: s}, "the function returns 0.0 at s = 0"),
        ({"velocity": "fast"}, "velocity is 'fast'"),
        ({"velocity": (1.0, 2.0)}, r"velocity is \(1.0, 2.0\); it must be \(vx, vy, omega\)"),
        ({"displacement": (0.0, 0.1, 0.0)}, "displacement has 3 entries, but the body has 5 nodes"),
        ({"displacement": [(0.0, 0.1)] * 5}, r"entry 0 is \(0.0, 0.1\); it must be \(dx, dy, dtheta\)"),
        ({"displacement": 3.0}, "displacement is 3.0; it must be a list of"),
        ({"displacement": lambda s: (0.0, math.inf * (s > 0.3), 0.0)}, "it must be finite"),
    ],
)
def test_fields_that_do_not_fit_are_refused(field, message):
    with pytest.raises(InputError, match=message) as caught:
        rod(**field)
    assert str(caught.value).startswith("FlexibleLink 'rod'")


@pytest.mark.parametrize("field", [[(0.0, 0.0, 0.0)] * 3, wave])
def test_rigid_bodies_have_no_fields(field):
    with pytest.raises(InputError, match=r"RigidLink 'rod': velocity(\[0\])? is"):
        fm.RigidLink("rod", (0.0, 0.0), (1.0, 0.0), 1.0, 0.1, velocity=field)
    with pytest.raises(InputError, match=r"RigidBody 'rod': velocity(\[0\])? is"):
        fm.RigidBody("rod", (0.0, 0.0), 1.0, 0.1, velocity=field)
