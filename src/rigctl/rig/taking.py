"""Takes orders for shots: one key and one token for each, then its run, in a thread of its own."""

from __future__ import annotations

from collections.abc import Callable

from rigctl.errors import IdempotencyError, RigError, StoreError
from rigctl.rig.conditions import Conditions
from rigctl.rig.firing import ShotRun
from rigctl.rig.parts import Bench
from rigctl.rig.readiness import Readiness
from rigctl.rig.running import ACTOR, RunningShot
from rigctl.rig.standing import Standing
from rigctl.rig.states import RigState, ShotState
from rigctl.store.catalogue import Change
from rigctl.store.records import NewShot, ShotRecord


class Taking:
    """From an accepted order to the shot that is left behind, and to its analysis.

    Parameters
    ----------
    spawn, analyse
        As `machine.Rig`.
    """

    def __init__(
        self,
        bench: Bench,
        standing: Standing,
        readiness: Readiness,
        *,
        conditions: Conditions,
        running: RunningShot,
        run: ShotRun,
        spawn: Callable[[Callable[[], None]], None],
        analyse: Callable[[str], None],
    ) -> None:
        self._bench, self._standing, self._readiness = bench, standing, readiness
        self._conditions, self._running, self._run = conditions, running, run
        self._spawn, self._analyse = spawn, analyse

    def accept(
        self,
        token: str,
        key: str,
        body_hash: str,
        *,
        campaign: str | None,
        note: str | None,
        actor: str,
    ) -> ShotRecord:
        """Claim the key, spend the token, create the shot, start its run; as `Rig.accept`."""
        if not key.strip():
            raise IdempotencyError("the idempotency key is empty", todo="send a fresh key")
        configuration = self._bench.configuration

        def describe() -> NewShot:
            return NewShot(
                settings=self._readiness.take(token),
                campaign=campaign,
                note=note,
                actor=actor,
                simulated=configuration.simulation is not None,
                configuration=configuration.digest,
                accepted_at=self._bench.clock.wall(),
            )

        with self._standing.lock:
            self._readiness.withdraw_expired()
            try:
                shot, known = self._bench.store.accept(key, body_hash, describe)
            except StoreError:
                self._readiness.disarm(ACTOR, "the shot could not be stored")
                raise
            if known:
                return shot
            self._start(shot, actor)
        self._spawn(lambda: self._work(shot))
        return shot

    def _start(self, shot: ShotRecord, actor: str) -> None:
        self._standing.armed_for(shot.ordered)
        try:
            self._standing.move(RigState.FIRING, actor, "fire accepted", shot.id)
        except RigError as error:
            self._readiness.disarm(ACTOR, "the shot could not be started")
            change = Change(ended_at=self._bench.clock.wall(), failure=str(error))
            self._bench.store.move(shot.id, ShotState.ABORTED, change)
            raise
        self._running.begin(shot)

    def _work(self, shot: ShotRecord) -> None:
        failure: RigError | None = RigError("the run of the shot was torn down", shot=shot.id)
        try:
            failure = self._run.run(shot)
        finally:
            self._conditions.shot_ended()
            ended = self._running.finish(failure)
        if ended is not None and ended.state is ShotState.STORED:
            self._analyse(ended.id)
