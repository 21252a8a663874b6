"""From folders, read without a catalogue, to a catalogue: all of it in one transaction, or none."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

from sqlalchemy import ColumnElement, Connection, Table, insert, update

from rigctl.documents import Json
from rigctl.errors import CatalogueLostError, NotFoundError, RefusedError, RigError, StoreError
from rigctl.rebuilding import contents
from rigctl.rebuilding.contents import FiredShot, ImportedCampaign, from_folder
from rigctl.settings import ShotSettings
from rigctl.store.folders import ShotFolders
from rigctl.store.imports import add_rows
from rigctl.store.integrity import chain, ledger
from rigctl.store.integrity.seal import Seal, new_seal, read_seal
from rigctl.store.orders import Orders
from rigctl.store.ownership import owned
from rigctl.store.sql.database import Database
from rigctl.store.sql.opened import open_catalogue
from rigctl.store.sql.schema import (
    edits,
    idempotency_keys,
    imports,
    results,
    shots,
    sweep_steps,
    sweeps,
    transitions,
)
from rigctl.store.states import Fired, ShotState
from rigctl.store.sweep_states import StepState, SweepState

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
        for name in contents.names(day):
            _take(found, found.shots, day / name, lambda path: _ended(folders, path))
    ended = {str(shot.row["id"]) for shot in found.shots}
    for name in sorted(set(orders.all()) - ended):
        _take(
            found, found.shots, Path(name), lambda path: contents.from_order(orders.read(path.name))
        )
    for path in sorted((root / "sweeps").glob("*.json")):
        _take(found, found.sweeps, path, lambda path: dict(json.loads(path.read_bytes())))
    found.shots.sort(key=lambda shot: shot.number)
    return found


def _ended(folders: ShotFolders, path: Path) -> FiredShot:
    return contents.from_manifest(folders, path.name)


def _take(found: Found, into: list[T], where: Path, read: Callable[[Path], T]) -> None:
    try:
        into.append(read(where))
    except _UNREADABLE as error:
        found.unreadable.append(f"{where}: {error}")


Rows = list[dict[str, object]]

REASON = "the catalogue was rebuilt; start a further sweep for the steps that were not fired"
_NOTE = re.compile(r"sweep (?P<sweep>\S+), step (?P<step>\d+)")


def sweep_rows(document: Json, shots: Iterable[FiredShot], now: str) -> tuple[Json, Rows]:
    """Return the row of a sweep and those of its steps.

    A sweep that had not ended when the catalogue was lost is over: it is never resumed unseen.
    """
    steps: Rows = [
        {
            "sweep": document["number"],
            "number": number,
            "settings": ShotSettings.model_validate(settings).model_dump_json(),
            "state": StepState.SKIPPED,
            "attempt": 0,
        }
        for number, settings in enumerate(document["steps"], start=1)
    ]
    for shot in shots:
        match = _NOTE.fullmatch(str(shot.row["note"] or ""))
        own = str(shot.row["actor"]).startswith(f"sweep {document['id']} of ")
        if match and own and match["sweep"] == document["id"]:
            steps[int(match["step"]) - 1] |= _fired(shot)
    left = any(step["state"] is StepState.SKIPPED for step in steps)
    row = {name: document[name] for name in _COLUMNS} | {
        "id": document["id"],
        "state": SweepState.ABORTED if left else SweepState.COMPLETED,
        "reason": REASON if left else "no step waits any more",
        "ended_at": now,
    }
    return row, steps


_COLUMNS = (
    "number",
    "key",
    "body_hash",
    "form",
    "rules",
    "campaign",
    "actor",
    "accepted_at",
)


def _fired(shot: FiredShot) -> dict[str, object]:
    outcome, fired = shot.row["outcome"], shot.row["fired"]
    if outcome is ShotState.STORED:
        state = StepState.STORED
    elif fired is Fired.UNKNOWN:
        state = StepState.UNKNOWN
    else:
        state = StepState.LOST if fired is Fired.YES else StepState.NOT_FIRED
    return {
        "state": state,
        "attempt": 1,
        "key": None if shot.request is None else shot.request.key,
        "shot": shot.row["id"],
        "taken_at": shot.row["accepted_at"],
        "ended_at": shot.row["ended_at"],
        "failure": shot.row["failure"],
    }


ACTOR = "rigctl recover"


def fill(connection: Connection, seal: Seal, found: Found, at: datetime) -> None:
    """Add every row, in the open transaction of `connection`."""
    anchors = [shot.anchor for shot in found.shots if shot.anchor is not None]
    after = max(anchors, key=lambda anchor: anchor.entry, default=None)
    ledger.begin(connection, seal, after)
    connection.execution_options(seal=seal)
    _add(connection, shots, (shot.row for shot in found.shots))
    _add(connection, idempotency_keys, _keys(found.shots))
    _add(connection, results, _digests(found.shots))
    taken = {shot.number for shot in found.shots}
    for campaign in found.imports:
        first = _free(taken, len(campaign.shots))
        taken |= set(range(first, first + len(campaign.shots)))
        _add_import(connection, campaign, first)
    swept = [sweep_rows(document, found.shots, at.isoformat()) for document in found.sweeps]
    _add(connection, sweeps, (row for row, _ in swept))
    _add(connection, sweep_steps, (step for _, steps in swept for step in steps))
    _tell(connection, found, at)


def _add(
    connection: Connection,
    table: Table,
    rows: Iterable[dict[str, object]],
    *added: ColumnElement[bool],
) -> None:
    """Add rows to a table and the ledger; `added` selects them from the rows already there."""
    known = list(rows)
    names = {name for row in known for name in row}
    if known:
        # One statement for all: a column that one row lacks stays empty.
        connection.execute(insert(table), [dict.fromkeys(names) | row for row in known])
        ledger.note(connection, table, *added)


def _keys(found: Iterable[FiredShot]) -> Iterator[dict[str, object]]:
    for shot in found:
        if shot.request is not None:
            key, body_hash = shot.request.key, shot.request.body_hash
            yield {"key": key, "body_hash": body_hash, "shot": shot.number}


def _digests(found: Iterable[FiredShot]) -> Iterator[dict[str, object]]:
    for shot in found:
        for number, digest in shot.digests.items():
            yield {"shot": shot.number, "number": number, "digest": digest}


def _free(taken: set[int], count: int) -> int:
    """Return the first of so many numbers in a row that no shot has."""
    first = 1
    for number in sorted(taken):
        if number - first >= count:
            break
        first = number + 1
    return first


def _add_import(connection: Connection, campaign: ImportedCampaign, first: int) -> None:
    about = {"campaign": campaign.campaign, "actor": ACTOR, "accepted_at": campaign.at.isoformat()}
    add_rows(connection, campaign.stage, about, campaign.shots, first)
    row = {"number": campaign.stage.number, "campaign": campaign.campaign}
    own = imports.c.number == campaign.stage.number
    _add(connection, imports, [{**row, "digest": campaign.digest}], own)
    for number, later in enumerate(campaign.later, start=first):
        if later:
            rows = [{"shot": number, "number": n, "digest": later[n]} for n in later]
            _add(connection, results, rows, results.c.shot == number, results.c.number > 1)
            mine = shots.c.number == number
            connection.execute(update(shots).where(mine).values(results=max(later)))
            ledger.note(connection, shots, mine)


def _tell(connection: Connection, found: Found, at: datetime) -> None:
    """Write into the audits that the catalogue was rebuilt, and what a person has to look at."""
    summary = f"rebuilt: {len(found.shots)} shots, {len(found.imports)} imported campaigns"
    change: dict[str, object] = {
        "at": at.isoformat(),
        "actor": ACTOR,
        "act": "recovered",
        "subject": "catalogue",
        "before": None,
        "after": summary,
    }
    chain.append(connection, edits, change)
    last = found.shots[-1].row if found.shots else {}
    if last.get("outcome") is ShotState.UNKNOWN_OUTCOME:
        # Whether a person has looked since stood in the lost audit alone.
        step: dict[str, object] = {
            "at": at.isoformat(),
            "before": "idle",
            "after": str(ShotState.UNKNOWN_OUTCOME),
            "actor": ACTOR,
            "reason": f"whether shot {last['id']} fired is not known",
            "shot": last["id"],
        }
        chain.append(connection, transitions, step)


_BROKEN = ("malformed", "not a database")


@dataclass(slots=True)
class Rebuilt:
    """What a catalogue was rebuilt from.

    Attributes
    ----------
    shots, imports, sweeps
        How many are in it again; shots are those that were fired here.
    open
        Shots that had not ended: whether they fired is not known, and a person has to look.
    without_key
        Shots whose manifests are older than their idempotency keys: who repeats a request under
        one of these fires again.
    missing
        How many numbers of shots are not on disk: they ended without frames, before such ends
        were kept beside the shots.
    unreadable
        Folders and files that could not be read, each with why; they are not in the catalogue.
    kept
        Where the former catalogue was put; None: there was none.
    """

    shots: int = 0
    imports: int = 0
    sweeps: int = 0
    open: list[str] = field(default_factory=list)
    without_key: list[str] = field(default_factory=list)
    missing: int = 0
    unreadable: list[str] = field(default_factory=list)
    kept: str | None = None


def rebuild(root: Path, address: str | None, now: datetime | None = None) -> Rebuilt:
    """Build the catalogue of a store again that is lost, damaged or older than its shots.

    A damaged file is kept under another name. Nothing beside it is changed.

    Raises
    ------
    NotFoundError
        There is no shot to build it from.
    RefusedError
        The catalogue is whole.
    StoreError
        Another process owns the store, or the disk refuses; nothing has changed.
    """
    at = now or datetime.now(UTC)
    path = root / "catalogue.db"
    found = look(root)
    if not (found.shots or found.imports or found.unreadable):
        raise NotFoundError("holds no shots", part=str(root), todo="start `rigctl serve`")
    with owned(root):
        _require_lost(root, address)
        found = look(root)
        rebuilt = _summary(found)
        rebuilt.kept = None if address else _put_aside(path, at)

        def begin(connection: Connection, version: int) -> Seal:
            if version:
                raise StoreError(
                    "the catalogue on the server is there, and no file that could be put aside",
                    part="store.database",
                    todo="name an empty schema or database, then recover again",
                )
            seal = read_seal(root) or new_seal(root)
            fill(connection, seal, found, at)
            return seal

        Database(path, address=address, sealing=begin).close()
    return rebuilt


def _require_lost(root: Path, address: str | None) -> None:
    try:
        catalogue = open_catalogue(root, address, 5.0, migrate=True)
    except CatalogueLostError:
        return
    except StoreError as error:
        if any(word in error.what for word in _BROKEN):
            return
        raise
    try:
        whole = not catalogue.integrity()
    finally:
        catalogue.close()
    if whole:
        raise RefusedError(
            "the catalogue is whole and knows every shot",
            part=catalogue.name,
            todo="look with `rigctl verify`; nothing is to be recovered",
        )


def _put_aside(path: Path, at: datetime) -> str | None:
    """Rename the former catalogue with what SQLite keeps beside it; return its new name."""
    aside = path.with_name(f"{path.name}.lost-{at:%Y%m%dT%H%M%S}")
    for ending in ("-wal", "-shm", ""):
        part = path.with_name(path.name + ending)
        if part.exists():
            part.rename(aside.with_name(aside.name + ending))
    return str(aside) if aside.exists() else None


def _summary(found: Found) -> Rebuilt:
    last = max((shot.number for shot in found.shots), default=0)
    imported = sum(len(campaign.shots) for campaign in found.imports)
    return Rebuilt(
        shots=len(found.shots),
        imports=len(found.imports),
        sweeps=len(found.sweeps),
        open=[str(shot.row["id"]) for shot in found.shots if shot.row["outcome"] is None],
        without_key=[str(shot.row["id"]) for shot in found.shots if shot.request is None],
        missing=max(0, last - len(found.shots) - imported),
        unreadable=found.unreadable,
    )
