"""A plan that fires one shot fires one shot, whatever a run engine does in between."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("bluesky")

import bluesky.plan_stubs as bps
import event_model
from bluesky import RunEngine
from bluesky.protocols import Movable, Readable, Stageable, Triggerable, check_supports
from bluesky.utils import FailedStatus, Msg, RunEngineInterrupted

from rigctl.bluesky_devices import Rig, Step, fire_once, one_shot
from rigctl.errors import FireOutcomeUnknownError, RefusedError
from tests.unit.bluesky_devices.laboratory import SETTINGS, CountingRig

WAIT_S = 60.0


@pytest.fixture
def documents() -> list[tuple[str, dict[str, Any]]]:
    return []


@pytest.fixture
def engine(documents: list[tuple[str, dict[str, Any]]]) -> Iterator[RunEngine]:
    running = RunEngine({}, context_managers=[])
    running.subscribe(lambda kind, document: documents.append((kind, document)))
    yield running
    running.loop.call_soon_threadsafe(running.loop.stop)
    running._th.join(WAIT_S)
    running.loop.close()


def device(laboratory: CountingRig) -> Rig:
    return Rig(laboratory, campaign="nylon", wait_s=WAIT_S)


def shots(rig: Rig, count: int) -> Iterator[Msg]:
    """A plan of one's own: several shots in one run."""
    yield from bps.open_run()
    for _ in range(count):
        yield from one_shot(rig, SETTINGS)
    yield from bps.close_run()


def test_it_fires_once_and_records_the_shot(
    engine: RunEngine, documents: list[tuple[str, dict[str, Any]]]
) -> None:
    laboratory = CountingRig()
    engine(fire_once(device(laboratory), SETTINGS, md={"operator": "M."}))
    assert len(laboratory.fires) == 1
    assert [kind for kind, _ in documents] == ["start", "descriptor", "event", "stop"]
    for kind, document in documents:
        event_model.schema_validators[event_model.DocumentNames[kind]].validate(document)
    start, descriptor, event, stop = (document for _, document in documents)
    assert (start["plan_name"], start["operator"]) == ("fire_once", "M.")
    assert start["settings"]["pressure_a_kpa"] == 40
    assert event["data"]["rig_e"] == 0.74
    assert event["data"]["rig_shot"] == "shot-1"
    assert math.isnan(event["data"]["rig_beta"])
    assert descriptor["data_keys"]["rig_v_n_sigma"]["units"] == "m/s"
    assert stop["exit_status"] == "success"


def test_a_pause_while_the_rig_arms_ends_the_run_and_fires_nothing(engine: RunEngine) -> None:
    laboratory = CountingRig(while_arming=lambda: engine.request_pause(defer=False))
    with pytest.raises(RunEngineInterrupted):
        engine(fire_once(device(laboratory), SETTINGS))
    assert engine.state == "idle"
    assert laboratory.fires == []


def test_a_pause_while_the_shot_is_fired_ends_the_run_after_one_fire(
    engine: RunEngine, documents: list[tuple[str, dict[str, Any]]]
) -> None:
    laboratory = CountingRig(while_firing=lambda: engine.request_pause(defer=False))
    with pytest.raises(RunEngineInterrupted):
        engine(fire_once(device(laboratory), SETTINGS))
    assert engine.state == "idle"
    assert len(laboratory.fires) == 1
    assert documents[-1][1]["exit_status"] == "abort"


def test_a_deferred_pause_lets_the_shot_come_on_record(
    engine: RunEngine, documents: list[tuple[str, dict[str, Any]]]
) -> None:
    laboratory = CountingRig(while_firing=lambda: engine.request_pause(defer=True))
    engine(fire_once(device(laboratory), SETTINGS))
    assert len(laboratory.fires) == 1
    assert documents[-1][1]["exit_status"] == "success"


def test_a_deferred_pause_ends_a_longer_plan_between_two_shots(
    engine: RunEngine, documents: list[tuple[str, dict[str, Any]]]
) -> None:
    laboratory = CountingRig(while_firing=lambda: engine.request_pause(defer=True))
    with pytest.raises(RunEngineInterrupted):
        engine(shots(device(laboratory), 3))
    assert engine.state == "idle"
    assert len(laboratory.armed) == len(laboratory.fires) == 1
    assert [kind for kind, _ in documents] == ["start", "descriptor", "event", "stop"]
    assert documents[-1][1]["exit_status"] == "abort"


def test_a_rewinding_plan_that_takes_no_care_fires_once_all_the_same(engine: RunEngine) -> None:
    """A checkpoint stands before the arming: all is done again, and the device knows the step."""
    laboratory = CountingRig()
    rig = device(laboratory)
    seen: list[str] = []

    def careless() -> Iterator[Msg]:
        step = Step(SETTINGS)
        yield from bps.open_run()
        yield from bps.checkpoint()
        yield from bps.abs_set(rig, step, wait=True)
        yield from bps.trigger(rig, wait=True)
        yield from bps.pause()
        yield from bps.create()
        seen.append((yield from bps.read(rig))["rig_shot"]["value"])
        yield from bps.save()
        yield from bps.close_run()

    asked: list[str] = []
    engine.msg_hook = lambda message: asked.append(message.command)
    with pytest.raises(RunEngineInterrupted):
        engine(careless())
    assert engine.state == "paused"
    engine.resume()
    assert (asked.count("set"), asked.count("trigger")) == (2, 2)
    assert len(laboratory.fires) == len(laboratory.armed) == 1
    assert seen == ["shot-1"]


def test_each_step_of_a_longer_plan_fires_under_a_key_of_its_own(
    engine: RunEngine, documents: list[tuple[str, dict[str, Any]]]
) -> None:
    laboratory = CountingRig()
    engine(shots(device(laboratory), 3))
    assert len({key for _, key in laboratory.fires}) == 3
    fired = [one["data"]["rig_shot"] for kind, one in documents if kind == "event"]
    assert fired == ["shot-1", "shot-2", "shot-3"]


def test_after_a_lost_answer_nothing_is_sent_again(engine: RunEngine) -> None:
    laboratory = CountingRig(loses_the_answer=True)
    rig, step = device(laboratory), Step(SETTINGS)

    def once() -> Iterator[Msg]:
        yield from bps.abs_set(rig, step, wait=True)
        yield from bps.trigger(rig, wait=True)

    with pytest.raises(FailedStatus):
        engine(once())
    with pytest.raises(FailedStatus) as again:
        engine(once())
    assert isinstance(again.value.__cause__, FireOutcomeUnknownError)
    assert len(laboratory.fires) == len(laboratory.armed) == 1


def test_what_was_not_set_cannot_be_fired_or_read() -> None:
    rig = device(CountingRig())
    status = rig.trigger()
    assert isinstance(status.exception(WAIT_S), RefusedError)
    assert not status.success
    with pytest.raises(RefusedError, match="nothing was fired"):
        rig.read()


def test_a_rig_that_refuses_to_arm_is_not_fired(engine: RunEngine) -> None:
    def refuse() -> None:
        raise RefusedError("the emergency stop is latched")

    laboratory = CountingRig(while_arming=refuse)
    rig, step = device(laboratory), Step(SETTINGS)
    failure = rig.set(step).exception(WAIT_S)
    assert "latched" in str(failure)
    assert "is not armed" in str(rig.trigger().exception(WAIT_S))
    assert laboratory.fires == []


def test_it_has_the_protocols_of_a_device() -> None:
    rig = device(CountingRig())
    for protocol in (Readable, Movable, Triggerable, Stageable):
        assert check_supports(rig, protocol) is rig
    rig.set(Step(SETTINGS)).exception(WAIT_S)
    rig.trigger().exception(WAIT_S)
    assert set(rig.read()) == set(rig.describe())


def test_a_status_calls_back_once_whether_asked_before_or_after_the_end() -> None:
    rig = device(CountingRig())
    status, called = rig.set(Step(SETTINGS)), []
    status.add_callback(called.append)
    assert status.exception(WAIT_S) is None
    status.add_callback(called.append)
    assert status.done
    assert repr(status) == "<arm rig: done>"
    assert called[-1] is status
