"""One shot from the accepted request to frames on disk, in the one order that is safe.

::

    recording confirmed -> interlocks re-read -> trigger armed -> intent on disk
        -> fire command, once -> mark -> outcome on disk -> frames -> folder, then row
        -> safe state, whatever happened
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any, Protocol

from analysis.setup import setup_document
from rigctl.cameras.capture import RecordingConfirmation
from rigctl.config import Configuration
from rigctl.devices.roles import FireOutcome, FireReceipt, OutcomeQuery
from rigctl.errors import DeviceAnswerError, DeviceError, RefusedError, RigError, StoreError
from rigctl.rig.conditions import Conditions
from rigctl.rig.interlocks import Interlock, require
from rigctl.rig.parts import Bench
from rigctl.rig.states import Fired, ShotState
from rigctl.rig.stopping.estop import EmergencyStop
from rigctl.store.catalogue import Change
from rigctl.store.records import ShotRecord

FORMAT = 2
"""2: the set-up is one table; manifests of format 1 are read as before."""


def manifest(
    shot: ShotRecord,
    configuration: Configuration,
    recording: RecordingConfirmation,
    receipt: FireReceipt | None,
    conditions: Iterable[Interlock],
) -> dict[str, Any]:
    """Return the manifest of a fired shot; every quantity has its unit in its name.

    The store adds the entry `frames`: digest, shape, times and lost pictures. Without a receipt
    the trigger confirmed the fire only when asked afterwards.
    """
    return {
        "format": FORMAT,
        "shot": shot.id,
        "number": shot.number,
        "campaign": shot.campaign,
        "note": shot.note,
        "accepted_at": shot.accepted_at.isoformat(),
        "fired_at": None if shot.fired_at is None else shot.fired_at.isoformat(),
        "settings": shot.ordered.model_dump(mode="json"),
        "simulated": shot.simulated,
        "program": {"name": "rigctl", "version": version("rigctl")},
        "configuration": {
            "name": configuration.name,
            "apparatus": configuration.apparatus,
            "sha256": configuration.digest,
        },
        "setup": setup_document(configuration.setup),
        "camera": configuration.camera.model_dump(mode="json"),
        "recording": {"by": recording.by, "evidence": recording.evidence},
        "trigger": None if receipt is None else _receipt(receipt),
        "interlocks": [_condition(condition) for condition in conditions],
    }


def _receipt(receipt: FireReceipt) -> dict[str, Any]:
    return {
        "sequence": receipt.sequence,
        "answer_time_s": receipt.confirmed_at - receipt.sent_at,
        "device_time_us": receipt.device_time_us,
    }


def _condition(condition: Interlock) -> dict[str, Any]:
    return {
        "name": condition.name,
        "value": condition.value,
        "limit": condition.limit,
        "unit": condition.unit,
        "source": condition.source,
    }


_log = logging.getLogger(__name__)


class Progress(Protocol):
    """The rig's side of a running shot: it alone changes states, under its lock."""

    def intend(self, shot: ShotRecord) -> ShotRecord:
        """Put the intent on disk; raise a `RigError` if that fails or the rig was stopped."""

    def confirm(self, shot: ShotRecord, change: Change) -> ShotRecord | None:
        """Put the confirmed fire on disk; None when a stop has overtaken it."""

    def end(self, shot: ShotRecord, state: ShotState, change: Change) -> StoreError | None:
        """Leave the shot in a final state, and the rig with it; say if that is not on disk."""


@dataclass(frozen=True, slots=True)
class _Ready:
    recording: RecordingConfirmation
    conditions: tuple[Interlock, ...]


class ShotRun:
    """Runs one shot in the thread that calls it; holds no lock while a device is waited for."""

    def __init__(
        self, bench: Bench, conditions: Conditions, stop: EmergencyStop, progress: Progress
    ) -> None:
        self._configuration, self._trigger = bench.configuration, bench.devices.trigger
        self._capture, self._store, self._clock = bench.capture, bench.store, bench.clock
        self._conditions, self._stop, self._progress = conditions, stop, progress

    def run(self, shot: ShotRecord) -> RigError | None:
        """Run the shot to its end and return the failure that makes the rig a FAULT, if any.

        Whatever goes wrong ends in a state of the shot and in the safe state of the devices.
        """
        failure: RigError | None = None
        try:
            failure = self._prepare_fire_collect(shot)
        finally:
            unsafe = self._make_safe()
            self._store.folders.room.give_back()
        return failure or unsafe

    def _prepare_fire_collect(self, shot: ShotRecord) -> RigError | None:
        try:
            ready = self._prepare(shot)
            shot = self._progress.intend(shot)
            if self._stop.latch is not None:
                raise RefusedError("stopped before the fire command left", shot=shot.id)
        except Exception as error:  # noqa: BLE001 - no driver's fault may leave a shot open
            return self._end(shot, ShotState.ABORTED, error, Fired.NO)
        receipt: FireReceipt | None = None
        sent_at = self._clock.monotonic()
        try:
            receipt = self._trigger.fire(shot.number)
        except DeviceAnswerError as error:
            self._end(shot, ShotState.MISFIRE, error, Fired.NO)
            return None
        except Exception as error:  # noqa: BLE001 - the byte may have left: nothing is assumed
            outcome = self._ask_what_happened(shot)
            if outcome is FireOutcome.NOT_FIRED:
                self._end(shot, ShotState.MISFIRE, error, Fired.NO)
                return None
            if outcome is FireOutcome.UNKNOWN:
                return self._end(shot, ShotState.UNKNOWN_OUTCOME, error, Fired.UNKNOWN)
        unmarked = self._mark(shot, sent_at if receipt is None else receipt.sent_at)
        return self._record(shot, ready, receipt, unmarked)

    def _mark(self, shot: ShotRecord, sent_at: float) -> Exception | None:
        """Mark the recording at once: what is written to disk first would make the mark late."""
        try:
            self._capture.mark(self._clock.monotonic() - sent_at)
        except Exception as error:  # noqa: BLE001 - that the rig fired must be written first
            _log.exception("shot %s: the recording could not be marked", shot.id)
            return error
        return None

    def _prepare(self, shot: ShotRecord) -> _Ready:
        recording = self._capture.start()
        conditions = self._conditions.all(shot.ordered, recording)
        require(conditions, shot.id)
        self._trigger.arm(shot.number, shot.ordered.delay_us)
        return _Ready(recording, conditions)

    def _ask_what_happened(self, shot: ShotRecord) -> FireOutcome:
        if not isinstance(self._trigger, OutcomeQuery):
            return FireOutcome.UNKNOWN
        try:
            return self._trigger.outcome(shot.number)
        except Exception:  # noqa: BLE001 - a query that fails answers: unknown
            _log.exception("shot %s: the trigger could not be asked", shot.id)
            return FireOutcome.UNKNOWN

    def _record(
        self,
        shot: ShotRecord,
        ready: _Ready,
        receipt: FireReceipt | None,
        unmarked: Exception | None,
    ) -> RigError | None:
        fired = Change(fired=Fired.YES, fired_at=self._clock.wall())
        try:
            confirmed = self._progress.confirm(shot, fired)
        except RigError as error:
            return self._end(shot, ShotState.UNKNOWN_OUTCOME, error, Fired.UNKNOWN)
        if confirmed is None:
            return None
        if unmarked is not None:
            return self._end(shot, ShotState.ABORTED, unmarked, Fired.YES)
        try:
            frames = self._capture.collect()
            document = manifest(
                confirmed, self._configuration, ready.recording, receipt, ready.conditions
            )
            ended_at = self._clock.wall()
            self._store.keep_frames(replace(confirmed, ended_at=ended_at), frames, document)
        except Exception as error:  # noqa: BLE001 - as above
            return self._end(shot, ShotState.ABORTED, error, Fired.YES)
        kept = Change(frames=len(frames.pixels), lost=len(frames.lost), ended_at=ended_at)
        return self._progress.end(shot, ShotState.STORED, kept)

    def _end(
        self, shot: ShotRecord, state: ShotState, error: Exception, fired: Fired
    ) -> RigError | None:
        _log.warning("shot %s: %s: %s", shot.id, state, error, exc_info=error)
        known = error if isinstance(error, RigError) else None
        change = Change(
            fired=fired,
            ended_at=self._clock.wall(),
            failure=str(error) if known else repr(error),
            failure_code=known.code if known else RigError.code,
        )
        unstored = self._progress.end(shot, state, change)
        if known is None:
            return RigError(f"shot {shot.id} met an error in the program: {error!r}")
        return known if isinstance(known, (DeviceError, StoreError)) else unstored

    def _make_safe(self) -> RigError | None:
        failure: RigError | None = None
        for part, act in (
            (self._capture.name, self._capture.stop),
            (self._trigger.name, self._trigger.make_safe),
        ):
            try:
                act()
            except Exception as error:  # noqa: BLE001 - the other part must be made safe too
                _log.exception("%s could not be made safe", part)
                failure = DeviceError(f"could not be made safe: {error}", part=part)
        return failure
