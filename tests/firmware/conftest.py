"""The trigger box's firmware, compiled and run on a simulated chip; skipped without compilers."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator
from functools import reduce
from operator import xor
from pathlib import Path

import pytest

from simulators.chip import NEEDS, SimulatedChip, build

FIRMWARE = Path(__file__).parents[2] / "firmware"
BYTE_S = 2.1e-4
"""Of the simulated chip's serial line, which runs at half the true speed, s."""
LINE_S = 0.025
"""Longer than a line there, its answer and the first edge take, s."""


@pytest.fixture(scope="session")
def programs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    if missing := [name for name in NEEDS if shutil.which(name) is None]:
        pytest.skip(f"not installed: {', '.join(missing)}")
    if not Path("/usr/include/simavr").is_dir():
        pytest.skip("not installed: libsimavr-dev")
    try:
        return build(FIRMWARE, tmp_path_factory.mktemp("firmware"))
    except subprocess.CalledProcessError as error:
        pytest.fail(error.stderr)


class Box:
    """A chip that is asked in whole lines."""

    def __init__(self, chip: SimulatedChip) -> None:
        self.chip = chip

    def ask(self, content: str, within_s: float = LINE_S) -> str:
        """Send a closed line, let the chip run so long, and return the answer, checked."""
        self.chip.received.clear()
        self.chip.send(framed(content))
        self.chip.run(within_s)
        lines = bytes(self.chip.received).decode().splitlines()
        assert len(lines) == 1, lines
        told, _, _ = lines[0].partition("*")
        assert lines[0].encode() + b"\n" == framed(told)
        return told

    def outputs(self) -> list[tuple[str, int]]:
        """Return edges of both outputs as (A rises, a falls, ...) with their cycles."""
        return [
            (edge.pin if edge.rises else edge.pin.lower(), edge.cycle)
            for edge in self.chip.edges
            if edge.pin != "W"
        ]

    def levels(self) -> dict[str, bool]:
        """Return the level of each pin after its last edge."""
        levels = dict.fromkeys("ABW", False)
        return levels | {edge.pin: edge.rises for edge in self.chip.edges}


def framed(content: str) -> bytes:
    return f"{content}*{reduce(xor, content.encode(), 0):02X}\n".encode()


@pytest.fixture
def new_box(programs: tuple[Path, Path]) -> Iterator[Callable[[], Box]]:
    chips: list[SimulatedChip] = []

    def make() -> Box:
        chips.append(SimulatedChip(*programs))
        return Box(chips[-1])

    yield make
    for chip in chips:
        chip.close()


@pytest.fixture
def box(new_box: Callable[[], Box]) -> Box:
    return new_box()
