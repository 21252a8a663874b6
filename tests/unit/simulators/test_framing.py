from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulators.wire.framing import Lines
from simulators.wire.lcus import LcusFrames

ON_1, OFF_1, ON_2 = b"\xa0\x01\x01\xa2", b"\xa0\x01\x00\xa1", b"\xa0\x02\x01\xa3"


def cut(data: bytes, places: list[int]) -> list[bytes]:
    bounds = [0, *sorted(place % (len(data) + 1) for place in places), len(data)]
    return [data[a:b] for a, b in itertools.pairwise(bounds)]


@given(
    lines=st.lists(st.binary(max_size=20).map(lambda line: line.replace(b"\n", b""))),
    places=st.lists(st.integers(0, 10_000)),
)
def test_lines_come_out_whole_however_the_bytes_are_cut(
    lines: list[bytes], places: list[int]
) -> None:
    framing = Lines(b"\n")
    data = b"".join(line + b"\n" for line in lines)
    assert [line for piece in cut(data, places) for line in framing.feed(piece)] == lines


@pytest.mark.parametrize("size", [1, 7, 300])
def test_an_overlong_line_is_thrown_away_and_the_next_one_heard(size: int) -> None:
    framing = Lines(b"\n", longest=10)
    heard = []
    data = b"x" * 500 + b"\nID?\n"
    for start in range(0, len(data), size):
        heard += framing.feed(data[start : start + size])
    assert heard == [b"ID?"]


@given(
    commands=st.lists(st.sampled_from([ON_1, OFF_1, ON_2])),
    places=st.lists(st.integers(0, 10_000)),
)
def test_relay_commands_come_out_whole_however_the_bytes_are_cut(
    commands: list[bytes], places: list[int]
) -> None:
    framing = LcusFrames()
    pieces = cut(b"".join(commands), places)
    assert [command for piece in pieces for command in framing.feed(piece)] == commands


@pytest.mark.parametrize("noise", [b"\x00", b"\xa0", b"\xa0\x01\x01\xff", b"\xff\xa0\x01"])
def test_a_relay_command_is_found_behind_noise(noise: bytes) -> None:
    assert LcusFrames().feed(noise + ON_1) == [ON_1]
