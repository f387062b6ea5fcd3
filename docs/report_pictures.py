"""Pictures of reports and of the live page in docs/pictures, from a browser; with --measure: sizes, frame rates."""

import argparse
import math
import resource
import shutil
import tempfile
import time
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

import flexmb as fm

PICTURES = Path(__file__).parent / "pictures"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
READY = "html[data-ready]"


def nine_bar(folder: Path) -> Path:
    mech = fm.mechanisms.nine_bar(clearance=5e-4, flexible=True)
    return fm.report(fm.simulate(mech, periods=2), folder / "nine_bar.html")


def slider_crank(folder: Path) -> Path:
    mech = fm.mechanisms.slider_crank(clearance=5e-4, flexible=True)
    return fm.report(fm.simulate(mech, periods=2), folder / "slider_crank.html")


def chain(folder: Path) -> Path:
    """Page of a falling chain of 50 flexible links of 4 elements, 1,000 frames."""
    steel = fm.Material(young=2e11, density=7850.0, poisson=0.3)
    parts, before = [], fm.GROUND
    for k in range(50):
        ends, section = ((0.1 * k, 0.0), (0.1 * (k + 1), 0.0)), fm.Rectangle(width=0.01, height=0.004)
        link = fm.FlexibleLink(f"link{k}", *ends, section=section, material=steel, elements=4, damping=1e-4)
        parts += [link, fm.Revolute(f"J{k}", before, link, at=ends[0])]
        before = link
    sol = fm.simulate(fm.Mechanism("chain", parts, gravity=(0.0, -9.81)), t_end=1.0, step=1e-3)
    return fm.report(sol, folder / "chain.html")


def fit(folder: Path) -> Path:
    """Page of the fit of docs/howto/design.md, from its code."""
    text = (PICTURES.parent / "howto" / "design.md").read_text(encoding="utf-8")
    block = text.partition("## What a measurement says")[2].partition("```python\n")[2].partition("```")[0]
    names = {"fm": fm}
    exec(block, names)
    return fm.report(names["result"], folder / "fit.html")


def opened(browser, path: Path, width: int, height: int, scheme: str) -> Page:
    page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme, reduced_motion="reduce")
    page.goto(path.as_uri())
    page.wait_for_selector(READY, state="attached")
    return page


def pictures(browser, folder: Path) -> None:
    """Residuals of a fit, nine-bar mechanism in light, slider-crank in dark with its journal, and on a phone."""
    page = opened(browser, fit(folder), 1000, 800, "light")
    page.locator("#residuals").screenshot(path=PICTURES / "report_fit.png")
    page = opened(browser, nine_bar(folder), 1280, 800, "light")
    page.select_option("#magnification", "auto")
    page.evaluate("flexmbReport.clock.goTo(0.741)")
    saved(page, "report_nine_bar.png")
    path = slider_crank(folder)
    page = opened(browser, path, 1240, 760, "dark")
    page.evaluate("flexmbReport.clock.goTo(0.00284)")
    page.wait_for_timeout(300)
    page.locator("#clearances .joint").screenshot(path=PICTURES / "report_journal.png")
    page = opened(browser, path, 390, 844, "light")
    page.select_option("#magnification", "auto")
    page.evaluate("flexmbReport.clock.goTo(0.00144)")
    saved(page, "report_phone.png")
    live(browser)


def live(browser) -> None:
    """Live page of a worn slider-crank, with a pinned run."""
    vary = {"speed": (50.0, 500.0), "clearance": (1e-5, 5e-4), "flexible": [False, True]}
    with fm.explore(fm.mechanisms.slider_crank, vary=vary, open=False, block=False) as served:
        served.set(speed=200.0, clearance=5e-4)
        page = browser.new_page(viewport={"width": 1280, "height": 1000}, reduced_motion="reduce")
        page.goto(served.url)
        page.wait_for_selector(READY, state="attached")
        page.get_by_role("button", name="Pin this run").click()
        served.set(speed=300.0, clearance=2e-4)
        page.wait_for_timeout(1500)
        page.evaluate("flexmbLive.clock.goToFrame(100)")
        page.evaluate("document.querySelector('.left').scrollTop = 0; scrollTo({ top: 0, behavior: 'instant' })")
        saved(page, "live_page.png")
        page.close()


def saved(page: Page, name: str) -> None:
    page.wait_for_timeout(300)
    page.screenshot(path=PICTURES / name)
    print(PICTURES / name)


def measure(browser, folder: Path) -> None:
    """Sizes and times of pages, and frames a second of the chain."""
    mech = fm.mechanisms.slider_crank(speed=1000 * math.pi / 6, clearance=5e-4)
    sol = fm.simulate(mech, t_end=0.2, step=2e-6, save="steps")
    began = time.perf_counter()
    path = fm.report(sol, folder / "long.html")
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"{sol.values.shape} values: {time.perf_counter() - began:.2f} s, {most:.2f} GB in all, {size(path)}")
    print(f"slider-crank, two periods: {size(slider_crank(folder))}; nine-bar, two periods: {size(nine_bar(folder))}")
    path = chain(folder)
    page = opened(browser, path, 1280, 800, "light")
    counted = "[flexmbReport.picture.drawn, performance.now()]"
    page.click("#play")
    before = page.evaluate(counted)
    page.wait_for_timeout(5000)
    after = page.evaluate(counted)
    rate = 1000.0 * (after[0] - before[0]) / (after[1] - before[1])
    print(f"chain of 200 beams: {size(path)}, {rate:.0f} frames a second")


def size(path: Path) -> str:
    return f"{path.stat().st_size / 1e6:.2f} MB"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--measure", action="store_true", help="print sizes, times and frame rates instead")
    options = parser.parse_args()
    found = next(path for name in BROWSERS if (path := shutil.which(name)))
    with tempfile.TemporaryDirectory() as scratch, sync_playwright() as running:
        browser = running.chromium.launch(executable_path=found, args=["--no-sandbox"])
        (measure if options.measure else pictures)(browser, Path(scratch))
        browser.close()


if __name__ == "__main__":
    main()
