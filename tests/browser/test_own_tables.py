"""Tables of balls on the page: a tracker's places, and bounces that were heard, are measured."""

from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.conftest import FIRST_USE_MS, Served, type_in, visit
from tests.browser.test_accessibility import faults

BOUNCE, RATE_HZ, GRAVITY, FALL_M = 0.8, 120.0, 9.80665, 0.8


def places(path: Path) -> Path:
    """Write the heights of a ball that falls and bounces in a vacuum, in cm, frame by frame."""
    first = (2 * FALL_M / GRAVITY) ** 0.5
    begun, speed, contact = 0.0, 0.0, first
    rows = ["frame,x (cm),y (cm)"]
    scatter = np.random.default_rng(1).normal(0.0, 0.02, 150)
    for frame in range(150):
        t = frame / RATE_HZ
        while t > contact:
            begun, speed = contact, BOUNCE * (speed if begun else GRAVITY * first)
            contact = begun + 2 * speed / GRAVITY
        since = t - begun
        height = (0.0 if begun else FALL_M) + speed * since - 0.5 * GRAVITY * since**2
        rows.append(f"{frame},{0.2 * frame:.3f},{100 * height + scatter[frame]:.3f}")
    path.write_text("\n".join(rows), encoding="utf-8")
    return path


def bounces(page: Page) -> Locator:
    return page.get_by_test_id("own-bounces").locator("tbody tr")


def coefficients(page: Page) -> list[tuple[float, float]]:
    """Return e of each bounce and its standard error, as the page says them."""
    found = []
    for said in bounces(page).locator("td:last-child").all_inner_texts():
        value, digits = re.fullmatch(r"(\d\.\d+)\((\d+)\)", said).groups()  # type: ignore[union-attr]
        found.append((float(value), int(digits) * 10.0 ** -len(value.partition(".")[2])))
    return found


@pytest.mark.long
def test_a_tracker_s_table_is_dropped_measured_and_handed_back(page: Page, served: Served) -> None:
    visit(page, f"{served.url}/own")
    page.locator("input[type=file]").set_input_files(places(served.folder / "places.csv"))
    said = page.get_by_test_id("own-track")
    expect(said).to_contain_text("150 places of 1 thing, without times", timeout=FIRST_USE_MS)
    type_in(page.get_by_test_id("ball-diameter-mm"), "40")
    expect(page.get_by_test_id("own-measure")).to_be_disabled()
    expect(page.get_by_test_id("no-rate")).to_be_visible()
    type_in(page.get_by_test_id("fps"), f"{RATE_HZ:g}")
    expect(page.get_by_test_id("no-rate")).to_be_hidden()
    assert faults(page) == []
    page.get_by_test_id("own-measure").click()
    expect(bounces(page)).to_have_count(2, timeout=FIRST_USE_MS)
    for value, sigma in coefficients(page):
        assert abs(value - BOUNCE) < 4 * sigma < 0.1
    figure = page.locator(".own-figure img")
    expect(figure).to_have_js_property("complete", value=True)
    assert figure.evaluate("picture => picture.naturalWidth") > 0
    campaign = page.locator("a[download='campaign.zip']").get_attribute("href") or ""
    packed = page.request.get(served.url + campaign)
    assert "campaign/poses.csv" in zipfile.ZipFile(io.BytesIO(packed.body())).namelist()
    assert faults(page) == []
    # Who comes back finds what was measured; who meant a table of impacts is asked for columns.
    visit(page, f"{served.url}/own")
    page.get_by_test_id("brought-before").get_by_role("link", name="places.csv").first.click()
    expect(bounces(page)).to_have_count(2)
    page.get_by_test_id("as-impacts").click()
    expect(page.get_by_test_id("own-table")).to_contain_text("places.csv: 150 rows")


@pytest.mark.long
def test_bounces_that_were_heard_give_e_without_a_picture(page: Page, served: Served) -> None:
    times = 0.5 + 0.8 * np.cumsum(BOUNCE ** np.arange(7))
    names = ",".join(f"Bounce {k} (s)" for k in range(len(times)))
    heard = served.folder / "heard.csv"
    heard.write_text(f"{names}\n{','.join(f'{t:.5f}' for t in times)}\n")
    visit(page, f"{served.url}/own")
    page.locator("input[type=file]").set_input_files(heard)
    expect(page.get_by_test_id("own-track")).to_contain_text("times of 7 bounces")
    expect(page.get_by_test_id("fps")).to_be_hidden()
    type_in(page.get_by_test_id("ball-diameter-mm"), "40")
    type_in(page.get_by_test_id("ball-mass-g"), "200")
    page.get_by_test_id("own-measure").click()
    expect(bounces(page)).to_have_count(5, timeout=FIRST_USE_MS)
    for value, sigma in coefficients(page):
        assert abs(value - BOUNCE) < sigma
    expect(page.locator(".own-figure")).to_have_count(0)
    page.get_by_test_id("own-compare").click()
    expect(page.get_by_test_id("story-compare")).to_be_visible(timeout=FIRST_USE_MS)
    assert faults(page) == []
