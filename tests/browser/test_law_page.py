"""A law of no catalogue on the page: proposed beside "unexplained", two clicks to a sweep."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from rigctl.challenge import new
from simulators.challenge import write_challenge
from tests.browser.conftest import Served, visit
from tests.browser.test_accessibility import faults
from tests.invoked import rigctl

pytestmark = pytest.mark.long

LONG_MS = 120_000
SEED = 15
"""Hides a bump of restitution at 5 m/s."""


@pytest.fixture(scope="module", autouse=True)
def campaigns(served: Served) -> None:
    """Give the store the two campaigns."""
    new(served.folder / "strange", seed=SEED, strength="full", shots=60)
    write_challenge(served.folder / "other", {"restitution-bump": 0.02}, seed=16, shots=60)
    for name in ("strange", "other"):
        done = rigctl("import", name, "--name", name, folder=served.folder)
        assert done.returncode == 0, done.stderr
    fired_here(served.folder, "other")


def fired_here(folder: Path, campaign: str) -> None:
    """Let a campaign count as fired by this rig: thirty films of its own would take minutes."""
    (catalogue,) = folder.rglob("catalogue.db")
    with closing(sqlite3.connect(catalogue)) as opened, opened:
        told = opened.execute("UPDATE shots SET imported_as = NULL WHERE campaign = ?", (campaign,))
    assert told.rowcount > 0


def test_a_law_is_proposed_beside_unexplained_with_where_the_shots_are_for_that_confirm_it(
    page: Page, served: Served
) -> None:
    visit(page, f"{served.url}/model/strange")
    # Its shots came without frames.
    expect(page.get_by_test_id("ghost-frame")).to_be_visible(timeout=LONG_MS)
    page.get_by_test_id("view-tables").click()
    page.get_by_test_id("explain").click(timeout=LONG_MS)
    expect(page.get_by_test_id("explained")).to_contain_text(
        "something is missing that the catalogue does not hold", timeout=LONG_MS
    )
    # Next shots and steps say the same as the verdict.
    expect(page.get_by_test_id("next-text")).to_contain_text("would show better what it goes with")
    page.get_by_test_id("propose").click(timeout=LONG_MS)
    said = page.get_by_test_id("proposed")
    expect(said).to_contain_text("depends on speed_n", timeout=LONG_MS)
    expect(said).to_contain_text("hint, not a finding")
    # The campaign was imported: this rig adds no shots to it.
    expect(said).to_contain_text("Its next shots are for the rig that fired this campaign")
    expect(said).to_contain_text("rigctl model propose --write writes them as a sweep file")
    expect(page.get_by_test_id("law-into-sweep")).to_have_count(0)
    assert faults(page) == []


def test_a_law_is_not_confirmed_on_its_own_shots_and_campaigns_are_asked_what_they_share(
    page: Page, served: Served
) -> None:
    visit(page, f"{served.url}/model/other?view=tables")
    page.get_by_test_id("explain").click(timeout=LONG_MS)
    page.get_by_test_id("propose").click(timeout=LONG_MS)
    page.get_by_test_id("confirm-law").first.click(timeout=LONG_MS)
    expect(page.get_by_test_id("confirmed-not")).to_contain_text(
        "0 shots of these did not take part in the choice of the form", timeout=LONG_MS
    )
    page.get_by_test_id("share-law").click()
    expect(page.get_by_test_id("shared-not")).to_contain_text("no other campaign is chosen")
    page.get_by_test_id("together-with").click()
    page.get_by_role("option", name="strange").click()
    page.keyboard.press("Escape")
    page.get_by_test_id("share-law").click()
    shared = page.get_by_test_id("shared")
    expect(shared).to_contain_text("together they ask for", timeout=LONG_MS)
    expect(shared).to_contain_text("e against speed_n")
    page.get_by_test_id("law-into-sweep").first.click()
    # The form holds the shots of the rig's own campaign; nothing is fired before Start.
    expect(page.get_by_test_id("proposed").locator("tbody tr")).not_to_have_count(0)
    expect(page.get_by_test_id("campaign")).to_have_value("other")
    expect(page.get_by_test_id("start-sweep")).to_be_enabled()
    expect(page.get_by_test_id("state")).to_have_text("idle")
