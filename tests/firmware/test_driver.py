"""The project's own driver and the real firmware, joined by a pseudo-terminal."""

from __future__ import annotations

import pytest

from rigctl.devices.roles import FireOutcome
from rigctl.devices.serial_port import SerialPort
from rigctl.devices.trigger_box import TriggerBox
from rigctl.errors import DeviceError
from simulators.chip import CLOCK_HZ
from tests.firmware.conftest import Box

ANSWER_S = 5.0
"""Far beyond what a line takes: a busy machine may halt the chip's process for a while."""


def driver_of(box: Box) -> TriggerBox:
    port = SerialPort(
        box.chip.join_terminal(), part="trigger", baud=115200, answer_timeout_s=ANSWER_S
    )
    return TriggerBox(port, pulse_us=20_000)


def test_the_driver_arms_and_fires_the_firmware_once(box: Box) -> None:
    driver = driver_of(box)
    driver.check()
    assert driver.status().powered
    driver.arm(5, delay_us=1500)
    receipt = driver.fire(5)
    assert receipt.sequence == 5
    assert driver.outcome(5) is FireOutcome.FIRED
    assert driver.outcome(6) is FireOutcome.NOT_FIRED
    driver.make_safe()
    with pytest.raises(DeviceError, match="armed"):
        driver.fire(5)
    driver.close()
    box.chip.run(0.5)
    edges = dict(box.outputs())
    assert len(box.outputs()) == 4
    assert (edges["B"] - edges["A"]) / CLOCK_HZ == pytest.approx(1.5e-3, abs=4e-6)


def test_the_firmware_makes_itself_safe_when_the_host_is_gone(box: Box) -> None:
    driver = driver_of(box)
    assert driver.watch(0.6)
    driver.arm(1, delay_us=0)
    driver.close()
    box.chip.run(0.7)
    assert [edge.rises for edge in box.chip.edges if edge.pin == "W"] == [True, False]
    assert box.outputs() == []
    assert box.ask("FIRE 1") == "ERR LATE 600"
