"""Every screen for everybody: axe-core finds nothing, nothing scrolls sideways, focus is seen."""

from __future__ import annotations

import re
from urllib.parse import quote

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.browser.conftest import FIRST_USE_MS, Served, fire, type_in, visit
from tests.browser.test_model_page import LONG_MS, known_challenge

LOOKS = ((320, "dark"), (768, "light"), (1280, "dark"), (1920, "light"))
PLACES = (
    "/",
    "/commissioning",
    "/recorder",
    "/shots",
    "/sweeps",
    "/campaigns",
    "/model",
    "/own",
    "/campaigns/seen",
)
BAD = {"resultTypes": ["violations"]}
COLOURS = {"runOnly": ["color-contrast", "target-size", "meta-viewport", "aria-hidden-focus"]}
"""What a narrow dark screen may get wrong alone."""
RULES: dict[int, dict[str, list[str]]] = {320: {**COLOURS, **BAD}, 1920: BAD}
VIOLATIONS = "async (rules) => (await axe.run(document, rules)).violations"
STOPS = 250
"""After so many a screen has a trap: the tabulator does not come round."""
BUNCH = 10
"""So many keys are pressed before the page is asked where they led."""
NOTED = """() => {
  document.activeElement.blur();
  window.reached = new Set();
  window.stops = [];
  if (window.noted) return;
  window.noted = true;
  const ring = (part) => part && parseFloat(getComputedStyle(part).outlineWidth) >= 3
    && getComputedStyle(part).outlineStyle === "solid";
  addEventListener("keyup", () => {
    const at = document.activeElement;
    if (at === document.body) return window.stops.push(null);
    window.reached.add(at.outerHTML.slice(0, 160));
    window.stops.push(
      ring(at) || ring(at.closest(".q-field__control")) ? "" : at.outerHTML.slice(0, 200));
  }, true);
}"""
"""Has the page note after each key what has the focus without showing it, or nothing, or null where
the tabulator has come round."""
STOPPED = "() => window.stops.splice(0)"
CONTROLS = """() => {
  const focusable = "a[href], button, input, select, textarea, summary, [tabindex='0']";
  const mute = ":disabled, [aria-disabled=true], .disabled";
  const shown = (part) => part.checkVisibility({ visibilityProperty: true, opacityProperty: true })
    && part.getClientRects().length > 0;
  const found = [];
  for (const part of document.body.querySelectorAll("*")) {
    if (!shown(part) || part.closest(mute)) continue;
    const control = part.matches(focusable) && part.tabIndex >= 0;
    // A pointer of a hand over what no key comes to is a control for the mouse alone.
    // The pointer over a line of a table is that over its cells.
    const hand = getComputedStyle(part.cells?.[0] ?? part).cursor === "pointer"
      && getComputedStyle(part.parentElement).cursor !== "pointer";
    const inside = part.querySelector(focusable) || part.closest(focusable);
    const label = part.closest("label");
    if (control || (hand && !inside && !(label && label.control))) found.push(part);
  }
  const known = found.map((part) => part.outerHTML.slice(0, 160));
  // Parts are known by what they are: a screen that shows news draws them anew.
  return known.filter((part) => !window.reached.has(part));
}"""
"""Controls of a screen that the tabulator has not come to."""

CUT = """() => [...document.querySelectorAll(
    ".on-page, .effects .head-cell, .effects .number > :not(.range)"
  )].filter((part) => part.scrollWidth > part.clientWidth).map((part) => part.textContent)"""
"""Titles that are cut, and numbers with units that reach into the next column."""


BROKEN = """() => {
  const found = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walk.nextNode(); node; node = walk.nextNode()) {
    if (!node.parentElement.checkVisibility() || node.parentElement.closest("svg, style")) continue;
    // What is hyphenated by the rules of its language, or is one long name, may go on below.
    if (getComputedStyle(node.parentElement).hyphens === "auto") continue;
    for (const { 0: word, index } of node.textContent.matchAll(/[A-Za-z]{2,14}/g)) {
      const range = document.createRange();
      range.setStart(node, index);
      range.setEnd(node, index + word.length);
      if (new Set([...range.getClientRects()].map((one) => Math.round(one.top))).size > 1)
        found.push(word);
    }
  }
  return found;
}"""
"""Words that are broken in their middle."""


def test_axe_finds_nothing_nothing_scrolls_sideways_and_focus_is_seen_on_any_screen(
    page: Page, served: Served
) -> None:
    type_in(page.get_by_test_id("campaign"), "seen")
    fire(page)
    page.get_by_test_id("film").wait_for(timeout=LONG_MS)
    page.get_by_test_id("coefficients").wait_for(timeout=FIRST_USE_MS)
    shot = page.locator("a[href^='/shots/']").first.get_attribute("href") or ""
    for place in (*PLACES, shot):
        visit(page, served.url + place)
        if place in {"/shots", "/campaigns/seen"}:
            page.get_by_test_id("shots").locator("tbody tr").first.wait_for()
        assert faults(page) == [], place
        assert out_of_reach(page) == [], place
    visit(page, served.url + "/shots")
    sorted_by_keys_and_not_drawn_anew(page)
    visit(page, served.url + shot)
    # Of the frames below the film one is the contact, and no two have the same time.
    captions = page.locator(".strip .frame").all_inner_texts()
    assert captions.count("contact") == 1
    assert len(set(captions)) == len(captions) > 3
    assert not [caption for caption in captions if re.fullmatch(r"[+−]0(\.0)? ms", caption)]


def test_dark_or_light_is_kept_from_page_to_page(page: Page, served: Served) -> None:
    page.emulate_media(color_scheme="light")
    for look, other in (("dark", "light"), ("light", "dark")):
        page.get_by_role("button", name="dark or light").click()
        expect(page.locator(f"body.body--{look}")).to_be_attached()
        visit(page, f"{served.url}/shots")
        expect(page.locator(f"body.body--{look}")).to_be_attached()
        expect(page.locator(f"body.body--{other}")).not_to_be_attached()


def test_axe_finds_nothing_on_the_page_of_a_model(page: Page, served: Served) -> None:
    folder = known_challenge(served)
    visit(page, f"{served.url}/model?folder={quote(str(folder))}&view=tables")
    page.get_by_test_id("heat-map").locator(".main-svg").first.wait_for(timeout=LONG_MS)
    assert faults(page) == []
    page.get_by_test_id("view-story").click()
    page.get_by_test_id("amount").wait_for(timeout=LONG_MS)
    assert faults(page) == []
    assert out_of_reach(page) == []


def sorted_by_keys_and_not_drawn_anew(page: Page) -> None:
    """A table is sorted by its heading's keys; news of its rows leaves heading and focus there."""
    table = page.get_by_test_id("shots")
    heading = table.get_by_role("columnheader", name="shot").first
    heading.focus()
    for key, order in (("Enter", "ascending"), ("Space", "descending")):
        page.keyboard.press(key)
        expect(heading).to_have_attribute("aria-sort", order)
    drawn, link = heading.element_handle(), table.get_by_role("link").first.element_handle()
    type_in(page.get_by_test_id("filter"), "offset > 1000")
    expect(table.get_by_role("link")).to_have_count(0)
    assert link is not None
    assert not link.evaluate("(part) => part.isConnected")
    assert drawn is not None
    assert drawn.evaluate("(part) => part.isConnected")


def out_of_reach(page: Page) -> list[str]:
    """Go round a screen by the tabulator; return what it does not come to, or does not show."""
    found = []
    page.evaluate(NOTED)
    rounds = 0
    for _ in range(STOPS // BUNCH):
        for _ in range(BUNCH):
            page.keyboard.press("Tab")
        where = page.evaluate(STOPPED)
        rounds += where.count(None)
        found += [f"focus is not seen: {part}" for part in where if part]
        # The first round may begin in the middle, where the last click was.
        if rounds > 1 or (rounds and not page.evaluate(CONTROLS)):
            break
    else:
        found.append(f"the tabulator has not come round after {STOPS} stops")
    return found + [f"no key comes to {part}" for part in page.evaluate(CONTROLS)]


def faults(page: Page) -> list[str]:
    """Return what is wrong with the screen that is open, at every width, dark and light."""
    found = []
    if not page.evaluate("'axe' in window"):
        page.evaluate(Axe().axe_script)
    # Until the page hears the daemon its controls are faint, as controls that are disabled.
    expect(page.locator(".deaf")).to_have_count(0)
    # What is below the pointer says so in words that fade in.
    page.mouse.move(0, 0)
    for width, scheme in LOOKS:
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        page.set_viewport_size({"width": width, "height": 800})
        if page.evaluate("document.documentElement.scrollWidth") > width:
            found.append(f"scrolls sideways at {width} px")
        found += [f"{words!r} does not fit at {width} px" for words in page.evaluate(CUT)]
        found += [f"{word!r} is broken at {width} px" for word in page.evaluate(BROKEN)]
        # Rules look at what is there, colours at a theme: all where most is seen, wide and light.
        for fault in page.evaluate(VIOLATIONS, RULES[width]) if width in RULES else ():
            places = [node["html"][:120] for node in fault["nodes"]]
            found.append(f"{fault['id']} at {width} px, {scheme}: {places}")
    return found
