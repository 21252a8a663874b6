"""A sweep on the page: built, watched, paused, resumed, given up, and stopped in its middle."""

from __future__ import annotations

import re
from typing import Any
from urllib.parse import quote

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import abort_sweep, answer, type_in, visit
from tests.browser.test_accessibility import faults, out_of_reach

pytestmark = pytest.mark.long

LONG_MS = 60_000


def test_a_sweep_is_previewed_watched_paused_resumed_and_aborted(page: Page) -> None:
    started(page, repeat=6)
    state = page.get_by_test_id("sweep-state")
    expect(state).to_contain_text(re.compile(r"[1-9]\d* of 24 shots"), timeout=LONG_MS)
    # Before points are waited for: shots are fired faster than a busy host measures them.
    page.get_by_test_id("pause").click()
    expect(state).to_contain_text("paused", timeout=LONG_MS)
    fired = done(page)
    assert 1 <= fired < 24
    expect(page.get_by_test_id("grows").locator(".scatterlayer .point")).not_to_have_count(
        0, timeout=LONG_MS
    )
    page.get_by_test_id("resume").click()
    expect(state).to_contain_text("running")
    expect(state).to_contain_text(f"{fired + 1} of 24 shots", timeout=LONG_MS)
    abort_sweep(page)
    expect(state).to_contain_text("aborted", timeout=LONG_MS)
    expect(page.get_by_test_id("resume")).to_have_count(0)
    expect(page.get_by_test_id("steps")).to_contain_text("skipped")
    assert faults(page) == []
    assert out_of_reach(page) == []


def test_a_stop_in_the_middle_of_a_sweep_fires_nothing_more_until_a_person_says_so(
    page: Page,
) -> None:
    started(page, repeat=2)
    state = page.get_by_test_id("sweep-state")
    expect(state).to_contain_text("1 of 8 shots", timeout=LONG_MS)
    page.keyboard.press("Control+.")
    expect(page.get_by_test_id("latched")).to_contain_text("stopped by the page's key")
    expect(state).to_contain_text("paused", timeout=LONG_MS)
    stopped_at = done(page)
    page.get_by_test_id("resume").click()
    expect(
        page.get_by_role("alert").filter(has_text="release the rig with a reason")
    ).to_be_visible()
    page.get_by_test_id("release").click()
    type_in(page.get_by_test_id("reason"), "tubes looked at: empty")
    answer(page, "release-now")
    expect(page.get_by_test_id("state")).to_have_text("idle", timeout=LONG_MS)
    expect(state).to_contain_text(f"{stopped_at} of 8 shots")
    abort_sweep(page)
    expect(state).to_contain_text("aborted")


def test_a_sweep_that_cannot_be_is_refused_before_anything_moves(page: Page) -> None:
    page.get_by_role("link", name="Sweeps").click()
    page.get_by_test_id("preview").wait_for()
    page.wait_for_function("window.did_handshake")
    type_in(page.get_by_test_id("repeat"), "100")
    type_in(page.get_by_test_id("pn"), "50")
    expect(page.get_by_test_id("sweep-text")).to_contain_text("a sweep holds 1 to 10000 shots")
    expect(page.get_by_test_id("start-sweep")).to_be_disabled()


def test_proposed_shots_open_as_a_form_and_fire_nothing_by_themselves(
    page: Page, served: Any
) -> None:
    shots = '[{"pressure_a_kpa": 50, "pressure_b_kpa": 50, "offset_mm": 9, "repeat": 3}]'
    form = f'{{"note": "tells a from b", "campaign": "next", "shots": {shots}}}'
    visit(page, f"{served.url}/sweeps?form={quote(form)}")
    expect(page.get_by_test_id("proposed")).to_contain_text("50")
    expect(page.get_by_test_id("sweep-text")).to_have_text("3 shots")
    expect(page.get_by_test_id("preview").locator(".scatterlayer .point")).to_have_count(1)
    expect(page.get_by_test_id("start-sweep")).to_be_enabled()
    expect(page.get_by_test_id("state")).to_have_text("idle")
    visit(page, f"{served.url}/sweeps?form={quote(form.replace('50', '-5'))}")
    expect(page.get_by_text("The proposed shots are no sweep")).to_be_visible()


def test_a_shot_of_a_sweep_is_excluded_with_a_reason_and_counts_again(page: Page) -> None:
    started(page, repeat=1, points=1)
    expect(page.get_by_test_id("sweep-state")).to_contain_text("completed", timeout=LONG_MS)
    page.get_by_role("link", name="Campaigns").click()
    page.get_by_test_id("campaigns").get_by_role("cell", name="sweep").click()
    type_in(page.get_by_test_id("filter"), "analysed")
    row = page.get_by_test_id("shots").locator("tbody tr").first
    expect(row).to_contain_text("0.7")
    row.click()
    page.get_by_test_id("exclude").click()
    expect(page.get_by_test_id("exclude-now")).to_be_disabled()
    type_in(page.get_by_test_id("reason"), "the sphere was chipped")
    answer(page, "exclude-now")
    expect(page.get_by_test_id("excluded")).to_contain_text("the sphere was chipped")
    page.get_by_test_id("include").click()
    expect(page.get_by_test_id("excluded")).to_have_count(0)
    expect(page.get_by_test_id("exclude")).to_be_visible()


def started(page: Page, repeat: int, points: int = 2) -> None:
    """Start a sweep of so many pressures and as many offsets, and stay on its page."""
    page.get_by_role("link", name="Sweeps").click()
    # What is typed before the page is connected is not heard.
    page.get_by_test_id("preview").wait_for()
    page.wait_for_function("window.did_handshake")
    type_in(page.get_by_test_id("repeat"), str(repeat))
    expect(page.get_by_test_id("sweep-text")).to_have_text(f"{24 * repeat} shots")
    fields = {"p0": 40, "p1": 60, "pn": points, "o0": 6, "o1": 8, "on": points}
    for field, value in fields.items():
        type_in(page.get_by_test_id(field), str(value))
    for field, value in fields.items():
        expect(page.get_by_test_id(field)).to_have_value(str(value))
    expect(page.get_by_test_id("sweep-text")).to_have_text(
        re.compile(rf"^{points**2 * repeat} shots?$")
    )
    preview = page.get_by_test_id("preview")
    if points == 2:
        expect(preview).to_contain_text("sliding ÷ approach from about 0.24 to 0.33")
    expect(preview.locator(".scatterlayer .point")).to_have_count(points**2)
    page.get_by_test_id("start-sweep").click()
    page.wait_for_url(re.compile(r"/sweeps/\d{8}-s\d{4}$"))


def done(page: Page) -> int:
    """Return how many steps the page says have ended."""
    said = page.get_by_test_id("sweep-state").inner_text()
    found = re.search(r"(\d+) of \d+ shots", said)
    assert found is not None
    return int(found[1])
