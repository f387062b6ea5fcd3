"""Notebooks of docs/ run; the live page as a widget, with a kernel and without; the player of a solution."""

import json
from pathlib import Path

import pytest

import flexmb as fm
from flexmb.mechanisms import nine_bar, slider_crank
from flexmb.show.reports import scene

nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
pytest.importorskip("anywidget", reason="anywidget is not installed")

NOTEBOOKS = Path(__file__).resolve().parents[2] / "docs" / "notebooks"
FIRST = "first_mechanism"
VIEW, STATE = "application/vnd.jupyter.widget-view+json", "application/vnd.jupyter.widget-state+json"

HOST = """<!DOCTYPE html><body><div id="cell" style="width: 900px"></div></body>"""
SHOW = """async ([script, state]) => {
  const { default: widget } = await import(URL.createObjectURL(new Blob([script], { type: 'text/javascript' })));
  const actions = [];
  window.sent = [];
  window.state = state;
  window.tell = (name, value) => { // as the kernel changes a value, or sends a message
    state[name] = value;
    actions.filter(([event]) => event === `change:${name}` || event === name).forEach(([, act]) => act(value));
  };
  const model = {
    get: (name) => state[name], send: (message) => sent.push(message),
    on: (event, act) => actions.push([event, act]), off: () => {},
  };
  window.end = widget.render({ model, el: document.getElementById('cell') });
}"""


def run(name, folder):
    """A notebook after its run, with the state of its widgets."""
    book = nbformat.read(NOTEBOOKS / f"{name}.ipynb", 4)
    nbclient.NotebookClient(
        book, timeout=600, kernel_name="python3", resources={"metadata": {"path": folder}}
    ).execute()
    return book


def outputs(book):
    return [output for one in book.cells for output in one.get("outputs", [])]


def widget_state(book):
    """State of the live page of a saved notebook."""
    found = book.metadata["widgets"][STATE]["state"].values()
    return next(one["state"] for one in found if "page" in one["state"])


def sent_by(tab):
    """Messages of the frame to the kernel, once there are some."""
    while not (sent := tab.evaluate("sent")):
        tab.wait_for_timeout(20)
    return sent


def frame_of(tab, name, ready):
    """The frame of a player or of a live page, once it is ready."""
    tab.wait_for_selector("iframe")
    frame = next(one for one in tab.frames if one.parent_frame)
    frame.wait_for_selector(f"html[data-ready={ready}]", state="attached", timeout=60_000)
    assert frame.evaluate(f"Boolean(window.{name})")
    return frame


@pytest.fixture
def tab(browser):
    """A tab that fails on messages on the console and on every request."""
    opened, faults = browser.new_page(viewport={"width": 940, "height": 900}), []
    opened.on("console", lambda said: faults.append(said.text) if said.type in ("error", "warning") else None)
    opened.on("pageerror", lambda error: faults.append(str(error)))
    opened.on("request", lambda asked: None if asked.url.startswith("blob:") else faults.append(asked.url))
    yield opened
    opened.close()
    assert not faults


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """The first notebook after its run."""
    return run(FIRST, tmp_path_factory.mktemp("first"))


@pytest.mark.parametrize("path", sorted(NOTEBOOKS.glob("*.ipynb")), ids=lambda path: path.stem)
def test_notebooks_are_kept_without_outputs(path):
    """The site and the tests run them."""
    assert all(not one.get("outputs") for one in nbformat.read(path, 4).cells)


@pytest.mark.slow
def test_the_first_notebook_runs(saved):
    assert_shown(saved)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(path.stem for path in NOTEBOOKS.glob("*.ipynb") if path.stem != FIRST))
def test_the_other_notebooks_run(name, tmp_path):
    assert_shown(run(name, tmp_path))


def assert_shown(book):
    """The cells have ended without an error or a warning, and one of them shows the live page."""
    shown = outputs(book)
    assert not [one for one in shown if one.output_type == "error" or one.get("name") == "stderr"]
    live = [one for one in shown if VIEW in one.get("data", {})]
    assert len(live) == 1
    assert "<iframe" in live[0].data["text/html"]  # where there are no widgets
    assert json.loads(widget_state(book)["run"])["ok"]


@pytest.mark.slow
def test_a_saved_notebook_shows_its_last_state_without_a_kernel(saved, tab):
    state = widget_state(saved)
    assert json.loads(state["run"])["values"]["piston.mass"] == 0.3  # what the last cell has set
    tab.set_content(HOST)
    tab.evaluate(SHOW, [state["_esm"], state])
    frame = frame_of(tab, "flexmbLive", "live")
    assert frame.locator("[id='knob-piston.mass']").input_value() == "0.3"
    assert frame.locator("#state").inner_text() == "finished"
    before = frame.evaluate("flexmbLive.clock.frame")
    tab.wait_for_timeout(500)
    assert frame.evaluate("flexmbLive.clock.frame") != before  # it moves
    frame.locator("[id='knob-piston.mass']").fill("0.2")
    frame.locator("[id='knob-piston.mass']").press("Enter")
    frame.get_by_text("opened again shows its last state").wait_for()


@pytest.mark.slow
def test_the_widget_runs_in_the_kernel(crank_page, tab):
    crank_page.set(speed=300.0, clearance=1e-4)
    widget = crank_page.widget()
    tab.set_content(HOST)
    state = {name: getattr(widget, name) for name in ("page", "run", "findings", "_esm")}
    tab.evaluate(SHOW, [state["_esm"], state])
    frame = frame_of(tab, "flexmbLive", "live")
    assert not frame.locator("#copy-link").is_visible()  # a frame has no address
    tab.evaluate("sent.length = 0")
    frame.locator("#knob-speed").fill("250")
    frame.locator("#knob-speed").press("Enter")
    sent = sent_by(tab)
    assert sent[-1] == {"type": "set", "values": {"speed": 250}}
    for message in sent:
        widget._hear(widget, message, [])
    crank_page.set()  # returns after the run
    assert json.loads(widget.run)["values"]["speed"] == 250.0
    tab.evaluate("(text) => tell('run', text)", widget.run)
    frame.get_by_text("finished", exact=True).wait_for()
    while frame.evaluate("flexmbLive.run.values.speed") != 250.0:  # unpacked in a moment
        tab.wait_for_timeout(20)
    said = []
    widget.send = said.append
    for wrong in ({"type": "set", "values": {"speed": 1e9}}, {"type": "steal"}, None, ["set"]):
        widget._hear(widget, wrong, [])
    assert [json.loads(one["text"])["type"] for one in said] == 4 * ["refused"]
    assert crank_page.view.values["speed"] == 250.0
    tab.evaluate("(text) => tell('msg:custom', { text })", said[0]["text"])
    assert "1e+09" in frame.locator("#fault").inner_text()
    tab.evaluate("end()")


@pytest.fixture
def saving(tmp_path):
    """A page that saves into a folder, its widget, and what the widget says."""
    folder = tmp_path / "kept" / "here"
    with fm.explore(slider_crank, vary=["speed"], periods=1, folder=folder, open=False, block=False) as page:
        widget, said = page.widget(), []
        widget.send = said.append
        yield page, widget, said, folder


def answer(widget, said, message):
    """What a widget says to a message, once its file is written."""
    said.clear()
    widget._hear(widget, message, [])
    widget._writer.join(120.0) if widget._writer.ident else None
    (one,) = said
    return json.loads(one["text"])


@pytest.mark.slow
def test_a_notebook_saves_report_film_and_netcdf(saving, tab):
    page, widget, said, folder = saving
    tab.set_content(HOST)
    tab.evaluate(SHOW, [widget._esm, {"page": widget.page, "run": widget.run, "findings": ""}])
    frame = frame_of(tab, "flexmbLive", "live")
    view = page.set(speed=321.0)
    names = {"report": "slider-crank.html", "film": "slider-crank.*", "netcdf": "slider-crank.nc"}
    for kind, name in names.items():
        tab.evaluate("sent.length = 0")
        frame.locator(f"#save-{kind}").click()
        (message,) = sent_by(tab)
        told = answer(widget, said, message)
        assert told["type"] == "saved", told
        tab.evaluate("(text) => tell('msg:custom', { text })", said[0]["text"])
        written = folder / told["text"].removeprefix(f"Saved as {folder}/")
        assert written.match(name)
        frame.get_by_text(str(written)).wait_for()
    assert fm.load(folder / "slider-crank.nc").peak("B.fx") == view.solution.peak("B.fx")
    first = (folder / "slider-crank.nc").read_bytes()
    page.set(speed=322.0)
    assert answer(widget, said, {"type": "save", "file": "run.nc"})["text"].endswith("slider-crank-2.nc")
    assert (folder / "slider-crank.nc").read_bytes() == first  # what is there stays
    assert len(list(folder.iterdir())) == 4  # no part of a file is left


@pytest.mark.parametrize("name", ["../x.html", "/etc/passwd", "report.html/../../x", "", None, ["film"], "run.nc\0"])
def test_a_notebook_saves_declared_files_alone(saving, name):
    _, widget, said, folder = saving
    said_of_it = answer(widget, said, {"type": "save", "file": name, "folder": "/"})
    assert said_of_it["type"] == "refused"
    assert "report.html" in said_of_it["text"]
    assert list(folder.iterdir()) == []


def test_a_folder_that_is_gone_or_full_is_told(saving, monkeypatch):
    _, widget, said, folder = saving
    folder.rmdir()
    folder.write_text("a file in its place")
    assert "is a file" in answer(widget, said, {"type": "save", "file": "run.nc"})["text"]
    folder.unlink()
    monkeypatch.setattr(fm.Solution, "to_netcdf", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left")))
    assert "No space left" in answer(widget, said, {"type": "save", "file": "run.nc"})["text"]
    assert list(folder.iterdir()) == []


@pytest.mark.slow
def test_a_frame_hears_its_notebook_alone(crank_page, tab):
    tab.set_content(HOST)
    widget = crank_page.widget()
    tab.evaluate(SHOW, [widget._esm, {"page": widget.page, "run": widget.run, "findings": ""}])
    frame = frame_of(tab, "flexmbLive", "live")
    shown = frame.evaluate("flexmbLive.run.number")
    frame.evaluate("postMessage(JSON.stringify({ type: 'refused', text: 'from elsewhere' }), '*')")
    tab.wait_for_timeout(200)
    assert not frame.locator("#fault").is_visible()
    assert frame.evaluate("flexmbLive.run.number") == shown
    assert frame.evaluate("(() => { try { return parent.document.title; } catch { return 'closed'; } })()") == "closed"


@pytest.mark.slow
@pytest.mark.parametrize(("width", "theme"), [(900, "light"), (360, "dark")])
def test_a_solution_is_a_player_above_its_table(browser, layout_faults, width, theme):
    sol = fm.simulate(nine_bar(clearance=5e-4, flexible=True), periods=0.2)
    shown = sol._repr_html_()
    assert len(scene.cell(sol)) <= scene.MOST_SIGNS
    opened = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=theme)
    opened.set_content(f"<!DOCTYPE html><body>{shown}</body>")
    frame = frame_of(opened, "flexmbCell", "cell")
    assert layout_faults(frame) == []
    frame.locator("#play").click()
    frame.wait_for_selector("#play[aria-pressed=true]")
    opened.wait_for_timeout(300)
    assert frame.evaluate("flexmbCell.clock.frame") > 0
    assert frame.evaluate("flexmbCell.clock.last") == len(sol.time) - 1 or frame.evaluate("flexmbCell.clock.last") < 200
    assert frame.evaluate("flexmbCell.picture.drawn") > 5
    opened.close()


def test_long_runs_have_fewer_frames_and_odd_ones_no_player(monkeypatch):
    sol = fm.simulate(slider_crank(clearance=2e-4), periods=1)
    whole = scene.cell(sol)
    monkeypatch.setattr(scene, "MOST_SIGNS", len(whole) - 1)
    assert 0 < len(scene.cell(sol)) < len(whole)
    monkeypatch.setattr(scene, "MOST_SIGNS", 1000)
    assert scene.cell(sol) == ""
    monkeypatch.undo()
    without = fm.simulate(slider_crank(), periods=0.1, signals=["motor.*"])
    assert scene.cell(without) == ""
    assert "motor.torque" in without._repr_html_()


def test_outside_of_a_notebook_the_page_opens_and_waits(monkeypatch):
    from flexmb.show.live import page

    assert not page.in_notebook()
    done = []
    monkeypatch.setattr(page, "_SHOWN", [])
    monkeypatch.setattr(page, "shown", lambda made, *, opened, block: done.append((opened, block)) or made)
    for kernel, wanted in ((False, True), (True, False)):
        monkeypatch.setattr(page, "in_notebook", lambda kernel=kernel: kernel)
        fm.explore(slider_crank, vary=["speed"], periods=0.1).close()
        assert done[-1] == (wanted, wanted)


def test_a_notebook_keeps_its_newest_pages(monkeypatch):
    from flexmb.show.live import page

    monkeypatch.setattr(page, "in_notebook", lambda: True)
    monkeypatch.setattr(page, "MOST_PAGES", 2)
    monkeypatch.setattr(page, "_SHOWN", [])
    made = [fm.explore(slider_crank, vary=["speed"], periods=0.1) for _ in range(3)]
    first, *others = made
    said, widget = [], first.widget()
    widget.send = said.append
    widget._hear(widget, {"type": "set", "values": {"speed": 300.0}}, [])
    assert "the page is closed" in said[0]["text"]
    assert all(one.set(speed=300.0).ok for one in others)
    for one in others:
        one.close()
