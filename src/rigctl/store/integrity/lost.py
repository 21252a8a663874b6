"""Refusals of a catalogue that is missing, or older than the shots beside it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from rigctl.errors import CatalogueLostError
from rigctl.store.folders import ShotFolders
from rigctl.store.orders import Orders

_DAY = re.compile(r"\d{8}")
_TODO = "restore the catalogue from a backup, or rebuild it from the folders with `rigctl recover`"


@dataclass(frozen=True, slots=True)
class OnDisk:
    """Shots below a store's folder, found without a catalogue.

    Attributes
    ----------
    shots, imports
        How many folders or orders of shots that were fired here, and of imported campaigns.
    first, last
        Days (YYYY-MM-DD) of the earliest and the latest shot fired; None without any.
    latest
        Number of the latest shot that has ended; 0 without any.
    """

    shots: int
    imports: int
    first: str | None
    last: str | None
    latest: int

    def words(self) -> str:
        """Return how many lie there and of what dates."""
        of = f" of {self.first} to {self.last}" if self.first else ""
        return f"{self.shots} shots{of} and {self.imports} imported campaigns"


def on_disk(root: Path) -> OnDisk:
    """Count the shots below a store's folder."""
    folders = ShotFolders(root)
    days = [day for day in folders.days() if _DAY.fullmatch(day.name)]
    ended = {path.name for day in days for path in day.iterdir() if path.name[0] != "."}
    open_ones = set(Orders(folders).all())
    dates = sorted({name[:8] for name in ended | open_ones if _DAY.match(name)})
    named = [f"{day[:4]}-{day[4:6]}-{day[6:8]}" for day in dates]
    numbers = (name.partition("-")[2] for name in ended)
    return OnDisk(
        shots=len(ended | open_ones),
        imports=len(folders.days()) - len(days),
        first=named[0] if named else None,
        last=named[-1] if named else None,
        latest=max((int(number) for number in numbers if number.isdecimal()), default=0),
    )


def require_no_shots(root: Path, catalogue: str) -> None:
    """Refuse to begin a catalogue beside shots of an earlier one.

    Raises
    ------
    CatalogueLostError
        There are some: their idempotency keys would be free again.
    """
    found = on_disk(root)
    if found.shots or found.imports:
        raise CatalogueLostError(
            f"the catalogue is missing or empty, and {found.words()} lie beside it",
            part=catalogue,
            todo=_TODO,
        )


def require_latest(root: Path, catalogue: str, latest: int) -> None:
    """Refuse a catalogue that lacks the latest shot on disk.

    Raises
    ------
    CatalogueLostError
        It is older than the shots: idempotency keys of those it lacks would be free again.
    """
    found = on_disk(root)
    if found.latest > latest:
        raise CatalogueLostError(
            f"the catalogue is older than the shots beside it: {found.words()}",
            part=catalogue,
            value=f"shot number {found.latest}",
            limit=f"shot number {latest}, the last that the catalogue knows",
            todo=_TODO,
        )
