"""The trigger box's firmware on a simulated chip: python -m benchmarks.firmware.

Fires shots of random delay and width and reads the edges from the pins; then resets the box and
kills its host at random cycles. Prints a table; ends 1 if an edge was lost, added or late.
Needs the packages that `make -C firmware bench` names.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from pathlib import Path

from rigctl.devices.trigger_box import closed
from simulators.chip import CLOCK_HZ, Edge, SimulatedChip, build

FIRMWARE = Path(__file__).parents[1] / "firmware"
LINES_S = 0.025
"""Longer than both lines of a shot take on the simulated serial line, s."""
TICK_US, JITTER_BAR_US = 4.0, 50.0


def framed(content: str) -> bytes:
    """Return a closed line with its ending."""
    return f"{closed(content)}\n".encode()


def us(cycles: int) -> float:
    """Return clock cycles in microseconds."""
    return cycles / CLOCK_HZ * 1e6


class Pins:
    """Largest deviations of edges from what was asked, and how many are too many or too few."""

    def __init__(self) -> None:
        self.shots = self.edges = self.wrong = 0
        self.delay_us = self.width_us = 0.0
        self.wait_us: list[float] = []

    def take(self, edges: list[Edge], delay_us: int, width_us: int, began: int) -> None:
        """Hold the edges of one shot against its delay and width."""
        self.shots += 1
        self.edges += len(edges)
        at = {(edge.pin, edge.rises): edge.cycle for edge in edges}
        if len(edges) != 4 or len(at) != 4:
            self.wrong += 1
            return
        delay = us(at["B", True] - at["A", True])
        self.delay_us = max(self.delay_us, abs(delay - delay_us))
        for pin in "AB":
            width = us(at[pin, False] - at[pin, True])
            self.width_us = max(self.width_us, abs(width - width_us))
        self.wait_us.append(us(min(edge.cycle for edge in edges) - began))


def fire_shots(chip: SimulatedChip, shots: int, draw: random.Random) -> Pins:
    """Fire shots of random delay and width, the command alone on the line each time."""
    pins = Pins()
    for number in range(1, shots + 1):
        delay_us, width_us = draw.randint(-3000, 3000), draw.randint(100, 3000)
        # As many characters in every number: the way over the line is then the same for each.
        sequence = 1_000_000 + number
        chip.send(framed(f"ARM {sequence} {delay_us} {width_us}"))
        chip.run(LINES_S / 2)
        chip.edges.clear()
        began = chip.cycle
        chip.send(framed(f"FIRE {sequence}"))
        chip.run(LINES_S / 2 + (abs(delay_us) + width_us) * 1e-6)
        pins.take(chip.edges, delay_us, width_us, began)
    return pins


def interrupt_shots(chip: SimulatedChip, times: int, draw: random.Random) -> int:
    """Reset the box, or let its host fall silent, at random cycles; count edges afterwards."""
    stray = 0
    for number in range(1, times + 1):
        chip.reset()
        chip.send(framed("WATCH 100") + framed(f"ARM {number} 2000 2000"))
        line = framed(f"FIRE {number}")
        chip.send(line[: draw.randint(0, len(line))])
        chip.run_cycles(draw.randrange(round(2 * LINES_S * CLOCK_HZ)))
        if draw.random() < 0.5:
            chip.reset()
        else:
            chip.run(0.2)  # until the watch is late, whatever came
        chip.edges.clear()
        chip.run(0.3)
        stray += len(chip.edges)
    return stray


def main() -> int:
    """Run both parts and print the table."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--shots", type=int, default=10_000)
    asked.add_argument("--interrupts", type=int, default=300)
    asked.add_argument("--seed", type=int, default=1)
    options = asked.parse_args()
    draw = random.Random(options.seed)
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        programs = build(FIRMWARE, Path(folder))
        with SimulatedChip(*programs) as chip:
            pins = fire_shots(chip, options.shots, draw)
        with SimulatedChip(*programs) as chip:
            stray = interrupt_shots(chip, options.interrupts, draw)
    jitter = max(pins.wait_us) - min(pins.wait_us) if pins.wait_us else float("nan")
    print(f"{pins.shots} shots, {pins.edges} edges, {pins.wrong} shots with other than four")
    print(f"delay off by at most {pins.delay_us:.2f} us, width by {pins.width_us:.2f} us (tick 4)")
    print(f"from the first byte of FIRE to the first edge: {jitter:.1f} us from least to most")
    print(f"{options.interrupts} resets and silent hosts at random cycles: {stray} edges after")
    print(f"{time.monotonic() - began:.0f} s")
    held = not pins.wrong and not stray and jitter < JITTER_BAR_US
    return 0 if held and max(pins.delay_us, pins.width_us) <= TICK_US else 1


if __name__ == "__main__":
    sys.exit(main())
