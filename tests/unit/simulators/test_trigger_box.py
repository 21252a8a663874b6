from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from operator import xor
from typing import Protocol

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulators.wire.framing import Lines
from simulators.wire.trigger_box import Pulses, TriggerBox


class Clock(Protocol):
    now: float

    def __call__(self) -> float: ...
    def advance(self, seconds: float) -> None: ...


def framed(content: str) -> bytes:
    return f"{content}*{reduce(xor, content.encode(), 0):02X}".encode()


class Bench:
    """A powered box, what it put out, and its answers without their checksum."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self.pulses: list[Pulses] = []
        self.box = TriggerBox(clock, self.pulses.append)
        self.box.power(True)

    def ask(self, content: str) -> str:
        answer = self.box.answer(framed(content))
        told, _, _ = answer.decode().partition("*")
        assert answer == framed(told) + b"\n"
        return told


@pytest.fixture
def bench(clock: Clock) -> Bench:
    return Bench(clock)


@pytest.mark.parametrize(
    ("asked", "answered"),
    [
        (["ID?"], "RIGTRIG 2 2"),
        (["STAT?"], "STAT SAFE 0 0 1"),
        (["ARM 1 0 20000"], "ARMED 1"),
        (["ARM 1 -100000 100"], "ARMED 1"),
        (["ARM 4294967295 100000 100000"], "ARMED 4294967295"),
        (["ARM 1 0 20000", "STAT?"], "STAT ARMED 0 0 1"),
        (["ARM 1 0 20000", "FIRE 1", "STAT?"], "STAT SAFE 1 1 1"),
        (["ARM 1 0 20000", "SAFE"], "SAFE"),
        (["ARM 1 0 20000", "SAFE", "FIRE 1"], "ERR NOTARMED no number"),
        (["FIRE 1"], "ERR NOTARMED no number"),
        (["ARM 7 0 20000", "FIRE 8"], "ERR SEQUENCE 7 is armed"),
        (["ARM 7 0 20000", "FIRE 8", "STAT?"], "STAT ARMED 0 0 1"),
        (["ARM 7 0 20000", "FIRE 7", "FIRE 7"], "ERR DUPLICATE 7"),
        (["ARM 7 0 20000", "FIRE 7", "ARM 7 0 20000"], "ERR DUPLICATE 7"),
        (["ARM 7 0 20000", "FIRE 7", "ARM 6 0 20000"], "ERR SEQUENCE above 7"),
        (["ARM 7 0 20000", "ARM 9 0 20000", "FIRE 7"], "ERR SEQUENCE 9 is armed"),
        (["ARM 0 0 20000"], "ERR RANGE sequence 1 to 4294967295"),
        (["ARM 4294967296 0 20000"], "ERR RANGE sequence 1 to 4294967295"),
        (["ARM 1 100001 20000"], "ERR RANGE delay within 100000 us"),
        (["ARM 1 0 99"], "ERR RANGE width 100 to 100000 us"),
        (["ARM 1 0 100001"], "ERR RANGE width 100 to 100000 us"),
        (["ARM 1 0"], "ERR SYNTAX unknown command"),
        (["ARM 1 0.5 20000"], "ERR SYNTAX unknown command"),
        (["fire 1"], "ERR SYNTAX unknown command"),
        (["WATCH 600"], "WATCHING 600"),
        (["WATCH 600", "BEAT"], "BEAT"),
        (["BEAT"], "ERR NOWATCH none is set"),
        (["WATCH 600", "WATCH 0", "BEAT"], "ERR NOWATCH none is set"),
        (["WATCH 99"], "ERR RANGE period 0 or 100 to 10000 ms"),
        (["WATCH 10001"], "ERR RANGE period 0 or 100 to 10000 ms"),
        (["WATCH"], "ERR SYNTAX unknown command"),
        (["WATCH 600", "ARM 1 0 20000", "WATCH 700", "STAT?"], "STAT ARMED 0 0 1"),
        (["WATCH 600", "ARM 1 0 20000", "WATCH 0", "STAT?"], "STAT SAFE 0 0 1"),
        (["WATCH 600", "ARM 1 0 20000", "WATCH 99", "STAT?"], "STAT ARMED 0 0 1"),
        ([""], "ERR SYNTAX unknown command"),
    ],
)
def test_the_box_answers_as_the_protocol_page_says(
    bench: Bench, asked: list[str], answered: str
) -> None:
    assert [bench.ask(each) for each in asked][-1] == answered


@pytest.mark.parametrize(
    ("delay_us", "a_after_s", "b_after_s"), [(0, 0, 0), (1500, 0, 1.5e-3), (-20_000, 20e-3, 0)]
)
def test_the_outputs_rise_apart_by_the_delay(
    clock: Clock, bench: Bench, delay_us: int, a_after_s: float, b_after_s: float
) -> None:
    clock.advance(2.5)
    bench.ask(f"ARM 1 {delay_us} 20000")
    assert bench.ask("FIRE 1") == "FIRED 1 2500000"
    (pulses,) = bench.pulses
    assert pulses.a_s == pytest.approx(clock.now + a_after_s, abs=1e-9)
    assert pulses.b_s == pytest.approx(clock.now + b_after_s, abs=1e-9)
    assert pulses.width_s == pytest.approx(0.02)


def test_a_box_arms_only_when_its_pulses_are_over(clock: Clock, bench: Bench) -> None:
    bench.ask("ARM 1 5000 20000")
    bench.ask("FIRE 1")
    clock.advance(0.0249)
    assert bench.ask("ARM 2 0 100") == "ERR BUSY pulses under way"
    clock.advance(0.0002)
    assert bench.ask("ARM 2 0 100") == "ARMED 2"


def test_a_refused_watch_disarms_nothing(bench: Bench) -> None:
    bench.ask("ARM 1 0 20000")
    assert bench.ask("WATCH 99").startswith("ERR RANGE")
    assert bench.ask("STAT?") == "STAT ARMED 0 0 1"


def test_the_box_disarms_itself_five_seconds_after_arming(clock: Clock, bench: Bench) -> None:
    bench.ask("ARM 1 0 20000")
    clock.advance(4.999)
    assert bench.ask("STAT?") == "STAT ARMED 0 0 1"
    clock.advance(0.001)
    assert bench.ask("STAT?") == "STAT SAFE 0 0 1"
    assert bench.ask("FIRE 1") == "ERR NOTARMED no number"
    assert bench.pulses == []


def test_a_box_that_hears_no_heartbeat_makes_itself_safe_until_it_is_told_to_watch_again(
    clock: Clock, bench: Bench
) -> None:
    bench.ask("WATCH 600")
    clock.advance(0.5)
    assert bench.ask("BEAT") == "BEAT"
    bench.ask("ARM 1 0 20000")
    clock.advance(0.599)
    assert bench.ask("STAT?") == "STAT ARMED 0 0 1"
    clock.advance(0.001)
    late = clock.now
    clock.advance(0.2)
    assert bench.ask("STAT?") == "STAT SAFE 0 0 1"
    assert bench.box.late_since_s == pytest.approx(late)
    for command in ("FIRE 1", "ARM 1 0 20000", "BEAT"):
        assert bench.ask(command) == "ERR LATE 600"
    assert bench.ask("WATCH 600") == "WATCHING 600"
    assert bench.ask("FIRE 1") == "ERR NOTARMED no number"
    assert bench.ask("ARM 1 0 20000") == "ARMED 1"
    assert bench.pulses == []


def test_other_commands_are_no_heartbeat(clock: Clock, bench: Bench) -> None:
    bench.ask("WATCH 100")
    for _ in range(4):
        bench.ask("STAT?")
        bench.ask("ARM 1 0 20000")
        clock.advance(0.03)
    assert bench.ask("BEAT") == "ERR LATE 100"


def test_a_watch_whose_contact_lies_in_the_powers_line_takes_the_power(clock: Clock) -> None:
    box = TriggerBox(clock, lambda _: None, contact_in_power=True)
    box.power(True)
    assert not box.is_powered
    box.answer(framed("WATCH 600"))
    assert box.is_powered
    clock.advance(0.6)
    assert not box.is_powered
    box.answer(framed("WATCH 600"))
    box.answer(framed("WATCH 0"))
    assert not box.is_powered


def test_a_box_of_before_the_heartbeat_knows_none(clock: Clock) -> None:
    bench = Bench(clock)
    bench.box = TriggerBox(clock, bench.pulses.append, version=1)
    assert bench.ask("ID?") == "RIGTRIG 1 2"
    assert bench.ask("WATCH 600") == bench.ask("BEAT") == "ERR SYNTAX unknown command"


def test_a_box_without_power_neither_arms_nor_fires(bench: Bench) -> None:
    bench.box.power(False)
    assert bench.ask("ARM 1 0 20000") == "ERR CUT no power"
    assert bench.ask("FIRE 1") == "ERR CUT no power"
    assert bench.ask("STAT?") == "STAT SAFE 0 0 0"


def test_a_power_cut_disarms_for_good(bench: Bench) -> None:
    bench.ask("ARM 1 0 20000")
    bench.box.power(False)
    bench.box.power(True)
    assert bench.ask("FIRE 1") == "ERR NOTARMED no number"
    assert bench.pulses == []


def test_a_stuck_box_says_it_fired_and_puts_nothing_out(bench: Bench) -> None:
    bench.box.stick(True)
    bench.ask("ARM 1 0 20000")
    assert bench.ask("FIRE 1").startswith("FIRED 1 ")
    assert bench.ask("STAT?") == "STAT SAFE 1 1 1"
    assert bench.pulses == []


def test_the_power_can_be_cut_from_within_a_pulse(clock: Clock) -> None:
    seen: list[str] = []

    def cut(_: Pulses) -> None:
        box.power(False)
        seen.append("cut")

    box = TriggerBox(clock, cut)
    box.power(True)
    box.answer(framed("ARM 1 0 20000"))
    box.answer(framed("FIRE 1"))
    assert seen == ["cut"]


@pytest.mark.parametrize("line", [b"FIRE 1", b"FIRE 1*", b"FIRE 1*6", b"FIRE 1*6a", b"FIRE 1*6A "])
def test_a_line_without_a_proper_checksum_is_refused(bench: Bench, line: bytes) -> None:
    bench.ask("ARM 1 0 20000")
    assert bench.box.answer(line).startswith(b"ERR ")
    assert bench.pulses == []


@given(given_sum=st.integers(0, 255))
def test_only_the_right_checksum_fires(given_sum: int) -> None:
    bench = Bench(lambda: 0.0)
    bench.ask("ARM 12 0 20000")
    right = reduce(xor, b"FIRE 12")
    answer = bench.box.answer(f"FIRE 12*{given_sum:02X}".encode())
    assert answer.startswith(b"FIRED 12 " if given_sum == right else b"ERR CHECKSUM ")
    assert len(bench.pulses) == (given_sum == right)


@given(pieces=st.lists(st.binary(max_size=60)), armed=st.booleans())
def test_no_bytes_make_the_box_raise_or_fire(pieces: list[bytes], armed: bool) -> None:
    bench = Bench(lambda: 0.0)
    if armed:
        bench.ask("ARM 1234567 0 20000")
    framing = Lines(b"\n")
    for piece in pieces:
        for line in framing.feed(piece + b"\n"):
            assert bench.box.answer(line).startswith(b"ERR ")
    assert bench.pulses == []


@given(
    steps=st.lists(
        st.tuples(
            st.sampled_from(["ARM", "FIRE", "SAFE", "WATCH", "BEAT", "cut", "restore", "wait"]),
            st.integers(1, 4),
        ),
        max_size=60,
    )
)
def test_no_number_fires_twice_whatever_the_order(steps: list[tuple[str, int]]) -> None:
    now = [0.0]
    bench = Bench(lambda: now[0])
    fired = []
    for verb, number in steps:
        if verb in {"cut", "restore"}:
            bench.box.power(verb == "restore")
        elif verb == "wait":
            now[0] += number
        else:
            told = bench.ask(
                {
                    "ARM": f"ARM {number} 0 20000",
                    "FIRE": f"FIRE {number}",
                    "WATCH": f"WATCH {1000 * number}",
                }.get(verb, verb)
            )
            fired += [int(told.split()[1])] if told.startswith("FIRED") else []
    assert fired == sorted(set(fired))
    assert len(bench.pulses) == len(fired)
