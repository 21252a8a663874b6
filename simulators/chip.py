"""The trigger box's own firmware on a simulated ATmega328P, with its pins by the clock cycle.

Needs `make -C firmware bench`: gcc-avr, avr-libc, gcc, libsimavr-dev and libelf-dev.
"""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Self

CLOCK_HZ = 16_000_000
NEEDS = ("avr-gcc", "cc", "make")


@dataclass(frozen=True, slots=True)
class Edge:
    """A change of one pin.

    Attributes
    ----------
    cycle
        Clock cycles of 62.5 ns since the chip's power-on.
    pin
        `A`, `B`: the outputs; `W`: the contact of the watch.
    rises
        True for a rising edge.
    """

    cycle: int
    pin: str
    rises: bool


def build(firmware: Path, into: Path) -> tuple[Path, Path]:
    """Compile the firmware and its bench; return the bench's program and the firmware's file.

    Raises
    ------
    subprocess.CalledProcessError
        A compiler or a library is missing, or the code does not compile; `stderr` says which.
    """
    subprocess.run(  # noqa: S603 - the project's own Makefile
        ["make", "-C", str(firmware), f"BUILD={into}", "bench"],  # noqa: S607
        check=True,
        capture_output=True,
        text=True,
    )
    return into / "bench", into / "trigger_box.elf"


class SimulatedChip:
    """A box under power on a bench: bytes in and out, edges of its pins.

    Parameters
    ----------
    bench, firmware
        What `build` has returned.

    Attributes
    ----------
    edges
        Every edge since power-on, in order.
    received
        All bytes from the serial line.
    cycle
        The chip's clock after the last `run`.
    """

    def __init__(self, bench: Path, firmware: Path) -> None:
        self._process = subprocess.Popen(  # noqa: S603 - what build has made
            [str(bench), str(firmware)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.edges: list[Edge] = []
        self.received = bytearray()
        self.cycle = 0
        self.power(True)
        self.run(1e-3)

    def __enter__(self) -> Self:
        """Return the chip."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Switch the bench off."""
        self.close()

    def close(self) -> None:
        """End the bench's process."""
        self._write.close()
        self._process.wait(timeout=10.0)
        self._read.close()

    def power(self, on: bool) -> None:
        """Give or take the power of the outputs."""
        self._tell(f"power {int(on)}")

    def reset(self) -> None:
        """Reset the chip now, in whatever it does."""
        self._tell("reset")
        self.run_cycles(1)

    def send(self, content: bytes) -> None:
        """Put bytes on the serial line; they go at its own speed as the chip runs."""
        if content:
            self._tell(f"send {content.hex()}")

    def run(self, seconds: float) -> None:
        """Let the chip run for a time of its own clock."""
        self.run_cycles(round(seconds * CLOCK_HZ))

    def run_cycles(self, cycles: int) -> None:
        """Let the chip run for so many cycles (a command ends within a cycle or two of it)."""
        self._tell(f"run {cycles}")
        while (word := self._note(self._read.readline())) != "done":
            if not word:
                raise RuntimeError(f"the bench has ended with {self._process.wait(10.0)}")

    def join_terminal(self) -> str:
        """Join the serial line to a pseudo-terminal, run beside the wall's clock, return its path.

        It runs so until the next call of any other method.
        """
        self._tell("pty")
        while True:
            line = self._read.readline()
            word, _, path = line.partition(" ")
            if word == "pty":
                return path.strip()
            self._note(line)

    @property
    def _write(self) -> IO[str]:
        assert self._process.stdin is not None  # noqa: S101 - opened above
        return self._process.stdin

    @property
    def _read(self) -> IO[str]:
        assert self._process.stdout is not None  # noqa: S101 - opened above
        return self._process.stdout

    def _tell(self, command: str) -> None:
        self._write.write(f"{command}\n")
        self._write.flush()

    def _note(self, line: str) -> str:
        match line.split():
            case ["edge", cycle, pin, level]:
                self.edges.append(Edge(int(cycle), pin, level == "1"))
            case ["byte", _, byte]:
                self.received += bytes.fromhex(byte)
            case ["done", cycle]:
                self.cycle = int(cycle)
            case []:
                return ""
        return line.split(maxsplit=1)[0]
