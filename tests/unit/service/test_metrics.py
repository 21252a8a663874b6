"""Numbers for Prometheus: what was counted is what happened."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import httpx
import pytest
from prometheus_client.parser import text_string_to_metric_families

from rigctl.rig.states import RigState
from rigctl.rig.status import Transition
from rigctl.service.metrics import Metrics

SETTINGS = {"pressure_a_kpa": 40, "pressure_b_kpa": 40, "offset_mm": 6}


def read(address: str) -> dict[tuple[str, str], float]:
    answer = httpx.get(f"{address}/metrics", timeout=60.0, trust_env=False)
    assert answer.headers["content-type"].startswith("text/plain")
    return {
        (sample.name, ",".join(sample.labels.values())): sample.value
        for family in text_string_to_metric_families(answer.text)
        for sample in family.samples
    }


def test_it_needs_no_key_and_shows_the_state_of_the_rig(address: str, rig: Any) -> None:
    found = read(address)
    assert found["rigctl_state", "idle"] == 1.0
    assert found["rigctl_state", "estop"] == 0.0
    rig.state = RigState.ESTOP
    assert read(address)["rigctl_state", "estop"] == 1.0
    assert found["rigctl_disk_free_bytes", ""] > 0


def test_a_shot_is_counted_once_however_often_it_changes_afterwards(
    address: str, store: Any, shoot: Callable[..., str]
) -> None:
    before = read(address)
    assert before["rigctl_frames_total", ""] == 0
    shot = shoot()
    store.move(shot, "analysing")
    store.move(shot, "stored")
    found = read(address)
    assert found["rigctl_shots_total", "stored"] == 1
    assert found["rigctl_fires_total", "yes"] == 1
    assert (found["rigctl_frames_total", ""], found["rigctl_frames_lost_total", ""]) == (10, 0)


def test_the_time_from_armed_to_fired_is_observed(address: str, rig: Any) -> None:
    since = rig.status().since
    for before, after in ((RigState.CHECKED, RigState.ARMED), (RigState.ARMED, RigState.FIRING)):
        rig.listeners.notify(Transition(before, after, since, "anna", "because", None))
    found = read(address)
    assert found["rigctl_arm_to_fire_seconds_count", ""] == 1
    assert found["rigctl_transitions_total", "firing"] == 1


def test_durations_are_right_where_the_hosts_clock_is_set_during_the_shot(
    rig: Any, store: Any, hub: Any, jobs: Any
) -> None:
    seconds = iter([10.0, 11.5, 11.6, 11.9])
    daemon: Any = SimpleNamespace(rig=rig, store=store, jobs=jobs)
    metrics = Metrics(daemon, hub, lambda: next(seconds))
    at = rig.status().since
    passed = (RigState.CHECKED, RigState.ARMED, RigState.FIRING, RigState.CAPTURING)
    for before, after in pairwise((*passed, RigState.STORED)):
        at -= timedelta(hours=3)
        metrics.transition(Transition(before, after, at, "anna", "because", None))
    shown = metrics.registry.get_sample_value
    assert shown("rigctl_arm_to_fire_seconds_sum") == pytest.approx(1.5)
    assert shown("rigctl_fire_to_stored_seconds_sum") == pytest.approx(0.3)


def test_every_name_carries_its_unit_or_counts(daemon_of_tests: Any) -> None:
    names = {family.name for family in daemon_of_tests.registry.collect()}
    units = ("_seconds", "_bytes", "_frames", "_lost", "_state", "_transitions", "_shots")
    counted = ("_fires", "_streams", "_jobs", "_threads")
    assert all(name.endswith(units + counted) for name in names)


@pytest.fixture
def daemon_of_tests(rig: Any, store: Any, hub: Any, jobs: Any) -> Metrics:
    daemon: Any = SimpleNamespace(rig=rig, store=store, jobs=jobs)
    return Metrics(daemon, hub)
