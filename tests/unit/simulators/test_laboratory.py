from __future__ import annotations

import json
import os
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import reduce
from operator import xor
from pathlib import Path

import numpy as np
import pytest
import serial
import tifffile
import usb.core
from numpy.typing import NDArray

from simulators.laboratory import Laboratory, open_laboratory
from simulators.options import Options, read_options
from simulators.world import Launch

POWER_ON, POWER_OFF = b"\xa0\x01\x01\xa2", b"\xa0\x01\x00\xa1"


class RecordingWorld:
    """Stands in for the world: remembers its launches and shows the time in each picture."""

    def __init__(self) -> None:
        self.launches: list[Launch] = []

    @property
    def fires(self) -> int:
        return len(self.launches)

    def fire(self, launch: Launch) -> int:
        self.launches.append(launch)
        return len(self.launches)

    def picture(self, time_s: float, rows: int = 192) -> NDArray[np.uint8]:
        return np.full((rows, 240), round(time_s * 1000) % 251, np.uint8)


class Host:
    """The host's side of every port, kept open."""

    def __init__(self, laboratory: Laboratory) -> None:
        self._laboratory = laboratory
        self._ports: dict[str, serial.Serial] = {}
        self.relay = usb.core.find(idVendor=0x16C0, backend=laboratory.usb_backend())
        self.relay.detach_kernel_driver(0)

    def port(self, role: str) -> serial.Serial:
        if role not in self._ports:
            path = self._laboratory.port(role)
            self._ports[role] = serial.Serial(path, 115200, timeout=60.0, exclusive=True)
        return self._ports[role]

    def ask(self, role: str, line: str, ending: str = "\n") -> str:
        self.port(role).write((line + ending).encode())
        return self.port(role).read_until(ending.encode()).decode().rstrip()

    def trigger(self, content: str) -> str:
        return self.ask("trigger", f"{content}*{reduce(xor, content.encode()):02X}").split("*")[0]

    def power(self, on: bool) -> None:
        self.port("cut-off").write(POWER_ON if on else POWER_OFF)
        self.until(lambda: self.trigger("STAT?").endswith(str(int(on))))

    def contact(self, closed: bool) -> None:
        report = bytes([0xFF if closed else 0xFD, 1, 0, 0, 0, 0, 0, 0])
        self.relay.ctrl_transfer(0x21, 0x09, 0x0300, 0, report, 500)

    def until(self, condition: Callable[[], bool], within_s: float = 60.0) -> None:
        deadline = time.monotonic() + within_s
        while not condition():
            assert time.monotonic() < deadline
            time.sleep(0.001)

    def close(self) -> None:
        for port in self._ports.values():
            port.close()


@pytest.fixture
def world() -> RecordingWorld:
    return RecordingWorld()


@pytest.fixture
def laboratory(tmp_path: Path, world: RecordingWorld) -> Iterator[Laboratory]:
    options = Options(pressure_lag_s=1e-3, slide_speed_mm_per_s=1000.0, run_up_s=0.01)
    laboratory = Laboratory(tmp_path, options, world, time.monotonic)  # type: ignore[arg-type]
    yield laboratory
    laboratory.close()


@pytest.fixture
def host(laboratory: Laboratory) -> Iterator[Host]:
    host = Host(laboratory)
    yield host
    host.close()


def test_a_laboratory_that_was_switched_on_cannot_fire(host: Host, laboratory: Laboratory) -> None:
    assert host.trigger("STAT?") == "STAT SAFE 0 0 0"
    assert host.trigger("ARM 1 0 20000") == "ERR CUT no power"
    assert laboratory.fires == 0


def test_a_fire_launches_with_the_pressures_offset_and_delay_of_that_moment(
    host: Host, world: RecordingWorld, laboratory: Laboratory
) -> None:
    host.power(True)
    host.ask("regulator", "AS40", "\r")
    host.ask("regulator", "BS60", "\r")
    host.until(lambda: host.ask("regulator", "A", "\r") == "A +040.00 +040.00")
    host.until(lambda: host.ask("regulator", "B", "\r") == "B +060.00 +060.00")
    host.ask("slide", "/1 1 home")
    host.until(lambda: "IDLE" in host.ask("slide", "/1 1"))
    host.ask("slide", "/1 1 move abs 12095")
    host.until(lambda: "IDLE" in host.ask("slide", "/1 1"))
    host.trigger("ARM 1 -3000 20000")
    before = time.monotonic()
    assert host.trigger("FIRE 1").startswith("FIRED 1 ")
    after = time.monotonic()
    (launch,) = world.launches
    assert launch.pressure_a_kpa == pytest.approx(40.0, abs=0.01)
    assert launch.pressure_b_kpa == pytest.approx(60.0, abs=0.01)
    assert launch.offset_m == pytest.approx(6.0e-3, abs=1e-6)
    assert launch.fire_a_s - launch.fire_b_s == pytest.approx(3e-3)
    assert before <= launch.fire_b_s <= after
    assert laboratory.fires == 1


def test_the_cut_off_disarms_and_bars_the_trigger(host: Host, laboratory: Laboratory) -> None:
    host.power(True)
    host.trigger("ARM 1 0 20000")
    host.power(False)
    assert host.trigger("FIRE 1") == "ERR CUT no power"
    host.power(True)
    assert host.trigger("FIRE 1") == "ERR NOTARMED no number"
    assert laboratory.fires == 0


def test_the_relays_first_channel_is_the_recorders_remote_trigger(host: Host) -> None:
    host.contact(True)
    host.until(lambda: host.ask("recorder", "STATUS?").startswith("OK RECORD 1 "))
    host.contact(False)
    assert host.ask("recorder", "STATUS?").startswith("OK STOP 1 ")


def test_a_serial_line_can_be_the_remote_trigger_instead(
    host: Host, laboratory: Laboratory
) -> None:
    url = laboratory.port("remote-trigger")
    with serial.serial_for_url(url, do_not_open=True) as port:
        port.rts = True
        host.until(lambda: host.ask("recorder", "STATUS?").startswith("OK RECORD "))
    assert host.ask("recorder", "STATUS?").startswith("OK STOP ")


def test_transferred_pictures_show_the_instants_after_the_recording_was_told(
    host: Host, laboratory: Laboratory
) -> None:
    told_at = time.monotonic()
    host.contact(True)
    host.until(lambda: int(host.ask("recorder", "STATUS?").split()[3]) >= 20)
    host.contact(False)
    ended_at = time.monotonic()
    assert host.ask("recorder", "TRANSFER 0 20 shot") == "OK TRANSFER 20 shot"
    capture = Path(laboratory.port("capture"))
    host.until((capture / "shot.json").exists)
    levels = tifffile.imread(capture / "shot.tiff")[:, 0, 0]
    seen = {round(told_at * 1000) + n for n in range(round((ended_at - told_at) * 1000) + 2)}
    assert set(levels.tolist()) <= {milliseconds % 251 for milliseconds in seen}
    assert len(set(levels.tolist())) == 20


def test_a_stuck_trigger_box_fires_nothing(host: Host, laboratory: Laboratory) -> None:
    host.power(True)
    laboratory.fault("trigger", "stuck")
    host.trigger("ARM 1 0 100")
    assert host.trigger("FIRE 1").startswith("FIRED 1 ")
    assert laboratory.fires == 0
    laboratory.clear_faults()
    host.trigger("ARM 2 0 20000")
    host.trigger("FIRE 2")
    assert laboratory.fires == 1


def test_a_fire_whose_answer_is_lost_has_fired(host: Host, laboratory: Laboratory) -> None:
    host.power(True)
    host.trigger("ARM 1 0 20000")
    laboratory.fault("trigger", "no-answer", times=1, command="FIRE")
    host.port("trigger").timeout = 0.1
    assert host.trigger("FIRE 1") == ""
    host.port("trigger").timeout = 60.0
    assert host.trigger("STAT?") == "STAT SAFE 1 1 1"
    assert laboratory.fires == 1


def test_a_recorder_that_never_starts_says_so(host: Host, laboratory: Laboratory) -> None:
    laboratory.fault("recorder", "never-starts")
    host.contact(True)
    for _ in range(20):
        assert host.ask("recorder", "STATUS?").startswith("OK STARTING 1 0 ")
    laboratory.clear_faults()
    host.until(lambda: host.ask("recorder", "STATUS?").startswith("OK RECORD 1 "))


def test_frame_faults_reach_the_capture_folder(host: Host, laboratory: Laboratory) -> None:
    laboratory.fault("recorder", "missing-frames", times=1, frames=2)
    host.contact(True)
    host.until(lambda: int(host.ask("recorder", "STATUS?").split()[3]) >= 20)
    host.contact(False)
    host.ask("recorder", "TRANSFER 0 20 shot")
    announced = Path(laboratory.port("capture")) / "shot.json"
    host.until(announced.exists)
    assert json.loads(announced.read_text())["lost"] == [10, 11]


def test_an_unplugged_device_is_gone_until_it_is_plugged_in(laboratory: Laboratory) -> None:
    for role in ("trigger", "regulator", "slide", "cut-off", "recorder"):
        laboratory.fault(role, "unplug")
        assert not os.path.lexists(laboratory.port(role))
        laboratory.fault(role, "plug-in")
        assert os.path.lexists(laboratory.port(role))


@pytest.mark.parametrize(
    ("device", "kind", "named"),
    [
        ("laser", "stuck", "laser"),
        ("trigger", "explode", "explode"),
        ("trigger", "never-starts", "never-starts"),
        ("relay", "garbage", "garbage"),
        ("slide", "frozen", "frozen"),
    ],
)
def test_a_fault_that_cannot_be_is_refused(
    laboratory: Laboratory, device: str, kind: str, named: str
) -> None:
    with pytest.raises(ValueError, match=named):
        laboratory.fault(device, kind)


def test_an_unknown_role_is_refused_with_those_there_are(laboratory: Laboratory) -> None:
    with pytest.raises(ValueError, match=r"laser.*trigger, solenoids, regulator"):
        laboratory.port("laser")


def test_closing_leaves_no_thread_no_descriptor_and_no_port(
    tmp_path: Path, world: RecordingWorld
) -> None:
    threads = threading.active_count()
    descriptors = len(os.listdir("/proc/self/fd"))
    laboratory = Laboratory(
        tmp_path,
        Options(),
        world,  # type: ignore[arg-type]
        time.monotonic,
    )
    laboratory.close()
    laboratory.close()
    assert threading.active_count() == threads
    assert len(os.listdir("/proc/self/fd")) == descriptors
    assert [path.name for path in tmp_path.iterdir()] == ["capture"]


@pytest.mark.parametrize(
    ("table", "named"),
    [
        ({"sede": 1}, "simulation.sede is no option"),
        ({"seed": -1}, "simulation.seed is -1"),
        ({"seed": 1.0}, "simulation.seed is 1.0"),
        ({"seed": True}, "simulation.seed is True"),
        ({"seed": "1"}, "simulation.seed is '1'"),
        ({"run_up_s": float("nan")}, "simulation.run_up_s is nan"),
        ({"pressure_lag_s": 0.0}, "simulation.pressure_lag_s is 0.0"),
    ],
)
def test_an_option_that_cannot_be_is_named(
    tmp_path: Path, table: dict[str, object], named: str
) -> None:
    with pytest.raises(ValueError, match=named):
        open_laboratory(tmp_path, table)
    assert list(tmp_path.iterdir()) == []


def test_options_have_defaults_and_whole_numbers_serve_as_numbers() -> None:
    read = read_options({})
    drag = read.world.environment.drag_coefficient
    assert drag == pytest.approx(0.40, abs=0.08)
    air = replace(Options().world.environment, drag_coefficient=drag)
    assert read == replace(Options(), world=replace(Options().world, environment=air))
    assert read_options({"seed": 7, "run_up_s": 1}).run_up_s == 1


def test_the_factory_builds_a_laboratory_whose_world_writes_the_truth(tmp_path: Path) -> None:
    laboratory = open_laboratory(tmp_path, {"seed": 3, "pressure_lag_s": 1e-3})
    host = Host(laboratory)
    host.power(True)
    for unit in "AB":
        host.ask("regulator", f"{unit}S40", "\r")
    host.until(lambda: host.ask("regulator", "B", "\r") == "B +040.00 +040.00")
    host.trigger("ARM 1 0 20000")
    host.trigger("FIRE 1")
    host.close()
    laboratory.close()
    assert laboratory.fires == 1
    (line,) = (laboratory.truth_folder / "fires.jsonl").read_text().splitlines()
    assert json.loads(line)["shot"] == 1
