"""Runs in the guest: the project's drivers on USB through the kernel's own stack."""

from __future__ import annotations

import json
import time
from pathlib import Path

from rigctl.devices.hid_relay import HidRelay as RelayDriver
from rigctl.devices.serial_port import SerialPort
from rigctl.devices.trigger_box import TriggerBox as BoxDriver
from rigctl.errors import RigError
from simulators.wire.hid_relay import HidRelay
from simulators.wire.trigger_box import Pulses, TriggerBox
from tests.kernel.usb_models import RelayBoard, SerialAdapter
from tests.kernel.usbip import CONTROLLER, Plug, await_node

ANSWER_S = 5.0
PLUGGED: list[Plug] = []


def tell(story: str, **found: object) -> None:
    print("STORY", json.dumps({"story": story, **found}), flush=True)  # noqa: T201


def name_of(error: RigError) -> str:
    return type(error).__name__


def relay() -> None:
    switched: list[tuple[int, bool]] = []
    plug = Plug(0, RelayBoard(HidRelay(2, lambda *change: switched.append(change))))
    PLUGGED.append(plug)
    await_node(Path("/sys/bus/usb/devices/1-1"))
    for _ in range(100):  # the kernel's HID driver takes the board a moment after it is there
        if list(Path("/sys/bus/hid/devices").iterdir()):
            break
        time.sleep(0.05)
    held = [path.name for path in Path("/sys/bus/hid/devices").iterdir()]
    driver = RelayDriver(channel=1, timeout_s=ANSWER_S)
    driver.close_contact()
    closed = driver.is_closed()
    driver.open_contact()
    tell("relay", held=held, closed=closed, open=not driver.is_closed(), switched=switched)
    plug.pull()
    try:
        driver.close_contact()
    except RigError as error:
        tell("relay pulled", error=name_of(error))
    driver.close()


def port() -> None:
    pulses: list[Pulses] = []
    box = TriggerBox(time.monotonic, pulses.append)
    box.power(True)
    adapter = SerialAdapter(box.answer)
    plug = Plug(1, adapter)
    PLUGGED.append(plug)
    node = Path("/dev/ttyACM0")
    await_node(node)
    serial = SerialPort(str(node), part="trigger", baud=115200, answer_timeout_s=ANSWER_S)
    opened = list(adapter.lines)
    driver = BoxDriver(serial, pulse_us=100)
    driver.check()
    driver.arm(1, delay_us=500)
    receipt = driver.fire(1)
    serial.set_rts(True)
    raised = adapter.lines[-1][1:]
    serial.set_rts(False)
    driver.arm(2, delay_us=0)
    plug.pull()
    try:
        driver.fire(2)
    except RigError as error:
        tell("port pulled", error=name_of(error), fires=len(pulses))
    before = len(adapter.lines)
    driver.close()
    tell(
        "port",
        sequence=receipt.sequence,
        opened=[line[1:] for line in opened],
        opened_s=opened[-1][0] - opened[0][0] if opened else None,
        raised=raised,
        closed=[line[1:] for line in adapter.lines[before:]],
    )


if not CONTROLLER.exists():
    raise SystemExit("no virtual USB controller in this kernel")
try:
    relay()
    port()
finally:
    # A process that ends with a device plugged in hangs in the kernel.
    for each in PLUGGED:
        each.pull()
