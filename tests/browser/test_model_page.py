"""The model on the page: a hidden effect is found, added, answered and revealed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from playwright.sync_api import Page, ViewportSize, expect

from rigctl.challenge import new
from tests.browser.conftest import Served, visit

pytestmark = pytest.mark.long

LONG_MS = 120_000
SCREENS: list[ViewportSize] = [
    {"width": 820, "height": 1180},
    {"width": 1180, "height": 820},
    {"width": 1280, "height": 800},
]
STEPS = ("error-path", "missing", "where-it-fails", "compare")
SEED = 4
"""Hides the angle of the mirror, and nothing else."""
HIDDEN = "mirror-angle"
OUTSIDE_SEED = 11
"""Hides that restitution depends on the temperature, which no effect of the catalogue knows."""


LEAST_MAP = 200
"""Width of the map, px: less shows no cell."""


def test_a_hidden_effect_is_found_added_answered_and_revealed(page: Page, served: Any) -> None:
    folder = challenge(served.folder / "hidden", SEED)
    visit(page, f"{served.url}/model?folder={quote(str(folder))}&view=tables")
    page.get_by_test_id("heat-map").locator(".main-svg").first.wait_for(timeout=LONG_MS)
    expect(page.get_by_test_id("verdict")).to_contain_text("missing")
    for size in SCREENS:
        page.set_viewport_size(size)
        assert width_of(page, "heat-map") > LEAST_MAP
        assert read_in_rows(page) == ["compare", "where-it-fails", "missing", "error-path"]
    before = error_now(page)
    page.get_by_test_id(f"add-{HIDDEN}").click()
    expect(page.get_by_test_id("verdict")).to_contain_text(
        f"With {HIDDEN} nothing stands out", timeout=LONG_MS
    )
    assert error_now(page) < before
    assert abs(error_now(page) - 1) < 0.05
    expect(page.get_by_test_id("error-path")).to_contain_text(f"{error_now(page):.3f}")
    # What was added is the answer already.
    chosen = page.get_by_test_id("challenge").locator(".q-chip")
    expect(chosen).to_contain_text(re.compile(rf"\({HIDDEN}\)"))
    page.get_by_test_id("commit").click()
    expect(page.get_by_test_id("ask-again")).to_contain_text("neither be changed nor taken back")
    page.get_by_test_id("commit-now").click()
    page.get_by_test_id("reveal").click()
    expect(page.get_by_test_id("truth")).to_contain_text("The mirror is not at 45°")
    page.get_by_test_id("undo").click()
    expect(page.get_by_test_id("error-now")).to_contain_text(f"{before:.3f}")


def width_of(page: Page, testid: str) -> float:
    """Return the width of the plot within a part, px, once the browser has laid it out."""
    plot = page.get_by_test_id(testid).locator(".main-svg").first
    return float(plot.evaluate("plot => plot.getBoundingClientRect().width"))


def test_a_plot_that_is_hidden_while_its_panel_changes_throws_nothing(
    page: Page, served: Any
) -> None:
    thrown: list[str] = []
    page.on("pageerror", lambda error: thrown.append(str(error)))
    visit(page, f"{served.url}/sweeps")
    plot = page.get_by_test_id("preview").locator(".js-plotly-plot")
    plot.locator(".main-svg").first.wait_for()
    # The plot's own style is the page library's: it writes it anew with each change of the page.
    sheet = page.add_style_tag(content=".js-plotly-plot { display: none !important; }")
    refused = page.evaluate(
        """async () => {
          const { Plotly } = await import("nicegui-plotly");
          const hidden = document.querySelector(".js-plotly-plot");
          try { await Plotly.Plots.resize(hidden); } catch (error) { return error.message; }
          return "";
        }"""
    )
    assert refused == ""
    narrow = ".js-plotly-plot { width: 400px !important; }"
    sheet.evaluate("(sheet, rules) => { sheet.textContent = rules; }", narrow)
    expect(plot.locator(".main-svg").first).to_have_attribute("width", "400")
    assert thrown == []


def test_an_effect_of_ones_own_is_ranked_explained_added_and_mends_the_model(
    page: Page, served: Any
) -> None:
    folder = challenge(served.folder / "outside", OUTSIDE_SEED)
    visit(page, f"{served.url}/model?folder={quote(str(folder))}&view=tables")
    missing = page.get_by_test_id("missing")
    expect(missing).to_contain_text("1 of them your own", timeout=LONG_MS)
    expect(missing.get_by_test_id("fault")).to_contain_text("unfinished.py, line 3")
    before = error_now(page)
    missing.get_by_role("button", name="restitution-warmth").click()
    expect(page.get_by_test_id("effect")).to_contain_text("e = e0 [1 + a (T - 23 C)]")
    expect(page.get_by_test_id("effect")).to_contain_text("warmth.py")
    page.get_by_role("button", name="Close").click()
    page.get_by_test_id("add-restitution-warmth").click()
    expect(page.get_by_test_id("verdict")).to_contain_text(
        "With restitution-warmth", timeout=LONG_MS
    )
    assert error_now(page) < 1.05 < before
    expect(page.get_by_test_id("compare")).to_contain_text("restitution-warmth.a")


def read_in_rows(page: Page) -> list[str]:
    """Return the four steps as a person reads them: rows from above, each from the left.

    What begins above the middle of the uppermost stands in its row.
    """
    left = {step: page.get_by_test_id(step).bounding_box() or {} for step in STEPS}
    found = []
    while left:
        top = min(left, key=lambda step: left[step]["y"])
        middle = left[top]["y"] + left[top]["height"] / 2
        row = [step for step, box in left.items() if box["y"] < middle]
        found += sorted(row, key=lambda step: left[step]["x"])
        left = {step: box for step, box in left.items() if step not in row}
    return found


def challenge(folder: Path, seed: int, shots: int = 60) -> Path:
    """Make a challenge and return its folder."""
    new(folder, seed=seed, strength="full", shots=shots)
    return folder


def known_challenge(served: Served) -> Path:
    """Return the folder of a challenge that is made, and fitted, once for a daemon."""
    folder = served.folder / "known"
    return folder if folder.exists() else challenge(folder, SEED)


def error_now(page: Page) -> float:
    """Return the error on shots left out that the page shows."""
    words = page.get_by_test_id("error-now").inner_text()
    return float(words.removeprefix("error now ").partition(",")[0])
