"""Whether a store still is what was stored: every digest, every chain, nothing missing.

Every row is held against ledger and manifest, and the ledger against its key and anchors.
"""

from __future__ import annotations

import hashlib
import json
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, select

from rigctl.documents import Json
from rigctl.errors import NotFoundError, RigError, StoreError
from rigctl.progress import Progress
from rigctl.store.folders import sha256
from rigctl.store.imports import LISTING
from rigctl.store.integrity.anchors import anchor_of
from rigctl.store.integrity.ledger import GUARDED, START, Anchor, before, content_of, key_of
from rigctl.store.integrity.seal import FILE_NAME, Seal, read_seal
from rigctl.store.orders import order_document, outcome_document
from rigctl.store.reading import StoreReader
from rigctl.store.records import Request, ShotRecord
from rigctl.store.sql.schema import ledger
from rigctl.store.states import ShotState


@dataclass(frozen=True, slots=True)
class Fault:
    """Something that is not as it was stored: which file or part, and what is wrong with it."""

    part: str
    what: str


_EDITED = frozenset({"note", "format"})
"""Fields that may be edited afterwards, or are not part of the shot."""


def verify_row(shot: ShotRecord, request: Request | None, manifest: Json) -> list[Fault]:
    """Compare a row with the manifest of its shot, as far as a manifest of its time goes."""
    part = f"shot {shot.id}"
    try:
        return [
            Fault(part, f"{name} is {row!r} in the catalogue and {stated!r} in the manifest")
            for name, row, stated in _pairs(shot, request, manifest)
            if row != stated
        ]
    except (AttributeError, KeyError, TypeError, IndexError) as error:
        return [Fault(part, f"its manifest cannot be compared with its row: {error!r}")]


def _pairs(
    shot: ShotRecord, request: Request | None, manifest: Json
) -> Iterator[tuple[str, object, object]]:
    """Give each field that both state: its name, the row's word, the manifest's word."""
    frames = manifest.get("frames")
    if frames and shot.outcome is not None:
        yield "frames", shot.frames, frames["shape"][0]
    if shot.imported_as is not None:
        yield "imported_as", shot.imported_as, manifest["number"]
        yield "campaign", shot.campaign, manifest["campaign"]
        return
    yield from _common("", order_document(shot, request), manifest)
    if shot.outcome is None:
        # The manifest comes first, then the row.
        return
    if "fired_at" in manifest:
        fired_at = None if shot.fired_at is None else shot.fired_at.isoformat()
        yield "fired_at", fired_at, manifest["fired_at"]
    if "outcome" not in manifest:
        return
    outcome = outcome_document(shot)
    if frames:
        yield "lost", shot.lost, len(frames["lost"])
        # Each analysis changes the state of a shot with frames.
        outcome = {name: outcome[name] for name in ("state", "fired")}
    yield from _common("", outcome, manifest["outcome"])
    if shot.outcome is not ShotState.STORED:
        yield "state", str(shot.state), manifest["outcome"]["state"]


def _common(prefix: str, row: Json, stated: Json) -> Iterator[tuple[str, object, object]]:
    for name in row.keys() & stated.keys() - _EDITED:
        if isinstance(row[name], dict):
            yield from _common(f"{name}.", row[name], stated[name])
        else:
            yield f"{prefix}{name}", row[name], stated[name]


Anchored = tuple[str, Anchor]
"""Who holds an anchor, and the anchor."""


@dataclass(slots=True)
class _Read:
    """The ledger, read to its end.

    Attributes
    ----------
    first, last
        The head before the first entry, and that of the last.
    heads
        Digests of the entries that anchors name.
    latest
        By table and row what was last written of it; None: that it is gone.
    """

    first: Anchor | None = None
    last: Anchor = field(default_factory=lambda: Anchor(0, START))
    heads: dict[int, str] = field(default_factory=dict)
    latest: defaultdict[str, dict[str, str | None]] = field(
        default_factory=lambda: defaultdict(dict)
    )
    faults: list[Fault] = field(default_factory=list)


def verify_ledger(
    store: StoreReader, manifests: Sequence[Anchored], kept: Sequence[Anchored]
) -> tuple[int, list[Fault]]:
    """Return how many rows were compared with the ledger, and what is wrong with any.

    Parameters
    ----------
    manifests, kept
        Heads in the shots' manifests, and heads that a user kept elsewhere.
    """
    anchors = [*manifests, *kept]
    try:
        seal = read_seal(store.folder)
        if seal is None:
            path = str(store.folder / FILE_NAME)
            return 0, [Fault(path, "is missing: no row can be compared with the audit")]
        with store.database.reading() as connection:
            read = _read(connection, seal, {anchor.entry for _, anchor in anchors})
            rows, faults = _verify_tables(connection, read)
    except (StoreError, ValueError) as error:
        return 0, [Fault(store.database.name, f"its rows cannot be read: {error}")]
    return rows, [*read.faults, *_verify_anchors(read, anchors), *_older(read, kept), *faults]


def _read(connection: Connection, seal: Seal, anchored: set[int]) -> _Read:
    read = _Read()
    for row in connection.execute(select(ledger).order_by(ledger.c.number)):
        if read.first is None:
            read.first = read.last = before(row)
        fits = row.number == read.last.entry + 1
        if not fits or row.digest != seal.digest(read.last.digest, tuple(row)[:-1]):
            what = "was altered, or the one before it was taken away"
            read.faults.append(Fault(f"ledger, entry {row.number}", what))
        read.last = Anchor(row.number, row.digest)
        if row.number in anchored:
            read.heads[row.number] = row.digest
        if row.about in GUARDED:
            read.latest[row.about][row.row] = row.content
    if read.first is None:
        read.faults.append(Fault("ledger", "has lost its entries"))
    else:
        read.heads[read.first.entry] = read.first.digest
    return read


def _verify_anchors(read: _Read, anchors: Sequence[Anchored]) -> Iterator[Fault]:
    first = 0 if read.first is None else read.first.entry
    for holder, anchor in anchors:
        if anchor.entry < first:
            # Written before the catalogue was rebuilt: its ledger is gone, its files are not.
            continue
        found = read.heads.get(anchor.entry)
        if found is None:
            what = f"ends at entry {read.last.entry}, before entry {anchor.entry} of {holder}"
            yield Fault("ledger", what)
        elif found != anchor.digest:
            yield Fault(f"ledger, entry {anchor.entry}", f"is not the one that {holder} names")


def _older(read: _Read, kept: Sequence[Anchored]) -> Iterator[Fault]:
    for holder, anchor in kept:
        if read.first is not None and anchor.entry < read.first.entry:
            what = f"names entry {anchor.entry}, from before the catalogue was rebuilt"
            yield Fault(holder, f"{what}: compare it with a backup of that time")


def _verify_tables(connection: Connection, read: _Read) -> tuple[int, list[Fault]]:
    rows, faults = 0, list[Fault]()
    for name, table in GUARDED.items():
        latest = read.latest[name]
        for row in connection.execute(select(table)):
            rows += 1
            key = key_of(table, row)
            known = latest.pop(key, None)
            if known != content_of(row):
                what = "was added by nobody" if known is None else "is not as it was last written"
                faults.append(Fault(f"{name} {key}", f"{what}: another program changed the row"))
        gone = (key for key, content in latest.items() if content is not None)
        faults += [Fault(f"{name} {key}", "is missing: its row was taken away") for key in gone]
    return rows, faults


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
