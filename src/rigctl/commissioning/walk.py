"""The walk through the steps: what is asked, what was answered, and the signed record of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from rigctl.commissioning.acts import Acts, Found
from rigctl.commissioning.answers import NO, REWIRED, YES, Answer, Answers, marks_of
from rigctl.commissioning.gate import Gate, Standing
from rigctl.commissioning.step import Part, Step
from rigctl.config import Configuration
from rigctl.errors import NotFoundError, RefusedError, SettingsError
from rigctl.firmware import source_digest
from rigctl.rig.clock import SYSTEM_CLOCK, Clock
from rigctl.rig.machine import Rig

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
