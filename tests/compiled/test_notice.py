"""What the user is told while functions are compiled."""

import io
import time
from functools import partial
from types import FunctionType, SimpleNamespace

import pytest

from flexmb.engine.compiled import notice
from flexmb.engine.compiled.notice import FIRST_STAGE, STAGES

EVALUATE, ADVANCE = "flexmb.engine.system.evaluate.evaluate", "flexmb.engine.newmark.method.advance"


class Screen(io.StringIO):
    """Stands for stderr."""

    terminal = False

    def isatty(self):
        return self.terminal


@pytest.fixture
def screen(monkeypatch):
    found = Screen()
    monkeypatch.setenv("FLEXMB_MESSAGES", "1")
    monkeypatch.setattr(notice, "sys", SimpleNamespace(stderr=found, modules={}))
    monkeypatch.setattr(notice, "caches", {})
    monkeypatch.setattr(notice, "pace", lambda: (1.0, 1.0))
    return found


def compiled(told, *names, within=()):
    """Let `told` hear of functions that are compiled, the first one while those of `within` are."""
    for name in names:
        event = SimpleNamespace(data={"dispatcher": SimpleNamespace(py_func=function(name))})
        told.on_start(event)
        if within:
            compiled(told, *within)
        told.on_end(event)


def function(name):
    module, _, own = name.rpartition(".")
    return SimpleNamespace(__module__=module, __qualname__=own)


def stage_of(name):
    return next(stage for stage, costs in STAGES.items() if name in costs)


def test_beginning_and_end_are_said(screen):
    told = notice.Notice()
    compiled(told, EVALUATE)
    about = sum(STAGES[FIRST_STAGE].values())
    assert screen.getvalue() == f"flexmb compiles {FIRST_STAGE} for this machine: about {about:.0f} s, once.\n"
    told.close()
    told.close()
    assert screen.getvalue().splitlines()[1:] == ["flexmb: done in 0 s."]


def test_a_stage_is_said_once_however_many_functions_it_has(screen):
    told = notice.Notice()
    compiled(told, *STAGES[FIRST_STAGE], within=["numpy.something"])
    assert screen.getvalue().count("\n") == 1


def test_functions_without_a_module_are_none_of_ours(screen):
    """Code without a file, functions of C and partial objects: no notice, and no failure."""
    told = notice.Notice()
    plain = FunctionType((lambda x: x).__code__, {})
    plain.__module__ = None
    for one in (plain, (1).__add__, partial(int, base=2)):
        event = SimpleNamespace(data={"dispatcher": SimpleNamespace(py_func=one)})
        told.on_start(event)
        told.on_end(event)
    assert not screen.getvalue()
    assert told.seconds == 0.0


def test_the_next_stage_ends_the_one_before(screen):
    told = notice.Notice()
    compiled(told, "flexmb.parts.joints.revolute.coincide", ADVANCE)
    told.close()
    begun, done, then, end = screen.getvalue().splitlines()
    assert FIRST_STAGE in begun
    assert stage_of(ADVANCE) in then
    assert done == end == "flexmb: done in 0 s."


def test_the_end_is_said_without_being_asked_for(screen, monkeypatch):
    monkeypatch.setattr(notice, "QUIET_SECONDS", 0.0)
    told = notice.Notice()
    compiled(told, EVALUATE)
    for thread in notice.threading.enumerate():
        if thread.daemon and getattr(thread, "_target", None) == told._watch:
            thread.join(5.0)
    assert screen.getvalue().endswith("done in 0 s.\n")


def test_a_kernel_belongs_to_the_stage_that_is_to_come(screen):
    told = notice.Notice()
    compiled(told, "flexmb.parts.drives.motions.ramp_kernel", EVALUATE)
    assert screen.getvalue().count("\n") == 1


def test_what_is_kept_does_not_count(screen):
    kept = SimpleNamespace(there=lambda: True)
    notice.caches.update(dict.fromkeys(STAGES[FIRST_STAGE], kept))
    told = notice.Notice()
    compiled(told, "flexmb.parts.drives.motions.ramp_kernel")
    assert screen.getvalue() == ""
    name = max(STAGES[FIRST_STAGE], key=STAGES[FIRST_STAGE].get)
    del notice.caches[name]
    assert notice.expected(FIRST_STAGE) == STAGES[FIRST_STAGE][name]


def test_a_slow_machine_takes_longer(screen, monkeypatch):
    monkeypatch.setattr(notice, "pace", lambda: (3.0, 1.1))
    compiled(notice.Notice(), EVALUATE)
    assert f"about {3.3 * sum(STAGES[FIRST_STAGE].values()):.0f} s" in screen.getvalue()


def test_other_work_makes_a_range(screen, monkeypatch):
    monkeypatch.setattr(notice, "pace", lambda: (0.5, 4.0))
    compiled(notice.Notice(), EVALUATE)
    cost = sum(STAGES[FIRST_STAGE].values())
    assert f"about {0.5 * cost:.0f} to {2.0 * cost:.0f} s, once" in screen.getvalue()


def test_what_a_stage_took_is_the_pace_of_the_next(screen, monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(notice.time, "perf_counter", lambda: clock[0])
    told = notice.Notice()
    compiled(told, "flexmb.parts.drives.motions.ramp_kernel")
    clock[0] = 2.0 * sum(STAGES[FIRST_STAGE].values())
    compiled(told, EVALUATE, ADVANCE)
    cost = STAGES[stage_of(ADVANCE)][ADVANCE]
    assert f"about {cost:.0f} to {2.0 * cost:.0f} s" in screen.getvalue()


def test_the_pace_is_measured():
    alone, beside = notice.pace.__wrapped__()
    assert 0.02 < alone < 50.0
    assert 1.0 <= beside < 1000.0


def test_waiting_for_others_is_no_slowness(monkeypatch):
    """A thread that has every fifth share of the clock: its processor time stays the same."""
    clock = [0.0]

    def compiling(*_):
        clock[0] += 1.0

    monkeypatch.setattr(notice, "compile", compiling, raising=False)
    times = {
        "perf_counter": lambda: 5.0 * notice.REFERENCE_PACE * clock[0],
        "thread_time": lambda: notice.REFERENCE_PACE * clock[0],
    }
    monkeypatch.setattr(notice, "time", SimpleNamespace(**times))
    assert notice.pace.__wrapped__() == pytest.approx((1.0, 5.0))


def test_functions_of_others_are_none_of_ours(screen):
    told = notice.Notice()
    compiled(told, "numpy.linalg.solve", "mine.advance")
    assert screen.getvalue() == ""


def test_a_users_function_is_named_where_it_takes_long(screen, monkeypatch):
    told = notice.Notice()
    with told.compiling("motor_curve"):
        compiled(told, "mine.law", "flexmb.kernels.copy")
    assert "motor_curve" not in screen.getvalue()
    monkeypatch.setattr(notice, "LEAST_SECONDS", 0.05)
    with told.compiling("motor_curve"):
        time.sleep(0.5)
    *lines, last = screen.getvalue().splitlines()  # those of stages of other tests may stand between them
    assert [line for line in lines if "compiles" in line] == [
        "flexmb compiles your function 'motor_curve' for this machine."
    ]
    assert last.startswith("flexmb: done in ")


def test_the_time_of_the_outermost_function_counts(screen, monkeypatch):
    clock = iter(range(100))
    monkeypatch.setattr(notice.time, "perf_counter", lambda: float(next(clock)))
    monkeypatch.setenv("FLEXMB_MESSAGES", "0")
    told = notice.Notice()
    compiled(told, EVALUATE, within=["numpy.a", "numpy.b"])  # enters at 0, inner ones end at 1 and 2, ends at 3
    assert told.seconds == 3.0
    compiled(told, "mine.law")
    assert told.seconds == 3.0


@pytest.mark.parametrize("how", ["switch", "worker", "no screen"])
def test_silence(screen, monkeypatch, how):
    if how == "switch":
        monkeypatch.setenv("FLEXMB_MESSAGES", "0")
    elif how == "worker":
        monkeypatch.setattr(notice.multiprocessing, "parent_process", lambda: "another")
        monkeypatch.setattr(notice.multiprocessing, "current_process", lambda: SimpleNamespace(name="SpawnProcess-2"))
    else:
        monkeypatch.setattr(notice.sys, "stderr", None)
    told = notice.Notice()
    compiled(told, EVALUATE)
    told.close()
    notice.say("something")
    assert screen.getvalue() == ""


def test_the_first_worker_speaks_for_all(screen, monkeypatch):
    monkeypatch.setattr(notice.multiprocessing, "parent_process", lambda: "another")
    monkeypatch.setattr(notice.multiprocessing, "current_process", lambda: SimpleNamespace(name="SpawnProcess-1"))
    assert notice.is_told()


def test_a_terminal_counts_the_seconds(screen):
    screen.terminal = True
    told = notice.Notice()
    compiled(told, EVALUATE)
    assert screen.getvalue().startswith("\rflexmb compiles")
    assert "\n" not in screen.getvalue()
    told.close()
    assert screen.getvalue().endswith("\nflexmb: done in 0 s.\n")


def test_a_line_goes_above_a_bar(screen):
    above = []
    tqdm = SimpleNamespace(_instances=["a bar"], write=lambda text, file: above.append((text, file)))
    notice.sys.modules["tqdm"] = SimpleNamespace(tqdm=tqdm)
    notice.say("something")
    assert above == [("flexmb: something", screen)]


def test_every_stage_has_names_of_functions_that_are_there():
    from importlib import import_module

    for costs in STAGES.values():
        for name in costs:
            module, _, own = name.rpartition(".")
            assert getattr(import_module(module), own).py_func.__qualname__ == own
