"""`rigctl firmware`: the trigger box's source, and how it comes onto a board."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Annotated

import typer

from rigctl.errors import SettingsError
from rigctl.firmware import SOURCES, source_digest, source_folder

_ALL = (*SOURCES, "Makefile", "bench/bench.c")
_STEPS = """\
Trigger box for an Arduino Nano (ATmega328P, 16 MHz), protocol version 2, in {out}
source {hash}

1. Install the compiler and the programmer once:
     sudo apt-get install gcc-avr avr-libc avrdude make
2. Plug the board in alone, no solenoid connected. Build and flash:
     make -C {out} flash PORT={port}
   A board with the old bootloader needs BAUD=57600 behind it.
3. Wire it:
     D9 output a, D10 output b: to the gates of two MOSFET modules, 10 kohm to ground each
     D2 power of the outputs: their 12 V, behind the cut-off, over 15 kohm, and 8.2 kohm to ground
     D4 contact of the watch: to a relay whose contact lies in that supply, or free
     RST: 10 uF to ground once it is flashed, or every opening of the port resets the box
4. Name the port in the configuration, under [trigger] with driver = "trigger-box", then
   `rigctl commission`: nothing fires before. After flashing anew: --rewired trigger.
"""


def firmware(
    *,
    out: Annotated[Path, typer.Option(help="Folder for the firmware's source.")] = Path("firmware"),
    port: Annotated[str, typer.Option(help="Where the board is plugged in.")] = "/dev/ttyUSB0",
) -> None:
    """Copy the source into a folder and print the steps to a board that runs it.

    Raises
    ------
    ConfigurationError
        The source did not come with the program.
    SettingsError
        A file of that name is there already and differs: it may hold somebody's changes.
    """
    source = source_folder()
    for name in _ALL:
        path = out / name
        if path.exists() and path.read_bytes() != (source / name).read_bytes():
            raise SettingsError(
                "a file is there already, and is not the one to be written",
                part=str(path),
                todo="choose another folder with --out",
            )
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            shutil.copyfile(source / name, path)
    text = _STEPS.format(out=out, port=port, hash=source_digest())
    typer.echo(text, nl=False)
