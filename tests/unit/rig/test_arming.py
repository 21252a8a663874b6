"""The arm token: one shot, exact settings, a few seconds."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from rig_fakes import SETTINGS, HandClock, Laboratory

from rigctl.errors import (
    ArmTokenError,
    DeviceSilentError,
    InterlockError,
    RefusedError,
    SettingsError,
)
from rigctl.rig.arming import ArmToken


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data")
    yield laboratory
    laboratory.close()


def test_arming_sets_pressure_and_offset_before_anything_is_checked(lab: Laboratory) -> None:
    lab.log.clear()
    lab.arm()
    opened = {f"{part}.reopen" for part in ("cut_off", "trigger", "regulator", "slide")}
    assert set(lab.log[:4]) == opened
    assert lab.log[4:7] == ["cut_off.check", "regulator.set_pressure", "slide.move_to"]
    assert lab.state == "armed"


def test_the_answer_says_until_when_the_token_holds(lab: Laboratory) -> None:
    armed = lab.rig.arm(SETTINGS, "anna")
    assert armed.expires_in_s == 30.0
    assert (armed.expires_at - lab.time.wall()).total_seconds() == pytest.approx(30.0)
    assert lab.rig.status().token_expires_at == armed.expires_at
    assert lab.rig.status().settings == SETTINGS


def test_a_token_fires_once(lab: Laboratory) -> None:
    token = lab.arm()
    lab.fire(token)
    with pytest.raises(ArmTokenError, match="spent"):
        lab.fire(token)
    assert lab.trigger.fired == [1]


def test_a_token_expires_on_the_monotonic_clock(lab: Laboratory) -> None:
    token = lab.arm()
    lab.time.step_s = -3600.0
    lab.time.pass_time(30.0)
    with pytest.raises(ArmTokenError, match="expired after 30 s"):
        lab.fire(token)
    assert lab.trigger.fired == []
    assert lab.state == "idle"


@pytest.mark.parametrize("step_s", [-7200.0, 7200.0])
def test_the_time_left_is_counted_whatever_the_hosts_clock_is_set_to(
    lab: Laboratory, step_s: float
) -> None:
    lab.arm()
    lab.time.step_s = step_s
    lab.time.pass_time(12.0)
    status = lab.rig.status()
    assert status.token_ends_s is not None
    assert status.token_ends_s - status.read_at == pytest.approx(18.0)
    lab.time.pass_time(18.0)
    assert lab.rig.status().token_ends_s is None


def test_a_token_holds_until_just_before_it_expires(lab: Laboratory) -> None:
    token = lab.arm()
    lab.time.pass_time(29.9)
    assert lab.fire(token).state == "stored"


def test_an_expired_token_cannot_be_taken_even_where_nobody_has_looked() -> None:
    time = HandClock()
    token = ArmToken(30.0, lambda: time.now)
    issued = token.issue(SETTINGS)
    time.pass_time(30.0)
    with pytest.raises(ArmTokenError, match="expired"):
        token.take(issued)


def test_an_expired_token_is_withdrawn_by_looking(lab: Laboratory) -> None:
    lab.arm()
    lab.time.pass_time(31.0)
    assert lab.state == "idle"
    assert lab.rig.status().token_expires_at is None


def test_arming_anew_with_other_settings_kills_the_token_before(lab: Laboratory) -> None:
    old = lab.arm()
    new = lab.arm(offset_mm=7.0)
    with pytest.raises(ArmTokenError, match="another token"):
        lab.fire(old)
    assert lab.fire(new).settings.offset_mm == 7.0
    assert lab.trigger.fired == [1]


def test_a_refused_arm_kills_the_token_before_as_well(lab: Laboratory) -> None:
    old = lab.arm()
    lab.slide.stuck = True
    with pytest.raises(InterlockError):
        lab.arm(offset_mm=8.0)
    with pytest.raises(ArmTokenError, match="armed anew"):
        lab.fire(old)


def test_disarming_withdraws_the_token_with_the_reason(lab: Laboratory) -> None:
    token = lab.arm()
    lab.rig.disarm("anna", "lunch")
    assert lab.state == "idle"
    with pytest.raises(ArmTokenError, match="lunch"):
        lab.fire(token)


@pytest.mark.parametrize("token", ["", "guess", "ünknown"])
def test_a_guessed_token_fires_nothing_and_leaves_the_live_one(lab: Laboratory, token: str) -> None:
    live = lab.arm()
    with pytest.raises(ArmTokenError):
        lab.fire(token)
    assert lab.fire(live).state == "stored"


def test_a_refused_token_leaves_its_key_free(lab: Laboratory) -> None:
    with pytest.raises(ArmTokenError):
        lab.fire("guess", key="mine")
    assert lab.fire(lab.arm(), key="mine").state == "stored"


@pytest.mark.parametrize(
    ("field", "value", "limit"),
    [
        ("pressure_a_kpa", 4.9, "5 to 120 kPa"),
        ("pressure_b_kpa", 120.1, "5 to 120 kPa"),
        ("offset_mm", 24.5, "0 to 24 mm"),
        ("delay_us", -20001.0, "-20000 to 20000 us"),
        ("angle_a_deg", 30.0, None),
    ],
)
def test_settings_beyond_the_rigs_limits_move_nothing(
    lab: Laboratory, field: str, value: object, limit: str | None
) -> None:
    lab.log.clear()
    with pytest.raises(SettingsError, match=field) as caught:
        lab.arm(**{field: value})
    assert caught.value.limit == limit
    assert lab.log == []


def test_arming_waits_until_the_pressure_is_reached(lab: Laboratory) -> None:
    lab.regulator.lag_s = 3.0
    began = lab.time.now
    lab.arm()
    assert 3.0 <= lab.time.now - began < 3.2


def test_arming_gives_up_after_the_settling_time_and_names_what_was_not_reached(
    lab: Laboratory,
) -> None:
    lab.regulator.lag_s = 60.0
    began = lab.time.now
    with pytest.raises(InterlockError, match=r"pressure_a: 0 kPa, needed 40 ± 0\.5 kPa"):
        lab.arm()
    assert 10.0 <= lab.time.now - began < 10.1
    assert lab.state == "idle"


def test_one_good_look_is_not_enough(lab: Laboratory) -> None:
    looks = []
    slide = lab.slide
    slide.hooks["position"] = lambda: looks.append(setattr(slide, "moving", not looks))
    lab.arm()
    # moving is read before each position: good, moving, good, good, then the full check
    assert len(looks) == 5


def test_arming_waits_for_the_cool_down(lab: Laboratory) -> None:
    lab.shoot()
    began = lab.time.now
    lab.arm()
    assert lab.time.now - began >= 0.2


@pytest.mark.parametrize("act", ["set_pressure", "move_to"])
def test_a_device_that_does_not_take_its_command_is_a_fault(lab: Laboratory, act: str) -> None:
    part = lab.regulator if act == "set_pressure" else lab.slide
    part.errors[act] = DeviceSilentError("gave no answer", part=part.name)
    with pytest.raises(DeviceSilentError):
        lab.arm()
    assert lab.state == "fault"
    assert "gave no answer" in lab.rig.status().latch_reason
    part.errors.clear()
    with pytest.raises(RefusedError, match="fault"):
        lab.arm()


def test_two_people_cannot_arm_at_the_same_time(lab: Laboratory) -> None:
    refused = []

    def second() -> None:
        lab.slide.hooks.clear()
        with pytest.raises(RefusedError, match="somebody else"):
            lab.rig.arm(SETTINGS, "berta")
        refused.append(True)

    lab.slide.hooks["move_to"] = second
    lab.arm()
    assert refused == [True]
