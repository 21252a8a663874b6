"""The digitiser: recorded pictures become a stack in the capture folder."""

from __future__ import annotations

import json
import logging
import os
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import tifffile
from numpy.typing import NDArray

from simulators.ektapro.faults import FrameFault, FrameFaults, Stack, spoil
from simulators.ektapro.processor import Transfer

COLUMNS = 240
MOST_PICTURES = 10_000

_LOG = logging.getLogger(__name__)


class Digitiser:
    """Writes `<name>.tiff` and then `<name>.json`, each under another name and renamed.

    Parameters
    ----------
    folder
        The capture folder; it is made if absent.
    picture
        Returns the picture of a laboratory time in seconds with so many rows, as 8-bit grey
        levels of shape (rows, columns). Called from the digitiser's own thread.
    faults
        What goes wrong at present.
    """

    def __init__(
        self,
        folder: Path,
        picture: Callable[[float, int], NDArray[np.uint8]],
        faults: FrameFaults,
    ) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._picture, self._faults = folder, picture, faults
        self._worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="digitiser")
        self._under_way: dict[str, Future[None]] = {}
        self._closing = threading.Event()

    def start(self, transfer: Transfer) -> None:
        """Begin to digitise; transfers follow one another.

        Raises
        ------
        ValueError
            A stack of that name exists or is under way, or there are too many pictures.
        """
        if transfer.count > MOST_PICTURES:
            raise ValueError(f"at most {MOST_PICTURES} pictures in one stack")
        self._under_way = {name: work for name, work in self._under_way.items() if not work.done()}
        exists = (self._folder / f"{transfer.name}.json").exists()
        if exists or transfer.name in self._under_way:
            raise ValueError(f"{transfer.name} exists")
        self._under_way[transfer.name] = self._worker.submit(self._carry_out, transfer)

    def finish(self, within_s: float) -> None:
        """Wait until nothing is under way, and raise what went wrong.

        Raises
        ------
        TimeoutError
            Something still is, after that many seconds.
        """
        for work in list(self._under_way.values()):
            work.result(within_s)

    def close(self) -> None:
        """Give up what is under way. Safe to call twice."""
        self._closing.set()
        self._worker.shutdown(wait=True, cancel_futures=True)

    def _carry_out(self, transfer: Transfer) -> None:
        try:
            self._transfer(transfer)
        except Exception:
            _LOG.exception("transfer %s came to nothing", transfer.name)
            raise

    def _transfer(self, transfer: Transfer) -> None:
        fault = self._faults.take()
        kind = fault.kind if fault else None
        pictures = self._digitised(transfer)
        if pictures is None or kind is FrameFault.NO_FRAMES:
            return
        stack = spoil(pictures, fault)
        self._write(transfer.name, stack, whole=kind is not FrameFault.TRUNCATED_TIFF)
        self._announce(transfer.name, stack)

    def _digitised(self, transfer: Transfer) -> Stack | None:
        per_s = transfer.format.pictures_per_s
        numbers = list(range(transfer.first, transfer.first + transfer.count))
        pixels = np.empty((len(numbers), transfer.format.rows, COLUMNS), np.uint8)
        for place, number in enumerate(numbers):
            if self._closing.is_set():
                return None
            instant = transfer.first_s + number / per_s
            pixels[place] = self._picture(instant, transfer.format.rows)
        if transfer.gamma != 1.0:
            pixels = np.rint(255.0 * (pixels / 255.0) ** transfer.gamma).astype(np.uint8)
        return Stack(pixels, float(per_s), numbers, [n / per_s for n in numbers], [])

    def _write(self, name: str, stack: Stack, whole: bool) -> None:
        partial = self._folder / f".{name}.tiff.part"
        tifffile.imwrite(partial, stack.pixels, photometric="minisblack", metadata=None)
        if not whole:
            os.truncate(partial, partial.stat().st_size // 2)
        partial.rename(self._folder / f"{name}.tiff")

    def _announce(self, name: str, stack: Stack) -> None:
        partial = self._folder / f".{name}.json.part"
        partial.write_text(json.dumps(asdict(Announcement.of(stack))) + "\n", encoding="utf-8")
        partial.rename(self._folder / f"{name}.json")


@dataclass(frozen=True, slots=True)
class Announcement:
    """What the JSON says of the TIFF beside it."""

    frames: int
    rows: int
    columns: int
    frame_rate_hz: float
    sequence: list[int]
    times_s: list[float]
    lost: list[int]

    @classmethod
    def of(cls, stack: Stack) -> Announcement:
        """Describe a stack."""
        _, rows, columns = stack.pixels.shape
        return cls(
            frames=len(stack.sequence),
            rows=rows,
            columns=columns,
            frame_rate_hz=stack.frame_rate_hz,
            sequence=stack.sequence,
            times_s=stack.times_s,
            lost=stack.lost,
        )
