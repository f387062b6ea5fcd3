"""Runs, pages, and a browser, for several files."""

import os
import shutil

import pytest
from pages import Page

import flexmb as fm

OVERLAPS = """() => {
  const chosen = 'h1, h2, h3, button, select, input, output, canvas, p, label, table, dl > div, nav a, .area, .keys';
  const visible = (e) => e.checkVisibility() && !e.closest('.visually-hidden');
  const all = [...document.querySelectorAll(chosen)].filter(visible);
  const box = (e) => e.getBoundingClientRect();
  const clipped = (e) => { const s = e.closest('.scroll, .signals'); return s ? box(s) : null; };
  const found = [];
  all.forEach((a, i) => all.slice(i + 1).forEach((b) => {
    if (a.contains(b) || b.contains(a) || a.closest('label') === b || b.closest('label') === a) return;
    const [p, q] = [box(a), box(b)];
    const limits = [clipped(a), clipped(b)].filter(Boolean);
    const left = Math.max(p.left, q.left, ...limits.map((l) => l.left));
    const right = Math.min(p.right, q.right, ...limits.map((l) => l.right));
    const top = Math.max(p.top, q.top, ...limits.map((l) => l.top));
    const bottom = Math.min(p.bottom, q.bottom, ...limits.map((l) => l.bottom));
    if (right - left > 1.5 && bottom - top > 1.5) {
      found.push([a, b].map((e) => `${e.tagName}#${e.id}.${e.className} ${e.textContent.slice(0, 30)}`).join(' over '));
    }
  }));
  return found;
}"""
"""Pairs of elements with text or controls that cover one another."""

CUT = """() => [...document.querySelectorAll('h1, h2, h3, button, p, label, output, dd, dt, caption, nav a')]
  .filter((e) => e.checkVisibility() && !e.closest('.visually-hidden, .scroll'))
  .filter((e) => { const b = e.getBoundingClientRect();
    return b.left < -1 || b.right > innerWidth + 1 || e.scrollWidth > e.clientWidth + 2 && e.clientWidth > 0; })
  .map((e) => `${e.tagName}#${e.id} ${e.textContent.slice(0, 40)}`)"""
"""Elements that leave the page, or whose text leaves them."""

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")


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


@pytest.fixture(scope="session")
def browser():
    """A browser without a window; tests that need one are skipped where there is none."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: pip install playwright"
    )
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip(f"none of these browsers is on the PATH: {', '.join(BROWSERS)}")
    alone = ["--no-sandbox"] if os.geteuid() == 0 else []
    with playwright.sync_playwright() as running:
        started = running.chromium.launch(executable_path=found, args=alone)
        yield started
        started.close()


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


@pytest.fixture(scope="session")
def layout_faults():
    """Function that lists elements of an open page that cover one another, are cut, or make it scroll sideways."""

    def faults(page):
        wide = page.evaluate("document.documentElement.scrollWidth - innerWidth")
        sideways = [f"the page scrolls sideways by {wide} px"] if wide else []
        return [*sideways, *page.evaluate(OVERLAPS), *page.evaluate(CUT)]

    return faults
