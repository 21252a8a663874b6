from __future__ import annotations

from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

import pytest

from analysis.effects.catalogue import CATALOGUE, LAUNCH_CATALOGUE
from rigctl.jobs import Jobs
from rigctl.store import ShotState, Store

Shoot = Callable[..., str]
CAMPAIGNS = "/api/v1/campaigns"
EFFECTS = "/api/v1/effects"
WAIT_S = 120.0


def test_campaigns_are_listed_with_their_shots_by_state(
    ask: Any, store: Store, shoot: Shoot
) -> None:
    shot = shoot("nylon")
    store.move(shot, ShotState.ANALYSING)
    shoot("nylon"), shoot("brass"), shoot(None)
    listed = ask("GET", CAMPAIGNS).json()["campaigns"]
    assert {(one["campaign"], one["shots"]) for one in listed} == {("nylon", 2), ("brass", 1)}
    nylon = ask("GET", f"{CAMPAIGNS}/nylon").json()
    assert nylon in listed
    assert nylon["states"] == {"analysing": 1, "stored": 1}
    assert nylon["first_at"] == nylon["last_at"] == "2026-01-31T12:00:00Z"


def test_a_campaign_that_is_not_there_is_not_found(ask: Any) -> None:
    answer = ask("GET", f"{CAMPAIGNS}/nylon")
    assert (answer.status_code, answer.json()["code"]) == (404, "not-found")
    assert ask("GET", f"{CAMPAIGNS}/.hidden").status_code == 422


def test_analysing_again_hands_shots_over_one_by_one_and_leaves_out_those_not_analysed_yet(
    ask: Any, jobs: Jobs, store: Store, shoot: Shoot, handed_over: list[str]
) -> None:
    shots = [shoot("nylon"), shoot("nylon"), shoot("nylon")]
    for shot in shots[:2]:
        store.move(shot, ShotState.ANALYSING)
        store.move(shot, ShotState.REFUSED)
    said = SimpleQueue[tuple[str, float | None]]()
    jobs.listeners.add(lambda job: said.put((job.progress, job.share)) if job.progress else None)
    answer = ask("POST", f"{CAMPAIGNS}/nylon/reanalyse")
    assert (answer.status_code, answer.json()["kind"]) == (202, "reanalyse")
    assert said.get(timeout=WAIT_S) == (f"analysing shot {shots[0]}", 0.0)
    store.move(shots[0], ShotState.ANALYSING)
    store.move(shots[0], ShotState.REFUSED)
    assert said.get(timeout=WAIT_S) == (f"analysing shot {shots[1]}", 0.5)
    assert ask("DELETE", answer.headers["location"]).json()["state"] == "cancelled"
    assert handed_over == shots[:2]


def test_a_campaign_is_analysed_again_by_a_method_of_choice(
    ask: Any, jobs: Jobs, store: Store, shoot: Shoot, handed_over: list[str]
) -> None:
    shot = shoot("nylon")
    store.move(shot, ShotState.ANALYSING)
    store.move(shot, ShotState.REFUSED)
    begun = SimpleQueue[str]()
    jobs.listeners.add(lambda job: begun.put(job.progress) if job.progress else None)
    assert ask("POST", f"{CAMPAIGNS}/nylon/reanalyse?method=guess").status_code == 422
    answer = ask("POST", f"{CAMPAIGNS}/nylon/reanalyse?method=thesis")
    assert begun.get(timeout=WAIT_S) == f"analysing shot {shot}"
    ask("DELETE", answer.headers["location"])
    assert handed_over == [f"{shot} by thesis"]


def test_every_effect_of_the_catalogue_and_of_the_launch_is_described(ask: Any) -> None:
    listed = ask("GET", EFFECTS).json()["effects"]
    assert [one["effect"] for one in listed] == [e.name for e in (*CATALOGUE, *LAUNCH_CATALOGUE)]
    for one in listed:
        assert ask("GET", f"{EFFECTS}/{one['effect']}").json() == one
        assert one["parameters"]
        assert one["source"]


@pytest.mark.parametrize(("name", "status"), [("phlogiston", 404), ("Drag", 422)])
def test_an_effect_that_is_not_there_is_answered_with_those_that_are(
    ask: Any, name: str, status: int
) -> None:
    answer = ask("GET", f"{EFFECTS}/{name}")
    assert answer.status_code == status
    if status == 404:
        assert "drag" in answer.json()["todo"]
