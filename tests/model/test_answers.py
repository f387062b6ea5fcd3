"""What a part says of itself: findings, former remarks, and methods that fail."""

from typing import TYPE_CHECKING, Annotated

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError
from flexmb.fields import unit_of

if TYPE_CHECKING:
    from flexmb import Mechanism as Made

FINDING = fm.doctor.Finding


class Speaking(fm.RigidBody):
    answer = None

    def findings_after(self, mechanism, motion):
        return self.answer()


def boom():
    raise ValueError("boom")


def run_of(answer=None, kind=Speaking):
    body = kind("stone", (0.0, 0.0), 1.0, 0.1)
    if answer is not None:
        type(body).answer = staticmethod(answer)
    return fm.simulate(fm.Mechanism("m", [body], gravity=(0.0, -9.81)), t_end=0.01, step=1e-3)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (boom, "ValueError: boom"),
        (lambda: ["a text"], "it gives 'a text', which is no Finding"),
        (lambda: None, "TypeError: 'NoneType' object is not iterable"),
    ],
)
def test_a_method_that_fails_is_told_and_loses_nothing(answer, words):
    sol = run_of(answer)
    assert sol.ok
    assert len(sol.time) > 1
    (note,) = sol.notes
    assert note.startswith("Speaking 'stone': findings_after failed: ")
    assert words in note


def test_numbers_of_a_finding_are_written(tmp_path):
    sol = run_of(lambda: [FINDING("mine", ["stone"], "Mine.", "", "warning", {"y": np.int64(3)})])
    sol.to_netcdf(tmp_path / "mine.nc")
    assert fm.load(tmp_path / "mine.nc").findings == sol.findings
    with pytest.raises(InputError, match="severity is 'Error'"):
        FINDING("mine", (), "Mine.", "", "Error")


def test_former_remarks_are_heard_once_more():
    class Former(fm.RigidBody):
        def remarks(self, mechanism, motion):
            yield f"{self.label} moved until {motion.times[-1]:g} s."

    with pytest.warns(DeprecationWarning, match="remarks is called findings_after now") as told:
        assert run_of(kind=Former).notes == ("Former 'stone' moved until 0.01 s.",)
    assert [warning.filename for warning in told] == [__file__]


def test_a_part_may_have_fields_of_any_plain_name():
    class Own(fm.RigidLink):
        tips, whole = 3, 5

    link = Own("bar", (0.0, 0.0), (1.0, 0.0), mass=1.0, inertia=0.1)
    pin = fm.Revolute("pin", fm.GROUND, link, at=(0.0, 0.0))
    assert fm.check(fm.Mechanism("m", [link, pin], gravity=(0.0, -9.81))).ok


def test_a_name_for_type_checking_hides_no_unit():
    def made(length: 'Annotated[float, "m"]' = 1.0) -> "Made":
        raise NotImplementedError(length)

    assert unit_of(made, "length") == "m"
    assert unit_of(made, "width") == ""
