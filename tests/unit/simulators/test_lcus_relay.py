from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulators.wire.lcus import LcusFrames, LcusRelay


class Bench:
    def __init__(self) -> None:
        self.switched: list[tuple[int, bool]] = []
        self.relay = LcusRelay(2, lambda channel, on: self.switched.append((channel, on)))
        self._framing = LcusFrames()

    def send(self, data: bytes) -> bytes:
        return b"".join(self.relay.answer(command) for command in self._framing.feed(data))


@pytest.mark.parametrize(
    ("sent", "switched"),
    [
        ("A0 01 01 A2", [(1, True)]),
        ("A0 01 00 A1", []),
        ("A0 01 01 A2 A0 01 00 A1", [(1, True), (1, False)]),
        ("A0 01 01 A2 A0 02 01 A3", [(1, True), (2, True)]),
        ("A0 01 01 A2 A0 01 01 A2", [(1, True)]),
        ("A0 03 01 A4", []),
        ("A0 00 01 A1", []),
        ("A0 01 02 A3", []),
        ("A0 01 01 A3", []),
    ],
)
def test_the_board_switches_and_says_nothing(sent: str, switched: list[tuple[int, bool]]) -> None:
    bench = Bench()
    assert bench.send(bytes.fromhex(sent)) == b""
    assert bench.switched == switched


def test_all_relays_are_off_at_power_on() -> None:
    relay = Bench().relay
    assert [relay.is_on(1), relay.is_on(2)] == [False, False]


def test_a_stuck_relay_stays_where_it_is() -> None:
    bench = Bench()
    bench.send(bytes.fromhex("A0 01 01 A2"))
    bench.relay.stick(True)
    bench.send(bytes.fromhex("A0 01 00 A1"))
    assert bench.relay.is_on(1)


@given(data=st.binary(max_size=200))
def test_only_bytes_with_a_right_sum_switch_anything(data: bytes) -> None:
    bench = Bench()
    bench.send(data)
    holds_a_command = any(
        data[at] == 0xA0 and sum(data[at : at + 3]) % 256 == data[at + 3]
        for at in range(len(data) - 3)
    )
    assert holds_a_command or bench.switched == []
