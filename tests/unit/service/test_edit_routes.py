"""Shots changed afterwards over REST."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rigctl.store import Store

Shoot = Callable[..., str]
SHOTS = "/api/v1/shots"
CAMPAIGNS = "/api/v1/campaigns"


def test_a_shot_is_excluded_with_a_reason_and_included_again(ask: Any, shoot: Shoot) -> None:
    shot = shoot("nylon")
    answer = ask("POST", f"{SHOTS}/{shot}/exclude", json={"reason": "the tube was dirty"})
    assert (answer.status_code, answer.json()["excluded"]) == (200, "the tube was dirty")
    assert ask("GET", f"{SHOTS}/{shot}").json() == answer.json()
    assert ask("GET", "/api/v1/campaigns/nylon").json()["excluded"] == 1
    assert ask("GET", f"{SHOTS}?excluded=true").json()["shots"] == [answer.json()]
    assert ask("POST", f"{SHOTS}/{shot}/include").json()["excluded"] is None
    assert ask("GET", f"{SHOTS}?excluded=true").json()["shots"] == []


def test_a_note_and_tags_are_put_and_the_audit_names_the_key(
    ask: Any, store: Store, shoot: Shoot
) -> None:
    shot, other = shoot(), shoot()
    assert ask("PUT", f"{SHOTS}/{shot}/note", json={"note": "seen"}).json()["note"] == "seen"
    assert ask("PUT", f"{SHOTS}/{shot}/note", json={"note": None}).json()["note"] is None
    tagged = ask("PUT", f"{SHOTS}/{shot}/tags", json={"tags": ["wet", "cold"]}).json()
    assert tagged["tags"] == ["cold", "wet"]
    assert ask("GET", f"{SHOTS}?tag=wet").json()["shots"] == [tagged]
    assert ask("PUT", f"{SHOTS}/{other}/tags", json={"tags": []}).json()["tags"] == []
    edits = store.edits.entries()
    assert [edit.act for edit in edits] == ["noted", "noted", "tagged"]
    assert all(edit.actor.startswith("key ") for edit in edits)


def test_a_campaign_is_noted_and_tagged_and_the_audit_names_the_key(
    ask: Any, store: Store, shoot: Shoot
) -> None:
    shoot("nylon")
    shoot("brass")
    noted = ask("PUT", f"{CAMPAIGNS}/nylon/note", json={"note": "a wet day"})
    assert (noted.status_code, noted.json()["note"]) == (200, "a wet day")
    tagged = ask("PUT", f"{CAMPAIGNS}/nylon/tags", json={"tags": ["wet", "cold"]}).json()
    assert (tagged["note"], tagged["tags"]) == ("a wet day", ["cold", "wet"])
    assert ask("GET", f"{CAMPAIGNS}/nylon").json() == tagged
    assert ask("GET", f"{CAMPAIGNS}?tag=wet").json() == {"campaigns": [tagged]}
    assert ask("GET", f"{CAMPAIGNS}?tag=two words").status_code == 422
    cleared = ask("PUT", f"{CAMPAIGNS}/nylon/note", json={"note": None}).json()
    assert (cleared["note"], cleared["tags"]) == (None, ["cold", "wet"])
    edits = store.edits.entries()
    assert [edit.act for edit in edits] == ["campaign noted", "campaign tagged", "campaign noted"]
    assert all(edit.actor.startswith("key ") for edit in edits)


@pytest.mark.parametrize(
    ("path", "body", "status"),
    [
        ("nylon/note", {}, 422),
        ("nylon/note", {"note": "two\nlines"}, 422),
        ("nylon/tags", {"tags": ["two words"]}, 422),
        ("nylon/tags", {"tags": ["x"] * 17}, 422),
        ("steel/note", {"note": "of nothing"}, 404),
        ("steel/tags", {"tags": ["wet"]}, 404),
    ],
)
def test_what_cannot_be_said_of_a_campaign_is_refused(
    ask: Any, store: Store, shoot: Shoot, path: str, body: dict[str, Any], status: int
) -> None:
    shoot("nylon")
    assert ask("PUT", f"{CAMPAIGNS}/{path}", json=body).status_code == status
    assert store.edits.entries() == []


@pytest.mark.parametrize(
    ("method", "path", "body", "status"),
    [
        ("POST", "exclude", {}, 422),
        ("POST", "exclude", {"reason": ""}, 422),
        ("POST", "exclude", {"reason": " "}, 422),
        ("POST", "exclude", {"reason": "two\nlines"}, 422),
        ("PUT", "note", {}, 422),
        ("PUT", "note", {"note": "x" * 501}, 422),
        ("PUT", "tags", {"tags": ["two words"]}, 422),
        ("PUT", "tags", {"tags": ["x"] * 17}, 422),
        ("PUT", "tags", {"tags": "wet"}, 422),
    ],
)
def test_what_cannot_be_kept_is_refused(
    ask: Any, shoot: Shoot, method: str, path: str, body: dict[str, Any], status: int
) -> None:
    shot = shoot()
    before = ask("GET", f"{SHOTS}/{shot}").json()
    assert ask(method, f"{SHOTS}/{shot}/{path}", json=body).status_code == status
    assert ask("GET", f"{SHOTS}/{shot}").json() == before


def test_a_shot_that_is_not_there_is_not_found(ask: Any) -> None:
    missing = f"{SHOTS}/20260131-000009"
    assert ask("POST", f"{missing}/exclude", json={"reason": "why"}).status_code == 404
    assert ask("POST", f"{missing}/include").status_code == 404
    assert ask("PUT", f"{missing}/note", json={"note": None}).status_code == 404
    assert ask("PUT", f"{missing}/tags", json={"tags": []}).status_code == 404
