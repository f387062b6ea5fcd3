"""Compiled steps hold no lock of Python: other threads go on while a run steps."""

import time
from concurrent.futures import ThreadPoolExecutor

import flexmb as fm


def test_another_thread_goes_on_while_a_run_steps():
    """The waking of a sleeping thread needs the lock; a run that held it would let it wake once a block of 0.2 s."""
    mechanism, step = fm.mechanisms.slider_crank(clearance=0.5e-3), fm.FixedStep(1e-6)
    fm.simulate(mechanism, t_end=1e-4, step=step)
    wakings, began = 0, time.process_time()
    with ThreadPoolExecutor(1) as pool:
        run = pool.submit(fm.simulate, mechanism, t_end=0.4, step=step, save=3)
        while not run.done():
            time.sleep(1e-3)
            wakings += 1
    took = time.process_time() - began
    assert run.result().ok
    assert took > 0.5
    assert wakings / took > 50.0
