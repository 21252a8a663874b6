"""From configuration to devices: each section opens its driver, and a failure leaves none open."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import serial

from rigctl.cameras.build import build_capture
from rigctl.cameras.live import LiveCapture
from rigctl.cameras.tape import TapeCapture
from rigctl.config import Configuration, V4l2Camera, V4l2Source, default_path, load
from rigctl.config import SerialLine as LineSection
from rigctl.config import SolenoidPair as SolenoidSection
from rigctl.devices.alicat import AlicatPair
from rigctl.devices.build import build_actuators, build_slide, build_trigger, resolved
from rigctl.devices.hid_relay import HidRelay
from rigctl.devices.lcus import Holders, LcusRelay
from rigctl.devices.serial_line import SerialLine
from rigctl.devices.trigger_box import TriggerBox
from rigctl.errors import ConfigurationError, DeviceAbsentError, DeviceError
from simulators.laboratory import open_laboratory

MakeDevice = Callable[..., Any]
Laboratory = Any


class Bench:
    """Ports for every role of the simulated configuration, with nothing much behind them."""

    def __init__(self, folder: Path, pty_device: MakeDevice) -> None:
        self.folder = folder
        self.devices = {role: pty_device() for role in ("trigger", "regulator", "recorder")}
        self.devices["cut-off"] = pty_device(length=4)
        self.devices["slide"] = pty_device(lambda message: b"@01 0 00 OK IDLE -- 80\r\n")

    def port(self, role: str) -> str:
        return str(self.folder) if role == "capture" else str(self.devices[role].path)

    def turn_tubes(self, a_deg: float, b_deg: float) -> None:
        raise NotImplementedError

    def usb_backend(self) -> object:
        return object()


@pytest.fixture
def bench(tmp_path: Path, pty_device: MakeDevice) -> Bench:
    return Bench(tmp_path, pty_device)


@pytest.fixture
def configuration() -> Configuration:
    return load(default_path())


def changed(configuration: Configuration, **sections: object) -> Configuration:
    return configuration.model_copy(update=sections)


def is_free(path: str) -> bool:
    try:
        serial.Serial(path, exclusive=True).close()
    except serial.SerialException:
        return False
    return True


def test_the_release_apparatus_has_a_solenoid_pair_and_neither_regulator_nor_slide(
    configuration: Configuration, bench: Laboratory
) -> None:
    section = SolenoidSection(
        driver="solenoid-pair", port="sim:trigger", channel_a=1, channel_b=2,
        energised="hold", power_cut="fires",
    )  # fmt: skip
    release = changed(configuration, trigger=section, regulator=None, slide=None)
    found = build_actuators(release, bench)
    assert isinstance(found.trigger, Holders)
    assert (found.regulator, found.slide) == (None, None)
    found.trigger.close()
    found.cut_off.close()


def test_no_port_stays_open_when_a_later_device_is_absent(
    configuration: Configuration, bench: Laboratory
) -> None:
    bench.devices["regulator"].path = "/dev/no-such-regulator"
    with pytest.raises(DeviceAbsentError, match="regulator"):
        build_actuators(configuration, bench)
    assert is_free(bench.port("trigger"))
    assert is_free(bench.port("cut-off"))


def test_nothing_is_switched_or_asked_of_an_actuator_by_opening_it(
    configuration: Configuration, bench: Laboratory
) -> None:
    found = build_actuators(changed(configuration, slide=None), bench)
    assert isinstance(found.trigger, TriggerBox)
    assert isinstance(found.regulator, AlicatPair)
    assert isinstance(found.cut_off, LcusRelay)
    assert all(bench.devices[role].messages == [] for role in ("trigger", "cut-off", "regulator"))
    for device in (found.trigger, found.regulator, found.cut_off):
        device.close()


def test_the_tape_camera_has_its_contact_recorder_and_folder(
    configuration: Configuration, bench: Laboratory
) -> None:
    capture = build_capture(configuration.camera, bench)
    assert isinstance(capture, TapeCapture)
    assert isinstance(capture._contact, HidRelay)
    assert str(bench.folder) in capture.name
    capture.close()


def test_the_contact_may_be_a_serial_line_and_the_pictures_may_come_from_playback(
    configuration: Configuration, bench: Laboratory
) -> None:
    camera = configuration.camera.model_copy(
        update={
            "remote_trigger": LineSection(driver="serial-line", port="sim:regulator"),
            "source": V4l2Source(driver="v4l2", device="/dev/video9"),
        }
    )
    capture = build_capture(camera, bench)
    assert isinstance(capture, TapeCapture)
    assert isinstance(capture._contact, SerialLine)
    assert "playback through video device /dev/video9" in capture.name
    capture.close()


def test_a_streaming_camera_is_opened_only_when_it_is_used() -> None:
    section = V4l2Camera(
        kind="v4l2", device="/dev/no-such-camera", frame_rate_hz=60.0, rows=192, columns=240,
        start_timeout_s=1.0, collect_timeout_s=1.0, frames_before_mark=0, frames_after_mark=60,
    )  # fmt: skip
    capture = build_capture(section, None)
    assert isinstance(capture, LiveCapture)
    with pytest.raises(DeviceAbsentError, match="no-such-camera"):
        capture.check()
    capture.close()


def test_a_simulated_port_without_a_laboratory_is_a_matter_of_the_configuration() -> None:
    assert resolved("/dev/ttyUSB0", None) == "/dev/ttyUSB0"
    with pytest.raises(ConfigurationError, match=r"sim:trigger.*\[simulation\]"):
        resolved("sim:trigger", None)


def test_a_simulated_port_that_the_laboratory_has_not_is_named(tmp_path: Path) -> None:
    laboratory = open_laboratory(tmp_path, {})
    with pytest.raises(ConfigurationError, match=r"^sim:valve: .*'valve'.*trigger.*; correct"):
        resolved("sim:valve", laboratory)
    laboratory.close()


@pytest.fixture
def laboratory(tmp_path: Path) -> Iterator[Laboratory]:
    opened = open_laboratory(tmp_path, {})
    yield opened
    opened.close()


def test_a_slide_whose_port_is_another_devices_says_so_and_names_the_port(
    configuration: Configuration, laboratory: Laboratory
) -> None:
    assert configuration.slide is not None
    slide = configuration.slide.model_copy(update={"port": "sim:trigger"})
    path = laboratory.port("trigger")
    with pytest.raises(DeviceError, match=rf"^slide \(zaber\): .*another device may be on {path}"):
        build_slide(slide, laboratory)


@pytest.mark.parametrize("role", ["slide", "regulator", "solenoids", "recorder"])
def test_a_trigger_whose_port_is_another_devices_says_so_and_names_the_port(
    configuration: Configuration, laboratory: Laboratory, role: str
) -> None:
    trigger = configuration.trigger.model_copy(update={"port": f"sim:{role}"})
    wired = configuration.model_copy(update={"trigger": trigger})
    path = laboratory.port(role)
    box = build_trigger(wired.trigger, laboratory)
    with pytest.raises(
        DeviceError, match=rf"^trigger \(trigger-box\): .*another device may be on {path}"
    ):
        box.make_safe()
    box.close()
