"""A recording of the page's whole story, as one strip: python -m benchmarks.recording STRIP.

From an empty store to a revealed truth, as a newcomer goes: a shot, thirty more, the verdict on
them, then a challenge, found by itself, answered, revealed and scored. A daemon of its own with the
simulated rig, Chromium in front of it. Takes some minutes; prints when each frame was taken.
"""

from __future__ import annotations

import argparse
import re
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Page

from benchmarks.page_served import launched, opened, served

Picture = NDArray[np.uint8]
SIZE = {"width": 1280, "height": 800}
SHARE = 0.5
"""Of the screen's size that a frame of the strip has."""
ACROSS = 2
GAP = 8
QUALITY = 82
LONG_MS = 600_000
DRAWN_MS = 1_500
MOVED = """slider => {
  slider.value = 0.8 * slider.dataset.best;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
}"""
"""Eight tenths of the best size: the slider is moved as by a hand."""


def story(page: Page, url: str) -> Iterator[str]:
    """Go the whole way, and name each place where a frame is taken."""
    yield "an empty store"
    page.get_by_test_id("arm").click()
    page.get_by_test_id("fire").click(timeout=60_000)
    page.get_by_text("So the bounce e is").wait_for(timeout=LONG_MS)
    page.get_by_test_id("film").wait_for()
    at_top(page)
    yield "the first shot is measured"
    page.get_by_test_id("guide-next").click()
    page.get_by_test_id("preview").locator(".main-svg").first.wait_for()
    page.get_by_test_id("start-sweep").click()
    page.wait_for_url(re.compile(r"/sweeps/\d{8}-s\d{4}$"))
    page.get_by_test_id("sweep-state").get_by_text(re.compile("1[0-9] of 30")).wait_for(
        timeout=LONG_MS
    )
    yield "thirty more are fired"
    page.get_by_test_id("sweep-state").get_by_text("completed").wait_for(timeout=LONG_MS)
    page.get_by_test_id("guide-next").click(timeout=LONG_MS)
    page.get_by_test_id("story-compare").wait_for(timeout=LONG_MS)
    page.get_by_test_id("amount").wait_for(timeout=LONG_MS)
    page.evaluate("document.querySelector('#step-1').scrollIntoView()")
    yield "compared: the film with the model over it"
    yield from _challenge(page, url)


def at_top(page: Page) -> None:
    """Scroll to the top, once what is drawn above has its height."""
    page.wait_for_timeout(DRAWN_MS)
    page.evaluate("scrollTo(0, 0)")
    page.wait_for_function("scrollY === 0")


def _challenge(page: Page, url: str) -> Iterator[str]:
    page.goto(f"{url}/model")
    page.wait_for_function("window.did_handshake")
    yield "a challenge is chosen"
    page.get_by_test_id("new-challenge").click()
    slider = page.get_by_test_id("amount")
    slider.wait_for(timeout=LONG_MS)
    page.evaluate("document.querySelector('#step-3').scrollIntoView()")
    page.wait_for_timeout(DRAWN_MS)
    without = page.get_by_test_id("preview-error").inner_text()
    slider.evaluate(MOVED)
    moved = "before => document.querySelector('[data-testid=preview-error]').innerText !== before"
    page.wait_for_function(moved, arg=without)
    yield "a challenge: the slider moves line and error"
    page.get_by_test_id("explain").click()
    page.get_by_test_id("explained").wait_for(timeout=LONG_MS)
    page.get_by_test_id("staircase").wait_for(timeout=LONG_MS)
    page.evaluate("document.querySelector('#step-4').scrollIntoView()")
    yield "added: the error falls to the floor"
    found = page.evaluate("new URLSearchParams(location.search).get('effects')") or "none"
    for name in str(found).split(","):
        page.get_by_test_id("answer").fill(name)
        page.get_by_role("option", name=re.compile(rf"\({name}\)$")).click()
    page.keyboard.press("Escape")
    page.get_by_test_id("commit").click()
    page.get_by_test_id("commit-now").click()
    page.get_by_test_id("reveal").click()
    page.get_by_test_id("score").wait_for()
    page.get_by_test_id("truth").evaluate("truth => truth.scrollIntoView()")
    page.evaluate("scrollBy(0, -70)")
    yield "revealed, and scored"


def taken(page: Page) -> Picture:
    """Return the screen as a frame of the strip, blue-green-red."""
    page.wait_for_timeout(800)
    shot: Any = cv2.imdecode(np.frombuffer(page.screenshot(), np.uint8), cv2.IMREAD_COLOR)
    return np.asarray(cv2.resize(shot, None, fx=SHARE, fy=SHARE, interpolation=cv2.INTER_AREA))


def strip(frames: list[Picture]) -> Picture:
    """Return frames beside and below each other."""
    rows, columns, _ = frames[0].shape
    down = -(-len(frames) // ACROSS)
    shape = (down * (rows + GAP) + GAP, ACROSS * (columns + GAP) + GAP, 3)
    whole = np.full(shape, 255, np.uint8)
    for k, frame in enumerate(frames):
        top, left = (
            GAP + at * (size + GAP)
            for at, size in zip(divmod(k, ACROSS), (rows, columns), strict=True)
        )
        whole[top : top + rows, left : left + columns] = frame
    return whole


def main() -> None:
    """Record the story and write the strip."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("strip", type=Path, help="file of the strip, .jpg or .png")
    path: Path = parser.parse_args().strip
    frames: list[Picture] = []
    started = time.perf_counter()
    with (
        tempfile.TemporaryDirectory() as folder,
        served(Path(folder)) as daemon,
        launched(aside=False) as browser,
    ):
        page, _ = opened(browser, daemon.url, [])
        page.set_viewport_size({"width": SIZE["width"], "height": SIZE["height"]})
        page.set_default_timeout(60_000)
        for place in story(page, daemon.url):
            frames.append(taken(page))
            print(f"{time.perf_counter() - started:6.1f} s  {place}", flush=True)
    cv2.imwrite(str(path), strip(frames), [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


if __name__ == "__main__":
    main()
