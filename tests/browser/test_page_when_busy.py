"""What stands on the page outlasts a network, a daemon and a browser that are busy for a while."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import KEY, entered, type_in
from tests.browser.wire import Wire

pytestmark = pytest.mark.long

LONG_MS = 60_000
AWAY_MS = 6_000
"""Twice as long as the page library by itself keeps a page without a connection."""
SILENCE = "nothing on this page is live"
ORDER = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 6.0}
DRILL = {"reason": "a drill"}
BEATS = """() => new Promise(done => {
  let left = 2;
  new MutationObserver(() => --left || done()).observe(
    document.querySelector('.watch'), {attributes: true, attributeFilter: ['class']});
})"""
"""Ends when the daemon has proved twice that the page is live."""


@pytest.fixture(scope="module")
def wire(served: Any) -> Iterator[Wire]:
    between = Wire(served.url)
    yield between
    between.end()


@pytest.fixture
def rest(served: Any) -> Iterator[httpx.Client]:
    bearer = {"Authorization": f"Bearer {KEY}"}
    with httpx.Client(base_url=f"{served.url}/api/v1", headers=bearer, timeout=60) as client:
        yield client


@pytest.fixture
def far(tab: Page, wire: Wire) -> Iterator[Page]:
    """The page at the other end of the wire, marked: a page that was loaded anew has no mark."""
    with entered(tab, wire.url):
        tab.evaluate("window.mark = 'the same'")
        yield tab


def test_a_page_that_was_cut_off_for_a_while_goes_on_with_what_was_typed(
    far: Page, wire: Wire, rest: httpx.Client
) -> None:
    type_in(far.get_by_test_id("pressure_a_kpa"), "47")
    type_in(far.get_by_test_id("campaign"), "long-typed")
    arm(rest)
    expect(far.get_by_test_id("state")).to_have_text("armed")
    wire.cut()
    expect(far.get_by_text(SILENCE)).to_be_visible()
    far.wait_for_timeout(AWAY_MS)
    stop_and_release(rest)
    wire.mend()
    expect(far.get_by_text(SILENCE)).to_be_hidden(timeout=LONG_MS)
    expect(far.get_by_test_id("state")).to_have_text("idle")
    assert far.evaluate("window.mark") == "the same"
    expect(far.get_by_test_id("pressure_a_kpa")).to_have_value("47")
    expect(far.get_by_test_id("campaign")).to_have_value("long-typed")


def test_what_was_on_its_way_when_the_network_broke_is_not_shown_after_what_came_later(
    far: Page, wire: Wire, rest: httpx.Client
) -> None:
    wire.hold()
    rest.post("/rig/estop", json=DRILL).raise_for_status()
    expect(far.get_by_text(SILENCE)).to_be_visible()
    wire.cut()
    rest.post("/rig/release", json=DRILL).raise_for_status()
    wire.mend()
    expect(far.get_by_text(SILENCE)).to_be_hidden(timeout=LONG_MS)
    far.evaluate(BEATS)
    assert far.get_by_test_id("state").inner_text() == "idle"
    expect(far.get_by_test_id("latched")).to_be_hidden()
    assert far.evaluate("window.mark") == "the same"


def test_what_was_pressed_without_a_connection_does_not_move_the_rig_once_it_is_back(
    far: Page, wire: Wire, rest: httpx.Client
) -> None:
    far.get_by_test_id("arm").focus()
    wire.cut()
    expect(far.get_by_text(SILENCE)).to_be_visible()
    far.keyboard.press("Enter")
    wire.mend()
    expect(far.get_by_role("alert").filter(has_text="press it again")).to_be_visible()
    expect(far.get_by_test_id("state")).to_have_text("idle")
    assert rest.get("/rig").json()["state"] == "idle"


def arm(rest: httpx.Client) -> None:
    """Arm the rig."""
    rest.post("/rig/arm", json=ORDER).raise_for_status()


def stop_and_release(rest: httpx.Client) -> None:
    """Have the rig idle at once: a token lives for half a minute."""
    for act in ("estop", "release"):
        rest.post(f"/rig/{act}", json=DRILL).raise_for_status()
