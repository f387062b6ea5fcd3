"""Objects show themselves in a few lines, and in notebooks as escaped tables."""

import dataclasses
import html.parser
import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from published import simeon
from spin_up import spinning_beam

import flexmb as fm
from flexmb import display as text
from flexmb import mechanisms
from flexmb.model.signal import Signal
from flexmb.results.contact_intervals import Episode
from flexmb.results.solution import Peak, Peaks

handmade = runpy.run_path(str(Path(__file__).parents[1] / "handmade.py"))
READY = [
    mechanisms.nine_bar(clearance=5e-4, flexible=True),
    mechanisms.slider_crank(clearance=1e-4),
    mechanisms.four_bar(),
    simeon(),
    spinning_beam(),
]
LONGEST_LINE = 110


class Reader(html.parser.HTMLParser):
    """Text and open tags of HTML; tags that are closed in another order are an error."""

    ALONE = ("br", "hr")

    def __init__(self, source):
        super().__init__()
        self.text, self.open, self.tags = "", [], []
        self.feed(source)
        assert not self.open, f"not closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        if tag not in self.ALONE:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def cantilever():
    rod = fm.FlexibleLink("rod", (0, 0), (1, 0), section=fm.Rectangle(0.01, 0.02), material=fm.STEEL, elements=2)
    wall = fm.Fixed("wall", fm.GROUND, rod, at=(0, 0))
    return fm.Mechanism("beam", [rod, wall, fm.Force("F", rod, (1, 0), (0.0, -10.0))])


@pytest.mark.parametrize("mech", READY, ids=lambda mech: mech.name)
def test_every_part_fits_into_three_lines_and_names_its_neighbours(mech):
    for part in mech.parts:
        lines = repr(part).splitlines()
        assert len(lines) <= 3
        assert max(map(len, lines)) <= LONGEST_LINE
        assert "object at 0x" not in repr(part)
        others = {name: mech.find(name) for name in part.references() if name != "ground"}
        for name, other in others.items():
            assert repr(name) in repr(part)
            assert type(other).__name__ + "(" not in repr(part)
        assert part.name in Reader(part._repr_html_()).text


@pytest.mark.parametrize("mech", READY, ids=lambda mech: mech.name)
def test_a_mechanism_fits_into_three_lines(mech):
    lines = repr(mech).splitlines()
    assert len(lines) <= 3
    assert max(map(len, lines)) <= LONGEST_LINE
    shown = Reader(mech._repr_html_()).text
    assert all(name in shown for name in mech.names)


def test_defaults_are_left_out_and_given_fields_are_not():
    rod = fm.RigidLink("rod", (0, 0), (0.1, 0), mass=0.1 + 0.2, inertia=1e-4)
    assert repr(rod) == "RigidLink('rod', start=(0, 0), end=(0.1, 0), mass=0.3, inertia=0.0001)"
    pin = fm.Revolute("O", fm.GROUND, rod, at=(0, 0))
    assert repr(pin) == "Revolute('O', first='ground', second='rod', at=(0, 0))"
    worn = dataclasses.replace(pin, friction=fm.friction.LuGre(0.15, 0.1), radius=0.01)
    assert "friction=LuGre(static=0.15, kinetic=0.1), radius=0.01" in repr(worn)
    assert repr(dataclasses.replace(worn, friction=None, radius=None)) == repr(pin)


def test_a_record_of_many_numbers_tells_how_many():
    t = tuple(np.linspace(0.0, 1.0, 50))
    assert repr(fm.drives.Table(t, t)) == "Table(times=(50 values), values=(50 values))"


def test_parts_of_users_show_themselves_in_the_same_way():
    @fm.model.record
    class Sled(fm.Part):
        """A sled."""

        body: fm.Part = fm.model.field("a body")
        stiffness: float = fm.model.field("stiffness", "N/m", default=1e3)
        table: tuple[float, ...] = ()

        def contributions(self, mechanism):
            return ()

    sled = Sled("sled", fm.GROUND, stiffness=2.5e4, table=tuple(map(float, range(99))))
    assert repr(sled) == "Sled('sled', body='ground', stiffness=25000, table=(99 values))"
    assert "N/m" in Reader(sled._repr_html_()).text

    @dataclasses.dataclass(frozen=True)
    class Own(Sled):
        def __repr__(self):
            return "mine"

    assert repr(Own("sled", fm.GROUND)) == "mine"


def test_names_are_escaped_in_html():
    name = "<script>alert('&')<"
    body = fm.RigidBody(name, at=(0, 0), mass=1.0, inertia=1.0)
    for shown in (body, fm.Mechanism("<b>", [body])):
        reader = Reader(shown._repr_html_())
        assert name in reader.text
        assert "script" not in reader.tags
    sol = handmade["solution"](model={"name": "<i>&"}, status="t < 1 & more", notes=("<u>",))
    reader = Reader(sol._repr_html_())
    assert all(word in reader.text for word in ("<i>&", "t < 1 & more", "<u>"))
    assert "i" not in reader.tags


def test_html_has_no_colours_of_its_own():
    """Lines and texts have the colour of the page, be it light or dark."""
    for shown in (READY[0], handmade["solution"](), READY[0].parts[0]):
        source = re.sub(
            "<iframe .*?</iframe>", "", shown._repr_html_(), flags=re.DOTALL
        )  # a player is a page of its own
        source = source.replace("color: inherit", "")
        assert "color" not in source
        assert "background" not in source


def test_a_solution_tells_status_span_cost_and_main_peaks():
    sol = handmade["solution"](notes=("first", "second"))
    lines = repr(sol).splitlines()
    assert lines[0] == "Solution of 'handmade': Reached t = 1 s."
    assert lines[1] == "  101 instants, 0 to 1 s; 17 signals of 3 parts; 2000 steps in 0.25 s on the clock"
    assert lines[2] == "  largest P.normal_force 100 N; 2 notes in sol.notes"
    shown = Reader(sol._repr_html_()).text
    assert all(word in shown for word in ("P.normal_force", "0.25", "first", "second", "crank", "2000 steps"))


def test_peaks_that_are_round_off_are_left_out():
    """A torque of 1e-17 N m beside energies of joules, a deflection of 1e-16 m beside travels of decimetres."""
    names = [
        ("arm.x", "m"),
        ("rod.deflection", "m"),
        ("motor.torque", "N m"),
        ("energy.kinetic", "J"),
        ("P.force", "N"),
    ]

    def largest(*values):
        signals = [Signal(name, unit) for name, unit in names]
        peaks = Peaks(np.array(values), np.zeros(5))
        return handmade["solution"](
            values=np.zeros((101, 5)), signals=tuple(signals), peaks=peaks, shapes=(), aliases={}
        )

    assert "largest motor.torque 3 N m" in repr(largest(0.3, 1e-16, 3.0, 2.0, 1e-14))
    assert "deflection" not in repr(largest(0.3, 1e-16, 3.0, 2.0, 1e-14))
    assert "largest P.force 5 N" in repr(largest(0.3, 1e-16, 1e-17, 2.0, 5.0))
    assert "largest" not in repr(largest(0.3, 1e-16, 1e-17, 2.0, 1e-15))
    assert "largest motor.torque nan" in repr(largest(0.3, 1e-16, np.nan, 2.0, 1e-15))


def test_peaks_episodes_curves_and_driven_motions():
    sol = handmade["solution"]()
    assert repr(sol.peak("P.normal_force")) == "Peak(value=100, time=0.25)"
    moments = {"value": 1.0 / 3.0, "time": np.float64(0.1) + 0.2}
    assert repr(Peak(**moments)) == "Peak(value=0.33333333, time=0.3)"
    numbers = dict.fromkeys([field.name for field in dataclasses.fields(Episode)][3:], 0.1 + 0.2)
    hit = Episode(contact="P", mode=1, start=0.1, **numbers)
    turns = np.linspace(0.0, 2.0 * np.pi, 91)[:-1]
    disc = fm.ClosedCurve(np.column_stack([0.03 * np.cos(turns), 0.03 * np.sin(turns)]))
    assert repr(disc) == "ClosedCurve(90 points, 0.06 m wide, 0.188496 m long)"
    driven = fm.inverse_dynamics(mechanisms.slider_crank(speed=10.0), np.linspace(0.0, 0.1, 5))
    assert repr(driven).startswith("Driven motion: 5 instants, 0 to 0.1 s; 9 coordinates; forces of O, ")
    for shown, word in ((hit, "approach_speed"), (disc, "curvature"), (driven, "motor")):
        lines = repr(shown).splitlines()
        assert len(lines) <= 3
        assert max(map(len, lines)) <= LONGEST_LINE
        assert word in Reader(shown._repr_html_()).text


def test_names_in_brackets_are_completed():
    sol, mech = handmade["solution"](), READY[1]
    assert set(sol.names) <= set(sol._ipython_key_completions_())
    assert all(name in sol for name in sol._ipython_key_completions_())
    assert "arm.end.x" in sol._ipython_key_completions_()
    assert mech._ipython_key_completions_() == list(mech) == list(mech.names)


def test_parts_are_found_in_brackets():
    mech = READY[1]
    assert mech["crank"] is mech.find("crank")
    assert "crank" in mech
    assert "ground" not in mech
    assert 3 not in mech
    with pytest.raises(KeyError, match="Did you mean 'crank'"):
        mech["crnk"]
    with pytest.raises(fm.errors.ModelError):
        mech["crnk"]


def test_results_of_statics_and_modes():
    mech = cantilever()
    found, modes = fm.static_equilibrium(mech), fm.modes(mech, count=3)
    assert repr(found).splitlines()[0].startswith("Equilibrium (stable): 9 coordinates")
    assert "wall 10 N" in repr(found)
    # first bending frequency of a cantilever: (1.8751)^2 / (2 pi) sqrt(EI/(rho A)) / L^2, I = b h^3 / 12
    assert repr(modes).startswith("Modes: 3; ")
    first = float(repr(modes).split()[2].rstrip(","))
    assert first == pytest.approx(1.8751**2 / (2 * np.pi) * np.sqrt(207e9 * 0.02**2 / 12 / 7801.0), rel=2e-3)
    for shown in (found, modes, fm.buckling(mech)):
        assert "\n\n" not in repr(shown)
        assert len(repr(shown).splitlines()) <= 3
        assert Reader(shown._repr_html_()).text


def test_a_compiled_mechanism_and_a_report():
    mech = READY[2]
    program, report = fm.compile(mech), fm.check(mech)
    assert repr(program).startswith("Program of 'four-bar': 3 bodies, 9 coordinates, 9 constraint rows, 0 contacts")
    assert repr(report).startswith("Report on 'four-bar': ")
    assert len(repr(report).splitlines()) == 1
    for shown in (program, report):
        assert "four-bar" in Reader(shown._repr_html_()).text


def test_exponents_and_verdicts():
    numbers = {"a": 1.4, "b": 0.3}
    henon = fm.chaos.Map(lambda x, a, b: [1.0 - a * x[0] ** 2 + x[1], b * x[0]], [0.1, 0.1], parameters=numbers)
    assert repr(henon).endswith("2 signals, at 0 iterations")
    found = fm.lyapunov(henon, skip=100, periods=500)
    assert len(repr(found).splitlines()) <= 3
    assert repr(found.verdict).startswith(f"Verdict: {found.verdict}. ")
    for shown in (found, found.verdict):
        assert str(found.verdict) in Reader(shown._repr_html_()).text


@pytest.mark.parametrize(
    ("number", "noun", "shown"), [(1, "body", "1 body"), (3, "body", "3 bodies"), (0, "joint", "0 joints")]
)
def test_nouns_are_counted(number, noun, shown):
    assert text.counted(number, noun) == shown
