"""What persons say of a campaign: kept as it is typed, and seen by everybody."""

from __future__ import annotations

import uuid

import httpx
import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import KEY, Served, type_in, visit

SETTINGS = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 6.0}
CAMPAIGN = "remarked"


@pytest.fixture(scope="module")
def campaign(served: Served) -> str:
    """Fire one shot of a campaign; what stands on its page needs no result."""
    bearer = {"Authorization": f"Bearer {KEY}"}
    with httpx.Client(base_url=f"{served.url}/api/v1", headers=bearer, timeout=60) as rest:
        armed = rest.post("/rig/arm", json=SETTINGS).raise_for_status().json()
        fired = rest.post(
            "/shots",
            json={"arm_token": armed["arm_token"], "campaign": CAMPAIGN},
            headers={"Idempotency-Key": uuid.uuid4().hex},
        )
        fired.raise_for_status()
    return CAMPAIGN


def test_a_note_and_tags_are_kept_seen_by_a_second_operator_and_found_in_the_list(
    page: Page, served: Served, campaign: str
) -> None:
    second = page.context.new_page()
    for each in (page, second):
        visit(each, f"{served.url}/campaigns/{campaign}")
    type_in(page.get_by_test_id("note"), "lamp exchanged after shot 1")
    page.get_by_test_id("note").press("Enter")
    expect(second.get_by_test_id("note")).to_have_value("lamp exchanged after shot 1")
    type_in(second.get_by_test_id("tags"), "dry")
    second.get_by_test_id("tags").press("Enter")
    expect(page.get_by_test_id("remarks")).to_contain_text("dry")
    second.close()
    visit(page, f"{served.url}/campaigns")
    type_in(page.get_by_test_id("filter"), "dry")
    expect(page.get_by_test_id("campaigns").get_by_role("cell", name=campaign)).to_be_visible()
    type_in(page.get_by_test_id("filter"), "wet")
    expect(page.get_by_test_id("campaigns").get_by_role("cell", name=campaign)).to_be_hidden()


def test_a_note_that_is_too_long_is_refused_in_words_and_not_kept(
    page: Page, served: Served, campaign: str
) -> None:
    visit(page, f"{served.url}/campaigns/{campaign}")
    type_in(page.get_by_test_id("note"), "n" * 3000)
    page.get_by_test_id("note").press("Enter")
    expect(page.get_by_test_id("remarks").get_by_role("alert")).to_contain_text("500")
    page.reload()
    expect(page.get_by_test_id("note")).not_to_have_value("n" * 3000)
