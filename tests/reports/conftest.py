"""Runs, pages, and a browser, for several files."""

import pytest
from pages import Page

import flexmb as fm


@pytest.fixture(scope="session")
def slider_crank():
    """A slider-crank with a flexible rod and clearance, and its run through half a turn."""
    mech = fm.mechanisms.slider_crank(speed=300.0, clearance=5e-4, flexible=True, elements=2)
    return mech, fm.simulate(mech, periods=0.5, save=600, step=1e-5)


@pytest.fixture(scope="session")
def run_page(slider_crank, tmp_path_factory):
    """Page of this run."""
    path = tmp_path_factory.mktemp("page") / "run.html"
    return Page(fm.report(slider_crank[1], path))


@pytest.fixture
def opened(browser):
    """Function that opens a page and fails on errors of its scripts and on requests beyond the folder of the page."""
    pages, faults = [], []

    def beside(path, url):
        return url.startswith(path.parent.as_uri())

    def opening(path, width=1280, height=800, **options):
        context = browser.new_context(viewport={"width": width, "height": height}, **options)
        pages.append(context)
        page = context.new_page()
        page.on("console", lambda said: faults.append(said.text) if said.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("request", lambda asked: faults.append(asked.url) if not beside(path, asked.url) else None)
        page.goto(path.as_uri())
        page.wait_for_selector("html[data-ready]", state="attached", timeout=60_000)
        return page

    yield opening
    for context in pages:
        context.close()
    assert not faults
