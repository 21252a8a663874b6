"""From rows of the catalogue to shots."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from pydantic import TypeAdapter
from sqlalchemy import Connection, Row, Select, select
from sqlalchemy.sql.dml import ReturningUpdate

from rigctl.errors import NotFoundError
from rigctl.settings import ShotSettings
from rigctl.store.records import ShotRecord
from rigctl.store.sql.schema import shot_tags, shots
from rigctl.store.states import Fired, ShotState

_SETTINGS: TypeAdapter[ShotSettings | None] = TypeAdapter(ShotSettings | None)


def records(connection: Connection, query: Select[Any] | ReturningUpdate[Any]) -> list[ShotRecord]:
    """Return the shots that a query of the table of shots finds, or changes, in its order."""
    rows = connection.execute(query).all()
    tags: dict[int, list[str]] = {}
    if rows:
        numbers = [row.number for row in rows]
        listed = select(shot_tags).where(shot_tags.c.shot.in_(numbers))
        for tagged in connection.execute(listed):
            tags.setdefault(tagged.shot, []).append(tagged.tag)
    return [_record(row, tuple(sorted(tags.get(row.number, ())))) for row in rows]


def one(connection: Connection, shot: str) -> ShotRecord:
    """Return one shot; raise `NotFoundError` if there is none of that name."""
    found = records(connection, select(shots).where(shots.c.id == shot))
    if not found:
        raise no_such_shot(shot)
    return found[0]


def no_such_shot(shot: str) -> NotFoundError:
    """Return the error of a name that is no shot's."""
    return NotFoundError("no such shot", value=repr(shot), todo="list the shots")


def _record(row: Row[Any], tags: tuple[str, ...]) -> ShotRecord:
    return ShotRecord(
        id=row.id,
        number=row.number,
        state=ShotState(row.state),
        outcome=None if row.outcome is None else ShotState(row.outcome),
        fired=Fired(row.fired),
        settings=_SETTINGS.validate_json(row.settings),
        campaign=row.campaign,
        note=row.note,
        actor=row.actor,
        simulated=bool(row.simulated),
        configuration=row.configuration,
        accepted_at=datetime.fromisoformat(row.accepted_at),
        fired_at=_moment(row.fired_at),
        ended_at=_moment(row.ended_at),
        frames=row.frames,
        lost=row.lost,
        failure=row.failure,
        failure_code=row.failure_code,
        results=row.results,
        excluded=row.excluded,
        tags=tags,
        imported_as=row.imported_as,
        manifest=row.manifest,
    )


def _moment(text: str | None) -> datetime | None:
    return None if text is None else datetime.fromisoformat(text)
