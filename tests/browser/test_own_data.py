"""Own data on the page: a film of a ball is dropped, looked at, measured and handed back."""

from __future__ import annotations

import io
import json
import re
import zipfile
from pathlib import Path

import cv2
import numpy as np
import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import FIRST_USE_MS, Served, type_in, visit
from tests.browser.test_accessibility import faults

BOUNCE = 0.8
RATE_HZ, FALL_PX, TOP, PLATE, RADIUS = 100.0, 4000.0, 40.0, 320.0, 18
BALL_MM = 88.3
"""With 9.81 m/s² a fall of 4000 px/s² is 2.4525 mm a pixel; so the ball of 36 px has 88.3 mm."""


def film(path: Path) -> Path:
    """Draw a ball that falls on a plate and bounces twice with e = 0.8."""
    rows, columns = np.mgrid[:360, :160]
    code = cv2.VideoWriter.fourcc(*"mp4v")
    video = cv2.VideoWriter(str(path), code, RATE_HZ, (160, 360))
    first = (2 * (PLATE - TOP) / FALL_PX) ** 0.5
    begun, speed, contact = 0.0, 0.0, first
    for t in np.arange(130) / RATE_HZ:
        while t > contact:
            begun, speed = contact, BOUNCE * (speed if begun else FALL_PX * first)
            contact = begun + 2 * speed / FALL_PX
        since = t - begun
        start = PLATE if begun else TOP
        row = start - speed * since + 0.5 * FALL_PX * since**2
        inside = np.hypot(rows - row, columns - 80) < RADIUS
        grey = cv2.GaussianBlur(np.where(inside, 210, 60).astype(np.uint8), (0, 0), 1.0)
        video.write(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR))
    video.release()
    return path


@pytest.mark.long
def test_a_film_is_dropped_measured_and_handed_back(page: Page, served: Served) -> None:
    visit(page, f"{served.url}/campaigns")
    page.get_by_test_id("own").click()
    page.locator("input[type=file]").set_input_files(film(served.folder / "bounce.mp4"))
    expect(page.get_by_test_id("own-film")).to_contain_text(
        "130 frames of 160 × 360 pixels; 100 frames a second", timeout=FIRST_USE_MS
    )
    expect(page.get_by_test_id("own-measure")).to_be_disabled()
    type_in(page.get_by_test_id("ball-diameter-mm"), str(BALL_MM))
    page.get_by_test_id("own-measure").click()
    bounces = page.get_by_test_id("own-bounces").locator("tbody tr")
    expect(bounces).to_have_count(2, timeout=FIRST_USE_MS)
    for said in bounces.locator("td:last-child").all_inner_texts():
        value, digits = re.fullmatch(r"(\d\.\d+)\((\d+)\)", said).groups()  # type: ignore[union-attr]
        sigma = int(digits) * 10.0 ** -len(value.partition(".")[2])
        assert abs(float(value) - BOUNCE) < 4 * sigma
    figure = page.locator(".own-figure img")
    expect(figure).to_have_js_property("complete", value=True)
    assert figure.evaluate("picture => picture.naturalWidth") > 0
    links = {
        name: page.locator(f"a[download='{name}']").get_attribute("href") or ""
        for name in ("result-1.json", "campaign.zip")
    }
    result = page.request.get(served.url + links["result-1.json"])
    assert len(json.loads(result.text())["impacts"]) == 2
    campaign = page.request.get(served.url + links["campaign.zip"])
    names = zipfile.ZipFile(io.BytesIO(campaign.body())).namelist()
    assert {"campaign/campaign.toml", "campaign/poses.csv"} <= set(names)
    assert faults(page) == []
    # Who comes back finds the film, and what was measured of it.
    visit(page, f"{served.url}/own")
    page.get_by_test_id("brought-before").get_by_role("link", name="bounce.mp4").first.click()
    expect(page.get_by_test_id("own-bounces").locator("tbody tr")).to_have_count(2)


@pytest.mark.long
def test_part_ring_and_line_are_dragged_and_moved_by_keys(page: Page, served: Served) -> None:
    visit(page, f"{served.url}/own")
    page.locator("input[type=file]").set_input_files(film(served.folder / "dragged.mp4"))
    # The ball of radius 18 px is found by itself in the picture that is shown.
    words = page.get_by_test_id("scale-words")
    expect(words).to_contain_text(re.compile(r"3[5-7]\.\d px across"), timeout=FIRST_USE_MS)
    part = page.get_by_test_id("part-words")
    expect(part).to_contain_text("All of the picture is looked at")
    drag(page, "left-border-of-the-part", 40, 0)
    expect(part).to_have_text(re.compile(r"columns (39|40|41) to 160, rows 0 to 360"))
    lower = page.get_by_test_id("grip-lower-border-of-the-part")
    lower.focus()
    page.keyboard.press("Shift+ArrowUp")
    page.keyboard.press("ArrowUp")
    expect(part).to_contain_text("rows 0 to 349")
    expect(lower).to_be_focused()
    expect(lower).to_have_attribute("aria-valuetext", "row 349")
    page.get_by_test_id("draw-line").click()
    # The line begins over half of the picture's width, 80 px.
    type_in(page.get_by_test_id("line-mm"), str(80 * BALL_MM / 36))
    page.keyboard.press("Tab")
    by_line = page.get_by_test_id("by-line")
    expect(by_line).to_contain_text("By the line the ball is")
    assert abs(told_mm(by_line.inner_text()) - BALL_MM) < 4
    page.get_by_test_id("grip-other-end-of-the-line").focus()
    page.keyboard.press("Shift+ArrowLeft")
    # A line of 70 px makes what is as long a pixel larger by 8 / 7.
    expect(by_line).not_to_contain_text(f"{told_mm(by_line.inner_text()):.1f}")
    assert abs(told_mm(by_line.inner_text()) - BALL_MM * 8 / 7) < 5
    page.keyboard.press("Shift+ArrowRight")
    assert faults(page) == []
    page.get_by_test_id("own-measure").click()
    bounces = page.get_by_test_id("own-bounces").locator("tbody tr")
    expect(bounces).to_have_count(2, timeout=FIRST_USE_MS)
    expect(page.get_by_test_id("own-result")).not_to_contain_text("another thing was followed")
    page.get_by_test_id("take-all").click()
    expect(part).to_contain_text("All of the picture is looked at")
    # A ring of another size than the ball: what was measured is not what was meant.
    size = page.get_by_test_id("grip-size-of-the-ring")
    size.focus()
    page.keyboard.press("Shift+ArrowRight")
    expect(words).to_contain_text(re.compile(r"5[5-7]\.\d px across"))
    page.get_by_test_id("own-measure").click()
    result = page.get_by_test_id("own-result")
    expect(result).to_contain_text("another thing was followed", timeout=FIRST_USE_MS)


def drag(page: Page, grip: str, columns: float, rows: float) -> None:
    """Drag a handle by so many pixels of the film."""
    handle = page.get_by_test_id(f"grip-{grip}")
    handle.scroll_into_view_if_needed()
    box = handle.bounding_box() or {}
    scale = (
        page.get_by_test_id("own-picture")
        .locator("svg")
        .evaluate("svg => svg.clientWidth / svg.viewBox.baseVal.width")
    )
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + scale * columns / 2, y + scale * rows / 2)
    page.mouse.move(x + scale * columns, y + scale * rows)
    page.mouse.up()


def told_mm(said: str) -> float:
    """Return the length that a sentence says, mm."""
    found = re.search(r"([\d.]+)\(\d+\) mm", said)
    assert found is not None
    return float(found[1])


def table(path: Path) -> Path:
    """Write 40 impacts whose e falls with the speed, heights in cm, with a row that is none."""
    rng = np.random.default_rng(5)
    lines = ["drop height (cm);rebound height (cm);weekday"]
    for fall in np.linspace(4.0, 160.0, 40):
        e = 0.85 - 0.06 * np.log(fall / 4.0) + rng.normal(0, 0.002)
        lines.append(f"{fall:.2f};{fall * e**2:.3f};Mon")
    lines[17] = "20;30;Tue"
    path.write_text("\n".join(lines).replace(".", ","), encoding="utf-8")
    return path


def test_a_table_is_told_what_its_columns_are_and_compared_with_the_model(
    page: Page, served: Served
) -> None:
    visit(page, f"{served.url}/own")
    page.locator("input[type=file]").set_input_files(table(served.folder / "heights.csv"))
    expect(page.get_by_test_id("own-table")).to_contain_text("heights.csv: 40 rows")
    expect(page.get_by_test_id("own-rows")).to_have_text("39 of 40 rows are impacts.")
    expect(page.get_by_text("Line 18 is left out: it parts faster")).to_be_visible()
    assert faults(page) == []
    choose(page, "means-1", "not used")
    expect(page.get_by_test_id("own-open")).to_contain_text("how fast it was after the impact")
    choose(page, "means-1", "height of the rebound")
    choose(page, "unit-1", "cm")
    expect(page.get_by_test_id("own-rows")).to_have_text("39 of 40 rows are impacts.")
    campaign = page.locator("a[download='campaign.zip']").get_attribute("href") or ""
    packed = page.request.get(served.url + campaign)
    assert "campaign/impacts.csv" in zipfile.ZipFile(io.BytesIO(packed.body())).namelist()
    page.get_by_test_id("own-compare").click()
    expect(page.get_by_test_id("story-compare")).to_contain_text(
        "taken from the scatter", timeout=FIRST_USE_MS
    )
    expect(page.get_by_test_id("story-where")).to_contain_text("with the approach speed")
    page.get_by_test_id("amount").wait_for(timeout=FIRST_USE_MS)
    # Falls of 4 to 160 cm end at 0.886 and 5.60 m/s; the fit moves speeds within their scatter.
    said = page.get_by_test_id("next-text").inner_text()
    ends = re.search(r"below ([\d.]+) m/s and above ([\d.]+) m/s", said)
    assert ends is not None
    asked = [float(end) for end in ends.groups()]
    assert asked == pytest.approx([0.886 / 1.5, 1.5 * 5.60], rel=0.15)
    assert faults(page) == []


def choose(page: Page, box: str, words: str) -> None:
    """Choose an entry of a select box."""
    page.get_by_test_id(box).click()
    page.get_by_role("option", name=words, exact=True).click()


def test_what_is_no_film_is_refused_in_words(page: Page, served: Served) -> None:
    visit(page, f"{served.url}/own")
    letter = {"name": "letter.txt", "mimeType": "text/plain", "buffer": b"dear all"}
    page.locator("input[type=file]").set_input_files([letter])
    failed = page.get_by_test_id("own-failed")
    expect(failed).to_contain_text("letter.txt: is neither film, table nor campaign")
    assert faults(page) == []
    # Nothing of it is kept, nor of what is cancelled while the daemon takes it.
    page.route("**/own-data", lambda route: None)
    page.locator("input[type=file]").set_input_files([letter])
    expect(failed).to_be_hidden()
    waits = page.get_by_test_id("bringing")
    # A second choice would be on its way beside it, where Cancel does not reach it.
    expect(page.get_by_test_id("drop")).to_be_disabled()
    expect(waits).to_contain_text(re.compile(r"Bringing 1 file: .*\d+ s gone.* MB are there"))
    assert faults(page) == []
    page.get_by_test_id("cancel-bringing").click()
    expect(waits).to_be_hidden()
    expect(failed).to_be_hidden()
    expect(page.get_by_test_id("drop")).to_be_enabled()
    page.unroute("**/own-data")
    page.reload()
    expect(page.get_by_test_id("drop")).to_be_visible()
    expect(page.get_by_text("letter.txt")).to_have_count(0)


@pytest.mark.long
def test_pictures_without_a_frame_rate_are_measured_once_it_is_stated(
    page: Page, served: Served
) -> None:
    pictures = []
    for number in range(4):
        grey = np.full((60, 80), 40, np.uint8)
        cv2.circle(grey, (40, 20 + 5 * number), 12, 210, -1)
        kept = cv2.imencode(".png", grey)[1].tobytes()
        pictures.append({"name": f"{number}.png", "mimeType": "image/png", "buffer": kept})
    visit(page, f"{served.url}/own")
    page.locator("input[type=file]").set_input_files(pictures)
    expect(page.get_by_test_id("own-film")).to_contain_text(
        "the file states no frame rate", timeout=FIRST_USE_MS
    )
    # What no ball is across is said at the field, and nothing is put in its place.
    diameter = page.get_by_test_id("ball-diameter-mm")
    type_in(diameter, "-40")
    diameter.blur()
    expect(page.get_by_text("0.1 to 2000 mm is allowed")).to_be_visible()
    expect(diameter).to_have_value("-40")
    expect(page.get_by_test_id("own-measure")).to_be_disabled()
    type_in(diameter, "40")
    expect(page.get_by_text("0.1 to 2000 mm is allowed")).to_have_count(0)
    expect(page.get_by_test_id("no-rate")).to_be_visible()
    expect(page.get_by_test_id("own-measure")).to_be_disabled()
    type_in(page.get_by_test_id("fps"), "100")
    expect(page.get_by_test_id("own-measure")).to_be_enabled()
    expect(page.get_by_test_id("no-rate")).to_have_count(0)


@pytest.mark.long
def test_several_films_are_measured_and_one_that_is_none_is_named(
    page: Page, served: Served
) -> None:
    broken = served.folder / "broken.mp4"
    broken.write_bytes(b"no film")
    good = film(served.folder / "good.mp4")
    visit(page, f"{served.url}/own")
    page.locator("input[type=file]").set_input_files([broken, good])
    type_in(page.get_by_test_id("ball-diameter-mm"), str(BALL_MM))
    page.get_by_test_id("own-measure").click()
    bounces = page.get_by_test_id("own-bounces").locator("tbody tr")
    expect(bounces).to_have_count(2, timeout=FIRST_USE_MS)
    expect(bounces.first).to_contain_text("2 / 1")
    result = page.get_by_test_id("own-result")
    expect(result).to_contain_text("broken.mp4")
    expect(result).to_contain_text("2 bounces are too few for the model")
    assert faults(page) == []
