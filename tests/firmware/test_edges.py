"""Both edges of both pulses, read from the pins: as many as shots, at the time that was asked."""

from __future__ import annotations

import random

import pytest

from simulators.chip import CLOCK_HZ
from tests.firmware.conftest import LINE_S, Box, framed

TICK_US = 4.0
ROUND_S = 65536 * TICK_US * 1e-6
"""Time in which the chip's 16-bit timer comes round."""


def us(cycles: int) -> float:
    return cycles / CLOCK_HZ * 1e6


def shot(box: Box, number: int, delay_us: int, width_us: int) -> dict[str, int]:
    """Fire, wait until everything has come round twice, return the cycle of each edge."""
    before = len(box.outputs())
    assert box.ask(f"ARM {number} {delay_us} {width_us}") == f"ARMED {number}"
    fired = box.ask(f"FIRE {number}")
    assert fired.startswith(f"FIRED {number} ")
    box.chip.run((abs(delay_us) + width_us) * 1e-6 + 2 * ROUND_S)
    edges = box.outputs()[before:]
    assert sorted(name for name, _ in edges) == ["A", "B", "a", "b"]
    return dict(edges)


@pytest.mark.parametrize(
    ("delay_us", "width_us"),
    [(0, 100), (0, 20_000), (5_000, 20_000), (-5_000, 20_000), (100, 100), (-100_000, 100_000)],
)
def test_delay_and_width_are_exact_to_a_clock_for_whole_ticks(
    box: Box, delay_us: int, width_us: int
) -> None:
    edges = shot(box, 1, delay_us, width_us)
    assert us(edges["B"] - edges["A"]) == pytest.approx(delay_us, abs=0.2)
    assert us(edges["a"] - edges["A"]) == pytest.approx(width_us, abs=0.2)
    assert us(edges["b"] - edges["B"]) == pytest.approx(width_us, abs=0.2)


def test_any_delay_and_width_are_kept_within_a_tick_and_no_edge_is_added(box: Box) -> None:
    draw = random.Random(4)
    for number in range(1, 13):
        delay_us = draw.randint(-100_000, 100_000)
        width_us = draw.choice([100, 101, draw.randint(100, 100_000)])
        edges = shot(box, number, delay_us, width_us)
        assert us(edges["B"] - edges["A"]) == pytest.approx(delay_us, abs=TICK_US)
        assert us(edges["a"] - edges["A"]) == pytest.approx(width_us, abs=TICK_US)
        assert us(edges["b"] - edges["B"]) == pytest.approx(width_us, abs=TICK_US)
    assert box.ask("STAT?") == "STAT SAFE 12 12 1"


def test_the_time_of_a_fire_is_the_boxs_clock_at_its_first_edge(box: Box) -> None:
    times, cycles = [], []
    for number in range(1, 6):
        box.ask(f"ARM {number} 0 100")
        times.append(int(box.ask(f"FIRE {number}").split()[2]))
        cycles.append(box.outputs()[-4][1])
        box.chip.run(number * 0.7 * ROUND_S)
    for time_us, cycle in zip(times, cycles, strict=True):
        assert time_us - times[0] == pytest.approx(us(cycle - cycles[0]), abs=TICK_US)


def test_edges_come_at_once_after_the_command_whatever_else_is_on_the_line(box: Box) -> None:
    waits = []
    for number in range(1, 8):
        box.ask(f"ARM {number} 0 100")
        command = framed(f"FIRE {number}")
        began = box.chip.cycle
        box.chip.send(command + b"?" * number)
        box.chip.run(2 * LINE_S)
        box.chip.send(b"\n")
        box.chip.run(LINE_S)
        waits.append(us(box.outputs()[-4][1] - began))
    assert max(waits) - min(waits) < 50.0
    assert max(waits) < 3000.0


@pytest.mark.parametrize("when_us", [0, 20, 3_000, 5_100, 24_000])
@pytest.mark.parametrize("by", ["SAFE", "power", "reset", "watch"])
def test_whatever_makes_the_box_safe_ends_pulses_under_way_and_those_to_come(
    box: Box, by: str, when_us: int
) -> None:
    box.ask("WATCH 100") if by == "watch" else None
    box.ask("ARM 1 5000 20000")
    box.chip.send(framed("FIRE 1"))
    box.chip.run(2.1e-3 + when_us * 1e-6)
    if by == "SAFE":
        box.chip.send(framed("SAFE"))
        box.chip.run(4e-3)
    elif by == "watch":
        box.chip.run(0.11)
    elif by == "reset":
        box.chip.reset()
    else:
        box.chip.power(False)
        box.chip.run(1e-5)
    edges = len(box.outputs())
    assert box.levels() == dict.fromkeys("ABW", False)
    box.chip.run(3 * ROUND_S)
    assert len(box.outputs()) == edges


def test_a_pulse_after_one_that_was_cut_short_begins_where_it_should(box: Box) -> None:
    box.ask("ARM 1 0 20000")
    box.ask("FIRE 1")
    box.ask("SAFE")
    edges = shot(box, 2, 1000, 2000)
    assert us(edges["B"] - edges["A"]) == pytest.approx(1000, abs=0.2)
    assert us(edges["a"] - edges["A"]) == pytest.approx(2000, abs=0.2)
