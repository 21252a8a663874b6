"""A telephone on the page: the word that it records, and its film dropped for the shot."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import Served
from tests.browser.test_accessibility import faults, out_of_reach
from tests.telephones import configure, film


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder = tmp_path_factory.mktemp("telephone")
    running = Served.start(folder, "--config", str(configure(folder)))
    yield running
    running.end()


def test_a_shot_waits_for_the_word_and_takes_the_film_that_is_dropped(
    page: Page, tmp_path: Path
) -> None:
    film(tmp_path / "drop.mp4")
    film(tmp_path / "short.mp4", frames=100)
    page.get_by_test_id("arm").click()
    page.get_by_test_id("fire").click()
    # The panel is drawn anew as the rig fires: a press on what it replaces is lost.
    expect(page.get_by_test_id("state")).to_contain_text("firing")
    page.get_by_test_id("film").click()
    waits, read = page.get_by_test_id("film-waits"), page.get_by_test_id("film-read")
    expect(waits).to_contain_text("A shot waits for the camera")
    expect(page.get_by_test_id("drop")).to_be_hidden()
    page.get_by_test_id("film-records").click()
    expect(waits).to_contain_text("The shot is fired")
    page.get_by_test_id("drop").set_input_files(tmp_path / "short.mp4")
    expect(read).to_contain_text("100 frames")
    assert faults(page) == []
    assert out_of_reach(page) == []
    expect(waits).to_contain_text("The shot is fired")
    page.get_by_test_id("drop").set_input_files(tmp_path / "drop.mp4")
    expect(read).to_contain_text("the shot has its frames")
    expect(waits).to_contain_text("No shot waits")
