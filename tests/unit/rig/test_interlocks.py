"""Every interlock refuses, all that refuse are named, and they are read again before the fire."""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest
from rig_fakes import SETTINGS, Laboratory, Part

from rigctl.config import load
from rigctl.errors import DeviceSilentError, FramesError, InterlockError


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data")
    yield laboratory
    laboratory.close()


def silent(part: Part) -> DeviceSilentError:
    return DeviceSilentError("gave no answer", part=part.name, limit="0.5 s", todo="look at it")


TRIPS = {
    "pressure_a": lambda lab: setattr(lab.regulator, "error_kpa", 0.51),
    "pressure_b": lambda lab: setattr(lab.regulator, "age_s", 2.01),
    "pressure": lambda lab: lab.regulator.errors.update(pressure=silent(lab.regulator)),
    "offset": lambda lab: setattr(lab.slide, "_at", 6.021),
    "slide": lambda lab: setattr(lab.slide, "moving", True),
    "trigger": lambda lab: lab.trigger.errors.update(check=silent(lab.trigger)),
    "cut_off": lambda lab: lab.cut_off.errors.update(check=silent(lab.cut_off)),
    "disk": lambda lab: setattr(lab, "free_mb", 199.9),
    "clock": lambda lab: setattr(lab.time, "step_s", -1.1),
    "store": lambda lab: setattr(lab, "holder", held(lab)),
}


def held(lab: Laboratory) -> sqlite3.Connection:
    holder = sqlite3.connect(lab.folder / "catalogue.db", isolation_level=None)
    holder.execute("BEGIN IMMEDIATE")
    return holder


def freed(lab: Laboratory) -> None:
    if hasattr(lab, "holder"):
        lab.holder.execute("ROLLBACK")
        lab.holder.close()


@pytest.mark.parametrize("name", TRIPS)
def test_arming_is_refused_by_each_condition_under_its_name(lab: Laboratory, name: str) -> None:
    lab.arm()
    lab.rig.disarm("anna", "test")
    lab.slide.stuck = True
    TRIPS[name](lab)
    with pytest.raises(InterlockError) as caught:
        lab.arm()
    freed(lab)
    assert any(sentence.startswith(f"{name}:") for sentence in caught.value.tripped)
    assert lab.state == "idle"
    assert lab.trigger.fired == []


@pytest.mark.parametrize("name", [name for name in TRIPS if name != "store"])
def test_each_condition_is_read_again_before_the_fire_command(lab: Laboratory, name: str) -> None:
    token = lab.arm()
    TRIPS[name](lab)
    shot = lab.fire(token)
    assert (shot.state, shot.fired, shot.failure_code) == ("aborted", "no", "interlock")
    assert f"{name}:" in shot.failure
    assert lab.trigger.fired == []
    assert lab.state == "idle"


def test_a_store_that_fails_before_the_fire_command_fires_nothing(lab: Laboratory) -> None:
    token = lab.arm()
    lab.capture.hooks["start"] = lambda: TRIPS["store"](lab)
    lab.fire(token)
    assert lab.trigger.fired == []
    assert lab.state == "fault"
    freed(lab)


def test_a_camera_that_gives_no_sign_of_life_refuses(lab: Laboratory) -> None:
    lab.capture.errors["check"] = FramesError("no camera", todo="plug it in")
    with pytest.raises(InterlockError, match=r"camera: no camera.*plug it in"):
        lab.arm()


def test_nothing_moves_unless_the_cut_off_answers(lab: Laboratory) -> None:
    lab.cut_off.errors["check"] = silent(lab.cut_off)
    lab.log.clear()
    with pytest.raises(InterlockError, match=r"cut_off: gave no answer.*look at it"):
        lab.arm()
    assert not {"regulator.set_pressure", "slide.move_to"} & set(lab.log)


def test_actuators_without_power_refuse(lab: Laboratory) -> None:
    lab.trigger.has_power = False
    said = "trigger: without power, needed powered.*the cut-off was restored.*port and channel"
    with pytest.raises(InterlockError, match=said):
        lab.arm()


def test_all_that_refuse_are_named_together(lab: Laboratory) -> None:
    lab.trigger.has_power = False
    lab.free_mb = 1.0
    lab.slide.moving = True
    with pytest.raises(InterlockError) as caught:
        lab.arm()
    names = [sentence.split(":")[0] for sentence in caught.value.tripped]
    assert names == ["slide", "trigger", "disk"]
    assert all(sentence in str(caught.value) for sentence in caught.value.tripped)


@pytest.mark.parametrize("age", [-0.5, 2.5])
def test_a_reading_that_is_stale_or_from_the_future_trips(lab: Laboratory, age: float) -> None:
    lab.regulator.age_s = age
    with pytest.raises(InterlockError, match=r"read -?[0-9.]+ s ago, needed a reading no older"):
        lab.arm()


def test_a_slow_part_makes_the_readings_before_it_stale(lab: Laboratory) -> None:
    token = lab.arm()
    lab.trigger.hooks["check"] = lambda: lab.time.pass_time(2.1)
    shot = lab.fire(token)
    assert (shot.state, lab.trigger.fired) == ("aborted", [])
    assert "pressure_a" in shot.failure


def test_a_pressure_that_is_not_a_number_trips(lab: Laboratory) -> None:
    lab.regulator.error_kpa = math.nan
    with pytest.raises(InterlockError, match="pressure_a: nan kPa"):
        lab.arm()


def test_a_step_of_the_clock_is_said_once(lab: Laboratory) -> None:
    lab.time.step_s = 5.0
    with pytest.raises(InterlockError, match="clock: 5 s, needed a step of at most 1 s"):
        lab.arm()
    lab.arm()


def test_the_state_report_shows_value_limit_age_and_source_of_each(lab: Laboratory) -> None:
    lab.arm()
    lab.time.pass_time(0.5)
    status = lab.rig.status()
    pressure = next(c for c in status.interlocks if c.name == "pressure_a")
    assert (pressure.value, pressure.limit, pressure.unit) == (40.0, "40 ± 0.5", "kPa")
    assert pressure.source == "regulator (stand-in)"
    assert pressure.age_s(status.read_at) == pytest.approx(0.5)
    assert {c.name for c in status.interlocks} == {
        "pressure_a",
        "pressure_b",
        "offset",
        "slide",
        "camera",
        "trigger",
        "cut_off",
        "latch",
        "cool_down",
        "disk",
        "store",
        "clock",
    }


@pytest.mark.parametrize(("offset_mm", "warned"), [(25.3, False), (25.5, True), (-25.5, True)])
def test_an_offset_beyond_the_sum_of_the_radii_is_warned_of_and_not_refused(
    tmp_path: Path, offset_mm: float, warned: bool
) -> None:
    configuration = load()
    assert [sphere.diameter_m for sphere in configuration.spheres] == [0.0254, 0.0254]
    limits = configuration.limits.model_copy(update={"offset_mm": (-30.0, 30.0)})
    wide = configuration.model_copy(update={"limits": limits})
    wide_lab = Laboratory(tmp_path / "wide", configuration=wide)
    settings = SETTINGS.model_copy(update={"offset_mm": offset_mm})
    armed = wide_lab.rig.arm(settings, "anna")
    said = [text for text in armed.warnings if "cannot meet" in text]
    assert bool(said) is warned
    assert all("25.4 mm" in text and f"{offset_mm:g} mm" in text for text in said)
    wide_lab.close()
