"""The story of a model: a hidden effect is shown, moved by a slider, added, and reloaded."""

from __future__ import annotations

import re
from urllib.parse import quote

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.conftest import Served, visit
from tests.browser.test_model_page import HIDDEN, LONG_MS, error_now, known_challenge

MOVED = """(slider, share) => {
  const best = Number(slider.dataset.best);
  slider.value = share * best;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
  return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(
    slider.closest(".lead-card").querySelector(".js-plotly-plot.over").data[0].y.map(Number),
  ))));
}"""

FOURTH_IS_READ = """() => {
  const top = document.getElementById("step-4").getBoundingClientRect().top;
  return top >= 0 && top < innerHeight / 2;
}"""
REDRAWN_MS = 2_000
"""Within which the page changes something, if only to say that it is alive."""
SHOTS = 60
"""Of the challenge."""
LONE_DOT = """(part) => {
  const plot = part.querySelector(".js-plotly-plot") || part;
  const dots = plot._fullData[0];
  const { xaxis, yaxis, margin } = { ...plot._fullLayout, margin: plot._fullLayout._size };
  const frame = plot.getBoundingClientRect();
  const places = dots.x.map((x, k) => [xaxis.d2p(x), yaxis.d2p(dots.y[k])]);
  const room = places.map(([x, y], k) => Math.min(
    ...places.map(([a, b], other) => (other === k ? Infinity : Math.hypot(a - x, b - y))),
  ));
  const alone = room.indexOf(Math.max(...room));
  const [x, y] = places[alone];
  return [dots.customdata[alone], [frame.left + margin.l + x, frame.top + margin.t + y]];
}"""
"""Of the dots the one that is farthest from all others: a click means no other."""


def test_a_hidden_effect_is_moved_added_and_kept_by_a_reload(page: Page, served: Served) -> None:
    folder = known_challenge(served)
    sent: list[str] = []
    page.on("websocket", lambda socket: socket.on("framesent", lambda text: sent.append(str(text))))
    visit(page, f"{served.url}/model?folder={quote(str(folder))}")
    slider = page.get_by_test_id("amount")
    slider.wait_for(timeout=LONG_MS)
    expect(page.get_by_test_id("story-compare")).to_contain_text("times the noise")
    expect(page.get_by_test_id("guide-text")).to_contain_text("add it, and the error falls")
    card = page.get_by_test_id("lead")
    expect(card).to_contain_text("The mirror is not at 45°")
    assert card.locator("math").count() == 1
    drawing = card.locator("img")
    # It is fetched once it is near the screen.
    drawing.scroll_into_view_if_needed()
    page.wait_for_function("picture => picture.naturalWidth > 0", arg=drawing.element_handle())

    without = preview_error(page)
    the_film_shows_the_gap(page)
    a_point_moves_the_film(page)

    before = len(sent)
    half = slider.evaluate(MOVED, 0.5)
    whole = slider.evaluate(MOVED, 1.0)
    assert without > preview_error(page)
    assert max(map(abs, half)) > 0
    assert all(
        abs(2 * a - b) <= 1e-3 * max(map(abs, whole)) for a, b in zip(half, whole, strict=True)
    )
    assert asked(sent[before:]) == []
    predicted = shown_error(page)
    the_thumb_stays_and_keys_move_it(page, slider)
    keys_lead_through_steps_and_map(page)

    page.get_by_test_id(f"add-{HIDDEN}").click()
    expect(page.get_by_test_id("story-added")).to_contain_text("The mirror is not at 45°")
    assert asked(sent[before:]) != []
    # The steps above it are drawn anew, and it comes back to where it is read.
    page.wait_for_function(FOURTH_IS_READ)
    expect(page.get_by_test_id("story-added")).to_contain_text(f"to {predicted} times")
    expect(page.get_by_test_id("guide-text")).to_contain_text("found and added")
    assert page.evaluate("location.search").endswith(f"effects={HIDDEN}&view=story")
    page.reload()
    expect(page.get_by_test_id("story-added")).to_contain_text(
        f"to {predicted} times", timeout=LONG_MS
    )
    expect(page.get_by_test_id("guide")).to_have_count(0)
    added = page.url
    before_and_after_are_turned(page)
    # The fourth step is drawn once more with the next trial: no key is lost meanwhile.
    page.keyboard.press("u")
    expect(page.get_by_test_id("story-added")).to_have_count(0)
    expect(page).not_to_have_url(re.compile(HIDDEN))
    visit(page, added)
    expect(page.get_by_test_id("story-added")).to_have_count(1, timeout=LONG_MS)
    page.get_by_test_id("view-tables").click()
    page.get_by_test_id("error-now").wait_for(timeout=LONG_MS)
    assert abs(error_now(page) - float(predicted)) < 0.006


def before_and_after_are_turned(page: Page) -> None:
    """Look at steps 1 and 2 without the effect, then with it again."""
    said, step = page.get_by_test_id("story-compare"), page.locator("#step-1")
    law = page.get_by_test_id("law")
    expect(said).to_contain_text("agrees with the model")
    expect(law).to_contain_text(re.compile(r"spin-back β₀\s*(\d\.\d+ ± \d\.\d+)\s*was (?!\1)\d"))
    step.get_by_role("button", name="before adding").click()
    expect(said).to_contain_text("times the noise, so this is no noise")
    expect(law).not_to_contain_text("was")
    expect(page.get_by_test_id("story-where")).to_contain_text("wrong")
    step.get_by_role("button", name="after", exact=True).click()
    expect(said).to_contain_text("agrees with the model")


def the_film_shows_the_gap(page: Page) -> None:
    """Scrub to before contact, where the gap is small, and take the model's outlines away."""
    frame, said = page.get_by_test_id("ghost-frame"), page.get_by_test_id("ghost-text")
    expect(said).to_contain_text("ms after contact: the model is")
    largest = gap_mm(said.inner_text())
    frame.focus()
    page.keyboard.press("Home")
    expect(said).to_contain_text("ms before contact: the model is")
    assert gap_mm(said.inner_text()) < 0.5 * largest
    outlines = page.get_by_test_id("ghost").locator("svg > circle")
    assert outlines.count() == 8
    loupe = page.get_by_test_id("ghost").locator(".loupe text")
    expect(loupe).to_have_text(re.compile(r"^\d+ × larger$"))
    page.get_by_role("checkbox", name="model", exact=True).uncheck()
    assert outlines.count() == 4
    assert loupe.count() == 0


def the_thumb_stays_and_keys_move_it(page: Page, slider: Locator) -> None:
    """Leave the slider alone while the page goes on, then press arrows."""
    best = float(slider.get_attribute("data-best") or "nan")
    page.wait_for_timeout(REDRAWN_MS)
    assert float(slider.input_value()) == pytest.approx(best)
    step = float(slider.get_attribute("step") or "nan")
    slider.focus()
    page.keyboard.press("ArrowUp")
    assert abs(float(slider.input_value()) - best) == pytest.approx(step, rel=1e-3)
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Shift+ArrowUp")
    assert abs(float(slider.input_value()) - best) == pytest.approx(10 * step, rel=1e-3)
    page.get_by_test_id("to-best").click()
    assert float(slider.input_value()) == pytest.approx(best)


def keys_lead_through_steps_and_map(page: Page) -> None:
    """Go to a step, read another cell, and open and close the list of keys, by keys alone."""
    page.keyboard.press("2")
    assert page.evaluate("document.activeElement.id") == "step-2"
    chosen = page.get_by_test_id("map").locator("[aria-pressed=true]")
    before = chosen.get_attribute("aria-label") or ""
    chosen.focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    expect(chosen).not_to_have_attribute("aria-label", before)
    page.keyboard.press("?")
    expect(page.locator("#keys")).to_be_visible()
    expect(page.get_by_test_id("stop")).to_be_enabled()
    page.keyboard.press("Escape")
    expect(page.locator("#keys")).to_be_hidden()


def a_point_moves_the_film(page: Page) -> None:
    """Choose another cell, then a point of it, then a shot by its number: the film follows."""
    film = page.get_by_test_id("ghost").locator("svg").first
    where = page.get_by_test_id("story-where")
    told = where.inner_text()
    page.get_by_test_id("map").locator("[aria-pressed=false]").first.click()
    expect(where).not_to_have_text(told)
    dots = page.get_by_test_id("story-points")
    dots.scroll_into_view_if_needed()
    shot, at = dots.evaluate(LONE_DOT)
    page.mouse.click(*at)
    expect(film).to_have_attribute("aria-label", re.compile(rf"^Film of shot {shot} "))
    number = page.get_by_test_id("film-other")
    number.fill("0")
    number.blur()
    expect(number).to_have_value("1")
    number.fill(str(shot % SHOTS + 1))
    number.press("Enter")
    expect(film).to_have_attribute("aria-label", re.compile(rf"^Film of shot {shot % SHOTS + 1} "))


def gap_mm(said: str) -> float:
    """Return by how much the model is said to be off in a frame."""
    return float(said.removesuffix(" mm off.").rpartition(" ")[2])


def asked(sent: list[str]) -> list[str]:
    """Return what of the messages to the server asks something of it."""
    return [text for text in sent if '"event"' in text]


def preview_error(page: Page) -> float:
    """Return the error on unseen shots that the slider shows."""
    return float(shown_error(page))


def shown_error(page: Page) -> str:
    """Return the error on unseen shots with the digits that the slider shows."""
    return page.get_by_test_id("preview-error").inner_text().removesuffix(" ×")
