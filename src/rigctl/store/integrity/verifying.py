"""Whether a store still is what was stored: every digest, every chain, nothing missing."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rigctl.errors import NotFoundError, RigError, StoreError
from rigctl.progress import Progress
from rigctl.store.folders import sha256
from rigctl.store.imports import LISTING
from rigctl.store.integrity.anchors import anchor_of
from rigctl.store.integrity.faults import Fault
from rigctl.store.integrity.verify_ledger import Anchored, verify_ledger, verify_row
from rigctl.store.reading import StoreReader
from rigctl.store.records import ShotRecord
from rigctl.store.states import ShotState


@dataclass(frozen=True, slots=True)
class Verified:
    """What was looked at, and all that is wrong with it.

    Attributes
    ----------
    shots, files, entries
        How many were looked at; entries are those of the two audits.
    unchecked
        How many results are of a time when no digest was noted: they were read, not compared.
    rows
        How many rows of the catalogue were compared with the ledger.
    """

    shots: int
    files: int
    entries: int
    faults: tuple[Fault, ...]
    unchecked: int = 0
    rows: int = 0


@dataclass(slots=True)
class _Found:
    """What was looked at so far."""

    shots: int = 0
    files: int = 0
    unchecked: int = 0
    known: set[str] = field(default_factory=set)
    faults: list[Fault] = field(default_factory=list)
    anchors: list[Anchored] = field(default_factory=list)


def verify_store(
    store: StoreReader,
    progress: Progress,
    campaign: str | None = None,
    anchors: Sequence[Anchored] = (),
) -> Verified:
    """Compare every file with its digest, every row with manifest and ledger, every audit.

    It may run while shots are fired: what is stored meanwhile is not looked at.

    Parameters
    ----------
    campaign
        Only its shots; None: all of them, and whether the folder holds anything else.
    anchors
        Heads of the ledger that were kept elsewhere, each with where.

    Raises
    ------
    NotFoundError
        There is no such campaign.
    StoreError
        The catalogue cannot be read.
    """
    found = _Found()
    total = store.catalogue.count(campaign)
    for shot in store.catalogue.each(campaign, unreadable=_named(found.faults)):
        progress(f"shot {shot.id}", found.shots / max(total, 1))
        found.shots += 1
        _verify_shot(store, shot, found)
    for number, name in store.imports.numbers().items():
        if campaign is None or campaign == name:
            looked_at, wrong = _verify_import(store, name)
            found.files += looked_at
            found.faults += wrong
            found.known.add(store.imports.folder(number).name)
    if campaign is None:
        found.faults += _strangers(store, found.known)
        found.faults += [Fault(store.database.name, what) for what in store.database.integrity()]
    entries = 0
    for audit in (store.journal, store.edits):
        try:
            entries += audit.verify()
        except StoreError as error:
            found.faults.append(Fault(str(error.part), f"{error.what} (found {error.value})"))
    rows, wrong = verify_ledger(store, found.anchors, anchors)
    faults = (*found.faults, *wrong)
    return Verified(found.shots, found.files, entries, faults, found.unchecked, rows)


def _named(faults: list[Fault]) -> Callable[[int, Exception], None]:
    """Return what makes a fault of a row that cannot be read."""

    def name(number: int, error: Exception) -> None:
        faults.append(Fault(f"shots [{number}]", f"its row cannot be read: {error}"))

    return name


def _verify_shot(store: StoreReader, shot: ShotRecord, found: _Found) -> None:
    found.known.add(shot.id)
    try:
        store.folders.folder(shot.id)
    except NotFoundError:
        found.faults.append(Fault(f"shots [{shot.number}]", f"its name {shot.id!r} is no shot's"))
        return
    looked_at, wrong = _verify_frames(store, shot)
    found.files += looked_at
    found.faults += wrong
    looked_at, without, wrong = _verify_results(store, shot)
    found.files += looked_at
    found.unchecked += without
    found.faults += wrong
    try:
        manifest = store.folders.manifest(shot.id)
    except RigError:
        return
    found.faults += verify_row(shot, store.catalogue.request(shot), manifest)
    if (anchor := anchor_of(manifest)) is not None:
        found.anchors.append((f"the manifest of shot {shot.id}", anchor))


def _verify_frames(store: StoreReader, shot: ShotRecord) -> tuple[int, list[Fault]]:
    """Return how many files of a shot were looked at, and what is wrong with them."""
    if shot.manifest is None and shot.frames is None:
        return 0, []
    folder, faults, files = store.folders.folder(shot.id), list[Fault](), 1
    digest = store.folders.digest(shot.id)
    if digest is None or (shot.manifest is not None and digest != shot.manifest):
        what = "is missing" if digest is None else "is not the one that was stored"
        return 1, [Fault(str(folder / "manifest.json"), what)]
    if shot.frames is not None:
        files += 1
        try:
            about = store.folders.manifest(shot.id)["frames"]
            if sha256(folder / about["file"]) != about["sha256"]:
                faults.append(Fault(str(folder / about["file"]), "are not the frames recorded"))
        except (RigError, OSError, KeyError, TypeError) as error:
            faults.append(Fault(str(folder), f"its frames cannot be read: {error}"))
    return files, faults


def _verify_results(store: StoreReader, shot: ShotRecord) -> tuple[int, int, list[Fault]]:
    """Return how many results a shot has, how many of them without a digest, and what is wrong."""
    folder = store.folders.folder(shot.id)
    there, digests = store.folders.results(shot.id), store.catalogue.results(shot)
    missing = digests.keys() - there.keys()
    faults = [Fault(str(folder / f"result-{n:04d}.json"), "is missing") for n in sorted(missing)]
    if len(there) + len(missing) < shot.results:
        faults.append(Fault(str(folder), f"holds {len(there)} results of {shot.results}"))
    ended = shot.state in {ShotState.ANALYSED, ShotState.REFUSED}
    for number, path in there.items():
        if number > shot.results and ended and store.catalogue.shot(shot.id) == shot:
            faults.append(Fault(str(path), "is a result that the catalogue does not know"))
        try:
            content = path.read_bytes()
            json.loads(content)
        except (OSError, ValueError) as error:
            faults.append(Fault(str(path), f"cannot be read: {error}"))
            continue
        if number in digests and hashlib.sha256(content).hexdigest() != digests[number]:
            faults.append(Fault(str(path), "is not the result that was stored"))
    return len(there), len(there.keys() - digests.keys()), faults


def _verify_import(store: StoreReader, campaign: str) -> tuple[int, list[Fault]]:
    home, digest = store.imports.of(campaign)
    listing = home / LISTING
    try:
        if sha256(listing) != digest:
            return 1, [Fault(str(listing), "is not the one that was stored")]
        files: dict[str, dict[str, Any]] = json.loads(listing.read_bytes())["files"]
    except OSError as error:
        return 1, [Fault(str(listing), f"cannot be read: {error.strerror}")]
    faults = [
        Fault(str(home / about["kept"]), "is not the file that was imported")
        for about in files.values()
        if not _holds(home / about["kept"], about["sha256"])
    ]
    return len(files) + 1, faults


def _holds(path: Path, digest: str) -> bool:
    try:
        return sha256(path) == digest
    except OSError:
        return False


def _strangers(store: StoreReader, known: set[str]) -> Iterator[Fault]:
    """Give the folders that belong to no shot and to no import."""
    for day in store.folders.days():
        if day.name.startswith("i"):
            if day.name not in known:
                yield Fault(str(day), "belongs to no campaign: an import was cut short")
            continue
        for folder in sorted(day.iterdir()):
            if folder.name in known or folder.name.startswith("."):
                continue
            if not store.catalogue.has(folder.name):
                yield Fault(str(folder), "belongs to no shot of the catalogue")
