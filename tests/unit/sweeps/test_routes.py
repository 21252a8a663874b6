"""Sweeps over REST: the whole way in one application, on a rig of stand-ins."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import httpx
import pytest
from bench import BOUND_S, Bench

from rigctl.errors import FireOutcomeUnknownError
from rigctl.service.app import create_app
from rigctl.service.events import EventHub

KEY = "a-key-for-tests"
GRID = {"grid": {"pressure_a_kpa": [30, 40], "offset_mm": [1, 2, 3]}, "campaign": "nylon"}
ONE = "20260131-s0001"


@pytest.fixture
def app(bench: Bench) -> Any:
    daemon: Any = SimpleNamespace(
        configuration=bench.lab.configuration,
        rig=bench.lab.rig,
        store=bench.lab.store,
        sweeps=bench.runner,
    )
    return create_app(daemon, KEY, EventHub())


class Caller:
    def __init__(self, app: Any, bench: Bench) -> None:
        self._app, self._bench = app, bench

    def __call__(
        self, method: str, path: str, body: object = None, key: str | None = None
    ) -> httpx.Response:
        headers = {"Authorization": f"Bearer {KEY}"} | ({"Idempotency-Key": key} if key else {})
        options = {} if body is None else {"json": body}

        async def ask() -> httpx.Response:
            transport = httpx.ASGITransport(self._app)
            async with httpx.AsyncClient(transport=transport, base_url="http://rig") as client:
                return await client.request(
                    method, f"/api/v1/sweeps{path}", headers=headers, **options
                )

        answer = asyncio.run(ask())
        assert self._bench.runner.wait(BOUND_S)
        return answer


@pytest.fixture
def ask(app: Any, bench: Bench) -> Caller:
    return Caller(app, bench)


def test_a_grid_is_fired_in_a_drawn_order_and_shown_step_by_step(ask: Caller, bench: Bench) -> None:
    answer = ask("POST", "", GRID, "k")
    assert answer.status_code == 202, answer.text
    assert answer.headers["Location"] == f"/api/v1/sweeps/{ONE}"
    assert answer.json()["steps"] == 6
    shown = ask("GET", f"/{ONE}").json()
    assert (shown["state"], shown["counts"]["stored"], shown["left_s"]) == ("completed", 6, None)
    shown = ask("GET", f"/{ONE}/steps").json()
    assert shown["form"]["grid"]["offset_mm"] == [1.0, 2.0, 3.0]
    fired = [
        (each["settings"]["pressure_a_kpa"], each["settings"]["offset_mm"])
        for each in shown["table"]
    ]
    written = [(a, offset) for a in (30.0, 40.0) for offset in (1.0, 2.0, 3.0)]
    assert sorted(fired) == written
    assert fired != written
    shots = bench.lab.store.shots(campaign="nylon")
    assert [each["shot"] for each in shown["table"]] == [shot.id for shot in shots]


def test_the_same_key_answers_with_the_same_sweep(ask: Caller, bench: Bench) -> None:
    ask("POST", "", GRID, "k")
    again = ask("POST", "", GRID, "k")
    assert (again.status_code, again.json()["state"]) == (202, "completed")
    other = ask("POST", "", GRID | {"repeat": 2}, "k")
    assert (other.status_code, other.json()["code"]) == (422, "idempotency-reused")
    assert bench.fires == 6


def test_a_sweep_needs_a_key(ask: Caller, bench: Bench) -> None:
    answer = ask("POST", "", GRID)
    assert (answer.status_code, answer.json()["code"]) == (400, "idempotency")
    assert bench.lab.store.sweeps.sweeps() == []


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ({}, "1 to 10000 shots, this one 0"),
        ({"grid": {"pressure_a_kpa": [], "offset_mm": [1]}}, "at least 1"),
        ({"grid": {"pressure_a_kpa": [40, 40], "offset_mm": [1]}}, "40 stands twice"),
        (
            {"grid": {"pressure_a_kpa": {"first": 40, "last": 40, "count": 3}, "offset_mm": [1]}},
            "from 40 to 40 is empty",
        ),
        ({"grid": {"pressure_a_kpa": [40], "offset_mm": [1, "2"]}}, "valid number"),
        ({"grid": {"pressure_a_kpa": [40], "offset_mm": [True]}}, "valid number"),
        (GRID | {"speed": 1}, "speed"),
        (GRID | {"until": {"coefficient": "mu", "sigma": 0.1}}, "coefficient"),
        (GRID | {"until": {"coefficient": "e", "sigma": 0}}, "sigma"),
        ({"grid": {"pressure_a_kpa": [40], "offset_mm": [25]}}, "step 1, offset_mm"),
        ({"grid": {"pressure_a_kpa": [4], "offset_mm": [2]}}, "5 to 120 kPa"),
    ],
)
def test_a_sweep_that_cannot_be_is_refused_with_field_value_and_limit(
    ask: Caller, bench: Bench, body: object, words: str
) -> None:
    answer = ask("POST", "", body, "k")
    assert answer.status_code == 422
    assert words in answer.json()["detail"]
    assert bench.lab.store.sweeps.sweeps() == []


def test_a_long_list_of_shots_fits_into_one_order(ask: Caller, bench: Bench) -> None:
    shot = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 1.0}
    bench.at_fire(1, lambda: bench.runner.abort(ONE, "anna"))
    answer = ask("POST", "", {"shots": [shot] * 2000}, "k")
    assert answer.status_code == 202
    assert ask("GET", f"/{ONE}").json()["counts"]["skipped"] == 1999
    too_long = ask("POST", "", {"shots": [shot] * 20_000}, "k2")
    assert (too_long.status_code, too_long.json()["code"]) == (413, "body-too-large")


def test_pause_resume_and_abort_go_the_whole_way(ask: Caller, bench: Bench) -> None:
    bench.at_fire(2, lambda: bench.runner.pause(ONE, "anna"))
    ask("POST", "", GRID, "k")
    assert ask("GET", f"/{ONE}").json()["counts"]["waiting"] == 4
    bench.at_fire(4, lambda: bench.runner.pause(ONE, "anna"))
    resumed = ask("POST", f"/{ONE}/resume")
    assert resumed.status_code == 200
    aborted = ask("POST", f"/{ONE}/abort").json()
    assert (aborted["state"], aborted["counts"]["skipped"]) == ("aborted", 2)
    refused = ask("POST", f"/{ONE}/resume")
    assert (refused.status_code, refused.json()["code"]) == (409, "refused")
    assert bench.fires == 4


def test_a_latched_rig_takes_no_sweep(ask: Caller, bench: Bench) -> None:
    bench.lab.trigger.errors["fire"] = FireOutcomeUnknownError("no answer")
    ask("POST", "", GRID, "k")
    shown = ask("GET", f"/{ONE}").json()
    assert (shown["state"], shown["counts"]["unknown"]) == ("paused", 1)
    assert "release the rig" in shown["reason"]
    for path in (f"/{ONE}/resume", ""):
        body = None if path else GRID
        assert ask("POST", path, body, "other").status_code == 409


def test_sweeps_are_listed_latest_first_page_by_page(ask: Caller) -> None:
    for key in "abc":
        ask("POST", "", GRID, key)
    page = ask("GET", "?limit=2").json()
    assert [each["sweep"] for each in page["sweeps"]] == ["20260131-s0003", "20260131-s0002"]
    rest = ask("GET", f"?limit=2&before={page['next']}").json()
    assert ([each["sweep"] for each in rest["sweeps"]], rest["next"]) == ([ONE], None)
    assert ask("GET", "?state=paused").json() == {"sweeps": [], "next": None}


def test_a_sweep_that_is_not_there_is_404_and_a_name_that_is_none_is_422(ask: Caller) -> None:
    for path in ("", "/steps", "/pause", "/resume", "/abort"):
        method = "GET" if path in {"", "/steps"} else "POST"
        assert ask(method, f"/{ONE}{path}").status_code == 404
        assert ask(method, f"/latest{path}").status_code == 422
