"""From the model to the rig and back: shots that tell two effects apart, fired and counted."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import FIRST_USE_MS, KEY, abort_sweep, type_in, visit
from tests.invoked import rigctl

pytestmark = pytest.mark.long

LONG_MS = 120_000
PRESSURES, OFFSETS = "40:80:2", "0:12:4"
MEASURED = re.compile("analysed|refused")
LAW = "lasting-contact"
"""What the rig's world has. Without it nothing fits, and any effect seems to be needed."""
FAINT = "Twisting friction"
"""An effect that eight shots do not tell from none, once the law is right."""


def test_shots_that_the_model_asks_for_are_fired_and_stand_in_its_next_fit(
    page: Page, served: Any
) -> None:
    fire(served.folder)
    visit(page, f"{served.url}/campaigns/nylon")
    measured = page.get_by_test_id("shots").locator("tbody tr").filter(has_text=MEASURED)
    expect(measured).to_have_count(8, timeout=FIRST_USE_MS)
    visit(page, f"{served.url}/model/nylon?effects={LAW}")
    counted = page.get_by_test_id("counted")
    expect(counted).to_contain_text("shots used", timeout=LONG_MS)
    before = used(counted.inner_text())
    assert 6 <= before <= 8
    choose(page, 0, FAINT)
    choose(page, 1, "No further effect")
    page.get_by_test_id("choose-shots").click()
    page.get_by_test_id("into-sweep").click(timeout=LONG_MS)
    proposed = page.get_by_test_id("proposed")
    expect(proposed).to_be_visible()
    expect(page.get_by_test_id("campaign")).to_have_value("nylon")
    expect(page.get_by_test_id("state")).to_have_text("idle")
    page.get_by_test_id("start-sweep").click()
    page.wait_for_url(re.compile(r"/sweeps/\d{8}-s\d{4}$"))
    expect(page.get_by_test_id("grows").locator(".scatterlayer .point")).not_to_have_count(
        0, timeout=LONG_MS
    )
    abort_sweep(page)
    expect(page.get_by_test_id("sweep-state")).to_contain_text("aborted", timeout=LONG_MS)
    page.get_by_role("link", name="Model").click()
    page.get_by_role("link", name="nylon").click()
    expect(counted).to_contain_text("shots used", timeout=LONG_MS)
    assert used(counted.inner_text()) > before


def choose(page: Page, place: int, effect: str) -> None:
    """Choose one of the two effects that the shots are to tell apart."""
    field = page.get_by_test_id(f"tell-{place}")
    field.click()
    type_in(field, effect)
    page.get_by_role("option", name=effect, exact=True).click()
    expect(field).to_have_value(effect)


def fire(folder: Path) -> None:
    """Fire a small sweep of eight shots under the campaign's name and wait for the last one."""
    swept = ("sweep", "--pressure-kpa", PRESSURES, "--offset-mm", OFFSETS, "--campaign", "nylon")
    done = rigctl(*swept, folder=folder, key=KEY)
    assert done.returncode == 0, done.stderr


def used(said: str) -> int:
    """Return how many shots of a campaign the page says it counts, used or left out of the fit."""
    found = re.match(r"(\d+) shots used", said)
    assert found is not None
    left_out = re.findall(r"\d+", said.partition("left out: ")[2])
    return int(found[1]) + len(left_out)
