"""The firmware answers as the protocol's page says, and as the simulated box does."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from simulators.chip import SimulatedChip
from simulators.wire.trigger_box import TriggerBox
from tests.firmware.conftest import BYTE_S, LINE_S, Box, framed


@pytest.mark.parametrize(
    ("asked", "answered"),
    [
        (["ID?"], "RIGTRIG 2 2"),
        (["STAT?"], "STAT SAFE 0 0 1"),
        (["ARM 1 -100000 100"], "ARMED 1"),
        (["ARM 4294967295 100000 100000", "FIRE 4294967295", "STAT?"], "STAT SAFE 4294967295 1 1"),
        (["ARM 1 0 20000", "SAFE", "FIRE 1"], "ERR NOTARMED no number"),
        (["ARM 7 0 20000", "FIRE 8"], "ERR SEQUENCE 7 is armed"),
        (["ARM 7 0 20000", "FIRE 7", "FIRE 7"], "ERR DUPLICATE 7"),
        (["ARM 7 0 20000", "FIRE 7", "ARM 6 0 20000"], "ERR SEQUENCE above 7"),
        (["ARM 7 90000 20000", "FIRE 7", "ARM 8 0 20000"], "ERR BUSY pulses under way"),
        (["ARM 4294967296 0 20000"], "ERR RANGE sequence 1 to 4294967295"),
        (["ARM 9999999999 0 20000"], "ERR RANGE sequence 1 to 4294967295"),
        (["ARM 1 -100001 20000"], "ERR RANGE delay within 100000 us"),
        (["ARM 1 0 99"], "ERR RANGE width 100 to 100000 us"),
        (["WATCH 99"], "ERR RANGE period 0 or 100 to 10000 ms"),
        (["BEAT"], "ERR NOWATCH none is set"),
        (["WATCH 600", "BEAT"], "BEAT"),
        (["WATCH 600", "WATCH 0", "BEAT"], "ERR NOWATCH none is set"),
        (["X" * 37], "ERR SYNTAX unknown command"),
        (["X" * 38], "ERR SYNTAX line too long"),
        (["X" * 300], "ERR SYNTAX line too long"),
    ],
)
def test_the_firmware_answers_as_the_protocol_page_says(
    box: Box, asked: list[str], answered: str
) -> None:
    assert [box.ask(each, LINE_S + BYTE_S * len(each)) for each in asked][-1] == answered


NUMBERS = st.sampled_from(["0", "1", "2", "3", "007", "4294967295", "4294967296", "-1", "", "1.5"])
WIDTHS = st.sampled_from(["99", "100", "2000", "100001", "-100", ""])
COMMANDS = st.one_of(
    st.just("ID?"),
    st.just("STAT?"),
    st.just("SAFE"),
    st.just("BEAT"),
    st.builds("ARM {} {} {}".format, NUMBERS, st.sampled_from(["0", "-500", "100001"]), WIDTHS),
    st.builds("ARM {} 0 1000".format, st.integers(1, 4)),
    st.builds("FIRE {}".format, NUMBERS),
    st.builds("FIRE {}".format, st.integers(1, 4)),
    st.builds("WATCH {}".format, st.sampled_from(["0", "99", "100", "600", "10001", "x", ""])),
    st.text(st.characters(min_codepoint=32, max_codepoint=126, exclude_characters="*"), max_size=9),
    st.sampled_from([0.05, 0.7, 5.1]),
    st.booleans(),
)
"""A line, a time to let pass in seconds, or the power given or taken."""


class _ModelClock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


@settings(max_examples=12, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(COMMANDS, min_size=3, max_size=12))
def test_firmware_and_simulated_box_give_the_same_answers(
    new_box: Callable[[], Box], steps: list[str | float | bool]
) -> None:
    clock = _ModelClock()
    box, model = new_box(), TriggerBox(clock, lambda _: None)
    model.power(True)
    for step in steps:
        clock.now += LINE_S
        if isinstance(step, bool):
            box.chip.power(step)
            model.power(step)
            box.chip.run(LINE_S)
        elif isinstance(step, float):
            clock.now += step - LINE_S
            box.chip.run(step)
        else:
            expected = model.answer(framed(step)[:-1]).decode().partition("*")[0]
            answer = box.ask(step)
            if expected.startswith("FIRED"):  # the clocks began at other times
                expected, answer = (text.rpartition(" ")[0] for text in (expected, answer))
            assert answer == expected, steps
    box.chip.close()


@given(st.binary(max_size=60).filter(lambda content: b"\n" not in content))
@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_noise_on_the_line_is_refused_and_the_next_command_works(armed: Box, noise: bytes) -> None:
    armed.chip.received.clear()
    armed.chip.send(noise + b"\n")
    armed.chip.run(LINE_S)
    assert armed.chip.received.startswith(b"ERR ")
    assert armed.ask("STAT?").startswith("STAT ")
    assert armed.outputs() == []


@pytest.fixture
def armed(box: Box) -> Box:
    box.ask("ARM 1 0 20000")
    return box


def test_more_bytes_than_the_box_can_hold_lose_their_lines_and_fire_nothing(box: Box) -> None:
    box.ask("ARM 1 0 20000")
    chip: SimulatedChip = box.chip
    chip.send(b"FIRE 1" * 200 + b"\n")
    chip.run(BYTE_S * 1300)
    assert box.ask("STAT?") == "STAT ARMED 0 0 1"
    assert box.outputs() == []
