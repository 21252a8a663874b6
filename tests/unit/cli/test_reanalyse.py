"""`rigctl reanalyse`: what it prints of a campaign that a stand-in analyses."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rigctl.cli import NOT_FOUND, run
from rigctl.reanalysis import Pool
from tests.unit.cli.test_campaign_commands import DESCRIPTION

Json = dict[str, Any]
REFUSED = {"status": "refused", "step": "markers", "reason": "only\none marker"}


class Inline(Executor):
    def submit(self, call: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        future = Future[Any]()
        try:
            future.set_result(call(*given, **named))
        except Exception as error:  # noqa: BLE001 - it is told by the future
            future.set_exception(error)
        return future


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> dict[str, Json]:
    """Results of the stand-in by the shots' names; it breaks for a shot without one."""
    found: dict[str, Json] = {}

    @contextmanager
    def pool(scheduler: str | None, workers: int | None) -> Iterator[Pool]:
        yield Pool(Inline(), lambda: 1)

    monkeypatch.setattr("rigctl.cli.store.reanalyse.pool", pool)
    monkeypatch.setattr(
        "rigctl.measuring.stored_shot.analyse_stored_shot_with",
        lambda folder, method, known: found[folder.name],
    )
    return found


@pytest.fixture
def shots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Three shots with frames, imported into the store of the folder that the test runs in."""
    monkeypatch.chdir(tmp_path)
    made = tmp_path / "exchange"
    (made / "frames").mkdir(parents=True)
    (made / "campaign.toml").write_text(DESCRIPTION)
    (made / "shots.csv").write_text("shot\n1\n2\n3\n")
    for number in (1, 2, 3):
        np.save(made / "frames" / f"{number:04d}.npy", np.zeros((2, 16, 24), np.uint8))
    assert run(["import", str(made)]) == 0
    return [f"i0001-{number:06d}" for number in (1, 2, 3)]


def measured(e: float) -> Json:
    return {"status": "measured", "e": {"value": e, "sigma": 0.03, "unit": "1"}}


def test_what_came_of_each_shot_is_one_json_document(
    shots: list[str], answers: dict[str, Json], capsys: pytest.CaptureFixture[str]
) -> None:
    answers |= {shots[0]: measured(0.7), shots[1]: REFUSED}
    capsys.readouterr()
    assert run(["reanalyse", "nylon", "--method", "thesis", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["campaign"], said["method"], said["changes"]) == ("nylon", "thesis", [])
    assert [(one["shot"], one["state"], one["result"]) for one in said["shots"]] == [
        (shots[0], "analysed", 1),
        (shots[1], "refused", 1),
        (shots[2], "stored", None),
    ]
    assert said["shots"][1]["failure"] == "only\none marker"
    assert "KeyError" in said["shots"][2]["failure"]


def test_the_table_compares_and_a_sentence_names_each_shot_that_was_not_measured(
    shots: list[str], answers: dict[str, Json], capsys: pytest.CaptureFixture[str]
) -> None:
    answers |= {shot: measured(0.7) for shot in shots}
    assert run(["reanalyse", "nylon", "--method", "thesis"]) == 0
    answers |= {shots[0]: measured(0.8), shots[1]: REFUSED}
    capsys.readouterr()
    assert run(["reanalyse", "nylon", "--method", "thesis"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "campaign nylon, thesis: 2 of 3 shots measured"
    assert lines[1] == "later minus earlier result"
    assert lines[3].split() == ["e", "2", "+0.05", "0.071", "1.67"]
    assert lines[4:] == [f"shot {shots[1]} refused: only one marker"]


def test_a_campaign_that_is_not_there_starts_no_process(
    shots: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object) -> None:
        raise AssertionError("a process was started")

    monkeypatch.setattr("rigctl.cli.store.reanalyse.pool", never)
    assert run(["reanalyse", "brass"]) == NOT_FOUND
