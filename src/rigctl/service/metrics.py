"""Numbers of the running daemon for Prometheus: `GET /metrics`, without a key."""

from __future__ import annotations

import shutil
import threading
import time
from collections.abc import Callable
from functools import partial

from fastapi import APIRouter
from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client.exposition import CONTENT_TYPE_LATEST
from starlette.responses import Response

from rigctl.daemon import Daemon
from rigctl.jobs.job import ENDED
from rigctl.rig.states import RigState
from rigctl.rig.status import Transition
from rigctl.service.events import EventHub
from rigctl.store import Fired, ShotRecord

_SECONDS = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 60.0)


class Metrics:
    """Counts what rig and shots report from the start of the service on.

    Names carry the unit. Shots are counted once, when they reach their outcome. Any thread may
    report. Durations are those of the monotonic clock, whatever the host's clock is set to.
    """

    def __init__(
        self, daemon: Daemon, hub: EventHub, monotonic: Callable[[], float] = time.monotonic
    ) -> None:
        self.registry = CollectorRegistry()
        self._monotonic = monotonic
        self._reached: dict[RigState, float] = {}
        self._lock = threading.Lock()
        self._counted = 0
        self._transitions = self._counter(
            "rigctl_transitions", "Steps of the rig, by the state reached", "state"
        )
        self._shots = self._counter("rigctl_shots", "Shots that ended, by outcome", "outcome")
        self._fires = self._counter("rigctl_fires", "Fire commands, by what is known", "fired")
        self._frames = self._counter("rigctl_frames", "Frames stored")
        self._lost = self._counter("rigctl_frames_lost", "Pictures that the source skipped")
        self._arming = self._histogram("rigctl_arm_to_fire_seconds", "Armed until fired")
        self._storing = self._histogram("rigctl_fire_to_stored_seconds", "Fired until stored")
        self._watch(daemon, hub)

    def listen(self, daemon: Daemon) -> list[Callable[[], None]]:
        """Begin to count what comes from now on; return what ends it."""
        last = daemon.store.catalogue.last()
        self._counted = 0 if last is None else last.number
        return [
            daemon.rig.listeners.add(self.transition),
            daemon.store.listeners.add(self.shot),
        ]

    def transition(self, step: Transition) -> None:
        """Count a step of the rig."""
        self._transitions.labels(step.after).inc()
        self._reached[step.after] = now = self._monotonic()
        armed, fired = self._reached.get(RigState.ARMED), self._reached.get(RigState.CAPTURING)
        if step.after is RigState.FIRING and armed is not None:
            self._arming.observe(now - armed)
        elif step.after is RigState.STORED and fired is not None:
            self._storing.observe(now - fired)

    def shot(self, shot: ShotRecord) -> None:
        """Count a shot when it has its outcome; shots end in the order of their numbers."""
        with self._lock:
            if shot.outcome is None or shot.number <= self._counted:
                return
            self._counted = shot.number
        self._shots.labels(shot.outcome).inc()
        if shot.fired is not Fired.NO:
            self._fires.labels(shot.fired).inc()
        self._frames.inc(shot.frames or 0)
        self._lost.inc(shot.lost or 0)

    def _counter(self, name: str, what: str, *labels: str) -> Counter:
        return Counter(name, what, labels, registry=self.registry)

    def _histogram(self, name: str, what: str) -> Histogram:
        return Histogram(name, what, buckets=_SECONDS, registry=self.registry)

    def _gauge(self, name: str, what: str, read: Callable[[], float]) -> None:
        Gauge(name, what, registry=self.registry).set_function(read)

    def _watch(self, daemon: Daemon, hub: EventHub) -> None:
        state = Gauge("rigctl_state", "1 for the rig's state", ["state"], registry=self.registry)
        for each in RigState:
            state.labels(each).set_function(partial(_is_state, daemon, each))
        self._gauge("rigctl_event_streams", "Clients that listen to events", lambda: hub.clients)
        self._gauge("rigctl_jobs", "Jobs that wait or run", lambda: _live_jobs(daemon))
        self._gauge("rigctl_disk_free_bytes", "Free space below the store", lambda: _free(daemon))
        self._gauge("rigctl_threads", "Threads of the daemon", threading.active_count)


def _is_state(daemon: Daemon, state: RigState) -> float:
    return float(daemon.rig.status().state is state)


def _live_jobs(daemon: Daemon) -> float:
    return sum(job.state not in ENDED for job in daemon.jobs.jobs())


def _free(daemon: Daemon) -> float:
    return shutil.disk_usage(daemon.store.path).free


def metrics_route(metrics: Metrics) -> APIRouter:
    """Return the route of `/metrics`."""
    router = APIRouter()

    @router.get("/metrics", include_in_schema=False)
    def read() -> Response:
        return Response(generate_latest(metrics.registry), media_type=CONTENT_TYPE_LATEST)

    return router
