"""Puts what came of an analysis on disk, with patience where the disk does not take it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from rigctl.errors import RigError, StoreError
from rigctl.store import Change, ShotRecord, ShotState, Store

_log = logging.getLogger(__name__)

T = TypeVar("T")
Json = Mapping[str, Any]

AGAIN = "again"
"""Key of a result under which it names other shots to be analysed once more; it is not stored."""

WAITS_S = (1.0, 2.0, 5.0, 10.0, 20.0, 30.0)
"""Rests between attempts: room is made on a full disk in a minute, or it takes long."""
AGAIN_S = 30.0
"""Rest between attempts to write down how an analysis ended, once these are over."""


class Keeper:
    """Takes shots into `analysing` and out of it, for one thread.

    A failure is reported at once to the log, and to the store's listeners by the shot's record with
    the reason in `failure`. After the attempts a result is given up: a shot that was
    measured before stays as it was, any other is `refused`, each with the reason. If not even that
    can be written it is tried again until the daemon ends, and the next start takes the shot up
    again. Frames and earlier results stay as they are.

    Parameters
    ----------
    rest
        Waits so many seconds; returns whether the daemon ends.
    """

    def __init__(self, store: Store, rest: Callable[[float], bool]) -> None:
        self._store, self._rest = store, rest
        self._unwritten: dict[str, tuple[ShotState, Change]] = {}

    @property
    def idle_s(self) -> float | None:
        """How long to wait for the next shot before `try_again`, s; None: no end is unwritten."""
        return AGAIN_S if self._unwritten else None

    def begin(self, shot: str) -> ShotRecord | None:
        """Record on disk that a shot is being analysed.

        Returns
        -------
        The shot as it stood before; None where the disk does not take it and nothing has changed.

        Raises
        ------
        StoreError
            It is being analysed already.
        """
        self.try_again()
        before = self._store.shot(shot)
        if before.state is ShotState.ANALYSING:
            raise StoreError("it is being analysed already", shot=shot)
        try:
            self._patiently(before, lambda: self._store.move(shot, ShotState.ANALYSING))
        except StoreError:
            return None
        return before

    def keep(self, before: ShotRecord, result: Json) -> None:
        """Write a result beside the frames, then record it in the row.

        Parameters
        ----------
        before
            What `begin` returned.
        """
        folders = self._store.folders
        try:
            number = self._patiently(before, lambda: folders.add_result(before.id, result))
        except StoreError as error:
            why = f"its result could not be stored: {error.what}"
            todo = "free disk space, then have it analysed again"
            self.fail(before, RigError(why, part=error.part, todo=todo).sentence(), error.code)
            return
        change = Change(results=number)
        if result.get("status") == "refused":
            change = replace(change, failure=str(result.get("reason")), failure_code="refused")
            self._end(before, ShotState.REFUSED, change)
        else:
            self._end(before, ShotState.ANALYSED, change)

    def fail(self, before: ShotRecord, why: str, code: str) -> None:
        """Record in the row that an analysis failed; `before` as in `keep`."""
        measured = before.state is ShotState.ANALYSED
        state = ShotState.ANALYSED if measured else ShotState.REFUSED
        self._end(before, state, Change(failure=why, failure_code=code))

    def try_again(self) -> None:
        """Write the ends down that could not be written before."""
        for shot, (state, change) in list(self._unwritten.items()):
            try:
                self._store.move(shot, state, change)
            except RigError as error:
                _log.warning("shot %s: its state %s is not on disk: %s", shot, state, error)
            else:
                del self._unwritten[shot]

    def _end(self, before: ShotRecord, state: ShotState, change: Change) -> None:
        try:
            self._patiently(before, lambda: self._store.move(before.id, state, change))
        except StoreError:
            self._unwritten[before.id] = (state, change)

    def _patiently(self, before: ShotRecord, act: Callable[[], T]) -> T:
        """Do what writes to the disk; on failure again after each of `WAITS_S`.

        Raises
        ------
        StoreError
            The last attempt's, once all have failed or the daemon ends.
        """
        for wait_s in WAITS_S:
            try:
                return act()
            except StoreError as error:
                _log.warning("shot %s: tried again in %g s: %s", before.id, wait_s, error)
                why = f"what came of it is not on disk yet: {error.what}"
                todo = f"free disk space; it is tried again in {wait_s:g} s"
                sentence = RigError(why, part=error.part, todo=todo).sentence()
                self._store.listeners.notify(
                    replace(
                        before,
                        state=ShotState.ANALYSING,
                        failure=sentence,
                        failure_code=StoreError.code,
                    )
                )
                if self._rest(wait_s):
                    raise
        return act()
