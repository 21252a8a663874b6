from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest

from rigctl.store import ShotState, Store

SHOTS = "/api/v1/shots"
SETTINGS = {"pressure_a_kpa": 40, "pressure_b_kpa": 40, "offset_mm": 6}
Shoot = Callable[..., str]


def fire(ask: Any, token: str, key: str | None, **body: object) -> Any:
    headers = {} if key is None else {"Idempotency-Key": key}
    return ask("POST", SHOTS, json={"arm_token": token, **body}, headers=headers)


@pytest.fixture
def token(ask: Any) -> str:
    return str(ask("POST", "/api/v1/rig/arm", json=SETTINGS).json()["arm_token"])


@pytest.mark.parametrize("key", [None, "", "two words", "é", "x" * 201])
def test_without_a_usable_key_nothing_fires(
    ask: Any, rig: Any, token: str, key: str | None
) -> None:
    headers = {} if key is None else {"Idempotency-Key": key.encode()}
    answer = ask("POST", SHOTS, json={"arm_token": token}, headers=headers)
    assert (answer.status_code, answer.json()["code"]) == (400, "idempotency")
    assert answer.json()["field"] == "Idempotency-Key"
    fault = "is missing" if key is None else "cannot be used"
    assert answer.json()["title"] == f"The idempotency key {fault}"
    assert not rig.fires


def test_an_accepted_shot_is_named_and_can_be_asked_for(ask: Any, token: str) -> None:
    answer = fire(ask, token, "k1", campaign="nylon-1", note="first")
    assert answer.status_code == 202
    assert answer.json() == {"shot": "20260131-000001", "state": "accepted"}
    shown = ask("GET", answer.headers["location"]).json()
    assert (shown["shot"], shown["campaign"], shown["note"]) == (
        "20260131-000001",
        "nylon-1",
        "first",
    )
    assert shown["settings"]["offset_mm"] == 6.0
    assert shown["simulated"] is True


def test_the_same_key_while_its_shot_runs_is_a_conflict(ask: Any, rig: Any, token: str) -> None:
    fire(ask, token, "k1")
    answer = fire(ask, token, "k1")
    assert (answer.status_code, answer.json()["code"]) == (409, "idempotency-running")
    assert answer.json()["shot"] == "20260131-000001"
    assert rig.fires == ["k1"]


def test_the_same_key_afterwards_gives_the_stored_answer_and_fires_nothing(
    ask: Any, rig: Any, store: Store, token: str
) -> None:
    fire(ask, token, "k1")
    store.move("20260131-000001", ShotState.FIRING)
    store.move("20260131-000001", ShotState.MISFIRE)
    for _ in range(3):
        answer = fire(ask, token, "k1")
        assert answer.status_code == 202
        assert answer.json() == {"shot": "20260131-000001", "state": "misfire"}
    assert rig.fires == ["k1"]


def test_the_same_key_with_another_body_is_refused(ask: Any, rig: Any, token: str) -> None:
    fire(ask, token, "k1")
    answer = fire(ask, token, "k1", campaign="other")
    assert (answer.status_code, answer.json()["code"]) == (422, "idempotency-reused")
    assert rig.fires == ["k1"]


def test_a_token_that_does_not_hold_is_a_conflict(ask: Any, rig: Any, token: str) -> None:
    answer = fire(ask, "token-99", "k1")
    assert (answer.status_code, answer.json()["code"]) == (409, "arm-token")
    assert not rig.fires


BAD_ORDERS = [
    ({}, "arm_token"),
    ({"arm_token": 1}, "arm_token"),
    ({"arm_token": ""}, "arm_token"),
    ({"arm_token": "t", "campaign": "../up"}, "campaign"),
    ({"arm_token": "t", "campaign": ""}, "campaign"),
    ({"arm_token": "t", "note": False}, "note"),
    ({"arm_token": "t", "fire": True}, "fire"),
]


@pytest.mark.parametrize(("body", "field"), BAD_ORDERS)
def test_a_faulty_order_is_refused_by_name(
    ask: Any, rig: Any, body: dict[str, object], field: str
) -> None:
    answer = ask("POST", SHOTS, json=body, headers={"Idempotency-Key": "k"})
    assert (answer.status_code, answer.json()["field"]) == (422, field)
    assert not rig.fires


def test_shots_are_listed_in_pages_oldest_first(ask: Any, shoot: Shoot) -> None:
    names = [shoot(campaign="even" if n % 2 == 0 else "odd") for n in range(5)]
    page = ask("GET", SHOTS, params={"limit": 2}).json()
    assert [shot["shot"] for shot in page["shots"]] == names[:2]
    rest = ask("GET", SHOTS, params={"limit": 3, "after": page["next"]}).json()
    assert [shot["shot"] for shot in rest["shots"]] == names[2:]
    assert rest["next"] is None
    even = ask("GET", SHOTS, params={"campaign": "even", "state": "stored"}).json()
    assert [shot["shot"] for shot in even["shots"]] == names[::2]


@pytest.mark.parametrize(
    ("query", "field"),
    [("limit=0", "limit"), ("limit=x", "limit"), ("state=flying", "state"), ("lim=3", "lim")],
)
def test_a_faulty_query_is_refused_by_name(ask: Any, query: str, field: str) -> None:
    answer = ask("GET", f"{SHOTS}?{query}")
    assert (answer.status_code, answer.json()["field"]) == (422, field)


@pytest.mark.parametrize(
    "path",
    ["20260131-000009", "20260131-000009/result", "20260131-000009/frames/0.png", "nonsense"],
)
def test_what_is_not_stored_is_not_found(ask: Any, path: str) -> None:
    answer = ask("GET", f"{SHOTS}/{path}")
    assert (answer.status_code, answer.json()["code"]) == (404, "not-found")


def test_a_frame_comes_as_png_with_the_pixels_that_were_stored(ask: Any, shoot: Shoot) -> None:
    shot = shoot()
    answer = ask("GET", f"{SHOTS}/{shot}/frames/7.png")
    assert answer.headers["content-type"] == "image/png"
    picture = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_UNCHANGED)
    assert picture is not None
    assert picture.shape == (192, 240)
    assert np.unique(picture).tolist() == [7]


def test_a_frame_the_shot_does_not_have_is_not_found(ask: Any, shoot: Shoot) -> None:
    answer = ask("GET", f"{SHOTS}/{shoot()}/frames/10.png")
    assert (answer.status_code, answer.json()["limit"]) == (404, "0 to 9")


@pytest.mark.parametrize("path", ["-1.png", "x.png", "0.png?overlay=everything", "0.png?size=3"])
def test_a_faulty_frame_request_is_refused(ask: Any, shoot: Shoot, path: str) -> None:
    assert ask("GET", f"{SHOTS}/{shoot()}/frames/{path}").status_code == 422


def test_outlines_are_drawn_where_the_result_says(ask: Any, shoot: Shoot, store: Store) -> None:
    shot = shoot()
    outline = {"sphere": "a", "view": "front", "row": 100.0, "column": 80.0, "radius": 20.0}
    overlay = {"frame": 3, "outlines": [outline], "markers": []}
    store.folders.add_result(shot, {"overlay": [overlay]})
    answer = ask("GET", f"{SHOTS}/{shot}/frames/3.png", params={"overlay": "outlines"})
    picture = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    rows, columns = np.nonzero(picture.max(axis=2) > 100)
    # Enlarged three times, about the centres of pixels.
    radii = np.hypot((rows - 1) / 3 - 100.0, (columns - 1) / 3 - 80.0)
    assert len(rows) > 300
    assert np.abs(radii - 20.0).max() < 0.7
    assert abs(radii.mean() - 20.0) < 0.1


def test_outlines_of_a_shot_without_result_leave_the_frame_plain(ask: Any, shoot: Shoot) -> None:
    path = f"{SHOTS}/{shoot()}/frames/3.png"
    assert ask("GET", f"{path}?overlay=outlines").content == ask("GET", path).content


def test_the_latest_result_is_shown(ask: Any, shoot: Shoot, store: Store) -> None:
    shot = shoot()
    assert ask("GET", f"{SHOTS}/{shot}/result").status_code == 404
    store.folders.add_result(shot, {"e": {"value": 0.7, "sigma": 0.1, "unit": "1"}})
    store.folders.add_result(shot, {"e": {"value": 0.74, "sigma": 0.01, "unit": "1"}})
    assert ask("GET", f"{SHOTS}/{shot}/result").json()["e"]["value"] == 0.74
