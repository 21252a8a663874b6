"""The durable table of sweeps and of their steps."""

from __future__ import annotations

import json
import secrets
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Row, func, insert, select, update

from rigctl.errors import KeyReusedError, NotFoundError, StoreError
from rigctl.settings import ShotSettings
from rigctl.store.durable import replace_synced
from rigctl.store.imports import require_own
from rigctl.store.integrity.ledger import note
from rigctl.store.sql.database import Database
from rigctl.store.sql.schema import sweep_steps, sweeps
from rigctl.store.sweep_records import NewSweep, StepRecord, SweepRecord
from rigctl.store.sweep_states import (
    STEP_TRANSITIONS,
    SWEEP_TRANSITIONS,
    StepState,
    SweepState,
)


class Sweeps:
    """Table of sweeps. Each method is one transaction; any thread may call any of them.

    Requests are kept below `root`/sweeps as well: with them a lost catalogue can be rebuilt.
    """

    def __init__(self, database: Database, root: Path) -> None:
        self._database, self._folder = database, root / "sweeps"

    def accept(
        self, key: str, body_hash: str, describe: Callable[[], NewSweep]
    ) -> tuple[SweepRecord, bool]:
        """Claim an idempotency key and create its sweep with every step, all or nothing.

        `describe` is called under the write lock and only when the key is free; what it raises
        leaves the key free. Returns the running sweep and whether it was there before.

        Raises
        ------
        KeyReusedError
            The key was used with another body.
        RefusedError
            The campaign was imported: none of its shots could be fired.
        StoreError
            The claim is not on disk.
        """
        with self._database.writing() as connection:
            known = connection.execute(select(sweeps).where(sweeps.c.key == key)).one_or_none()
            if known is not None:
                if known.body_hash != body_hash:
                    raise KeyReusedError(
                        "the idempotency key was used with another body",
                        value=repr(key),
                        todo="take a fresh key for a fresh sweep",
                    )
                return _sweep(connection, known), True
            new = describe()
            require_own(connection, new.campaign)
            number = (connection.execute(select(func.max(sweeps.c.number))).scalar_one() or 0) + 1
            connection.execute(insert(sweeps).values(_row(new, number, key, body_hash)))
            connection.execute(insert(sweep_steps), _steps(number, new.steps))
            note(connection, sweeps, sweeps.c.number == number)
            note(connection, sweep_steps, sweep_steps.c.sweep == number)
            self._keep(new, number, key, body_hash)
            return _one(connection, _name(new.accepted_at, number)), False

    def _keep(self, new: NewSweep, number: int, key: str, body_hash: str) -> None:
        row = _row(new, number, key, body_hash)
        steps = [settings.model_dump(mode="json") for settings in new.steps]
        path = self._folder / f"{row['id']}.json"
        try:
            replace_synced(path, json.dumps({**row, "steps": steps}).encode())
        except OSError as error:
            raise StoreError(
                f"the sweep cannot be written: {error.strerror}",
                part=str(path),
                todo="free or repair the disk, then start it again",
            ) from error

    def files(self) -> list[Path]:
        """Return the file of each sweep of the table, whether it is there or not."""
        with self._database.reading() as connection:
            names = connection.execute(select(sweeps.c.id).order_by(sweeps.c.number)).scalars()
            return [self._folder / f"{name}.json" for name in names]

    def sweep(self, sweep: str) -> SweepRecord:
        """Return one sweep; raise `NotFoundError` if there is none of that name."""
        with self._database.reading() as connection:
            return _one(connection, sweep)

    def sweeps(
        self, *, state: SweepState | None = None, limit: int = 100, before: str | None = None
    ) -> list[SweepRecord]:
        """Return up to `limit` sweeps, latest first, that were accepted before `before`."""
        query = select(sweeps).order_by(sweeps.c.number.desc()).limit(limit)
        if state is not None:
            query = query.where(sweeps.c.state == state)
        with self._database.reading() as connection:
            if before is not None:
                query = query.where(sweeps.c.number < _number(connection, before))
            return [_sweep(connection, row) for row in connection.execute(query).all()]

    def steps(self, sweep: str, state: StepState | None = None) -> list[StepRecord]:
        """Return the steps of a sweep in the order of firing; raise `NotFoundError` as `sweep`."""
        with self._database.reading() as connection:
            number = _number(connection, sweep)
            query = select(sweep_steps).where(sweep_steps.c.sweep == number)
            if state is not None:
                query = query.where(sweep_steps.c.state == state)
            return [_step(row) for row in connection.execute(query.order_by(sweep_steps.c.number))]

    def next_step(self, sweep: str) -> StepRecord | None:
        """Return the first step that waits, or None."""
        with self._database.reading() as connection:
            query = (
                select(sweep_steps)
                .where(
                    sweep_steps.c.sweep == _number(connection, sweep),
                    sweep_steps.c.state == StepState.WAITING,
                )
                .order_by(sweep_steps.c.number)
                .limit(1)
            )
            row = connection.execute(query).one_or_none()
        return None if row is None else _step(row)

    def move(self, sweep: str, to: SweepState, reason: str, at: datetime) -> SweepRecord:
        """Give a sweep its next state and return it once it is on disk.

        Where it is to run, steps of which certainly nothing flew wait again; where it has ended,
        the steps that still wait are skipped.

        Raises
        ------
        NotFoundError
            There is no such sweep.
        StoreError
            The table of states does not allow the move, or it is not on disk.
        """
        with self._database.writing() as connection:
            present = _one(connection, sweep)
            if to not in SWEEP_TRANSITIONS[present.state]:
                raise StoreError(
                    f"a sweep that is {present.state} cannot become {to}",
                    part=self._database.name,
                    value=sweep,
                )
            ended_at = None
            if to is SweepState.RUNNING:
                _turn(connection, present.number, StepState.NOT_FIRED, StepState.WAITING)
            elif to is not SweepState.PAUSED:
                ended_at = at.isoformat()
                _turn(connection, present.number, StepState.WAITING, StepState.SKIPPED)
            connection.execute(
                update(sweeps)
                .where(sweeps.c.number == present.number)
                .values(state=to, reason=reason, ended_at=ended_at)
            )
            note(connection, sweeps, sweeps.c.number == present.number)
            return _one(connection, sweep)

    def take(self, sweep: str, step: int, at: datetime) -> StepRecord:
        """Take a waiting step: the key of its next attempt is on disk when this returns.

        Raises
        ------
        StoreError
            The step does not wait, or it is not on disk.
        """
        with self._database.writing() as connection:
            number = _number(connection, sweep)
            present = _require_move(connection, number, step, StepState.TAKEN)
            values = {
                "state": StepState.TAKEN,
                "attempt": present.attempt + 1,
                # Random: a shot that somebody fires beforehand is never taken for the step's.
                "key": secrets.token_urlsafe(24),
                "shot": None,
                "taken_at": at.isoformat(),
                "ended_at": None,
                "failure": None,
            }
            return _changed(connection, number, step, values)

    def end(
        self,
        sweep: str,
        step: int,
        to: StepState,
        at: datetime,
        *,
        shot: str | None = None,
        failure: str | None = None,
    ) -> StepRecord:
        """Record the outcome of a taken step.

        Raises
        ------
        StoreError
            The step is not taken, or it is not on disk.
        """
        with self._database.writing() as connection:
            number = _number(connection, sweep)
            _require_move(connection, number, step, to)
            values = {"state": to, "shot": shot, "ended_at": at.isoformat(), "failure": failure}
            return _changed(connection, number, step, values)


def _name(accepted_at: datetime, number: int) -> str:
    return f"{accepted_at:%Y%m%d}-s{number:04d}"


def _row(new: NewSweep, number: int, key: str, body_hash: str) -> dict[str, object]:
    return {
        "number": number,
        "id": _name(new.accepted_at, number),
        "key": key,
        "body_hash": body_hash,
        "state": SweepState.RUNNING,
        "reason": "accepted",
        "form": new.form,
        "rules": new.rules,
        "campaign": new.campaign,
        "actor": new.actor,
        "accepted_at": new.accepted_at.isoformat(),
    }


def _steps(sweep: int, settings: tuple[ShotSettings, ...]) -> list[dict[str, object]]:
    return [
        {
            "sweep": sweep,
            "number": number,
            "settings": each.model_dump_json(),
            "state": StepState.WAITING,
            "attempt": 0,
        }
        for number, each in enumerate(settings, start=1)
    ]


def _turn(connection: Connection, sweep: int, before: StepState, after: StepState) -> None:
    standing = (sweep_steps.c.sweep == sweep, sweep_steps.c.state == before)
    turned = update(sweep_steps).where(*standing).values(state=after)
    numbers = connection.scalars(turned.returning(sweep_steps.c.number)).all()
    if numbers:
        # Steps fall in few runs of numbers, and a statement takes only so many of them.
        first, last = min(numbers), max(numbers)
        mine = (sweep_steps.c.sweep == sweep, sweep_steps.c.number.between(first, last))
        note(connection, sweep_steps, *mine, sweep_steps.c.state == after)


def _require_move(connection: Connection, sweep: int, step: int, to: StepState) -> StepRecord:
    present = _one_step(connection, sweep, step)
    if to not in STEP_TRANSITIONS[present.state]:
        raise StoreError(
            f"a step that is {present.state} cannot become {to}", part=f"step {step} of a sweep"
        )
    return present


def _changed(connection: Connection, sweep: int, step: int, values: dict[str, Any]) -> StepRecord:
    connection.execute(
        update(sweep_steps)
        .where(sweep_steps.c.sweep == sweep, sweep_steps.c.number == step)
        .values(values)
    )
    note(connection, sweep_steps, sweep_steps.c.sweep == sweep, sweep_steps.c.number == step)
    return _one_step(connection, sweep, step)


def _one(connection: Connection, sweep: str) -> SweepRecord:
    number = _number(connection, sweep)
    return _sweep(
        connection, connection.execute(select(sweeps).where(sweeps.c.number == number)).one()
    )


def _number(connection: Connection, sweep: str) -> int:
    query = select(sweeps.c.number).where(sweeps.c.id == sweep)
    number: int | None = connection.execute(query).scalar_one_or_none()
    if number is None:
        raise NotFoundError("no such sweep", value=repr(sweep), todo="list the sweeps")
    return number


def _sweep(connection: Connection, row: Row[Any]) -> SweepRecord:
    query = (
        select(sweep_steps.c.state, func.count())
        .where(sweep_steps.c.sweep == row.number)
        .group_by(sweep_steps.c.state)
    )
    counts = {StepState(state): count for state, count in connection.execute(query)}
    return SweepRecord(
        id=row.id,
        number=row.number,
        state=SweepState(row.state),
        reason=row.reason,
        form=row.form,
        rules=row.rules,
        campaign=row.campaign,
        actor=row.actor,
        accepted_at=datetime.fromisoformat(row.accepted_at),
        ended_at=_moment(row.ended_at),
        counts=counts,
    )


def _one_step(connection: Connection, sweep: int, step: int) -> StepRecord:
    query = select(sweep_steps).where(sweep_steps.c.sweep == sweep, sweep_steps.c.number == step)
    row = connection.execute(query).one_or_none()
    if row is None:
        raise NotFoundError("no such step", value=f"{step}", todo="list the sweep's steps")
    return _step(row)


def _step(row: Row[Any]) -> StepRecord:
    return StepRecord(
        number=row.number,
        settings=ShotSettings.model_validate_json(row.settings),
        state=StepState(row.state),
        attempt=row.attempt,
        key=row.key,
        shot=row.shot,
        taken_at=_moment(row.taken_at),
        ended_at=_moment(row.ended_at),
        failure=row.failure,
    )


def _moment(text: str | None) -> datetime | None:
    return None if text is None else datetime.fromisoformat(text)
