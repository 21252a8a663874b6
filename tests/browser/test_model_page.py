"""The model on the page: a hidden effect is found, added, answered and revealed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any
from urllib.parse import quote

from playwright.sync_api import Page, expect

LONG_MS = 60_000
SEED = "4"
"""Hides the angle of the mirror, and nothing else."""
HIDDEN = "mirror-angle"


def test_a_hidden_effect_is_found_added_answered_and_revealed(page: Page, served: Any) -> None:
    folder = challenge(served.folder / "hidden")
    page.goto(f"{served.url}/model?folder={quote(str(folder))}")
    page.get_by_test_id("heat-map").locator(".main-svg").first.wait_for(timeout=LONG_MS)
    expect(page.get_by_test_id("verdict")).to_contain_text("missing")
    before = error_now(page)
    page.get_by_test_id(f"add-{HIDDEN}").click()
    expect(page.get_by_test_id("verdict")).to_contain_text(
        f"With {HIDDEN} nothing stands out", timeout=LONG_MS
    )
    assert error_now(page) < before
    assert abs(error_now(page) - 1) < 0.05
    expect(page.get_by_test_id("error-path")).to_contain_text(f"{error_now(page):.3f}")
    page.get_by_test_id("answer").click()
    page.keyboard.type(HIDDEN)
    page.get_by_role("option", name=HIDDEN, exact=True).click()
    page.keyboard.press("Escape")
    page.get_by_test_id("commit").click()
    page.get_by_test_id("reveal").click()
    expect(page.get_by_test_id("truth")).to_contain_text(f"The truth is: {HIDDEN}")
    page.get_by_test_id("undo").click()
    expect(page.get_by_test_id("error-now")).to_contain_text(f"{before:.3f}")


def challenge(folder: Path) -> Path:
    """Make a challenge of 60 shots and return its folder."""
    rigctl = Path(sys.executable).with_name("rigctl")
    made = [str(rigctl), "challenge", "new", str(folder), "--seed", SEED, "--shots", "60"]
    subprocess.run(made, check=True, capture_output=True, timeout=60)
    return folder


def error_now(page: Page) -> float:
    """Return the error on shots left out that the page shows."""
    words = page.get_by_test_id("error-now").inner_text()
    return float(words.removeprefix("error now ").partition(",")[0])
