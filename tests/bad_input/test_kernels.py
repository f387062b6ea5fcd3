"""Users' kernels that do not keep their contract are refused before a run, with the name of part and kernel."""

from dataclasses import dataclass

import numpy as np
import pytest

import flexmb as fm
from flexmb.elastic.beams.corotational import beam_kernel
from flexmb.errors import InputError, KernelError
from flexmb.parts.bodies.rigid import node_mass_kernel

O, A = (0.0, 0.0), (0.2, 0.0)
CRANK = fm.RigidLink("crank", O, A, mass=0.5, inertia=2e-3)


@fm.element_kernel
def unpacks_two(p, t, h, q, v, a, z, r, K, C, M, z_new):
    k, d = p
    r[0] = k * q[0] + d * v[0]


@fm.element_kernel
def gives_nan(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = np.log(-p[0])


@fm.element_kernel
def divides_by_zero(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = 1.0 / h


@fm.element_kernel
def reaches_too_far(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[1] = p[0]


@fm.element_kernel
def misspelt(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = stiffness * q[0]  # noqa: F821 - the mistake under test


@fm.element_kernel
def cannot_be_compiled(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = p[0] * float({"k": 1.0}.get(str(t), 0.0) if isinstance(t, object) else len(globals()))


def holding(kernel):
    """A mechanism with an element 'own' of that kernel with one parameter."""

    @dataclass(frozen=True)
    class Own(fm.Element):
        body: fm.Part
        k: float

        coords = ("body.theta",)

    Own.kernel = kernel
    pin = fm.Revolute("O", fm.GROUND, CRANK, at=O)
    return fm.Mechanism("m", [CRANK, pin, Own("own", CRANK, 20.0)])


@pytest.mark.parametrize("kernel", [beam_kernel, node_mass_kernel], ids=lambda kernel: kernel.name)
def test_a_kernel_of_the_package_for_more_coordinates_is_refused(kernel):
    """These are called compiled, where nobody counts: numbers behind their arrays are not finite, and watched."""
    with pytest.raises(
        KernelError, match=f"Part 'own': element kernel '{kernel.name}' (writes beyond|gives values|failed with 1 par)"
    ):
        fm.compile(holding(kernel))


@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")
@pytest.mark.parametrize(
    ("kernel", "message"),
    [
        (
            unpacks_two,
            r"failed with 1 parameters p = \(20\).*not enough values.*must unpack as many numbers as its class",
        ),
        (gives_nan, r"gives values that are not finite for p = \(20\); check its numbers"),
        (
            divides_by_zero,
            r"failed in the reference configuration, at rest, with p = \(20\): ZeroDivisionError.*also for t = h = 0",
        ),
        (reaches_too_far, r"failed with 1 parameters.*index 1 is out of bounds"),
        (misspelt, r"failed in the reference configuration.*NameError: name 'stiffness' is not defined"),
    ],
    ids=lambda x: x.name if isinstance(x, fm.kernels.Kernel) else "",
)
def test_refused_when_packed(kernel, message):
    with pytest.raises(KernelError, match=f"Part 'own': element kernel '{kernel.name}' {message}"):
        fm.compile(holding(kernel))


def test_kernel_that_numba_cannot_compile():
    with pytest.raises(KernelError, match="Kernel 'cannot_be_compiled' cannot be compiled as element"):
        fm.simulate(holding(cannot_be_compiled), t_end=0.01, step=1e-3)


def test_kernel_with_a_wrong_number_of_arguments():
    with pytest.raises(
        KernelError, match=r"too_short' takes 2 parameters; the element contract has 12: \(p, t, h, q, v"
    ):

        @fm.element_kernel
        def too_short(p, t):
            return None


def test_law_with_a_kernel_of_another_contract():
    with pytest.raises(
        KernelError, match=r"Wrong.kernel is <element kernel unpacks_two>; it must be .* a normal kernel"
    ):

        @dataclass(frozen=True)
        class Wrong(fm.NormalLaw):
            kernel = unpacks_two


def test_law_with_a_plain_function():
    with pytest.raises(KernelError, match="it must be a function decorated as a motion kernel"):

        @dataclass(frozen=True)
        class Plain(fm.Motion):
            kernel = len


@fm.normal_law
def two_results(p, h, gap, gap_rate, z, z_new):
    return 0.0, 0.0


@dataclass(frozen=True)
class TwoResults(fm.NormalLaw):
    kernel = two_results


@fm.drive_kernel
def no_result(p, t):
    s = p[0] * t  # noqa: F841 - forgotten in the return


@dataclass(frozen=True)
class NoResult(fm.Motion):
    k: float = 1.0
    kernel = no_result


def test_law_with_too_few_results():
    play = fm.RevoluteClearance(
        "play", fm.GROUND, CRANK, at=O, clearance=1e-4, bearing_radius=5e-3, normal=TwoResults()
    )
    with pytest.raises(KernelError, match=r"Part 'play': TwoResults returned \(0.0, 0.0\); it must return 3 numbers"):
        fm.compile(fm.Mechanism("m", [CRANK, play]))


def test_motion_without_a_result():
    parts = [CRANK, fm.Revolute("O", fm.GROUND, CRANK, at=O), fm.Drive("motor", "O", NoResult())]
    with pytest.raises(KernelError, match="Part 'motor': NoResult returned None; it must return 3 numbers"):
        fm.compile(fm.Mechanism("m", parts))


@fm.element_kernel
def sound(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = p[0] * q[0]
    K[0, 0] = p[0]


@pytest.mark.parametrize(
    ("coords", "message"),
    [
        (("arm.theta",), r"coords entry 'arm.theta' must read FIELD.AXIS or FIELD.NODE.AXIS with FIELD in \['body'\]"),
        (("body.z",), "coords entry 'body.z' must read FIELD.AXIS"),
        (("body.tip.x",), "RigidLink 'crank' has no node 'tip'"),
    ],
)
def test_coordinate_that_is_not_there(coords, message):
    mechanism = holding(sound)
    type(mechanism.find("own")).coords = coords
    with pytest.raises(InputError, match=message):
        fm.compile(mechanism)
