"""What the page says when the daemon is silent, dies, is shared, or never gets an answer."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import (
    Served,
    abort_sweep,
    answer,
    patient_configuration,
    type_in,
    visit,
)

pytestmark = pytest.mark.long

LONG_MS = 60_000
SILENT_MS = 15_000
SILENCE = "nothing on this page is live"
DEAF = 'method = "photometric"\ntimeout_s = 0.001'


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Serve for those who end the daemon."""
    folder = tmp_path_factory.mktemp("faults")
    (folder / "rig.toml").write_text(patient_configuration(), encoding="utf-8")
    running = Served.start(folder, "--config", "rig.toml")
    yield running
    running.end()


def test_a_daemon_that_hangs_covers_the_page_until_it_answers_again(
    page: Page, served: Any
) -> None:
    cover = page.get_by_text(SILENCE)
    expect(cover).to_be_hidden()
    os.kill(served.process.pid, signal.SIGSTOP)
    expect(cover).to_be_visible(timeout=SILENT_MS)
    os.kill(served.process.pid, signal.SIGCONT)
    expect(cover).to_be_hidden(timeout=SILENT_MS)
    expect(page.get_by_test_id("state")).to_have_text("idle")


def test_a_browser_without_its_network_is_covered_and_goes_on_with_what_was_typed(
    page: Page, served: Any
) -> None:
    type_in(page.get_by_test_id("pressure_a_kpa"), "47")
    network = page.context.new_cdp_session(page)
    cut = {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0}
    network.send("Network.emulateNetworkConditions", cut)
    page.evaluate("window.socket.io.engine.close()")
    expect(page.get_by_text(SILENCE)).to_be_visible(timeout=SILENT_MS)
    whole = {**cut, "offline": False, "downloadThroughput": -1, "uploadThroughput": -1}
    network.send("Network.emulateNetworkConditions", whole)
    expect(page.get_by_text(SILENCE)).to_be_hidden(timeout=LONG_MS)
    expect(page.get_by_test_id("pressure_a_kpa")).to_have_value("47")
    page.get_by_test_id("stop").click()
    expect(page.get_by_test_id("latched")).to_be_visible()
    page.get_by_test_id("release").click()
    type_in(page.get_by_test_id("reason"), "a drill")
    answer(page, "release-now")
    expect(page.get_by_test_id("state")).to_have_text("idle")


def test_two_operators_see_each_other_and_only_who_armed_may_fire(page: Page, served: Any) -> None:
    second = page.context.new_page()
    visit(second, served.url)
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("fire")).to_be_enabled(timeout=LONG_MS)
    expect(second.get_by_test_id("arming")).to_contain_text("by somebody else")
    expect(second.get_by_test_id("fire")).to_be_disabled()
    second.get_by_test_id("stop").click()
    expect(page.get_by_test_id("latched")).to_contain_text("stopped by the page's button")
    expect(page.get_by_test_id("fire")).to_be_hidden()
    page.get_by_test_id("release").click()
    type_in(page.get_by_test_id("reason"), "a drill")
    answer(page, "release-now")
    expect(second.get_by_test_id("state")).to_have_text("idle")
    second.close()


def test_a_daemon_killed_in_a_sweep_and_started_again_is_found_by_the_open_page(
    page: Page, served: Any
) -> None:
    page.get_by_role("link", name="Sweeps").click()
    page.get_by_test_id("start-sweep").click()
    state = page.get_by_test_id("sweep-state")
    expect(state).to_contain_text("1 of 24 shots", timeout=LONG_MS)
    served.process.kill()
    expect(page.get_by_text(SILENCE)).to_be_visible(timeout=SILENT_MS)
    served.start_again()
    expect(page.get_by_text(SILENCE)).to_be_hidden(timeout=LONG_MS)
    expect(state).to_contain_text("paused")
    # Killed between the fire and its answer, a shot may also be of unknown outcome.
    expect(page.get_by_text("the daemon ended;")).to_be_visible()
    abort_sweep(page)
    expect(state).to_contain_text("aborted")


def test_an_analysis_that_does_not_end_is_said_and_offered_again(page: Page, served: Any) -> None:
    start_with(served, 'method = "photometric"', DEAF)
    released(page, served)
    page.get_by_test_id("arm").click()
    page.get_by_test_id("fire").click()
    expect(page.get_by_test_id("refusal")).to_contain_text("took too long", timeout=LONG_MS)
    # What the guide says of it may move the link down, and a click would miss it.
    shot = page.get_by_role("link", name="open").get_attribute("href")
    visit(page, f"{served.url}{shot}")
    expect(page.get_by_test_id("analyse-again")).to_be_enabled()


def test_an_interlock_that_refuses_is_marked_and_says_what_to_do(page: Page, served: Any) -> None:
    start_with(served, "free_disk_mb = 200.0", "free_disk_mb = 1e12")
    released(page, served)
    page.get_by_test_id("arm").click()
    refused = page.get_by_test_id("interlocks").locator("tr.fails")
    expect(refused).to_contain_text("▲ disk", timeout=LONG_MS)
    expect(page.get_by_role("alert").filter(has_text="free")).to_be_visible()
    expect(page.get_by_test_id("fire")).to_be_hidden()
    expect(page.get_by_test_id("state")).to_have_text("idle")


def released(page: Page, served: Any) -> None:
    """Open the page, and release a rig that a daemon which was killed has left latched."""
    visit(page, served.url)
    expect(page.locator(".deaf")).to_have_count(0)
    if page.get_by_test_id("latched").is_visible():
        page.get_by_test_id("release").click()
        type_in(page.get_by_test_id("reason"), "a drill")
        answer(page, "release-now")


def start_with(served: Any, line: str, other: str) -> None:
    """Start the daemon anew at the same address with another line in its configuration."""
    text = patient_configuration()
    assert line in text
    (served.folder / "rig.toml").write_text(text.replace(line, other))
    served.start_again()
