"""Everything the OpenAPI document allows, and much that it forbids, sent to the simulated rig."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
import schemathesis
from hypothesis import HealthCheck, given, settings
from schemathesis import GenerationMode

from rigctl.config import Configuration
from rigctl.daemon import Daemon, open_daemon
from rigctl.service.app import create_app
from rigctl.service.events import EventHub
from rigctl.store import Fired, ShotState
from tests.simulated import with_short_films

KEY = "contract-key"
WAIT_S = 200.0
SETTINGS = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 6.0}
HEADERS = {"Authorization": f"Bearer {KEY}"}


def simulated(folder: str) -> Configuration:
    short = with_short_films(folder)
    # A busy machine renders the films of a shot late.
    camera = short.camera.model_copy(update={"collect_timeout_s": WAIT_S / 2})
    return short.model_copy(update={"camera": camera})


@pytest.fixture(scope="module")
def daemon(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Daemon]:
    folder = tmp_path_factory.mktemp("contract") / "data"
    with open_daemon(simulated(str(folder))) as opened:
        yield opened


@pytest.fixture(scope="module")
def app(daemon: Daemon) -> Any:
    return create_app(daemon, KEY, EventHub())


@pytest.fixture(scope="module")
def contract(app: Any) -> Any:
    # A body that breaks a schema may break the bounds of bodies first.
    refused = ["400", "401", "403", "404", "405", "408", "409", "411", "413", "422", "5xx"]
    # Wrong keys are answered later and later: routes without a key are tried in test_auth.
    checks = {
        "negative_data_rejection": {"expected-statuses": refused},
        "ignored_auth": {"enabled": False},
    }
    config = schemathesis.Config.from_dict({"checks": checks})
    return schemathesis.openapi.from_asgi("/openapi.json", app, config=config)


# A stream has no end, and a stop latches the rig: both have tests of their own.
ORDERS = [
    ("POST", "/api/v1/rig/arm"),
    ("POST", "/api/v1/rig/release"),
    ("GET", "/api/v1/shots"),
    ("POST", "/api/v1/shots"),
    ("GET", "/api/v1/shots/{shot}/frames/{number}.png"),
    ("GET", "/api/v1/sweeps"),
    ("POST", "/api/v1/sweeps/{sweep}/pause"),
    ("GET", "/api/v1/campaigns/{campaign}/ranking"),
    ("POST", "/api/v1/campaigns/{campaign}/propose"),
    ("POST", "/api/v1/campaigns/{campaign}/next"),
    ("POST", "/api/v1/campaigns/{campaign}/fits"),
    ("GET", "/api/v1/campaigns/{campaign}/fits/{fit}"),
    ("DELETE", "/api/v1/jobs/{job}"),
]
QUESTIONS = [
    ("GET", "/api/v1/rig"),
    ("GET", "/api/v1/shots/{shot}"),
    ("GET", "/api/v1/shots/{shot}/result"),
    ("GET", "/api/v1/sweeps/{sweep}"),
    ("GET", "/api/v1/sweeps/{sweep}/steps"),
    ("POST", "/api/v1/sweeps/{sweep}/resume"),
    ("POST", "/api/v1/sweeps/{sweep}/abort"),
    ("GET", "/api/v1/campaigns"),
    ("GET", "/api/v1/campaigns/{campaign}"),
    ("POST", "/api/v1/campaigns/{campaign}/reanalyse"),
    ("GET", "/api/v1/campaigns/{campaign}/agreement"),
    ("GET", "/api/v1/campaigns/{campaign}/structure"),
    ("POST", "/api/v1/campaigns/{campaign}/explain"),
    ("GET", "/api/v1/campaigns/{campaign}/fits"),
    ("GET", "/api/v1/effects"),
    ("GET", "/api/v1/effects/{effect}"),
    ("GET", "/api/v1/jobs"),
    ("GET", "/api/v1/jobs/{job}"),
    ("GET", "/health/live"),
    ("GET", "/health/ready"),
]


def explore(contract: Any, method: str, path: str, mode: GenerationMode) -> None:
    cases = contract[path][method].as_strategy(generation_mode=mode)

    @settings(max_examples=15, deadline=None, database=None, suppress_health_check=[*HealthCheck])
    @given(case=cases)
    def ask(case: Any) -> None:
        case.call_and_validate(headers=HEADERS)

    ask()


@pytest.mark.parametrize(("method", "path"), ORDERS + QUESTIONS)
def test_what_the_document_allows_is_answered_as_it_promises(
    contract: Any, method: str, path: str
) -> None:
    explore(contract, method, path, GenerationMode.POSITIVE)


# No schema says which sweeps this rig allows: of them only refusals are tried.
FORBIDDEN = [*ORDERS, ("POST", "/api/v1/sweeps")]


@pytest.mark.parametrize(("method", "path"), FORBIDDEN)
def test_what_the_document_forbids_is_refused_as_it_promises(
    contract: Any, method: str, path: str
) -> None:
    explore(contract, method, path, GenerationMode.NEGATIVE)


async def post(app: Any, path: str, body: object, key: str = "") -> httpx.Response:
    transport = httpx.ASGITransport(app)
    headers = HEADERS | {"Idempotency-Key": key}
    async with httpx.AsyncClient(transport=transport, base_url="http://rig") as client:
        return await client.post(path, json=body, headers=headers)


async def fire_from_fifty_callers(app: Any, key: str) -> tuple[list[httpx.Response], object]:
    armed = await post(app, "/api/v1/rig/arm", SETTINGS)
    body = {"arm_token": armed.json()["arm_token"]}
    calls = [post(app, "/api/v1/shots", body, key) for _ in range(50)]
    return list(await asyncio.gather(*calls)), body


def test_fifty_callers_with_one_key_fire_once_and_are_told_the_same_shot(
    app: Any, daemon: Daemon
) -> None:
    for key in ("first", "second"):
        answers, body = asyncio.run(fire_from_fifty_callers(app, key))
        accepted = [answer for answer in answers if answer.status_code == 202]
        running = [answer for answer in answers if answer.status_code == 409]
        assert len(accepted) + len(running) == 50
        assert len(accepted) == 1
        shot = accepted[0].json()["shot"]
        assert {answer.json()["shot"] for answer in running} == {shot}
        assert daemon.rig.wait(shot, WAIT_S).outcome is ShotState.STORED
        again = asyncio.run(post(app, "/api/v1/shots", body, key))
        assert (again.status_code, again.json()) == (202, {"shot": shot, "state": "stored"})


def test_the_spheres_flew_once_for_each_accepted_key_and_never_otherwise(daemon: Daemon) -> None:
    """Comes last: the simulated laboratory has counted through all tests above."""
    shots = daemon.store.shots(limit=1000)
    assert daemon.laboratory is not None
    assert daemon.laboratory.fires == len(shots)  # type: ignore[attr-defined]
    assert {shot.fired for shot in shots} <= {Fired.YES}
