"""Tasks of docs/howto/live.md done on the page as a user does them, in short."""

import pytest

import flexmb as fm
from flexmb.mechanisms import slider_crank


@pytest.fixture
def open_page(browser):
    """Function that opens a live page in a browser of its own."""
    contexts = []

    def opening(url):
        contexts.append(browser.new_context(viewport={"width": 1280, "height": 1000}))
        tab = contexts[-1].new_page()
        tab.set_default_timeout(120_000)
        tab.goto(url)
        tab.wait_for_selector("html[data-ready]", state="attached")
        return tab

    yield opening
    for context in contexts:
        context.close()


def section(tab, title):
    return tab.locator("section", has=tab.get_by_role("heading", name=title))


def typed(tab, name, text):
    tab.locator(f"#knob-{name}").fill(text)
    tab.locator(f"#knob-{name}").press("Enter")


def wait_for_whole_run(tab, name, value):
    """Wait until the shown run has the value and has come to its end: before, peaks are those of a part."""
    reached = f"Boolean(flexmbLive.run) && flexmbLive.run.values.{name} === {value} && flexmbLive.run.raw.done"
    while not tab.evaluate(reached):
        tab.wait_for_timeout(50)


@pytest.mark.slow
def test_the_speed_at_which_chaos_begins(open_page):
    vary = {"speed": (150.0, 450.0)}
    with fm.explore(slider_crank, vary=vary, fixed={"clearance": 2e-5}, open=False, block=False) as page:
        tab = open_page(page.url)
        for kind in ("diagram", "verdict"):
            tab.select_option("#add-panel", kind)
        diagram, verdict = section(tab, "Bifurcation diagram"), section(tab, "Exponent and verdict")
        diagram.get_by_label("Signal").select_option("B.ex")
        for label, text in (("from", "330"), ("to", "350"), ("values", "2"), ("skip", "40"), ("keep", "30")):
            diagram.get_by_label(label, exact=True).fill(text)
        diagram.get_by_role("button", name="Paint").click()
        diagram.get_by_text("opens its run").wait_for()
        points = tab.evaluate(
            "(() => { const { x, y } = flexmbLive.panels.find((one) => one.kind === 'diagram').panel;"
            " return x.map((at, k) => [at, y[k]]); })()"
        )
        widths = {at: max(y for x, y in points if x == at) - min(y for x, y in points if x == at) for at in (330, 350)}
        assert widths[330] > 1e-7 > 1e-9 > widths[350]  # a cloud, and one point
        for speed, word in (("330", "chaotic"), ("350", "periodic-1")):
            typed(tab, "speed", speed)
            verdict.get_by_role("button", name="Compute").click()
            verdict.get_by_text("200 of 200 periods").wait_for()
            verdict.get_by_role("button", name="Compute").wait_for()
            tab.wait_for_timeout(300)
            assert verdict.locator(".verdict").inner_text().startswith(f"{word}:")
            verdict.get_by_role("button", name="Remove").click()
            tab.select_option("#add-panel", "verdict")


@pytest.mark.slow
def test_the_clearance_that_halves_the_peak_force(open_page):
    vary = {"clearance": (2e-5, 5e-4)}
    with fm.explore(slider_crank, vary=vary, fixed={"speed": 300.0}, periods=40, open=False, block=False) as page:
        tab = open_page(page.url)
        tab.get_by_label("Go on after the end").check()
        forces = {}
        for text, value in (("0.5 mm", 0.0005), ("170", 0.00017)):  # of a field in micrometres
            typed(tab, "clearance", text)
            wait_for_whole_run(tab, "clearance", value)
            while not tab.evaluate("flexmbLive.run.frames[0] > 0"):
                tab.wait_for_timeout(50)
            forces[text] = tab.evaluate("flexmbLive.run.peak('B.normal_force')")
            tab.get_by_role("button", name="Pin this run").click()
        assert tab.get_by_role("columnheader", name="pin 2").is_visible()
        assert 0.35 < forces["170"] / forces["0.5 mm"] < 0.55


@pytest.mark.slow
def test_a_colleague_sees_the_same_view_by_a_link(open_page):
    vary, tokens = {"speed": (50.0, 500.0), "clearance": (2e-5, 5e-4)}, []
    with fm.explore(slider_crank, vary=vary, periods=1, open=False, block=False) as page:
        port, own = page._server.port, open_page(page.url)
        tokens.append(page._server.token)
        with pytest.raises(fm.errors.InputError, match=f"port {port} is not free"):
            fm.explore(slider_crank, vary=vary, periods=1, port=port, open=False, block=False)
        typed(own, "speed", "321")
        own.select_option("#add-panel", "phase")
        wait_for_whole_run(own, "speed", 321)
        own.wait_for_timeout(500)  # the address follows
        link, seen = own.url, own.evaluate("flexmbLive.run.peak('B.normal_force')")
    with fm.explore(slider_crank, vary=vary, periods=1, port=port, open=False, block=False) as page:
        theirs = open_page(page.url)
        assert page._server.token not in tokens
        theirs.goto("about:blank")
        theirs.goto(link)
        theirs.wait_for_selector("html[data-ready]", state="attached")
        wait_for_whole_run(theirs, "speed", 321)
        assert theirs.evaluate("flexmbLive.run.peak('B.normal_force')") == seen
        assert theirs.evaluate("flexmbLive.panels.map((one) => one.kind)")[-1] == "phase"
