"""What the box does by itself: it disarms, it watches, and no death of host or box fires it."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from simulators.chip import CLOCK_HZ
from tests.firmware.conftest import BYTE_S, LINE_S, Box, framed


def test_the_box_disarms_itself_five_seconds_after_arming(box: Box) -> None:
    box.ask("ARM 1 0 20000")
    box.chip.run(4.97)
    assert box.ask("STAT?") == "STAT ARMED 0 0 1"
    box.chip.run(0.03)
    assert box.ask("FIRE 1") == "ERR NOTARMED no number"
    assert box.outputs() == []


def test_a_power_cut_shorter_than_a_millisecond_disarms(box: Box) -> None:
    box.ask("ARM 1 0 20000")
    box.chip.power(False)
    box.chip.run(5e-6)
    box.chip.power(True)
    box.chip.run(1e-3)
    assert box.ask("FIRE 1") == "ERR NOTARMED no number"
    assert box.outputs() == []


@pytest.mark.parametrize("period_ms", [100, 600, pytest.param(10_000, marks=pytest.mark.long)])
def test_a_late_watch_opens_its_contact_within_ten_milliseconds(box: Box, period_ms: int) -> None:
    began = box.chip.cycle
    box.ask(f"WATCH {period_ms}")
    box.ask("ARM 1 0 100")
    assert box.levels()["W"]
    box.chip.run(period_ms * 1e-3)
    [closed, opened] = [edge for edge in box.chip.edges if edge.pin == "W"]
    assert closed.rises
    assert not opened.rises
    silent_s = (opened.cycle - began) / CLOCK_HZ
    assert period_ms * 1e-3 <= silent_s < period_ms * 1e-3 + 0.010 + BYTE_S * len("WATCH 10000*00")
    assert box.ask("FIRE 1") == f"ERR LATE {period_ms}"
    assert box.ask("BEAT") == f"ERR LATE {period_ms}"
    assert box.ask("STAT?") == "STAT SAFE 0 0 1"
    assert box.ask(f"WATCH {period_ms}") == f"WATCHING {period_ms}"
    assert box.ask("FIRE 1") == "ERR NOTARMED no number"


def test_heartbeats_keep_the_watch_and_other_commands_do_not(box: Box) -> None:
    box.ask("WATCH 100")
    for _ in range(8):
        box.chip.run(0.07)
        assert box.ask("BEAT") == "BEAT"
    for _ in range(4):
        box.chip.run(0.01)
        box.ask("STAT?")
    assert box.ask("BEAT") == "ERR LATE 100"


def test_no_reset_of_the_box_at_any_cycle_fires_it(new_box: Callable[[], Box]) -> None:
    draw = random.Random(7)
    box = new_box()
    for number in range(1, 61):
        box.chip.send(framed("WATCH 600") + framed(f"ARM {number} 3000 2000"))
        box.chip.send(framed(f"FIRE {number}"))
        # Across start-up, both lines, both pulses and after.
        box.chip.run_cycles(draw.randrange(round(0.03 * CLOCK_HZ)))
        box.chip.reset()
        edges = len(box.chip.edges)
        assert box.levels() == dict.fromkeys("ABW", False)
        box.chip.run(draw.choice([0.02, 0.3]))
        assert len(box.chip.edges) == edges
        # A box that was reset remembers no number and nothing armed.
        box.chip.received.clear()
        assert box.ask("STAT?") == "STAT SAFE 0 0 1"
        assert box.ask(f"FIRE {number}") == "ERR NOTARMED no number"


def test_no_death_of_the_host_in_the_middle_of_a_line_fires(box: Box) -> None:
    box.ask("WATCH 600")
    whole = framed("ARM 1 0 2000") + framed("FIRE 1")
    draw = random.Random(11)
    for cut in [*range(len(whole)), len(whole) - 1]:
        box.chip.send(whole[:cut])
        box.chip.run(draw.choice([0.02, 0.7]))
        box.chip.send(b"\n")  # the next host begins its line on what the last one left
        box.chip.run(LINE_S)
        fired = [edge for edge in box.chip.edges if edge.pin in "AB"]
        # Only the newline was missing of the whole line, and its checksum holds.
        assert fired == [] or cut == len(whole) - 1
        box.ask("SAFE")
        box.ask("WATCH 600")
