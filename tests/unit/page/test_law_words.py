"""How the page says what a proposed law and a verdict say."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import rigctl.page.model.source as sources
from rigctl.jobs import ENDED, Jobs
from rigctl.page.model.law import in_story, last_proposal, on_page
from rigctl.page.model.source import Source
from rigctl.page.model.story.words import cells_in_plain


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        (
            "  with a = 0.019 +- 0.001, m = 5.0 +- 0.1 m/s",
            "with a = 0.019 ± 0.001, m = 5.0 ± 0.1 m/s",
        ),
        ("chance: less than 1e-12", "chance: less than 10⁻¹²"),
        ("a = 3.2e-05", "a = 3.2·10⁻⁵"),
        (
            "fire the next shots, then ask with --confirm.",
            "fire the next shots, then press Confirm.",
        ),
    ],
)
def test_a_law_is_said_with_the_signs_and_buttons_of_the_page(said: str, shown: str) -> None:
    assert on_page(said) == shown


def test_in_the_story_quantities_have_their_words() -> None:
    assert in_story("pressure_b_kpa is one and the same as pressure_a_kpa; e on speed_n*order") == (
        "pressure b is one and the same as pressure a; e on approach speed*order"
    )


def test_the_cell_that_a_verdict_names_is_said_in_words() -> None:
    assert cells_in_plain("What is left shows most in relative velocity n against ln v_n.") == (
        "What is left shows most in the speed along the line of centres, with approach speed."
    )
    assert cells_in_plain("common spin b against spin along v_t x n") == (
        "the mean rolling, with rolling spin before"
    )
    assert cells_in_plain("common orientation n against always") == (
        "the mean twist angle, in all shots alike"
    )
    assert cells_in_plain("relative spin t against humidity") == (
        "the difference of tumbling, with humidity"
    )


def test_of_campaigns_of_one_name_each_has_its_own_last_proposal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs = Jobs()
    daemon: Any = SimpleNamespace(
        jobs=jobs, configuration=SimpleNamespace(analysis=SimpleNamespace(effects=None))
    )
    places = [tmp_path / place / "strange" for place in ("here", "there")]
    here, there = (Source(daemon, "strange", place) for place in places)
    stored = Source(daemon, "strange")

    def work(_: str, asked: dict[str, Any]) -> Any:
        # What is proposed names the shots that were asked.
        return lambda _: json.dumps({"proposals": [asked["folder"]]})

    monkeypatch.setattr(sources, "in_process", work)
    try:
        answered = [jobs.wait(one.ask("propose").id, 60.0) for one in (here, there)]
        assert all(job.state in ENDED for job in answered)
        assert last_proposal(here)["proposals"] == [str(here.folder)]
        assert last_proposal(there)["proposals"] == [str(there.folder)]
        assert last_proposal(stored)["proposals"] == []
        # As REST asks it of the store's campaign.
        of_store = jobs.submit("propose", "strange", lambda _: json.dumps({"proposals": ["own"]}))
        jobs.wait(of_store.id, 60.0)
        assert last_proposal(stored)["proposals"] == ["own"]
    finally:
        jobs.close()
