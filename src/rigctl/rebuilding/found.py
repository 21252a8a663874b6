"""Contents of a store's folder, read without a catalogue."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from rigctl.errors import RigError
from rigctl.rebuilding import fired
from rigctl.rebuilding.fired import FiredShot
from rigctl.rebuilding.imported import ImportedCampaign, from_folder
from rigctl.store.folders import ShotFolders
from rigctl.store.orders import Orders

T = TypeVar("T")

_UNREADABLE = (RigError, OSError, ValueError, KeyError, TypeError, AttributeError)


@dataclass(slots=True)
class Found:
    """What lies in a store's folder."""

    shots: list[FiredShot] = field(default_factory=list)
    imports: list[ImportedCampaign] = field(default_factory=list)
    sweeps: list[dict[str, Any]] = field(default_factory=list)
    unreadable: list[str] = field(default_factory=list)


def look(root: Path) -> Found:
    """Read all that a catalogue can be built from; what cannot be read is named."""
    folders, found = ShotFolders(root), Found()
    orders = Orders(folders)
    for day in folders.days():
        if day.name.startswith("i"):
            _take(found, found.imports, day, from_folder)
            continue
        for name in fired.names(day):
            _take(found, found.shots, day / name, lambda path: _ended(folders, path))
    ended = {str(shot.row["id"]) for shot in found.shots}
    for name in sorted(set(orders.all()) - ended):
        _take(found, found.shots, Path(name), lambda path: fired.from_order(orders.read(path.name)))
    for path in sorted((root / "sweeps").glob("*.json")):
        _take(found, found.sweeps, path, lambda path: dict(json.loads(path.read_bytes())))
    found.shots.sort(key=lambda shot: shot.number)
    return found


def _ended(folders: ShotFolders, path: Path) -> FiredShot:
    return fired.from_manifest(folders, path.name)


def _take(found: Found, into: list[T], where: Path, read: Callable[[Path], T]) -> None:
    try:
        into.append(read(where))
    except _UNREADABLE as error:
        found.unreadable.append(f"{where}: {error}")
