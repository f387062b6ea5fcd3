"""The live page in a browser: sliders, keys, panels, pins, link, layouts; silent console, no network."""

import json
import math
import time

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import nine_bar, slider_crank
from flexmb.show.live import page as messages

SIZES = [(1280, 800), (390, 844)]


def until(tab, condition):
    """Wait for a condition of the page, which forbids the evaluation of texts to its own scripts."""
    end = time.monotonic() + 60.0
    while not tab.evaluate(condition):
        assert time.monotonic() < end, condition
        tab.wait_for_timeout(20)


@pytest.fixture
def tab_of(browser):
    """Function that opens a live page, and fails on messages on the console and on requests to other places."""
    contexts, faults = [], []

    def opening(page, fragment="", width=1280, height=800, **options):
        context = browser.new_context(viewport={"width": width, "height": height}, **options)
        contexts.append(context)
        tab = context.new_page()
        home = page.url.partition("?")[0]
        tab.on("console", lambda said: faults.append(said.text) if said.type in ("error", "warning") else None)
        tab.on("pageerror", lambda error: faults.append(str(error)))
        tab.on("request", lambda asked: faults.append(asked.url) if not asked.url.startswith(home) else None)
        tab.goto(page.url + fragment)
        tab.wait_for_selector("html[data-ready]", state="attached", timeout=60_000)
        until(tab, "flexmbLive.run")
        return tab

    yield opening
    for context in contexts:
        context.close()
    assert not faults


def settled(tab):
    for _ in range(2):  # what waits for a timer of the page is sent meanwhile
        until(tab, "!flexmbLive.waiting && !flexmbLive.sent")
        tab.wait_for_timeout(100)


def values(tab):
    return tab.evaluate("flexmbLive.run.values")


def test_a_slider_runs_the_mechanism_and_undo_goes_back(tab_of, crank_page):
    crank_page.set(speed=300.0, clearance=1e-4)
    tab = tab_of(crank_page)
    slider = tab.get_by_label("Slider of speed")
    slider.focus()
    frame = tab.evaluate("flexmbLive.clock.frame")
    for _ in range(3):
        tab.keyboard.press("ArrowRight")
    settled(tab)
    assert values(tab)["speed"] == pytest.approx(300.0, abs=2.5)
    assert values(tab)["speed"] > 300.0
    assert crank_page.view.values["speed"] == values(tab)["speed"]
    largest = tab.evaluate("flexmbLive.run.peak('B.normal_force')")
    assert largest == pytest.approx(crank_page.view.largest["B.normal_force"])
    while tab.get_by_role("button", name="Undo").is_enabled():  # changes within a second are one step
        tab.get_by_role("button", name="Undo").click()
        settled(tab)
    assert values(tab)["speed"] == 300.0
    assert frame is not None


def test_fields_take_numbers_and_refuse_others(tab_of, crank_page):
    crank_page.set(speed=300.0, clearance=1e-4)
    tab = tab_of(crank_page)
    field = tab.locator("#knob-speed")
    for text, words in (
        ("abc", "speed: 'abc' is no number; give an angular speed in rad/s"),
        ("1e9", "speed: 1e9 rad/s lies outside 50 to 500 rad/s."),
        ("", "give an angular speed in rad/s"),
        ("0.5 mm", "speed: '0.5 mm' is a length; give an angular speed in rad/s."),
        ("9000 rpm", "speed is 942.478 rad/s; it must lie between 50 and 500."),
    ):
        field.fill(text)
        field.press("Enter")
        tab.locator(".knob .refused", has_text=words).wait_for()
        assert field.input_value() == text  # stays, to be mended
        assert tab.locator("#fault").is_hidden()
    assert values(tab)["speed"] == 300.0
    assert not tab.get_by_role("button", name="Undo").is_enabled()
    field.fill("2,5e2")
    field.press("Enter")
    until(tab, "flexmbLive.run.values.speed === 250")
    settled(tab)
    assert values(tab)["speed"] == 250.0
    tab.get_by_label("none").check()
    settled(tab)
    assert values(tab)["clearance"] is None
    assert tab.get_by_text("no joint with clearance").is_visible()
    assert "clearance=None" in tab.locator("#code").inner_text()
    tab.get_by_label("none").uncheck()
    settled(tab)
    assert values(tab)["clearance"] == 1e-4


@pytest.mark.slow
def test_fields_have_handy_units_and_take_others(tab_of, crank_page):
    crank_page.set(speed=300.0, clearance=1e-4)
    tab = tab_of(crank_page)
    speed, clearance = tab.locator("#knob-speed"), tab.locator("#knob-clearance")
    assert clearance.input_value() == "100"
    assert tab.locator(".knob-field .unit").all_inner_texts()[:2] == ["rad/s", "µm"]
    exact = {"300": 3e-4, "0.3 mm": 3e-4, "70 µm": 7e-5, "70um": 7e-5, "4e-2cm": 4e-4, "0,02 mm": 2e-5}
    for text, value in exact.items():
        clearance.fill(text)
        clearance.press("Enter")
        until(tab, f"flexmbLive.run.values.clearance === {value}")
        settled(tab)
        assert crank_page.view.values["clearance"] == value
        assert float(clearance.input_value()) == pytest.approx(1e6 * value, rel=1e-12)
    for text, value in (("1200 rpm", 40.0 * math.pi), ("30 pi rad/s", 30.0 * math.pi)):
        speed.fill(text)
        speed.press("Enter")
        until(tab, f"Math.abs(flexmbLive.run.values.speed - {value}) < 1e-9")
    settled(tab)
    assert crank_page.code() == f"slider_crank(speed={30.0 * math.pi!r}, clearance=2e-05)"
    assert "speed=94.2" in crank_page.command()
    tab.wait_for_timeout(400)
    assert "clearance=0.00002" in tab.url.replace("2e-5", "0.00002")  # in SI, for any page
    tab.get_by_role("button", name="Pin this run").click()
    assert "clearance 20 µm" in tab.locator("#pins").inner_text()
    tab.get_by_role("button", name="Undo").click()  # changes within a second are one step
    settled(tab)
    assert values(tab)["speed"] in (300.0, 40.0 * math.pi)
    tab.evaluate("clearTimeout(flexmbLive.later); flexmbLive.sent = performance.now()")  # an answer is waited for
    clearance.fill("40")
    clearance.press("Enter")
    speed.fill("3 kg")
    speed.press("Enter")
    tab.get_by_text("speed: '3 kg' is a mass").wait_for()
    until(tab, "flexmbLive.run.values.clearance === 4e-5")
    settled(tab)
    assert (clearance.input_value(), speed.input_value()) == ("40", "3 kg")  # a run leaves what was refused
    assert tab.get_by_text("speed: '3 kg' is a mass").is_visible()
    tab.get_by_role("button", name="Start values").click()
    assert tab.get_by_text("speed: '3 kg' is a mass").is_hidden()
    tab.locator("#knob-periods").fill("two")
    tab.locator("#knob-periods").press("Enter")
    tab.get_by_text("periods: 'two' is no number").wait_for()


@pytest.mark.slow
def test_what_is_typed_stays_while_runs_go_on(tab_of, crank_page):
    crank_page.set(speed=300.0, clearance=1e-4)
    tab = tab_of(crank_page)
    tab.get_by_label("Go on after the end").check()
    begun = tab.evaluate("flexmbLive.frames")
    tab.locator("#knob-speed").fill("")
    tab.locator("#knob-speed").press_sequentially("123.")
    until(tab, f"flexmbLive.frames > {begun + 2}")  # runs have arrived meanwhile
    tab.locator("#knob-speed").press_sequentially("5")
    tab.locator("#knob-speed").press("Enter")
    until(tab, "flexmbLive.run.values.speed === 123.5")
    tab.get_by_label("Go on after the end").uncheck()
    tab.wait_for_timeout(500)
    assert tab.locator("#knob-speed").input_value() == "123.5"


@pytest.mark.slow
def test_a_page_follows_its_script(tab_of, crank_page):
    tab = tab_of(crank_page)
    crank_page.set(speed=333.0)
    until(tab, "flexmbLive.run.values.speed === 333")
    assert tab.locator("#knob-speed").input_value() == "333"


@pytest.mark.slow
def test_every_panel_shows_the_run(tab_of, crank_page):
    crank_page.set(speed=300.0, clearance=1e-4)
    tab = tab_of(crank_page, height=4000)
    for kind in ("phase", "poincare", "spectrum", "verdict", "diagram"):
        tab.select_option("#add-panel", kind)
    tab.get_by_role("button", name="Pin this run").click()
    crank_page.set(speed=200.0)
    until(tab, "flexmbLive.run.values.speed === 200")
    settled(tab)
    lines = tab.evaluate(
        "flexmbLive.panels.filter((p) => p.panel.plot).map((p) => [p.kind, p.panel.plot.lines.length])"
    )
    assert dict(lines)["signals"] == dict(lines)["phase"] == dict(lines)["spectrum"] == 2  # the run and the pinned one
    assert tab.get_by_role("columnheader", name="pin 1").is_visible()
    assert tab.locator("canvas.journal").is_visible()


def spectrum(tab, times, values):
    """Frequencies and amplitudes that the panel draws for a curve, and its remark."""
    found = tab.evaluate(
        """([times, values]) => {
          const there = flexmbLive.panels.find((one) => one.kind === 'spectrum');
          const panel = there ? there.panel : flexmbLive.addPanel('spectrum', []);
          const run = flexmbLive.run;
          const kept = [run.times, run.curve];
          [run.times, run.curve] = [Float64Array.from(times), () => Float64Array.from(values)];
          panel.update();
          const [line] = panel.plot.lines;
          [run.times, run.curve] = kept;
          return [Array.from(line.x), Array.from(line.y), panel.told.textContent];
        }""",
        [times.tolist(), values.tolist()],
    )
    return np.array(found[0]), 10.0 ** np.array(found[1]), found[2]


@pytest.mark.slow
def test_the_spectrum_has_its_line_at_the_frequency_of_a_sine(tab_of, crank_page):
    """Up to the frequency of Nyquist, for any number of samples; 300 Hz at 1 kHz were 212 Hz of 1.47 m."""
    tab = tab_of(crank_page)
    times = np.arange(1001) / 1000.0
    for frequency in (3.0, 100.0, 300.0, 490.0):
        f, amplitudes, told = spectrum(tab, times, 7.0 + 2.0 * np.sin(2.0 * math.pi * frequency * times))
        k = int(np.argmax(amplitudes))
        assert (f[k], amplitudes[k], told) == (pytest.approx(frequency), pytest.approx(2.0, rel=1e-9), "")
        assert np.delete(amplitudes, [k - 1, k, k + 1]).max() < 1e-7
        power = fm.chaos.power_spectrum(2.0 * np.sin(2.0 * math.pi * frequency * times[:-1]), 1e-3)
        assert power.peaks[0] == pytest.approx(f[k])
        assert math.sqrt(2.0 * power.power[0]) == pytest.approx(amplitudes[k], rel=1e-3)


@pytest.mark.parametrize(
    "count",
    [
        pytest.param(5, marks=pytest.mark.slow),
        64,
        pytest.param(738, marks=pytest.mark.slow),
        pytest.param(1001, marks=pytest.mark.slow),
        pytest.param(4097, marks=pytest.mark.slow),
    ],
)
def test_the_spectrum_is_that_of_the_samples(tab_of, crank_page, count):
    """Hann's window and the discrete Fourier transform of numpy, also where the last instant lies off the grid."""
    tab, values = tab_of(crank_page), np.random.default_rng(count).normal(size=count)
    times, n = 0.3 + 0.01 * np.arange(count), count - 1
    windowed = (values[:-1] - values[:-1].mean()) * (1.0 - np.cos(2.0 * math.pi * np.arange(n) / n))
    wanted = 2.0 / n * np.abs(np.fft.rfft(windowed))[1 : math.ceil(n / 2)]
    for last in (times[-1], times[-1] - 0.004):
        f, amplitudes, told = spectrum(tab, np.append(times[:-1], last), values)
        assert f == pytest.approx(np.fft.rfftfreq(n, 0.01)[1 : math.ceil(n / 2)], rel=1e-9)
        assert amplitudes == pytest.approx(wanted, rel=1e-6, abs=1e-7)
        assert not told


@pytest.mark.slow
def test_the_spectrum_of_odd_instants_says_so(tab_of, crank_page):
    tab, times = tab_of(crank_page), np.linspace(0.0, 1.0, 801) ** 1.2
    f, amplitudes, told = spectrum(tab, times, 2.0 * np.sin(2.0 * math.pi * 20.0 * times))
    k = int(np.argmax(amplitudes))
    assert (f[k], amplitudes[k]) == (pytest.approx(20.0), pytest.approx(2.0, rel=0.01))
    assert told.startswith("Instants are not evenly spaced")


def test_the_link_holds_all_settings_and_no_token(tab_of, crank_page):
    crank_page.set(speed=300.0, clearance=1e-4)
    tab = tab_of(crank_page)
    tab.select_option("#add-panel", "phase")
    until(tab, "!location.href.includes('token') && location.hash.includes('phase')")
    address = tab.url
    crank_page.set(speed=200.0)
    again = tab_of(crank_page, "#" + address.partition("#")[2])
    until(again, "flexmbLive.run.values.speed === 300")
    assert again.evaluate("flexmbLive.panels.map((p) => p.kind)")[-1] == "phase"
    tab.goto("about:blank")
    tab.goto(address)  # without the token: the browser has its cookie
    until(tab, "window.flexmbLive && flexmbLive.run")


@pytest.mark.slow
@pytest.mark.parametrize("fragment", ["#speed=1e9&clearance=0.0002", "#speed=fast"])
def test_a_link_with_values_that_are_refused_says_so(tab_of, crank_page, fragment):
    crank_page.set(speed=300.0, clearance=1e-4)
    tab = tab_of(crank_page, fragment)
    settled(tab)
    tab.wait_for_timeout(500)  # runs that arrive leave it
    assert "speed" in tab.locator("#fault").inner_text()
    assert values(tab) == crank_page.view.values  # none of the link
    tab.locator("#knob-speed").fill("200")
    tab.locator("#knob-speed").press("Enter")
    until(tab, "flexmbLive.run.values.speed === 200")
    assert tab.locator("#fault").is_hidden()


@pytest.mark.slow
def test_a_film_that_is_drawn_is_told_at_once(tab_of, crank_page):
    tab = tab_of(crank_page)
    with tab.expect_download(timeout=120_000) as film:
        tab.locator("#save-film").click()
        assert "film is drawn" in tab.locator("#copied").inner_text()
    assert film.value.suggested_filename.startswith("slider-crank.")


@pytest.mark.slow
def test_a_fourth_pin_tells_that_the_first_one_is_gone(tab_of, crank_page):
    tab = tab_of(crank_page)
    for count in range(1, 5):
        tab.get_by_role("button", name="Pin this run").click()
        assert ("made room" in tab.locator("#copied").inner_text()) == (count == 4)
        assert tab.locator("#pins li").count() == min(count, 3)


@pytest.mark.slow
def test_largest_values_fit_on_a_phone(tab_of, crank_page):
    crank_page.set(speed=500.0, clearance=1e-4)
    tab = tab_of(crank_page, "", *SIZES[1])
    table = tab.get_by_role("region", name="Largest values")
    table.get_by_role("button").first.wait_for()
    assert table.evaluate("(box) => box.scrollWidth - box.clientWidth") <= 0


def test_a_lost_server_is_told_and_the_page_stays(browser):
    page = fm.explore(slider_crank, vary={"speed": (50.0, 500.0)}, periods=1, open=False, block=False)
    tab = browser.new_page()
    tab.goto(page.url)
    until(tab, "window.flexmbLive && flexmbLive.run")
    page.close()
    tab.wait_for_selector("#fault:not([hidden])")
    assert "connection" in tab.locator("#fault").inner_text()
    before = tab.evaluate("flexmbLive.clock.frame")
    tab.wait_for_timeout(500)
    assert tab.evaluate("flexmbLive.clock.frame") != before  # it still moves
    tab.close()


@pytest.mark.slow
def test_a_failing_model_is_told_as_text(tab_of):
    def sometimes(speed: float = 100.0) -> fm.Mechanism:
        if speed > 300.0:
            raise ValueError("<b>too fast</b>")
        return slider_crank(speed=speed)

    with fm.explore(sometimes, vary={"speed": (50.0, 500.0)}, periods=1, open=False, block=False) as page:
        tab = tab_of(page)
        tab.locator("#knob-speed").fill("400")
        tab.locator("#knob-speed").press("Enter")
        tab.wait_for_selector("#fault:not([hidden])")
        assert "<b>too fast</b>" in tab.locator("#fault").inner_text()
        tab.locator("#knob-speed").fill("200")
        tab.locator("#knob-speed").press("Enter")
        tab.wait_for_selector("#fault", state="hidden")
        until(tab, "flexmbLive.run.values.speed === 200")
        tab.context.close()


@pytest.mark.slow
def test_a_diagram_paints_and_a_click_opens_its_run(tab_of, crank_page):
    crank_page.set(speed=300.0, clearance=1e-4)
    tab = tab_of(crank_page, height=2400)
    tab.select_option("#add-panel", "diagram")
    panel = tab.locator("section", has=tab.get_by_role("heading", name="Bifurcation diagram"))
    for label, text in (("from", "200"), ("to", "300"), ("values", "3"), ("skip", "1"), ("keep", "2")):
        panel.get_by_label(label, exact=True).fill(text)
    panel.get_by_label("from", exact=True).fill("5 mm")
    panel.get_by_role("button", name="Paint").click()
    panel.get_by_text("speed, from: '5 mm' is a length; give an angular speed in rad/s.").wait_for()
    panel.get_by_label("from", exact=True).fill("1909.8593171027441 rpm")  # 200 rad/s
    panel.get_by_role("button", name="Paint").click()
    panel.get_by_text("opens its run").wait_for(timeout=60_000)
    # What is found in the run moves the panels below it when it comes.
    until(tab, "flexmbLive.findings && flexmbLive.findings.number === flexmbLive.run.number")
    tab.wait_for_timeout(50)
    spot = tab.evaluate(
        "(() => { const p = flexmbLive.panels.find((one) => one.kind === 'diagram').panel;"
        " return p.plot.screen(p.x[p.x.length - 1], p.y[p.y.length - 1]); })()"
    )
    panel.locator("canvas").click(position={"x": spot[0], "y": spot[1]})
    until(tab, "flexmbLive.run.values.speed === 250")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("width", "height", "theme"),
    [
        (*SIZES[0], "light"),
        (*SIZES[1], "dark"),
        *(pytest.param(*one, marks=pytest.mark.slow) for one in ((*SIZES[0], "dark"), (*SIZES[1], "light"))),
    ],
)
def test_nothing_is_cut_or_covered(tab_of, layout_faults, width, height, theme):
    with fm.explore(nine_bar, fixed={"clearance": 5e-4}, periods=0.5, open=False, block=False) as page:
        tab = tab_of(page, "", width, height, color_scheme=theme)
        for kind in ("phase", "poincare", "spectrum", "verdict", "diagram"):
            tab.select_option("#add-panel", kind)
        tab.get_by_role("button", name="Pin this run").click()
        tab.wait_for_timeout(500)
        tab.evaluate("flexmbLive.clock.play(false)")
        assert layout_faults(tab) == []
        tab.evaluate("document.querySelector('.left').scrollTop = 1e4; scrollTo(0, 0)")
        assert layout_faults(tab) == []
        tab.context.close()


@pytest.mark.slow
def test_keys_alone_reach_everything(tab_of, crank_page):
    tab = tab_of(crank_page)
    reached = set()
    for _ in range(60):
        tab.keyboard.press("Tab")
        reached.add(tab.evaluate("(document.activeElement.id || document.activeElement.textContent).slice(0, 30)"))
    wanted = {"theme", "picture", "play", "time", "reset", "knob-speed", "knob-clearance", "pin", "go-on"}
    assert wanted <= reached
    assert {"copy-code", "copy-link", "save-report", "save-netcdf", "add-panel"} <= reached


@pytest.mark.slow
def test_many_random_changes_leave_no_element_behind(tab_of, crank_page):
    tab = tab_of(crank_page)
    counts = []
    for k in range(25):
        place = int(1000 * math.fmod(0.618 * k, 1.0))
        tab.evaluate(
            "(place) => { const k = flexmbLive.values.knobs.get('speed'); k.slider.value = place;"
            " k.slider.dispatchEvent(new Event('input')); k.slider.dispatchEvent(new Event('change')); }",
            place,
        )
        settled(tab)
        counts.append(tab.evaluate("document.querySelectorAll('*').length"))
    assert max(counts[5:]) - min(counts[5:]) <= 40  # findings and contacts differ
    assert json.loads(json.dumps(values(tab)))["speed"] == crank_page.view.values["speed"]


@pytest.mark.slow
def test_an_older_run_that_comes_late_is_passed_over(tab_of, crank_page):
    crank_page.set(speed=300.0)
    tab = tab_of(crank_page)
    older = messages.run_message(crank_page.view, (), "", "")
    crank_page.set(speed=310.0)
    until(tab, "flexmbLive.run.values.speed === 310")
    tab.evaluate("async (text) => { flexmbLive._hear(JSON.parse(text)); await flexmbLive.arrived; }", older)
    assert values(tab)["speed"] == 310.0
    assert tab.locator("#knob-speed").input_value() == "310"
