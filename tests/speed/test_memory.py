"""A step allocates nothing: neither Python's memory nor numba's grows or is asked for while the compiled loop steps."""

import gc
import tracemalloc

import numba
import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys

import flexmb as fm
from flexmb.engine.newmark.method import advance
from flexmb.run.run import Run
from flexmb.statics.start.consistent import consistent_start

REPEATS = 5
NOISE = 256
"""Bytes by which the peaks of two calls may differ: a call unpacks its arguments.  Thousand steps ask for no more."""


def memory(call, steps):
    """Least peak of Python's memory [bytes], and least number of allocations by numba, of `call(steps)`.

    Least of several: an allocation of the loop is there every time, one by somebody else is not.  The garbage collector
    waits meanwhile, since what it throws away may ask for memory (finalisers of whatever ran before in this process).
    """
    peaks, asked = [], []
    gc.collect()
    gc.disable()
    try:
        for _ in range(REPEATS):
            before = rtsys.get_allocation_stats().alloc
            tracemalloc.start()
            call(steps)
            peaks.append(tracemalloc.get_traced_memory()[1])
            tracemalloc.stop()
            asked.append(rtsys.get_allocation_stats().alloc - before)
    finally:
        tracemalloc.stop()
        gc.enable()
    return min(peaks), min(asked)


def grows(call):
    """Whether 1000 steps ask for more memory than 10: (Python's, numba's)."""
    _nrt_python.memsys_enable_stats()
    call(10)
    few, many = memory(call, 10), memory(call, 1000)
    return many[0] > few[0] + NOISE, many[1] > few[1]


def hinged(*, flexible):
    """A pendulum on a worn pin, or one of beams."""
    if flexible:
        section, steel = fm.Rectangle(width=0.02, height=0.004), fm.Material(young=2.1e11, density=7850.0)
        rod = fm.FlexibleLink("rod", (0.0, 0.0), (0.4, 0.0), section=section, material=steel, elements=4)
        return fm.Mechanism("beam", (rod, fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0))), gravity=(0.0, -9.81))
    rod = fm.RigidLink("rod", (0.0, 0.0), (0.4, 0.0), mass=0.5, inertia=1e-3)
    law, friction = (
        fm.contact.ExactRestitution(stiffness=1e9, restitution=0.5),
        fm.friction.SmoothCoulomb(0.05, v0=1e-2),
    )
    options = {"clearance": 2e-4, "bearing_radius": 0.01, "normal": law, "friction": friction}
    pin = fm.RevoluteClearance("O", fm.GROUND, rod, at=(0.0, 0.0), **options)
    return fm.Mechanism("worn", (rod, pin), gravity=(0.0, -9.81))


@pytest.mark.parametrize("flexible", [False, True], ids=["worn pin", "beams"])
def test_a_step_allocates_nothing(flexible):
    mechanism = hinged(flexible=flexible)
    program = fm.compile(mechanism)
    run = Run(program, fm.Newmark.generalised_alpha(0.8), fm.FixedStep(1e-5), 1e3, None)
    run.begin(consistent_start(mechanism, program))
    run.flow.balance.residual_limit = run.stepper.residual_limit
    options = run.options(1e3, 1e300)
    arguments = (program.tables, program.addresses, run.lu, options, run.flow, run.trial, run.work, run.record)
    assert grows(lambda steps: advance(*arguments, steps)) == (False, False)
    assert run.record.count.steps == 10 + REPEATS * 1010, run.status()  # it did step


def test_an_allocation_in_compiled_code_is_seen():
    @numba.njit
    def loop(steps):
        total = 0.0
        for k in range(steps):
            total += np.full(3, float(k))[k % 3]
        return total

    assert grows(loop) == (False, True)


def test_an_allocation_of_python_is_seen():
    assert grows(lambda steps: [float(k) for k in range(steps)]) == (True, False)
