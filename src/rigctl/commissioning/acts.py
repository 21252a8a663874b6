"""What the daemon does for a step, and what it saw of it."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from dataclasses import dataclass

from rigctl.commissioning.step import Act, Part, Step
from rigctl.errors import RecordingNotConfirmedError, RefusedError, RigError
from rigctl.rig.clock import Clock
from rigctl.rig.machine import Rig
from rigctl.rig.states import LATCHED
from rigctl.settings import ShotSettings
from rigctl.store.records import ShotRecord
from rigctl.store.states import Fired, ShotState

CAMPAIGN = "commissioning"
"""Of the shots that steps fire."""


@dataclass(frozen=True, slots=True)
class Found:
    """Whether the daemon saw what it must of its act, and what it saw."""

    holds: bool
    text: str


class Acts:
    """The acts of the steps, on a rig. The caller lets the rig arm for the step's settings."""

    def __init__(self, rig: Rig, clock: Clock) -> None:
        self._rig, self._clock = rig, clock
        self._acts: dict[Act, Callable[[Step, str], Found]] = {
            Act.RELEASE: self._release,
            Act.STOP: self._stop,
            Act.STOP_RELEASE: self._stop_release,
            Act.REFUSED: self._refused,
            Act.LATCHED: self._latched,
            Act.BACK: self._back,
            Act.SET: self._set,
            Act.SET_STOP: self._set_stop,
            Act.FIRE: self._fire,
            Act.UNRECORDED: self._unrecorded,
            Act.REST: self._rest,
        }

    def perform(self, step: Step, actor: str) -> Found:
        """Do a step's act; what the rig refuses or fails at is found, not raised."""
        if step.act is None:
            return Found(True, "")
        try:
            return self._acts[step.act](step, actor)
        except RigError as error:
            return Found(False, error.sentence())

    def _release(self, step: Step, actor: str) -> Found:
        self._release_latched(step, actor)
        return self._seen("")

    def _stop(self, step: Step, actor: str) -> Found:
        began = self._clock.monotonic()
        self._rig.estop(actor, _why(step))
        took_ms = 1e3 * (self._clock.monotonic() - began)
        return self._seen(f"cut and confirmed after {took_ms:.0f} ms; ")

    def _stop_release(self, step: Step, actor: str) -> Found:
        self._rig.estop(actor, _why(step))
        self._rig.release(actor, _why(step))
        return self._seen("")

    def _refused(self, step: Step, actor: str) -> Found:
        try:
            # Before the cut-off was seen nothing moves, not even to the lowest settings.
            self._rig.arm(_settings(step), actor, still=step.part is Part.CUT_OFF)
        except RigError as error:
            said = f"{error.sentence()} [{self._rig.status().reason}]"
            return Found(any(word in said for word in step.refused_by), f"refused: {said}")
        self._rig.disarm(actor, _why(step))
        return Found(False, "the rig armed: it did not see what was done")

    def _latched(self, step: Step, actor: str) -> Found:
        status = self._rig.status()
        why = status.latch_reason
        if why is None:
            return Found(False, f"the rig is {status.state} and has not stopped by itself")
        if not any(word in why for word in step.latched_by):
            return Found(False, f"the rig stopped for another reason: {why}")
        self._rig.release(actor, _why(step))
        return self._seen(f"stopped by itself: {why}; released; ")

    def _back(self, step: Step, actor: str) -> Found:
        self._release_latched(step, actor)
        return self._set(step, actor)

    def _set(self, step: Step, actor: str) -> Found:
        self._rig.arm(_settings(step), actor)
        read = self._rig.status().interlocks
        self._rig.disarm(actor, _why(step))
        return Found(True, "armed and disarmed; " + "; ".join(each.sentence() for each in read))

    def _set_stop(self, step: Step, actor: str) -> Found:
        armed = self._set(step, actor)
        return Found(armed.holds, f"{armed.text}; then: {self._stop(step, actor).text}")

    def _fire(self, step: Step, actor: str) -> Found:
        shot = self._shot(step, actor)
        seen = shot.fired is Fired.YES and shot.outcome is ShotState.STORED
        return Found(seen, _told(shot))

    def _unrecorded(self, step: Step, actor: str) -> Found:
        shot = self._shot(step, actor)
        code = RecordingNotConfirmedError.code
        return Found(shot.fired is Fired.NO and shot.failure_code == code, _told(shot))

    def _rest(self, step: Step, actor: str) -> Found:
        shot = self._shot(step, actor)
        ended = self._clock.monotonic()
        self._rig.arm(_settings(step), actor)
        waited_s = self._clock.monotonic() - ended
        self._rig.disarm(actor, _why(step))
        return Found(shot.fired is Fired.YES, f"{_told(shot)}; armed again after {waited_s:.1f} s")

    def _shot(self, step: Step, actor: str) -> ShotRecord:
        armed = self._rig.arm(_settings(step), actor)
        key = f"{CAMPAIGN}-{uuid.uuid4()}"
        return self._rig.fire(
            armed.token, key, step.name, campaign=CAMPAIGN, note=_why(step), actor=actor
        )

    def _release_latched(self, step: Step, actor: str) -> None:
        if self._rig.status().state in LATCHED:
            self._rig.release(actor, _why(step))

    def _seen(self, text: str) -> Found:
        return Found(True, f"{text}the rig is {self._rig.status().state}")


def _settings(step: Step) -> ShotSettings:
    if step.settings is None:
        raise RefusedError("the step has no settings to arm with", part=step.name)
    return step.settings


def _why(step: Step) -> str:
    return f"commissioning, step {step.name}"


def _told(shot: ShotRecord) -> str:
    frames = "" if shot.frames is None else f", {shot.frames} frames"
    failure = "" if shot.failure is None else f": {shot.failure}"
    return f"shot {shot.id}: {shot.outcome}, fired: {shot.fired}{frames}{failure}"
