"""How fast the page is, and what it costs the rig: python -m benchmarks.page.

A daemon of its own with the simulated rig, Chromium in front of it. What five pages cost a fire
request is measured with five browsers on the rig's own computer, and apart from that with five that
follow without a browser: what the daemon does for them. Prints each number beside what is asked,
writes out/page.json, and ends 1 where one is missed.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any
from urllib.parse import quote, urlsplit

import numpy as np
from playwright.sync_api import Browser, Page

from benchmarks.cpu_seconds import of_process
from benchmarks.page_cancels import cancels
from benchmarks.page_followers import followers
from benchmarks.page_served import LONG_S, RIGCTL, FireRequest, Served, launched, opened, served
from benchmarks.page_waits import (
    Waited,
    cells_shown,
    first_coefficients,
    first_numbers,
    refused_share,
    settle,
    undone,
)

OUT = Path("out/page.json")
SMALL = 120
PAGES, ROUNDS = 5, 4
DRAWS = 2000
"""Of the two lots of shots again, by which the error of the difference of their medians is had."""
OPENINGS = 5
PARTS = ("first", "coefficients", "fire", "numbers", "cancel", "model", "story", "refused")
WATCH = """() => {
  const chip = document.querySelector('[data-testid=state]');
  window.changes = [];
  new MutationObserver(() => window.changes.push([Date.now(), chip.innerText]))
    .observe(chip, {childList: true, characterData: true, subtree: true});
}"""
REMEMBER = """() => {
  window.structure = () =>
    JSON.stringify(document.querySelector('[data-testid=heat-map]')?._fullData?.[0].z);
  window.steps = () =>
    document.querySelector('[data-testid=error-path] .js-plotly-plot')?._fullData?.[0].x.length;
  window.before = window.structure();
}"""
ANOTHER = "window.steps() > 1 && window.structure() !== window.before"
"""What the plots hold that were drawn last; a plot stays and is drawn over."""
MOVES = 100
WEIGHT = """() => [...performance.getEntriesByType("navigation"),
  ...performance.getEntriesByType("resource")].reduce((sum, one) => sum + one.transferSize, 0)"""
"""Bytes of everything that a page has loaded, packed as they travel."""
SLIDE = """async (slider, moves) => {
  const taken = [];
  for (let move = 1; move <= moves; move++) {
    const began = performance.now();
    slider.value = (move / moves) * slider.dataset.best;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    await new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)));
    taken.push(performance.now() - began);
  }
  return taken;
}"""
AT_REST = "new Promise(done => requestIdleCallback(() => requestIdleCallback(done)))"


@dataclass(frozen=True, slots=True)
class Number:
    """One number beside what is asked of it; `asked` is None where nothing is."""

    what: str
    value: float
    unit: str
    asked: float | None = None

    @property
    def met(self) -> bool:
        return self.asked is None or self.value <= self.asked

    def line(self) -> str:
        asked = "" if self.asked is None else f"at most {self.asked:g} {self.unit}"
        mark = "" if self.met else "  MISSED"
        return f"{self.what:<66} {self.value:9.3g} {self.unit:<3} {asked}{mark}"


def first_page(browser: Browser, daemon: Served) -> list[Number]:
    asked: list[str] = []
    times, weight = [], 0.0
    for _ in range(OPENINGS):
        page, took = opened(browser, daemon.url, asked)
        times.append(took)
        weight = page.evaluate(WEIGHT)
        page.context.close()
    foreign = [
        url
        for url in asked
        if urlsplit(url).scheme in {"http", "https", "ws", "wss"}
        and urlsplit(url).hostname != "127.0.0.1"
    ]
    return [
        Number("first page until it can be used, median", statistics.median(times), "s", 2.0),
        Number("first page until it can be used, longest", max(times), "s"),
        Number("first page, as it travels", weight / 1e6, "MB", 1.0),
        Number(f"requests beyond loopback, of {len(asked)}", len(foreign), "", 0),
    ]


@dataclass(slots=True)
class Fired:
    """Fire requests, and CPU seconds of the daemon until all that follows them is done."""

    requests: list[FireRequest] = field(default_factory=list)
    daemon_s: float = 0.0

    @property
    def took(self) -> list[float]:
        return [one.took_s for one in self.requests]

    def fire(self, daemon: Served, shots: int) -> None:
        """Fire so many, one after another, and wait until all that follows is done."""
        before = of_process(daemon.pid)
        self.requests += [daemon.fire() for _ in range(shots)]
        settle(daemon)
        self.daemon_s += of_process(daemon.pid) - before


def fire_delay(browser: Browser, daemon: Served, shots: int) -> Iterator[Number]:
    """Compare fire requests with and without pages that follow the rig ten times a second.

    Five pages without a browser show what the daemon does for them. Five in browsers add what these
    draw on the same processors, as on a computer that is rig and desk in one.
    """
    daemon.fire()
    alone, followed, watched, shown = Fired(), Fired(), Fired(), []
    for _ in range(ROUNDS):
        alone.fire(daemon, shots // ROUNDS)
        with followers(daemon.url, PAGES):
            settle(daemon)
            followed.fire(daemon, shots // ROUNDS)
        pages = [opened(browser, daemon.url, [])[0] for _ in range(PAGES)]
        settle(daemon)
        watched.fire(daemon, shots // ROUNDS)
        shown += [latency(page, daemon) for page in pages]
        for page in pages:
            page.context.close()
        settle(daemon)
    yield from fire_numbers("alone", alone)
    for whose, fired in (
        (f"with {PAGES} pages without browsers", followed),
        (f"with {PAGES} browsers on this host", watched),
    ):
        yield from fire_numbers(whose, fired)
        added = statistics.median(fired.took) - statistics.median(alone.took)
        yield Number("  added to the request, medians", 1e3 * added, "ms", 10.0)
        off = sigma_of_difference(fired.took, alone.took)
        yield Number("    its standard error", 1e3 * off, "ms")
        spent = fired.daemon_s / len(fired.took) - alone.daemon_s / len(alone.took)
        yield Number("  added to the daemon's CPU time of a whole shot", 1e3 * spent, "ms")
    yield Number(
        "state shown after it changed, median", 1e3 * statistics.median(shown), "ms", 200.0
    )


def fire_numbers(whose: str, fired: Fired) -> Iterator[Number]:
    """Return how long fire requests took, and what of it the daemon ran and waited."""
    took, name = fired.took, f"fire request {whose}"
    yield Number(f"{name}, median of {len(took)}", 1e3 * statistics.median(took), "ms")
    yield Number("  longest", 1e3 * max(took), "ms")
    yield Number("  distance between its quartiles", 1e3 * middle_half(took), "ms")
    ran, waited = (
        statistics.median(getattr(one, what) for one in fired.requests)
        for what in ("ran_s", "waited_s")
    )
    yield Number("  threads of the daemon ran within it, median", 1e3 * ran, "ms")
    yield Number("  and waited for a processor, median", 1e3 * waited, "ms")


def sigma_of_difference(one: Sequence[float], other: Sequence[float]) -> float:
    """Return the standard error of a difference of medians, by drawing both lots again."""
    rng = np.random.default_rng(1)
    drawn = [
        np.median(rng.choice(lot, (DRAWS, len(lot))), axis=1) for lot in (list(one), list(other))
    ]
    return float(np.std(drawn[0] - drawn[1]))


def middle_half(values: Sequence[float]) -> float:
    """Return the distance between the quartiles."""
    low, high = np.quantile(list(values), [0.25, 0.75])
    return float(high - low)


def latency(page: Page, daemon: Served) -> float:
    """Return how long after a stop the page shows it, s, from the time that the rig gives it."""
    # Another page may have seen the release of the last stop sooner.
    page.get_by_text("idle", exact=True).wait_for()
    page.evaluate(WATCH)
    daemon.rest.post("/api/v1/rig/estop", json={"reason": "the benchmark"}).raise_for_status()
    page.wait_for_function("window.changes.length > 0")
    at = page.evaluate("window.changes[0][0]") / 1e3
    began = datetime.fromisoformat(daemon.rest.get("/api/v1/rig").json()["since"]).timestamp()
    daemon.rest.post("/api/v1/rig/release", json={"reason": "the benchmark"}).raise_for_status()
    page.get_by_text("idle", exact=True).wait_for()
    return float(at - began)


def model_page(browser: Browser, daemon: Served, folder: Path) -> Iterator[Number]:
    """Open the model of a large campaign unknown and known, and add an effect."""
    address = f"{daemon.url}/model?folder={quote(str(folder))}&view=tables"
    page, _ = opened(browser, daemon.url, [])
    reacts = _until(page, address, "window.did_handshake && document.querySelector('.busy')")
    yield Number("model page of 1000 shots reacts, nothing fitted yet", reacts, "s", 3.0)
    drawn = "document.querySelectorAll('[data-testid=heat-map] .main-svg').length > 0"
    page.wait_for_function(drawn)
    yield Number("  its fit, agreement, structure and ranking", _lasted(daemon.job()), "s")
    known = _until(page, address, drawn)
    yield Number("model page of 1000 shots drawn, fit known", known, "s", 3.0)
    best = page.locator("[data-testid^=add-]").first.get_attribute("data-testid") or ""
    said = f"With {best.removeprefix('add-')}"
    page.evaluate(REMEMBER)
    page.wait_for_function("window.steps() === 1")
    page.evaluate(AT_REST)
    began = time.perf_counter()
    page.get_by_test_id(best).click()
    page.wait_for_function(
        f"document.querySelector('[data-testid=verdict]')?.innerText.includes('{said}')"
    )
    page.wait_for_function(ANOTHER)
    redrawn = time.perf_counter() - began - _lasted(daemon.job())
    yield Number("effect added: redrawn after the fit's own time", redrawn, "s", 0.5)


def story_page(browser: Browser, daemon: Served, folder: Path) -> Iterator[Number]:
    """Move the slider of the story's best effect; what it draws is awaited to the next frame."""
    page, _ = opened(browser, daemon.url, [])
    page.goto(f"{daemon.url}/model?folder={quote(str(folder))}")
    slider = page.get_by_test_id("amount")
    slider.wait_for(timeout=1e3 * LONG_S)
    page.evaluate(AT_REST)
    yield Number("a model's story, beside the first page", page.evaluate(WEIGHT) / 1e6, "MB", 1.0)
    taken = sorted(slider.evaluate(SLIDE, MOVES))
    yield Number("slider moved: redrawn, median", statistics.median(taken), "ms", 50.0)
    yield Number("  of 20 moves 19 are faster than", taken[-MOVES // 20], "ms")
    shown, back = cells_shown(page, daemon), undone(page, daemon)
    waited = (
        (f"a cell chosen: its points drawn, median of {len(shown)}", shown, 200.0),
        ("  the first, before the browser has compiled what draws them", shown[:1], 200.0),
        ("undone", [back], 300.0),
    )
    for what, taken, most_ms in waited:
        yield Number(what, 1e3 * statistics.median(one.seconds for one in taken), "ms", most_ms)
        spent = statistics.median(one.daemon_s + one.browser_s for one in taken)
        yield Number("  CPU time of daemon and browser within it", 1e3 * spent, "ms")


def waits(browser: Browser, daemon: Served, small: Path) -> dict[str, Callable[[], list[Number]]]:
    """Return what measures each wait; `small` is a campaign of 120 shots that nobody has fitted."""

    def coefficients() -> list[Number]:
        took = first_coefficients(opened(browser, daemon.url, [])[0], daemon)
        what = "first shot of a fresh store: fired until its coefficients"
        return waited_numbers(what, took, 5.0)

    def numbers() -> list[Number]:
        took = first_numbers(opened(browser, daemon.url, [])[0], daemon, daemon.url, small)
        return waited_numbers("model of 120 shots until its first numbers", took, 3.0)

    def refused() -> list[Number]:
        (shots, count), (share, of) = refused_share(daemon)
        return [Number(shots, count, ""), Number(share, of, "%", 3.0)]

    return {"coefficients": coefficients, "numbers": numbers, "refused": refused}


def cancel_numbers(browser: Browser, daemon: Served, large: Path) -> Iterator[Number]:
    """Cancel each kind of long work on the page."""
    for what, taken in cancels(browser, daemon, large):
        yield Number(f"{what}: cancel answered, median", _median(taken), "s", 0.5)
        yield Number("  longest", taken[-1].seconds, "s", 0.9)
        spent = statistics.median(one.daemon_s + one.browser_s for one in taken)
        yield Number("  CPU time of daemon and browser within one, median", spent, "s", 0.5)


def _median(taken: Sequence[Waited]) -> float:
    return statistics.median(one.seconds for one in taken)


def waited_numbers(what: str, waited: Waited, asked_s: float) -> list[Number]:
    """Return a wait, the CPU seconds within it, and print its steps."""
    print(f"  {waited.chain()}")
    spent = (("daemon", waited.daemon_s), ("workers", waited.workers_s))
    return [
        Number(what, waited.seconds, "s", asked_s),
        Number("  CPU time of daemon, workers and browser within it", waited.cpu_s, "s", asked_s),
        *(Number(f"    of the {whose}", value, "s") for whose, value in spent),
    ]


def _until(page: Page, address: str, condition: str) -> float:
    began = time.perf_counter()
    page.goto(address, wait_until="commit")
    page.wait_for_function(condition)
    return time.perf_counter() - began


def _lasted(job: dict[str, Any]) -> float:
    """Return how long a job ran, s."""
    began, ended = (datetime.fromisoformat(job[name]) for name in ("started_at", "ended_at"))
    return float((ended - began).total_seconds())


def told(found: Iterable[Number]) -> list[Number]:
    """Print each number as soon as it is known, and return them all."""
    kept = []
    for number in found:
        print(number.line(), flush=True)
        kept.append(number)
    return kept


def main() -> int:
    """Measure, print, write."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--fires", type=int, default=60, help="with browsers, and as many without")
    asked.add_argument("--shots", type=int, default=1000, help="of the large campaign")
    asked.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS))
    asked.add_argument("--out", type=Path, default=OUT)
    options = asked.parse_args()
    # Compiled beside the first shot, for minutes, it would be measured instead of the page.
    subprocess.run([str(RIGCTL), "precompile"], check=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        large, small = folder / "large", folder / "small"
        for place, shots in ((large, options.shots), (small, SMALL)):
            made = [str(RIGCTL), "challenge", "new", str(place), "--shots", str(shots)]
            subprocess.run([*made, "--seed", "4"], check=True, capture_output=True)
        with served(folder) as daemon:
            parts: dict[str, Callable[[Browser], Iterable[Number]]] = {
                "first": lambda browser: first_page(browser, daemon),
                "fire": lambda browser: fire_delay(browser, daemon, options.fires),
                "cancel": lambda browser: cancel_numbers(browser, daemon, large),
                "model": lambda browser: model_page(browser, daemon, large),
                "story": lambda browser: story_page(browser, daemon, large),
            }
            found = []
            for part in options.parts:
                with launched(aside=part == "fire") as browser:
                    wait = waits(browser, daemon, small).get(part)
                    found += told(parts[part](browser) if wait is None else wait())
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps([asdict(number) for number in found], indent=1) + "\n")
    return 0 if all(number.met for number in found) else 1


if __name__ == "__main__":
    sys.exit(main())
