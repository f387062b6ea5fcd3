"""The record of episodes: arrays by name, single ones, tables, labels, what does not fit together."""

import pickle
import runpy
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import flexmb as fm
from flexmb.errors import InputError
from flexmb.results.contact_intervals import COLUMNS, ContactLog, impacts

handmade = runpy.run_path(str(Path(__file__).with_name("handmade.py")))
solution = handmade["solution"]

NAN = float("nan")
NAMES = ("P", "G.front", "G.rear")
ROWS = np.array(
    # contact, mode, end, separation, start, approach, impulse, force, depth, lost, lost by friction; as they ended
    [
        [1, 1, 0.20, 0.5, 0.10, 1.0, 3.0, 90.0, 1e-5, 0.4, 0.1],
        [0, 1, 0.30, 0.4, 0.25, 0.8, 2.0, 80.0, 2e-5, 0.3, 0.0],
        [2, 2, 0.50, 0.2, 0.15, 0.0, 5.0, 70.0, 3e-5, 0.2, 0.0],
        [1, 1, 0.80, 0.3, 0.70, 0.6, 1.0, 60.0, 4e-5, 0.1, 0.0],
        [0, 2, NAN, NAN, 0.90, 0.7, 0.5, 50.0, 5e-5, 0.0, 0.0],
    ]
)


@pytest.fixture
def sol():
    return solution(contacts=ContactLog(NAMES, ROWS))


def test_arrays_of_a_joint_and_of_a_contact(sol):
    e = sol.episodes("P")
    assert len(e) == 2
    np.testing.assert_array_equal(e.start, [0.25, 0.9])
    np.testing.assert_array_equal(e.end, [0.3, NAN])
    np.testing.assert_array_equal(e.mode, [1, 2])
    np.testing.assert_allclose(e.duration, [0.05, NAN])
    np.testing.assert_allclose(e.restitution, [0.5, NAN])
    np.testing.assert_allclose(e.flight, [NAN, 0.6])
    assert sol.episodes("G.rear").impulse.tolist() == [5.0]


def test_contacts_of_a_joint_are_merged_in_time(sol):
    """The rear touches before the front has parted, so only the last episode follows a flight of both."""
    e = sol.episodes("G")
    assert e.contact.tolist() == ["G.front", "G.rear", "G.front"]
    np.testing.assert_array_equal(e.start, [0.1, 0.15, 0.7])
    np.testing.assert_allclose(e.flight, [NAN, 0.0, 0.2])
    assert np.isnan(e.restitution[1]), "it began without an approach"
    assert sol.episodes().contact.tolist() == ["G.front", "G.rear", "P", "G.front", "P"]


def test_one_and_some(sol):
    e = sol.episodes("G")
    last = e[-1]
    assert isinstance(last, fm.results.Episode)
    assert (last.contact, last.mode, last.start, last.end) == ("G.front", 1, 0.7, 0.8)
    assert last.duration == pytest.approx(0.1)
    assert last.restitution == pytest.approx(0.5)
    assert [one.impulse for one in e] == [3.0, 5.0, 1.0]
    hits = e[e.mode == 1]
    assert isinstance(hits, fm.results.Episodes)
    assert hits.peak_force.tolist() == [90.0, 60.0]
    assert e[1:].name == "G"
    with pytest.raises(IndexError):
        e[3]


def test_a_dataset_with_units(sol):
    data = sol.episodes("G").to_dataset()
    assert isinstance(data, xr.Dataset)
    assert data.sizes == {"episode": 3}
    units = {"start": "s", "approach_speed": "m/s", "impulse": "N s", "peak_force": "N", "peak_penetration": "m"}
    assert {name: data[name].attrs["units"] for name in units} == units
    assert data["dissipated_friction"].attrs["units"] == "J"
    assert data["contact"].values.tolist() == ["G.front", "G.rear", "G.front"]
    assert data["mode"].attrs == {"flag_values": [1, 2], "flag_meanings": "impact continuous"}


def test_printing_shows_a_table(sol):
    lines = repr(sol.episodes("P")).splitlines()
    assert lines[0] == "2 episodes of contact of 'P'"
    assert lines[1].split() == "contact mode start end approach separation impulse force depth lost friction".split()
    assert (
        lines[2].split() == "[s] [s] [m/s] [m/s] [N s] [N] [m] [J] [J]".replace("N s", "N#s").replace("#", " ").split()
    )
    assert lines[3].split() == "P impact 0.25 0.3 0.8 0.4 2 80 2e-05 0.3 0".split()
    assert lines[4].split() == "P continuous 0.9 nan 0.7 nan 0.5 50 5e-05 0 0".split()
    assert len({len(line) for line in lines[1:]}) == 1, "columns stand below one another"


def test_a_long_table_leaves_its_middle_out():
    many = np.tile(ROWS[1], (100, 1))
    many[:, 4] = np.arange(100.0)
    lines = repr(solution(contacts=ContactLog(("P",), many)).episodes("P")).splitlines()
    assert len(lines) == 3 + 21
    assert lines[13] == "... 80 more"
    assert (lines[12].split()[2], lines[14].split()[2]) == ("9", "90")


def test_unknown_names(sol):
    with pytest.raises(KeyError, match=r"'handmade' has no contact 'G.frnt'. Did you mean 'G.front'\? Known: P, G, G"):
        sol.episodes("G.frnt")
    with pytest.raises(InputError, match="no contact 3"):
        sol.episodes(3)
    with pytest.raises(InputError, match="no contact ''"):
        sol.episodes("")


def test_nothing_can_be_changed(sol):
    e = sol.episodes("P")
    with pytest.raises(AttributeError):
        e.name = "Q"
    for array in (e.start, sol.contacts.rows):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    back = pickle.loads(pickle.dumps(sol))  # noqa: S301 - written in this line
    assert back.contacts.rows.tobytes() == sol.contacts.rows.tobytes()
    assert not back.contacts.rows.flags.writeable


@pytest.mark.parametrize(
    ("log", "words"),
    [
        (ContactLog(NAMES, ROWS[:, :5]), r"contacts.rows has shape \(5, 5\)"),
        (ContactLog(NAMES[:2], ROWS), "names a contact beyond the 2 of contacts.names"),
    ],
)
def test_what_does_not_fit_together(log, words):
    with pytest.raises(InputError, match=words):
        solution(contacts=log)
    e = solution(contacts=ContactLog(NAMES, ROWS)).episodes("P")
    with pytest.raises(InputError, match=r"'P': end has shape \(1,\)"):
        fm.results.Episodes(**{**vars(e), "end": [1.0]})


def test_a_solution_without_contacts_has_none():
    assert len(solution().episodes()) == 0
    assert len(ROWS[0]) == len(COLUMNS)


def test_words_of_the_summary(sol):
    assert impacts(sol.episodes("P")) == "1 and 1 continuous contact, largest impulse 2 N s, longest flight 0.6 s"
    assert impacts(sol.episodes("G.rear")) == "0 and 1 continuous contact"
    assert impacts(solution(contacts=ContactLog(("P",))).episodes("P")) == "0"
