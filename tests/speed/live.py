"""Time from a moved slider to the first new frame of a live page, in Chromium; memory of page and server.

    python tests/speed/live.py                # slider-crank and rigid nine-bar mechanism, 50 changes each
    python tests/speed/live.py --changes 1000 # memory before and after so many random changes of the slider-crank
    python tests/speed/live.py --attack 1000000 # so many messages at full speed; a script moves a slider meanwhile

The time is taken in the page, from the event of the slider to the end of the animation frame that has drawn the run.
"""

import argparse
import gc
import random
import shutil
import statistics
import threading
import time
from collections import Counter
from pathlib import Path
from urllib.parse import urlsplit

import httpx
from playwright.sync_api import sync_playwright
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

import flexmb as fm

CASES = {
    "slider-crank with clearance, 2 periods": (
        fm.mechanisms.slider_crank,
        {"speed": (50.0, 500.0), "clearance": (1e-5, 5e-4)},
        100.0,
    ),
    "nine-bar, rigid, ideal joints, 2 periods": (fm.mechanisms.nine_bar, {"speed": (1.0, 20.0)}, 250.0),
}
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")

MOVE = """async (place) => {
  const board = window.flexmbLive;
  const [knob] = board.values.knobs.values();
  const before = board.frames;
  const began = performance.now();
  knob.slider.value = String(place);
  knob.slider.dispatchEvent(new Event('input'));
  knob.slider.dispatchEvent(new Event('change'));
  while (board.frames === before || board.waiting || board.sent) {
    await new Promise((done) => setTimeout(done, 1)); // no animation frame: it would add up to 17 ms
  }
  await new Promise(requestAnimationFrame);
  return performance.now() - began;
}"""


def resident() -> float:
    """Memory of this process [MB]."""
    text = Path("/proc/self/status").read_text(encoding="ascii")
    return int(text.split("VmRSS:")[1].split()[0]) / 1024


def opened(playwright, page):
    """Page of a browser, and what it complains about."""
    path = next(found for name in BROWSERS if (found := shutil.which(name)))
    browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox", "--enable-precise-memory-info"])
    tab, faults = browser.new_page(viewport={"width": 1280, "height": 800}), []
    tab.on("console", lambda said: faults.append(said.text) if said.type in ("error", "warning") else None)
    tab.on("pageerror", lambda error: faults.append(str(error)))
    tab.goto(page.url)
    tab.wait_for_selector("html[data-ready]", state="attached", timeout=120_000)
    return browser, tab, faults


def times(case: str, changes: int) -> None:
    """Print the times of a case."""
    make, vary, limit = CASES[case]
    drawn = random.Random(1)
    with fm.explore(make, vary=vary, open=False, block=False) as page, sync_playwright() as playwright:
        browser, tab, faults = opened(playwright, page)
        took = []
        for k in range(changes + 3):
            tab.wait_for_timeout(700)  # the mechanism is examined
            one = tab.evaluate(MOVE, drawn.randrange(1000))
            took += [one] if k >= 3 else []
        rate = tab.evaluate(
            "async () => { const from = flexmbLive.stats.ticks; await new Promise((d) => setTimeout(d, 2000));"
            " return (flexmbLive.stats.ticks - from) / 2; }"
        )
        browser.close()
    low, high = min(took), max(took)
    spread = f"{changes} changes ({low:.0f} to {high:.0f})"
    print(f"{case}: median {statistics.median(took):.0f} ms of {spread}, wanted {limit:.0f} ms;")
    print(f"    {rate:.0f} animation frames a second while playing; faults: {faults or 'none'}")


def memory(changes: int) -> None:
    """Print the memory of page and server before and after random changes."""
    make, vary, _ = CASES["slider-crank with clearance, 2 periods"]
    drawn = random.Random(2)
    heap = "performance.memory.usedJSHeapSize / 1e6"
    with fm.explore(make, vary=vary, open=False, block=False) as page, sync_playwright() as playwright:
        browser, tab, faults = opened(playwright, page)
        session = tab.context.new_cdp_session(tab)
        for k in range(changes + 1):
            tab.evaluate(MOVE, drawn.randrange(1000))
            if k in (0, changes // 4, changes // 2, 3 * changes // 4, changes):
                session.send("HeapProfiler.collectGarbage")
                gc.collect()
                print(f"after {k:5d} changes: page {tab.evaluate(heap):.1f} MB, server {resident():.0f} MB", flush=True)
        browser.close()
    print(f"faults: {faults or 'none'}")


MESSAGES = ('{"type": "set", "values": {"speed": 1e300}}', '{"type": "stop"}', "[" * 1000, '{"type": "<script>"}')


class Attack(threading.Thread):
    """Browser with the token that sends messages as fast as it can, and comes back whenever it is sent away."""

    def __init__(self, url: str, count: int) -> None:
        super().__init__(daemon=True)
        parts = urlsplit(url)
        self.address, self.origin = f"ws://{parts.netloc}/ws?{parts.query}", f"http://{parts.netloc}"
        self.left, self.sent_away, self.reasons = count, 0, Counter()

    def run(self) -> None:
        while self.left > 0:
            try:
                headers = {"Origin": self.origin}
                with connect(self.address, additional_headers=headers, compression=None, open_timeout=60) as connection:
                    while self.left > 0:
                        connection.send(MESSAGES[self.left % len(MESSAGES)])
                        self.left -= 1
            except (ConnectionClosed, OSError) as error:
                self.sent_away += 1
                self.reasons[str(error)[:60]] += 1


def attack(count: int) -> None:
    """Print what an attack of so many messages costs."""
    vary = {"speed": (50.0, 500.0)}
    with fm.explore(fm.mechanisms.slider_crank, vary=vary, periods=1, open=False, block=False) as page:
        page.set(speed=100.0)
        before, began = resident(), time.perf_counter()
        attacks = [Attack(page.url, count // 4) for _ in range(4)]
        for one in attacks:
            one.start()
        took = []
        while any(one.is_alive() for one in attacks):
            moved = time.perf_counter()
            view = page.set(speed=100.0 + len(took) % 300)
            took.append(time.perf_counter() - moved)
            assert view.ok, view.status
            time.sleep(0.2)
        seconds, away = time.perf_counter() - began, sum(one.sent_away for one in attacks)
        reasons = dict(sum((one.reasons for one in attacks), Counter()))
        middle, most = 1e3 * statistics.median(took), 1e3 * max(took)
        print(f"{count} messages in {seconds:.0f} s; sent away {away} times: {reasons}")
        print(f"    a slider of a script meanwhile: median {middle:.0f} ms, at most {most:.0f} ms of {len(took)} moves")
        began = time.perf_counter()
        code = httpx.get(page.url).status_code
        print(f"    then the page answers {code} in {1e3 * (time.perf_counter() - began):.0f} ms; {page.view.status}")
        gc.collect()
        print(f"    memory {before:.0f} MB before, {resident():.0f} MB after; threads {threading.active_count()}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--changes", type=int, help="number of random changes for a look at the memory")
    parser.add_argument("--attack", type=int, help="number of messages of an attack")
    parser.add_argument("--count", type=int, default=50, help="number of timed changes")
    options = parser.parse_args()
    if options.attack:
        attack(options.attack)
    elif options.changes:
        memory(options.changes)
    else:
        for name in CASES:
            times(name, options.count)
