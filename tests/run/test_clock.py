"""The time that a run tells."""

import time

import flexmb as fm
from flexmb.engine.compiled.notice import notice
from flexmb.engine.newmark.method import NewmarkStepper


def test_the_clock_of_a_run_stands_while_something_is_compiled(monkeypatch):
    advance, waits = NewmarkStepper.advance, []

    def slow(self, *arguments):
        with notice.compiling("law"):
            time.sleep(0.3)
        waits.append(None)
        return advance(self, *arguments)

    body = fm.RigidBody("body", (0.0, 0.0), 1.0, 1.0, velocity=(1.0, 0.0, 0.0))
    fm.simulate(fm.Mechanism("flight", [body]), t_end=0.1)
    monkeypatch.setattr(NewmarkStepper, "advance", slow)
    sol = fm.simulate(fm.Mechanism("flight", [body]), t_end=0.1)
    assert waits
    assert sol.stats.wall_time < 0.3 * len(waits)
