"""The recorder's client against the table of the wire-protocol reference."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigctl.devices.ektapro import (
    LONGEST_LINE,
    EktaproLink,
    RecorderMode,
    RecorderStatus,
    RecordingFormat,
    TapePlace,
)
from rigctl.devices.serial_port import SerialPort
from rigctl.errors import DeviceAnswerError, DeviceSilentError

MakeDevice = Callable[..., Any]
Build = Callable[[str], tuple[EktaproLink, Any]]


@pytest.fixture
def build(pty_device: MakeDevice) -> Build:
    def make(answer: str) -> tuple[EktaproLink, Any]:
        device = pty_device(lambda message: answer.encode())
        port = SerialPort(device.path, part="recorder", baud=115200, answer_timeout_s=0.1)
        return EktaproLink(port), device

    return make


TABLE: list[tuple[Callable[[EktaproLink], object], str, str, object]] = [
    (lambda link: link.check(), "ID?", "OK EKTAPRO-SIM 1", None),
    (lambda link: link.set_rate(1000, 6), "RATE 1000 6", "OK 6000 32", RecordingFormat(6000, 32)),
    (lambda link: link.live(), "LIVE", "OK LIVE", None),
    (lambda link: link.record(), "RECORD", "OK RECORD 4", 4),
    (lambda link: link.stop(), "STOP", "OK STOP", None),
    (
        lambda link: link.status(),
        "STATUS?",
        "OK RECORD 4 812 29.188 MID",
        RecorderStatus(RecorderMode.RECORD, 4, 812, 29.188, TapePlace.MIDDLE),
    ),
    (lambda link: link.mark(), "MARK", "OK MARK 812", 812),
    (lambda link: link.marks(), "MARKS?", "OK 3 812", (3, 812)),
    (lambda link: link.marks(), "MARKS?", "OK", ()),
    (lambda link: link.select_session(2), "SESSION 2", "OK SESSION 2 900", 900),
    (lambda link: link.sessions(), "SESSIONS?", "OK 1:900 2:30", {1: 900, 2: 30}),
    (lambda link: link.sessions(), "SESSIONS?", "OK", {}),
    (lambda link: link.replay(), "REPLAY", "OK REPLAY", None),
    (lambda link: link.play(), "PLAY", "OK PLAY", None),
    (lambda link: link.step(-1), "STEP -1", "OK PICTURE 7", 7),
    (lambda link: link.step(1), "STEP +1", "OK PICTURE 9", 9),
    (lambda link: link.jog(-5), "JOG -5", "OK JOG", None),
    (lambda link: link.search(800), "SEARCH 800", "OK PICTURE 800", 800),
    (lambda link: link.picture(), "PICTURE?", "OK PICTURE 3", 3),
    (lambda link: link.transfer(8, 60, "x1"), "TRANSFER 8 60 x1", "OK TRANSFER 60 x1", None),
    (lambda link: link.erase(), "ERASE", "OK BOT", None),
    (lambda link: link.check(), "ID?", "OK EKTAPRO-SIM 2", None),
    (lambda link: link.set_gamma(0.4), "GAMMA 0.40", "OK GAMMA 0.40", None),
    (lambda link: link.gamma(), "GAMMA?", "OK GAMMA 0.40", 0.4),
]


@pytest.mark.parametrize(
    ("call", "question", "answer", "result"), TABLE, ids=[f"{row[1]}={row[2]}" for row in TABLE]
)
def test_each_command_is_sent_and_its_answer_understood(
    build: Build, call: Callable[[EktaproLink], object], question: str, answer: str, result: object
) -> None:
    link, device = build(answer + "\n")
    assert call(link) == result
    assert device.messages == [question.encode() + b"\n"]
    link.close()


@pytest.mark.parametrize(("call", "question"), [row[:2] for row in TABLE])
def test_each_command_may_be_refused(
    build: Build, call: Callable[[EktaproLink], object], question: str
) -> None:
    link, _ = build("ERR STATE not now\n")
    with pytest.raises(DeviceAnswerError, match="STATE not now") as caught:
        call(link)
    assert question in str(caught.value)
    link.close()


def test_a_tape_of_two_thousand_sessions_is_listed(pty_device: MakeDevice) -> None:
    told = "OK " + " ".join(f"{session}:15" for session in range(1, 2001)) + "\n"
    port = SerialPort(
        pty_device(lambda message: told.encode()).path,
        part="recorder",
        baud=115200,
        answer_timeout_s=1.0,
        longest_line=LONGEST_LINE,
    )
    link = EktaproLink(port)
    assert link.sessions() == dict.fromkeys(range(1, 2001), 15)
    link.close()


def test_an_answer_to_an_earlier_question_is_passed_over(build: Build) -> None:
    link, _ = build("OK RECORD 4 812 29.2 MID\nOK MARK 813\n")
    assert link.mark() == 813
    link.close()


def test_silence_is_named(build: Build) -> None:
    link, _ = build("")
    with pytest.raises(DeviceSilentError, match=r"MARKS\?"):
        link.marks()
    link.close()


def test_a_transfer_of_something_else_is_not_taken(build: Build) -> None:
    link, _ = build("OK TRANSFER 59 x1\n")
    with pytest.raises(DeviceAnswerError, match="59 pictures as x1, allowed 60 pictures as x1"):
        link.transfer(8, 60, "x1")
    link.close()


class Parrot:
    """A port that answers every question with one line."""

    part = "recorder"

    def __init__(self, line: str) -> None:
        self.line = line

    def ask(self, question: str, *, late: Callable[[str], bool]) -> str:
        if late(self.line):
            raise DeviceSilentError("only late answers", part=self.part)
        return self.line


@given(
    st.text(st.characters(codec="ascii")) | st.text("OK ERRMIDBOT0123456789.:+-").map("OK ".__add__)
)
def test_no_answer_makes_the_client_raise_anything_but_its_error(text: str) -> None:
    link = EktaproLink(Parrot(text))  # type: ignore[arg-type]
    for call in (link.status, link.marks, link.sessions, link.mark, lambda: link.set_rate(30, 1)):
        with suppress(DeviceAnswerError, DeviceSilentError):
            call()
