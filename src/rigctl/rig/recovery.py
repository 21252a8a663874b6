"""After a restart: what was under way is closed, and nothing is ever fired again."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from datetime import datetime
from itertools import takewhile

from rigctl.devices.roles import Trigger
from rigctl.errors import DeviceError
from rigctl.rig.standing import AFTER_STOP, Standing
from rigctl.rig.states import LATCHED, Fired, RigState, ShotState
from rigctl.rig.stopping.estop import EmergencyStop
from rigctl.rig.stopping.latch import Latch
from rigctl.store.catalogue import Change
from rigctl.store.records import JournalEntry, ShotRecord
from rigctl.store.states import RUNNING
from rigctl.store.store import Store

_log = logging.getLogger(__name__)

NOT_CLEAN = (
    "the last daemon left no mark of a clean end: it was killed or lost power, or a stop could "
    "not be written; look at the rig, then release it"
)

NOTES = 1000
"""So far back the audit is searched for a transition before the notes on a stop."""


@dataclass(frozen=True, slots=True)
class Recovery:
    """What a start found, by the names of the shots.

    Attributes
    ----------
    interrupted
        Ended by the last daemon's end: not fired, or fired without frames.
    unknown
        The fire command may have left; a person looks and releases the rig.
    completed
        Their frames were whole on disk, only the row was missing.
    to_analyse
        Handed to the analysis again.
    partial_removed
        Half-written files and folders that were removed.
    """

    interrupted: tuple[str, ...]
    unknown: tuple[str, ...]
    completed: tuple[str, ...]
    to_analyse: tuple[str, ...]
    partial_removed: int


def close_open_shots(store: Store, now: datetime) -> Recovery:
    """Give every shot that was under way its final state.

    Raises
    ------
    StoreError
        The store cannot be read or written.
    """
    removed = store.folders.remove_partial()
    closed = close_running(store, now, "the daemon ended")
    for shot in store.catalogue.in_states(frozenset({ShotState.ANALYSING})):
        store.move(shot.id, ShotState.STORED)
    waiting = store.catalogue.in_states(frozenset({ShotState.STORED}))

    def named(state: ShotState) -> tuple[str, ...]:
        return tuple(shot.id for shot in closed if shot.state is state)

    return Recovery(
        interrupted=named(ShotState.INTERRUPTED),
        unknown=named(ShotState.UNKNOWN_OUTCOME),
        completed=named(ShotState.STORED),
        to_analyse=tuple(shot.id for shot in waiting),
        partial_removed=removed,
    )


def close_running(store: Store, now: datetime, cause: str) -> list[ShotRecord]:
    """Give every shot that was under way its final state, while none is under way any more.

    Parameters
    ----------
    cause
        What kept the shot's own end from being recorded, for its `failure`.

    Raises
    ------
    StoreError
        The store cannot be read or written.
    """
    closed = [_close(store, shot, now, cause) for shot in store.catalogue.in_states(RUNNING)]
    store.settle()
    return closed


def start(
    store: Store,
    standing: Standing,
    stop: EmergencyStop,
    trigger: Trigger,
    now: datetime,
    *,
    clean: bool,
) -> Recovery:
    """Close open shots, enter the state the rig starts in, and bring its devices to safety.

    Power is given unless a person has to release the rig first. `clean` says that the last daemon
    left the mark of a clean end; a rig that has never run needs none.

    Raises
    ------
    StoreError
        The store cannot be read or written.
    """
    recovery = close_open_shots(store, now)
    steps, latch = _recent_steps(store), stop.latch
    last = RigState(steps[0].after) if steps else RigState.IDLE
    state = start_state(last, recovery, latched=latch is not None, clean=clean or not steps)
    reason, since = _cause(state, steps, latch, recovery)
    standing.last_shot(store.catalogue.last())
    standing.start(last, state, reason, since)
    acts = [trigger.make_safe]
    if state is RigState.ESTOP:
        acts.insert(0, lambda: stop.stop("rig", reason))
    elif state is RigState.IDLE:
        acts.append(stop.restore)
    try:
        for act in acts:
            act()
    except DeviceError as error:
        _log.exception("the rig starts without one of its devices: %s", error)
        if state is RigState.IDLE:
            standing.move(RigState.FAULT, "rig", str(error))
    return recovery


def _recent_steps(store: Store) -> list[JournalEntry]:
    """Return the rig's transitions, the last one first, without the notes that follow a stop."""
    last = store.journal.last()
    if last is None:
        return []
    recent = store.journal.entries(after=max(0, last.number - NOTES), limit=NOTES)
    return [entry for entry in reversed(recent) if entry.actor != AFTER_STOP] or [last]


def _cause(
    state: RigState, steps: list[JournalEntry], latch: Latch | None, recovery: Recovery
) -> tuple[str, datetime | None]:
    """Return why the rig starts in a state, and since when it is there; None: since this start."""
    if latch is not None:
        return latch.reason, datetime.fromisoformat(latch.at) if latch.at else None
    if state is RigState.UNKNOWN_OUTCOME and recovery.unknown:
        return f"whether shot {', '.join(recovery.unknown)} fired is not known", None
    if state in LATCHED and steps and steps[0].after == state:
        # Each start in between has written the same state once more.
        lasting = list(takewhile(lambda step: step.after == state, steps))
        return steps[0].reason, lasting[-1].at
    return NOT_CLEAN if state is RigState.ESTOP else "the daemon started", None


def start_state(last: RigState, recovery: Recovery, *, latched: bool, clean: bool) -> RigState:
    """Return the state in which the rig starts: what a person had to end, a restart does not."""
    if latched or last is RigState.ESTOP:
        return RigState.ESTOP
    if recovery.unknown:
        return RigState.UNKNOWN_OUTCOME
    if last in LATCHED:
        return last
    return RigState.IDLE if clean else RigState.ESTOP


def _close(store: Store, shot: ShotRecord, now: datetime, cause: str) -> ShotRecord:
    died = f"{cause} while the shot was"
    if shot.state is ShotState.ACCEPTED:
        change = Change(ended_at=now, failure=f"{died} being prepared; nothing was fired")
        return store.move(shot.id, ShotState.INTERRUPTED, change)
    if shot.state is ShotState.FIRING:
        why = f"{died} being fired; whether it fired is not known"
        change = Change(fired=Fired.UNKNOWN, ended_at=now, failure=why)
        return store.move(shot.id, ShotState.UNKNOWN_OUTCOME, change)
    if store.folders.is_whole(shot.id):
        frames = store.folders.frames(shot.id)
        change = Change(ended_at=now, frames=len(frames.pixels), lost=len(frames.lost))
        return store.move(shot.id, ShotState.STORED, change)
    change = Change(ended_at=now, failure=f"{died} being recorded; its frames are lost")
    return store.move(shot.id, ShotState.INTERRUPTED, change)
