"""Effects of the user's own by REST: shown with their files, handed to the jobs, faults named."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rigctl.config import Configuration, load
from rigctl.jobs import Jobs
from rigctl.service.routes import model as routes_model
from rigctl.store import Change, ShotState, Store
from tests.unit.analysis.effects.own_files import STRETCH, text_of, write

OWN = "/api/v1/effects/own"
WAIT_S = 120.0


@pytest.fixture
def effects(tmp_path: Path) -> Path:
    write(tmp_path / "effects", text_of(STRETCH, name="stretch"), "stretch")
    return tmp_path / "effects"


@pytest.fixture
def configuration(effects: Path) -> Configuration:
    plain = load()
    analysis = plain.analysis.model_copy(update={"effects": str(effects)})
    return plain.model_copy(update={"analysis": analysis})


def shown(ask: Any, jobs: Jobs) -> dict[str, Any]:
    """Ask until the folder as it stands now is read."""
    first = ask("GET", OWN)
    assert first.status_code == 202
    job = jobs.wait(first.json()["job"], WAIT_S)
    assert job.state == "done", job
    again = ask("GET", OWN)
    assert again.status_code == 200
    return dict(again.json())


def test_the_folder_is_shown_and_read_again_when_a_file_is_written(
    ask: Any, jobs: Jobs, effects: Path
) -> None:
    found = shown(ask, jobs)
    [own] = found["effects"]
    assert (own["effect"], own["stage"], own["formula"]) == ("stretch", "camera", "f")
    assert own["file"] == str(effects / "stretch.py")
    assert found["faults"] == []
    write(effects, "import nothing_of_this_name", "broken")
    fault = shown(ask, jobs)["faults"][0]
    assert (fault["effect"], fault["line"]) == ("broken", 1)
    assert "nothing_of_this_name" in fault["what"]


def test_a_file_that_ends_its_process_ends_the_job_and_not_the_daemon(
    ask: Any, jobs: Jobs, effects: Path
) -> None:
    write(effects, "import os; os._exit(7)", "abrupt")
    job = jobs.wait(ask("GET", OWN).json()["job"], WAIT_S)
    assert job.state == "failed"
    assert "ended with status 7" in str(job.failure)
    assert ask("GET", "/api/v1/effects").status_code == 200


def test_a_question_with_an_own_effect_goes_to_a_job_that_reads_the_folder(
    ask: Any,
    jobs: Jobs,
    store: Store,
    shoot: Callable[..., str],
    effects: Path,
    monkeypatch: pytest.MonkeyPatch,
    request: pytest.FixtureRequest,
) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    monkeypatch.setattr(routes_model, "FUNCTIONS", "stand_in_model")
    shot = shoot("nylon")
    store.move(shot, ShotState.ANALYSING)
    number = store.folders.add_result(shot, {"status": "measured"})
    store.move(shot, ShotState.ANALYSED, Change(results=number))
    order = {"between": ["stretch", "none"]}
    accepted = ask("POST", "/api/v1/campaigns/nylon/next", json=order)
    assert accepted.status_code == 202
    jobs.wait(accepted.json()["job"], WAIT_S)
    told = ask("GET", accepted.headers["location"]).json()["result"]
    assert (told["own"], told["between"]) == (str(effects), ["stretch", "none"])


def test_without_files_there_is_nothing_to_show_and_the_document_says_where_to_name_it(
    ask: Any, jobs: Jobs, effects: Path
) -> None:
    (effects / "stretch.py").unlink()
    answer = ask("GET", OWN)
    assert (answer.status_code, answer.json()["code"]) == (404, "not-found")
    assert "serve --effects" in answer.json()["todo"]
    assert jobs.jobs() == []
