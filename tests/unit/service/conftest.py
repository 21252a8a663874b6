"""A rig of its own for the service: it answers at once, or blocks when a test says so."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from types import SimpleNamespace
from typing import Any

import fastapi.dependencies.models
import httpx
import numpy as np
import pytest
import uvicorn

from rigctl.cameras.frames import FrameSequence
from rigctl.config import Configuration, load
from rigctl.errors import ArmTokenError, RigError
from rigctl.jobs import Jobs
from rigctl.listeners import Listeners
from rigctl.rig.arming import Armed
from rigctl.rig.interlocks import Interlock
from rigctl.rig.recovery import Recovery
from rigctl.rig.states import RigState
from rigctl.rig.status import RigStatus, Transition
from rigctl.service.app import create_app
from rigctl.service.events import EventHub
from rigctl.service.guards.connections import Connections
from rigctl.settings import ShotSettings
from rigctl.store import Change, Fired, NewShot, ShotRecord, ShotState, Store

KEY = "a-key-for-tests"
NOW = datetime(2026, 1, 31, 12, 0, tzinfo=UTC)
PRESSURE = Interlock("pressure", True, 40.0, "40 ± 0.5", "kPa", "regulator", 99.0, "wait")
RECOVERY = Recovery(("20260130-000001",), (), ("20260130-000002", "20260130-000003"), (), 0)
WAIT_S = 60.0


@dataclass
class FakeRig:
    """What the service asks of a rig: it notes every call, and fires only into its list."""

    store: Store
    listeners: Listeners[Transition] = field(default_factory=Listeners)
    state: RigState = RigState.IDLE
    refusal: Exception | None = None
    armed: list[tuple[ShotSettings, str]] = field(default_factory=list)
    fires: list[str] = field(default_factory=list)
    stops: list[tuple[str, str]] = field(default_factory=list)
    releases: list[tuple[str, str]] = field(default_factory=list)
    holds_arm: threading.Event | None = None
    arming: threading.Event = field(default_factory=threading.Event)

    def status(self) -> RigStatus:
        return RigStatus(
            name="simulated",
            apparatus="pusher",
            simulated=True,
            state=self.state,
            since=NOW,
            reason="started",
            settings=None,
            token_expires_at=None,
            token_ends_s=None,
            interlocks=(PRESSURE,),
            read_at=100.0,
            running=None,
            last_shot=None,
            latch_reason="stopped" if self.state is RigState.ESTOP else None,
            warnings=(),
        )

    def arm(self, settings: ShotSettings, actor: str) -> Armed:
        self.arming.set()
        if self.holds_arm is not None and not self.holds_arm.wait(WAIT_S):
            raise RigError("the test never let the arming go")
        if self.refusal is not None:
            raise self.refusal
        self.armed.append((settings, actor))
        return Armed(f"token-{len(self.armed)}", NOW, 30.0, ())

    def accept(
        self,
        *,
        token: str,
        key: str,
        body_hash: str,
        campaign: str | None,
        note: str | None,
        actor: str,
    ) -> ShotRecord:
        def describe() -> NewShot:
            if token != f"token-{len(self.armed)}":
                raise ArmTokenError("the arm token does not hold", todo="arm again")
            settings = self.armed[-1][0]
            return NewShot(settings, campaign, note, actor, True, "0" * 64, NOW)

        record, known = self.store.accept(key, body_hash, describe)
        if not known:
            self.fires.append(key)
        return record

    def estop(self, actor: str, reason: str) -> None:
        self.stops.append((actor, reason))
        self.state = RigState.ESTOP

    def release(self, actor: str, reason: str) -> None:
        self.releases.append((actor, reason))
        self.state = RigState.IDLE


class Client:
    """A caller with the key, in the same process and without a socket."""

    def __init__(self, app: Any) -> None:
        self._app = app

    def __call__(
        self, method: str, path: str, key: str | None = KEY, **options: Any
    ) -> httpx.Response:
        headers = dict(options.pop("headers", {}))
        if key is not None:
            headers.setdefault("Authorization", f"Bearer {key}")

        async def ask() -> httpx.Response:
            transport = httpx.ASGITransport(self._app, raise_app_exceptions=False)
            async with httpx.AsyncClient(transport=transport, base_url="http://rig") as client:
                return await client.request(method, path, headers=headers, **options)

        return asyncio.run(ask())


@pytest.fixture
def rig(store: Store) -> FakeRig:
    return FakeRig(store)


@pytest.fixture
def hub() -> EventHub:
    return EventHub()


@pytest.fixture
def jobs() -> Iterator[Jobs]:
    opened = Jobs()
    yield opened
    opened.close()


@pytest.fixture
def handed_over() -> list[str]:
    """Shots that the service handed to the analysis."""
    return []


@pytest.fixture
def configuration() -> Configuration:
    return load()


@pytest.fixture
def app(
    rig: FakeRig,
    store: Store,
    hub: EventHub,
    jobs: Jobs,
    handed_over: list[str],
    configuration: Configuration,
) -> Iterator[Any]:
    daemon = SimpleNamespace(
        configuration=configuration,
        rig=rig,
        store=store,
        recovery=RECOVERY,
        jobs=jobs,
        sweeps=SimpleNamespace(listeners=Listeners()),
        analyse=handed_over.append,
        analyse_by=lambda shot, method: handed_over.append(f"{shot} by {method}"),
    )
    yield create_app(daemon, KEY, hub)  # type: ignore[arg-type]
    # Routes of every application are kept there, and through them all of it: a quarter of the time
    # of these tests went into looking for garbage among applications of tests before.
    for kept in vars(fastapi.dependencies.models).values():
        if hasattr(kept, "cache_clear"):
            kept.cache_clear()


@pytest.fixture
def ask(app: Any) -> Client:
    return Client(app)


@pytest.fixture
def shoot(ask: Client, store: Store) -> Callable[..., str]:
    """Fire a shot by REST and carry it to `stored` with ten frames, each of its number's grey."""

    def fire(campaign: str | None = None, key: str | None = None) -> str:
        settings = {"pressure_a_kpa": 40, "pressure_b_kpa": 40, "offset_mm": 6}
        token = ask("POST", "/api/v1/rig/arm", json=settings).json()["arm_token"]
        body = {"arm_token": token} | ({"campaign": campaign} if campaign else {})
        headers = {"Idempotency-Key": key or token}
        answer = ask("POST", "/api/v1/shots", json=body, headers=headers)
        assert answer.status_code == 202, answer.text
        shot = str(answer.json()["shot"])
        store.move(shot, ShotState.FIRING)
        store.move(shot, ShotState.CAPTURING, Change(fired=Fired.YES, fired_at=NOW))
        store.folders.write(shot, ten_frames(), {})
        store.move(shot, ShotState.STORED, Change(ended_at=NOW, frames=10, lost=0))
        return shot

    return fire


def ten_frames() -> FrameSequence:
    pixels = np.zeros((10, 192, 240), dtype=np.uint8)
    pixels += np.arange(10, dtype=np.uint8)[:, None, None]
    times = np.arange(10) * 1e-3
    return FrameSequence(pixels, times, np.arange(10, dtype=np.int64), (), "test")


class _ThreadServer(uvicorn.Server):
    """Says when it listens."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self.listening = threading.Event()

    async def startup(self, sockets: Any = None) -> None:
        await super().startup(sockets)
        self.listening.set()


@contextmanager
def served(app: Any, hub: EventHub, connections: Connections | None = None) -> Iterator[str]:
    """Serve the application on a free loopback port; give its address."""
    config = uvicorn.Config(
        app,
        http=(connections or Connections(64)).protocol(),  # type: ignore[arg-type]
        port=0,
        log_level="warning",
        timeout_graceful_shutdown=2,
    )
    server = _ThreadServer(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        assert server.listening.wait(WAIT_S), "the server did not start"
        host, port = server.servers[0].sockets[0].getsockname()[:2]
        yield f"http://{host}:{port}"
    finally:
        hub.close()
        server.should_exit = True
        thread.join(WAIT_S)
    assert not thread.is_alive(), "the server did not end"


@pytest.fixture
def address(app: Any, hub: EventHub) -> Iterator[str]:
    with served(app, hub) as url:
        yield url


@pytest.fixture
def serving(app: Any, hub: EventHub) -> Callable[[int], AbstractContextManager[str]]:
    """Serve the application to at most so many connections, for the length of a `with` block."""
    return lambda most: served(app, hub, Connections(most))
