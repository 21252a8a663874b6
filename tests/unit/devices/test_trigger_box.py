"""The trigger box fires at most once, and every doubt about a fire is called a doubt."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any, Protocol

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigctl.devices.roles import FireOutcome, HeartbeatWatch, OutcomeQuery, PowerQuery
from rigctl.devices.serial_port import SerialPort
from rigctl.devices.trigger_box import TriggerBox, TriggerBoxStatus, closed, opened, status
from rigctl.errors import (
    DeviceAnswerError,
    DeviceSilentError,
    FireOutcomeUnknownError,
    SettingsError,
)

MakeDevice = Callable[..., Any]
Build = Callable[[Callable[[bytes], bytes]], tuple[TriggerBox, Any]]


class Wire(Protocol):
    messages: list[bytes]


SILENT = b""


def sealed(text: str) -> bytes:
    """Close a line by hand, byte by byte, as NMEA 0183 does."""
    total = 0
    for character in text:
        total ^= ord(character)
    return f"{text}*{total:02X}\n".encode()


class Box:
    """A well-behaved box whose answer to each kind of question a test may replace."""

    def __init__(self, **replies: bytes) -> None:
        self.replies, self.last, self.armed, self.powered = replies, 0, False, 1

    def __call__(self, message: bytes) -> bytes:
        word, *rest = message.decode().partition("*")[0].split()
        reply = self._act(word, rest)
        return self.replies.get(word.rstrip("?"), reply)

    def _act(self, word: str, rest: list[str]) -> bytes:
        if word == "ARM":
            self.armed = True
            return sealed(f"ARMED {rest[0]}")
        if word == "FIRE":
            self.armed, self.last = False, int(rest[0])
            return sealed(f"FIRED {rest[0]} 123456")
        if word == "SAFE":
            self.armed = False
            return sealed("SAFE")
        if word == "STAT?":
            state = "ARMED" if self.armed else "SAFE"
            return sealed(f"STAT {state} {self.last} {self.last} {self.powered}")
        watching = {"WATCH": f"WATCHING {''.join(rest)}", "BEAT": "BEAT"}
        return sealed(watching.get(word, "RIGTRIG 2 2"))


@pytest.fixture
def build(pty_device: MakeDevice) -> Build:
    def make(answer: Callable[[bytes], bytes]) -> tuple[TriggerBox, Any]:
        device = pty_device(answer)
        port = SerialPort(device.path, part="trigger", baud=115200, answer_timeout_s=0.1)
        return TriggerBox(port, pulse_us=20000, clock=iter(range(100)).__next__), device

    return make


def fires_on_the_wire(device: Wire) -> int:
    return sum(message.startswith(b"FIRE") for message in device.messages)


def test_arm_then_fire_is_confirmed_with_the_boxs_own_time(build: Build) -> None:
    box, device = build(Box())
    box.check()
    box.arm(7, -150.0)
    receipt = box.fire(7)
    assert (receipt.sequence, receipt.device_time_us) == (7, 123456)
    assert receipt.confirmed_at > receipt.sent_at
    assert device.messages[1:] == [sealed("ARM 7 -150 20000"), sealed("FIRE 7")]
    box.close()


@pytest.mark.parametrize(
    "reply",
    [
        SILENT,
        b"FIRED 7",
        b"\xfe\x01\n",
        b"FIRED 7 123456*00\n",
        sealed("FIRED 6 99"),
        sealed("STAT SAFE 7 7 1"),
        sealed("ERR DUPLICATE 7"),
    ],
    ids=["silence", "half", "garbage", "checksum", "earlier number", "other", "duplicate"],
)
def test_without_a_clear_answer_the_outcome_is_unknown_and_fire_went_out_once(
    build: Build, reply: bytes
) -> None:
    box, device = build(Box(FIRE=reply))
    box.arm(7, 0)
    with pytest.raises(FireOutcomeUnknownError, match="not sent again"):
        box.fire(7)
    with pytest.raises(DeviceAnswerError, match="no fire command was sent"):
        box.fire(7)
    assert fires_on_the_wire(device) == 1
    box.close()


def test_a_late_answer_of_an_earlier_shot_is_passed_over_for_the_present_one(build: Build) -> None:
    box, _ = build(Box(FIRE=sealed("FIRED 6 99") + sealed("FIRED 7 123")))
    box.arm(7, 0)
    assert box.fire(7).device_time_us == 123
    box.close()


def test_a_refusal_that_the_boxs_record_confirms_did_not_fire(build: Build) -> None:
    answer = Box(FIRE=sealed("ERR CUT no power"))
    box, device = build(lambda message: refusing(answer, message))
    box.arm(7, 0)
    with pytest.raises(DeviceAnswerError, match="restore the cut-off"):
        box.fire(7)
    assert fires_on_the_wire(device) == 1
    box.close()


def refusing(box: Box, message: bytes) -> bytes:
    return box.replies["FIRE"] if message.startswith(b"FIRE") else box(message)


def test_a_refusal_that_noise_earned_before_the_true_fire_is_a_doubt(build: Build) -> None:
    box, _ = build(Box(FIRE=sealed("ERR CHECKSUM 00") + sealed("FIRED 7 5")))
    box.arm(7, 0)
    with pytest.raises(FireOutcomeUnknownError, match="counts a fire"):
        box.fire(7)
    assert box.outcome(7) is FireOutcome.FIRED
    box.close()


def test_nothing_fires_under_a_number_that_was_not_armed(build: Build) -> None:
    box, device = build(Box())
    box.arm(7, 0)
    with pytest.raises(DeviceAnswerError, match="armed for 7"):
        box.fire(8)
    assert fires_on_the_wire(device) == 0
    box.close()


def test_nothing_fires_after_a_question_failed_since_arming(build: Build) -> None:
    box, device = build(Box(STAT=SILENT))
    box.arm(7, 0)
    with pytest.raises(DeviceSilentError):
        box.status()
    with pytest.raises(DeviceAnswerError, match="arm again"):
        box.fire(7)
    assert fires_on_the_wire(device) == 0
    box.close()


def test_nothing_fires_after_the_box_was_made_safe(build: Build) -> None:
    box, device = build(Box())
    box.arm(7, 0)
    box.make_safe()
    with pytest.raises(DeviceAnswerError):
        box.fire(7)
    assert fires_on_the_wire(device) == 0
    box.close()


def test_a_hang_up_before_the_command_left_did_not_fire(build: Build) -> None:
    box, device = build(Box())
    box.arm(7, 0)
    device.hang_up()
    with pytest.raises(DeviceAnswerError, match=r"no fire command was sent.*hung up"):
        box.fire(7)


def test_a_delay_finer_than_the_boxs_clock_is_refused_and_not_rounded(build: Build) -> None:
    box, device = build(Box())
    with pytest.raises(SettingsError, match="whole microseconds"):
        box.arm(7, 0.5)
    assert device.messages == []
    box.close()


@pytest.mark.parametrize(
    ("record", "outcome"),
    [
        ("STAT SAFE 7 3 1", FireOutcome.FIRED),
        ("STAT ARMED 6 3 1", FireOutcome.NOT_FIRED),
        ("STAT ARMED 0 0 1", FireOutcome.NOT_FIRED),
        ("STAT SAFE 6 3 0", FireOutcome.NOT_FIRED),
        ("STAT SAFE 0 0 1", FireOutcome.UNKNOWN),
        ("STAT SAFE 8 3 1", FireOutcome.UNKNOWN),
        ("STAT SAFE x 3 1", FireOutcome.UNKNOWN),
    ],
)
def test_the_boxs_record_settles_an_open_fire(
    build: Build, record: str, outcome: FireOutcome
) -> None:
    box, device = build(Box(STAT=sealed(record)))
    assert isinstance(box, OutcomeQuery)
    assert box.outcome(7) is outcome
    assert fires_on_the_wire(device) == 0
    box.close()


def test_a_silent_box_leaves_an_open_fire_unknown(build: Build) -> None:
    box, _ = build(lambda message: SILENT)
    assert box.outcome(7) is FireOutcome.UNKNOWN
    box.close()


@pytest.mark.parametrize("powered", [True, False])
def test_the_box_says_whether_the_cut_off_has_taken_its_power(build: Build, powered: bool) -> None:
    box, _ = build(Box(STAT=sealed(f"STAT SAFE 0 0 {int(powered)}")))
    assert isinstance(box, PowerQuery)
    assert box.powered() is powered
    box.close()


def test_another_device_on_the_port_is_not_taken_for_a_trigger_box(build: Build) -> None:
    box, _ = build(Box(ID=sealed("RIGTRIG 3 2")))
    with pytest.raises(DeviceAnswerError, match="RIGTRIG 3 2"):
        box.check()
    box.close()


def test_a_box_watches_over_the_host_and_is_told_that_it_lives(build: Build) -> None:
    box, device = build(Box())
    assert isinstance(box, HeartbeatWatch)
    assert box.watch(0.6)
    assert box.beat()
    box.end_watch()
    told = [sealed("ID?"), sealed("WATCH 600"), sealed("BEAT"), sealed("WATCH 0")]
    assert device.messages == told
    box.close()


def test_a_box_of_before_the_heartbeat_is_recognised_and_asked_for_none(build: Build) -> None:
    box, device = build(Box(ID=sealed("RIGTRIG 1 2")))
    box.check()
    assert not box.watch(0.6)
    assert device.messages == [sealed("ID?")] * 2
    box.close()


@pytest.mark.parametrize("refusal", ["ERR LATE 600", "ERR NOWATCH none is set"])
def test_nothing_fires_after_a_box_that_watches_no_more(build: Build, refusal: str) -> None:
    box, device = build(Box(BEAT=sealed(refusal)))
    box.arm(7, 0)
    assert not box.beat()
    with pytest.raises(DeviceAnswerError, match="arm again"):
        box.fire(7)
    assert fires_on_the_wire(device) == 0
    box.close()


def test_an_answer_to_a_heartbeat_that_comes_late_is_passed_over(build: Build) -> None:
    box, device = build(Box(BEAT=SILENT))
    with pytest.raises(DeviceSilentError):
        box.beat()
    box.arm(7, 0)
    device.answer = Box(FIRE=sealed("BEAT") + sealed("FIRED 7 5"))
    assert box.fire(7).device_time_us == 5
    box.close()


@given(st.text(st.characters(codec="ascii", exclude_characters="*\r\n"), min_size=1))
def test_what_was_closed_opens_again(text: str) -> None:
    assert opened(closed(text), "box") == text
    assert closed(text).encode() + b"\n" == sealed(text)


@given(st.text(st.characters(codec="ascii", exclude_characters="*\r\n"), min_size=1), st.data())
def test_one_changed_character_never_opens(text: str, data: st.DataObject) -> None:
    line = closed(text)
    place = data.draw(st.integers(0, len(line) - 1))
    other = data.draw(st.characters(codec="ascii").filter(lambda c: c != line[place]))
    changed = line[:place] + other + line[place + 1 :]
    with pytest.raises(DeviceAnswerError):
        opened(changed, "box")


@given(st.text())
def test_no_text_makes_the_parsers_raise_anything_but_their_error(text: str) -> None:
    for parse in (opened, status):
        with suppress(DeviceAnswerError):
            parse(text, "box")


@given(st.booleans(), st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1), st.booleans())
def test_a_status_comes_back_as_it_was_written(
    armed: bool, last: int, fires: int, powered: bool
) -> None:
    words = f"STAT {'ARMED' if armed else 'SAFE'} {last} {fires} {int(powered)}"
    assert status(words, "box") == TriggerBoxStatus(armed, last, fires, powered)
