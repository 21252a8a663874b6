"""Verify every row against ledger and manifest, and the ledger against its key and anchors."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from sqlalchemy import Connection, select

from rigctl.documents import Json
from rigctl.errors import StoreError
from rigctl.store.integrity.faults import Fault
from rigctl.store.integrity.ledger import GUARDED, START, Anchor, before, content_of, key_of
from rigctl.store.integrity.seal import FILE_NAME, Seal, read_seal
from rigctl.store.orders import order_document, outcome_document
from rigctl.store.reading import StoreReader
from rigctl.store.records import Request, ShotRecord
from rigctl.store.sql.schema import ledger
from rigctl.store.states import ShotState

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
