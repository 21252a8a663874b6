"""What `rigctl analyse` prints of shots; it waits in temporary files until all are measured."""

from __future__ import annotations

import json
from contextlib import ExitStack
from typing import Self

from rich.console import Console

from analysis.document import shot_document
from analysis.shot import MeasuredShot, RefusedShot
from rigctl.cli.spool import Spool

HEADINGS = (
    *("shot", "contact\nms", "lasts\nus", "v_n\nm/s", "v_s\nm/s", "v_n'\nm/s", "v_s'\nm/s"),
    *("e", "beta"),
)
_CAPTION = "in brackets: standard error in units of the last digit"
_CELL = "\t"


def shot_object(number: int, shot: MeasuredShot | RefusedShot) -> str:
    """Return the result of a shot as a JSON object on one line."""
    return json.dumps({"shot": number, **shot_document(shot)}, allow_nan=False)


class ShotTable:
    """A row for each measured shot and a sentence for each refused one.

    Every method raises `StoreError` where the temporary folder is full.
    """

    def __init__(self) -> None:
        self._files = ExitStack()
        self._rows = self._files.enter_context(Spool())
        self._refused = self._files.enter_context(Spool())
        self._headings = [heading.partition("\n") for heading in HEADINGS]
        self._widths = [max(len(name), len(unit)) for name, _, unit in self._headings]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._files.close()

    def add(self, number: int, shot: MeasuredShot | RefusedShot) -> None:
        """Append a shot."""
        if isinstance(shot, RefusedShot):
            place = "" if shot.frame is None else f", frame {shot.frame}"
            reason = " ".join(shot.reason.split())
            self._refused.add(f"shot {number} refused at {shot.step}{place}: {reason}")
            return
        cells = _cells(number, shot)
        self._widths = [max(w, len(cell)) for w, cell in zip(self._widths, cells, strict=True)]
        self._rows.add(_CELL.join(cells))

    def print(self, title: str) -> None:
        """Print all of it."""
        console = Console(highlight=False, markup=False, soft_wrap=True)
        console.print(title, style="italic")
        for part in (0, 2):
            console.print(self._line([heading[part] for heading in self._headings]), style="bold")
        for row in self._rows.lines():
            console.print(self._line(row.split(_CELL)))
        console.print(_CAPTION, style="dim")
        for sentence in self._refused.lines():
            console.print(sentence)

    def _line(self, cells: list[str]) -> str:
        return " ".join(cell.rjust(w) for cell, w in zip(cells, self._widths, strict=True))


def _cells(number: int, shot: MeasuredShot) -> list[str]:
    impact = shot.impact
    cells = (
        impact.contact_time.rescaled(1e3, "ms"),
        None if impact.duration is None else impact.duration.rescaled(1e6, "us"),
        *(impact.v_n, impact.v_s, impact.v_n_after, impact.v_s_after, impact.e, impact.beta),
    )
    return [str(number), *("" if cell is None else cell.concise() for cell in cells)]
