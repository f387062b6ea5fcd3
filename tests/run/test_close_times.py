"""Saved times that lie close together."""

import flexmb as fm


def test_two_close_times_ask_for_no_more_memory_than_they_fill():
    times = [0.001, 0.001 + 1e-10, 0.01]
    sol = fm.simulate(fm.mechanisms.slider_crank(), t_end=0.01, save=times)
    assert sol.ok, sol.status
    assert sol.time.tolist() == times
