"""Shots and idempotency keys: all shots, their states, and the request that made each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import Connection, bindparam, func, insert, select, update

from rigctl.errors import KeyReusedError, KeyRunningError, NotFoundError, StoreError
from rigctl.store.campaign_remarks import no_such_campaign
from rigctl.store.imports import require_own
from rigctl.store.integrity.ledger import note
from rigctl.store.records import NewShot, Request, ShotRecord
from rigctl.store.shot_rows import no_such_shot, one, records
from rigctl.store.sql.database import Database
from rigctl.store.sql.schema import idempotency_keys, results, shot_tags, shots
from rigctl.store.states import RUNNING, SHOT_TRANSITIONS, Fired, ShotState

_PAGE = 500
_STANDING = select(shots.c.number, shots.c.state, shots.c.outcome, shots.c.manifest).where(
    shots.c.id == bindparam("shot")
)


@dataclass(frozen=True, slots=True)
class Change:
    """What becomes known of a shot with its next state; None leaves a field as it is.

    `result` is the SHA-256 of the file of the result that `results` counts last.
    """

    fired: Fired | None = None
    fired_at: datetime | None = None
    ended_at: datetime | None = None
    frames: int | None = None
    lost: int | None = None
    failure: str | None = None
    failure_code: str | None = None
    results: int | None = None
    manifest: str | None = None
    result: str | None = None


class Catalogue:
    """Table of shots. Each method is one transaction; any thread may call any of them."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def accept(
        self,
        key: str,
        body_hash: str,
        describe: Callable[[], NewShot],
        keep: Callable[[ShotRecord, Request], object] = lambda shot, request: None,
    ) -> tuple[ShotRecord, bool]:
        """Claim an idempotency key and create its shot, both or neither.

        `describe` is called under the write lock and only when the key is free; what it raises
        leaves the key free, and so does what `keep` raises, which gets the shot before the claim
        is on disk. Returns the shot and whether it was there before.

        Raises
        ------
        KeyRunningError
            The key's shot has not ended.
        KeyReusedError
            The key was used with another body.
        RefusedError
            The campaign was imported.
        StoreError
            The claim is not on disk.
        """
        with self._database.writing() as connection:
            known = _claimed(connection, key, body_hash)
            if known is not None:
                return known, True
            new = describe()
            require_own(connection, new.campaign)
            number = connection.execute(select(func.max(shots.c.number))).scalar_one() or 0
            record = _created(connection, number + 1, new)
            row = {"key": key, "body_hash": body_hash, "shot": record.number}
            connection.execute(insert(idempotency_keys).values(row))
            note(connection, idempotency_keys, idempotency_keys.c.key == key)
            keep(record, Request(key, body_hash))
        return record, False

    def move(self, shot: str, to: ShotState, change: Change | None = None) -> ShotRecord:
        """Give a shot its next state and return the record once it is on disk.

        Raises
        ------
        NotFoundError
            There is no such shot.
        StoreError
            The table of states does not allow the move, or it is not on disk.
        """
        with self._database.writing() as connection:
            present = connection.execute(_STANDING, {"shot": shot}).one_or_none()
            if present is None:
                raise no_such_shot(shot)
            if to not in SHOT_TRANSITIONS[ShotState(present.state)]:
                raise StoreError(
                    f"a shot that is {present.state} cannot become {to}",
                    part=self._database.name,
                    shot=shot,
                )
            change = change or Change()
            known = {name: value for name, value in _columns(change) if value is not None}
            if known.pop("result", None) is not None:
                _add_result(connection, present.number, change)
            if to is ShotState.ANALYSING:
                # A failure of an earlier analysis is cleared.
                known |= {"failure": None, "failure_code": None}
            if present.manifest is not None:
                # What was stored first is what is to be found later.
                known.pop("manifest", None)
            if to not in RUNNING and present.outcome is None:
                known["outcome"] = to
            statement = update(shots).where(shots.c.id == shot).values(state=to, **known)
            (record,) = records(connection, statement.returning(shots))
            note(connection, shots, shots.c.number == record.number)
            return record

    def shot(self, shot: str) -> ShotRecord:
        """Return one shot; raise `NotFoundError` if there is none of that name."""
        with self._database.reading() as connection:
            return one(connection, shot)

    def numbered(self, number: int, campaign: str | None = None) -> ShotRecord:
        """Return the shot of a number; in a campaign, of the number its fits name it by.

        Raises
        ------
        NotFoundError
            There is none.
        """
        query = select(shots).where(shots.c.number == number)
        if campaign is not None:
            own = func.coalesce(shots.c.imported_as, shots.c.number)
            query = select(shots).where(shots.c.campaign == campaign, own == number)
        with self._database.reading() as connection:
            found = records(connection, query)
        if not found:
            part = None if campaign is None else f"campaign {campaign}"
            raise NotFoundError("no such shot", part=part, value=f"{number}", todo="list the shots")
        return found[0]

    def of_key(self, key: str) -> ShotRecord | None:
        """Return the shot that an idempotency key made; None while the key is free."""
        query = (
            select(shots)
            .join(idempotency_keys, idempotency_keys.c.shot == shots.c.number)
            .where(idempotency_keys.c.key == key)
        )
        with self._database.reading() as connection:
            return next(iter(records(connection, query)), None)

    def request(self, shot: ShotRecord) -> Request | None:
        """Return the request that made a shot; None where none did, as of an imported one."""
        query = select(idempotency_keys).where(idempotency_keys.c.shot == shot.number)
        with self._database.reading() as connection:
            row = connection.execute(query).first()
        return None if row is None else Request(row.key, row.body_hash)

    def stored(self, shot: str, manifest: str) -> None:
        """Note the digest of a manifest that was written once its shot had ended."""
        with self._database.writing() as connection:
            mine = (shots.c.id == shot, shots.c.manifest.is_(None))
            connection.execute(update(shots).where(*mine).values(manifest=manifest))
            note(connection, shots, shots.c.id == shot)

    def shots(
        self,
        *,
        campaign: str | None = None,
        state: ShotState | None = None,
        excluded: bool | None = None,
        tag: str | None = None,
        limit: int = 100,
        after: str | None = None,
    ) -> list[ShotRecord]:
        """Return up to `limit` shots, oldest first, that come later than the shot `after`.

        `excluded`: only those left out of every fit (True), or only those that count (False).
        """
        query = select(shots).order_by(shots.c.number).limit(limit)
        if campaign is not None:
            query = query.where(shots.c.campaign == campaign)
        if state is not None:
            query = query.where(shots.c.state == state)
        if excluded is not None:
            query = query.where(shots.c.excluded.is_not(None) == excluded)
        if tag is not None:
            query = query.join(shot_tags, shot_tags.c.shot == shots.c.number)
            query = query.where(shot_tags.c.tag == tag)
        with self._database.reading() as connection:
            if after is not None:
                query = query.where(shots.c.number > one(connection, after).number)
            return records(connection, query)

    def each(
        self,
        campaign: str | None = None,
        unreadable: Callable[[int, Exception], None] | None = None,
    ) -> Iterator[ShotRecord]:
        """Give every shot, or every one of a campaign, oldest first; few are held at any time.

        Each page is one transaction: a shot accepted meanwhile is given as well. `unreadable` is
        called with the number of a shot whose row is invalid, and the error; without it that is
        raised.
        """
        query = select(shots.c.number).order_by(shots.c.number).limit(_PAGE)
        if campaign is not None:
            query = query.where(shots.c.campaign == campaign)
        after = -(1 << 31)
        while True:
            with self._database.reading() as connection:
                numbers = connection.scalars(query.where(shots.c.number > after)).all()
            if not numbers:
                return
            yield from self._page(numbers, unreadable)
            after = numbers[-1]

    def _page(
        self, numbers: Sequence[int], unreadable: Callable[[int, Exception], None] | None
    ) -> list[ShotRecord]:
        """Return shots by their numbers; one by one where not all of them can be read."""
        query = select(shots).where(shots.c.number.in_(numbers)).order_by(shots.c.number)
        try:
            with self._database.reading() as connection:
                return records(connection, query)
        except (ValueError, StoreError) as error:
            if unreadable is None:
                raise
            if len(numbers) == 1:
                unreadable(numbers[0], error)
                return []
        return [shot for number in numbers for shot in self._page([number], unreadable)]

    def results(self, shot: ShotRecord) -> dict[int, str]:
        """Return the SHA-256 of each result's file by its number; of old ones none is known."""
        query = select(results.c.number, results.c.digest).where(results.c.shot == shot.number)
        with self._database.reading() as connection:
            return {row.number: row.digest for row in connection.execute(query)}

    def has(self, shot: str) -> bool:
        """Whether there is a shot of that name, even if its row is invalid."""
        query = select(shots.c.number).where(shots.c.id == shot)
        with self._database.reading() as connection:
            return connection.execute(query).first() is not None

    def count(self, campaign: str | None = None) -> int:
        """Return how many shots there are; raise `NotFoundError` if a campaign has none."""
        query = select(func.count()).select_from(shots)
        if campaign is not None:
            query = query.where(shots.c.campaign == campaign)
        with self._database.reading() as connection:
            found = int(connection.execute(query).scalar_one())
            if campaign is not None and not found:
                raise no_such_campaign(connection, campaign)
        return found

    def latest(self, limit: int, campaign: str | None = None) -> list[ShotRecord]:
        """Return up to `limit` shots, of one campaign or of all, the latest first."""
        query = select(shots).order_by(shots.c.number.desc()).limit(limit)
        if campaign is not None:
            query = query.where(shots.c.campaign == campaign)
        with self._database.reading() as connection:
            return records(connection, query)

    def last(self) -> ShotRecord | None:
        """Return the shot accepted last, or None."""
        query = select(shots).order_by(shots.c.number.desc()).limit(1)
        with self._database.reading() as connection:
            return next(iter(records(connection, query)), None)

    def in_states(self, states: frozenset[ShotState]) -> list[ShotRecord]:
        """Return every shot in one of these states, oldest first."""
        query = select(shots).where(shots.c.state.in_(states)).order_by(shots.c.number)
        with self._database.reading() as connection:
            return records(connection, query)


def _claimed(connection: Connection, key: str, body_hash: str) -> ShotRecord | None:
    query = (
        select(shots.c.id, idempotency_keys.c.body_hash)
        .join(idempotency_keys, idempotency_keys.c.shot == shots.c.number)
        .where(idempotency_keys.c.key == key)
    )
    row = connection.execute(query).one_or_none()
    if row is None:
        return None
    record = one(connection, row.id)
    if row.body_hash != body_hash:
        raise KeyReusedError(
            "the idempotency key was used with another body",
            value=repr(key),
            todo="take a fresh key for a fresh shot",
            shot=record.id,
        )
    if record.outcome is None:
        raise KeyRunningError(
            "the shot of this idempotency key has not ended",
            value=repr(key),
            todo="ask for the shot until it has ended",
            shot=record.id,
        )
    return record


def _add_result(connection: Connection, shot: int, change: Change) -> None:
    """Note a result's digest; what was stored first is what is to be found later."""
    row = {"shot": shot, "number": change.results}
    known = select(results).filter_by(**row)
    if connection.execute(known).one_or_none() is None:
        connection.execute(insert(results).values(**row, digest=change.result))
        note(connection, results, results.c.shot == shot, results.c.number == change.results)


def _created(connection: Connection, number: int, new: NewShot) -> ShotRecord:
    name = f"{new.accepted_at:%Y%m%d}-{number:06d}"
    connection.execute(
        insert(shots).values(
            number=number,
            id=name,
            state=ShotState.ACCEPTED,
            fired=Fired.NO,
            settings=new.settings.model_dump_json(),
            campaign=new.campaign,
            note=new.note,
            actor=new.actor,
            simulated=int(new.simulated),
            configuration=new.configuration,
            accepted_at=new.accepted_at.isoformat(),
        )
    )
    note(connection, shots, shots.c.number == number)
    return one(connection, name)


def _columns(change: Change) -> list[tuple[str, object]]:
    values = ((name, getattr(change, name)) for name in Change.__slots__)
    return [(name, v.isoformat() if isinstance(v, datetime) else v) for name, v in values]
