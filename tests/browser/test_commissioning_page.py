"""The commissioning on the page: a step is done, refused without a name, seen, or not."""

from __future__ import annotations

from playwright.sync_api import Page, expect

from tests.browser.conftest import type_in


def test_a_step_is_done_by_the_daemon_and_seen_by_people_that_are_named(page: Page) -> None:
    # A shot of another test may not have ended yet.
    expect(page.get_by_test_id("state")).to_have_text("idle")
    page.get_by_test_id("commissioning").click()
    step = page.get_by_test_id("step")
    expect(step).to_contain_text("Supply on (supply)")
    expect(step).to_contain_text("never seen")
    page.get_by_test_id("seen").click()
    expect(page.get_by_text("people: is empty")).to_be_visible()
    type_in(page.get_by_test_id("people"), "Anna Berg, Bo Lind")
    page.get_by_test_id("seen").click()
    expect(page.get_by_text("has not been done")).to_be_visible()
    page.get_by_test_id("act").click()
    expect(page.get_by_test_id("found")).to_contain_text("The daemon saw: the rig is idle")
    page.get_by_test_id("seen").click()
    expect(step).to_contain_text("(stop)")
    expect(page.get_by_test_id("steps")).to_contain_text("by Anna Berg, Bo Lind")


def test_what_is_not_as_it_must_be_is_kept_and_asked_for_again(page: Page) -> None:
    page.get_by_role("link", name="Commissioning").click()
    type_in(page.get_by_test_id("people"), "Anna Berg")
    name = page.get_by_test_id("step").inner_text().partition("(")[2].partition(")")[0]
    page.get_by_test_id("not-seen").click()
    type_in(page.get_by_test_id("reason"), "the lamp stays on")
    page.get_by_test_id("keep-now").click()
    expect(page.get_by_test_id("step")).to_contain_text("the lamp stays on")
    expect(page.get_by_test_id("step")).to_contain_text(f"({name})")
