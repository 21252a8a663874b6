"""The walk through the steps: what is asked, what the daemon does for it, and the signed record."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any

from rigctl.commissioning.answers import NO, REWIRED, YES, Answer, Answers, marks_of
from rigctl.commissioning.gate import Gate, Standing
from rigctl.commissioning.step import Act, Part, Step
from rigctl.config import Configuration
from rigctl.errors import (
    NotFoundError,
    RecordingNotConfirmedError,
    RefusedError,
    RigError,
    SettingsError,
)
from rigctl.firmware import source_digest
from rigctl.rig.clock import SYSTEM_CLOCK, Clock
from rigctl.rig.machine import Rig
from rigctl.rig.states import LATCHED
from rigctl.settings import ShotSettings
from rigctl.store.records import ShotRecord
from rigctl.store.states import Fired, ShotState

FORMAT = 1


class Commissioning:
    """One rig's commissioning. Any thread may call; one act is done at a time."""

    def __init__(
        self,
        configuration: Configuration,
        rig: Rig,
        gate: Gate,
        answers: Answers,
        clock: Clock = SYSTEM_CLOCK,
    ) -> None:
        self._configuration, self._gate, self._answers = configuration, gate, answers
        self._acts, self._clock = Acts(rig, clock), clock
        self._found: dict[str, Found] = {}

    def standings(self) -> tuple[Standing, ...]:
        """Return every step, in order, and whether it is asked for."""
        self._gate.missing()
        return self._gate.standings()

    def found(self, step: str) -> Found | None:
        """Return what the daemon saw of a step's act since it was last answered."""
        return self._found.get(step)

    def act(self, name: str, actor: str) -> Found:
        """Do the act of a step and return what was seen of it.

        Raises
        ------
        NotFoundError
            There is no such step.
        RefusedError
            Another step is being done, or this one would move something and the cut-off has not
            been seen to work.
        """
        step = self._step(name)
        if step.may_move:
            self._gate.require_cut_off()
        with self._gate.trial(step.settings):
            self._found[name] = found = self._acts.perform(step, actor)
        return found

    def answer(
        self, name: str, *, seen: bool, people: Sequence[str], note: str, actor: str
    ) -> Standing:
        """Write down whether a step was as it must be, and return how it stands then.

        Raises
        ------
        NotFoundError
            There is no such step.
        SettingsError
            Nobody is named, or a no comes without what was seen.
        RefusedError
            A yes to what the daemon has not done, or not seen.
        StoreError
            It is not on disk.
        """
        step = self._step(name)
        _require_said(people, note, needed=not seen)
        found = self._found.get(name)
        if seen and step.act is not None and (found is None or not found.holds):
            why = (
                "has not been done"
                if found is None
                else f"was not seen by the daemon: {found.text}"
            )
            raise RefusedError(f"step '{name}' {why}", todo="do the step, or answer no")
        said = YES if seen else NO
        self._write(step, said, people=people, note=note, actor=actor)
        self._found.pop(name, None)
        return next(each for each in self.standings() if each.step.name == name)

    def rewired(self, part: str, *, people: Sequence[str], note: str, actor: str) -> None:
        """Ask for every step of a part again, after work on its wiring or its boards.

        Raises
        ------
        NotFoundError
            There is no such part.
        SettingsError
            Nobody is named, or not what was done.
        StoreError
            It is not on disk.
        """
        if part not in {each.step.part for each in self._gate.standings()}:
            raise NotFoundError(
                "is no part of this rig", part=part, limit=", ".join(Part), todo="name one of them"
            )
        _require_said(people, note, needed=True)
        self._write(part, REWIRED, people=people, note=note, actor=actor)
        self._gate.missing()

    def record(self) -> dict[str, Any]:
        """Return the signed record: steps, dates, people, hashes, and the signature of it all."""
        standings = self.standings()
        answers = [each.answer for each in standings if each.answer is not None]
        document: dict[str, Any] = {
            "format": FORMAT,
            "rig": self._configuration.name,
            "apparatus": self._configuration.apparatus,
            "simulated": self._configuration.simulation is not None,
            "at": self._clock.wall().isoformat(),
            "program": {"name": "rigctl", "version": version("rigctl")},
            "complete": not any(each.missing for each in standings),
            "people": sorted({name for answer in answers for name in answer.people}),
            "configuration_sha256": self._configuration.digest,
            "firmware": self._gate.firmware(),
            "firmware_source_sha256": source_digest(),
            "steps": [_entry(each) for each in standings],
        }
        return document | {"signature": self._answers.sign(document)}

    def _write(
        self, about: Step | str, answer: str, *, people: Sequence[str], note: str, actor: str
    ) -> None:
        step = about if isinstance(about, Step) else None
        name = about if isinstance(about, str) else about.name
        firmware = self._gate.firmware()
        found = self._found.get(name)
        self._answers.add(
            Answer(
                about=name,
                answer=answer,
                at=self._clock.wall().isoformat(),
                people=tuple(people),
                actor=actor,
                found="" if found is None else found.text,
                note=note,
                configuration=self._configuration.digest,
                firmware=firmware,
                marks={} if step is None else marks_of(step, self._configuration, firmware),
            )
        )

    def _step(self, name: str) -> Step:
        for each in self._gate.standings():
            if each.step.name == name:
                return each.step
        raise NotFoundError(
            "is no step of this rig's commissioning", part=name, todo="rigctl commission --list"
        )


def _entry(standing: Standing) -> dict[str, Any]:
    step, answer = standing.step, standing.answer
    shown = {"name": step.name, "part": step.part, "see": step.see, "missing": standing.missing}
    return shown | {"answer": None if answer is None else asdict(answer)}


def _require_said(people: Sequence[str], note: str, *, needed: bool) -> None:
    if not people or not all(name.strip() for name in people):
        raise SettingsError("is empty", part="people", todo="name the person who has looked")
    if needed and not note.strip():
        raise SettingsError("is empty", part="note", todo="say what was seen or done")


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
