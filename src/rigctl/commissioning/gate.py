"""What holds a rig back until every step was seen, and lets the steps' own acts through."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

from rigctl.commissioning.answers import NO, REWIRED, YES, Answer, Answers, day_of, marks_of
from rigctl.commissioning.step import Part, Step
from rigctl.commissioning.steps import steps_of
from rigctl.config import Configuration
from rigctl.errors import RefusedError
from rigctl.rig.clock import SYSTEM_CLOCK, Clock
from rigctl.rig.interlocks import Interlock
from rigctl.settings import ShotSettings

SOURCE = "commissioning"
TODO = "run `rigctl commission`, or open Commissioning on the rig's page"


@dataclass(frozen=True, slots=True)
class Standing:
    """A step and what is known of it: why it is asked for, empty once it was seen."""

    step: Step
    missing: str
    answer: Answer | None


class Gate:
    """The interlock `commissioning` of a real rig; a simulated one needs none.

    Parameters
    ----------
    configuration
        Its steps.
    answers
        What was said of them.
    firmware
        What each device says of its firmware, as far as it answers; by part.
    """

    def __init__(
        self,
        configuration: Configuration,
        answers: Answers,
        firmware: Callable[[], Mapping[str, str]],
        clock: Clock = SYSTEM_CLOCK,
    ) -> None:
        self._configuration, self._answers, self._clock = configuration, answers, clock
        self._ask_firmware, self._needed = firmware, configuration.simulation is None
        self._steps = steps_of(configuration)
        self._acting = threading.Lock()
        self._trial: ShotSettings | None = None
        # A device that is silent is taken for the one that was there last.
        self._firmware = dict(answers.entries[-1].firmware) if answers.entries else {}
        self._said: tuple[str, ...] = ()
        self._tell(self.standings())

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the rig refuses, for the operator; as last found."""
        return self._said

    def firmware(self) -> dict[str, str]:
        """Return what the devices say of their firmware, now or when they last answered."""
        self._firmware |= self._ask_firmware()
        return dict(self._firmware)

    def standings(self) -> tuple[Standing, ...]:
        """Return every step and whether it was seen as things are now."""
        firmware = self._firmware
        return tuple(self._standing(step, firmware) for step in self._steps)

    def missing(self) -> tuple[Standing, ...]:
        """Return the steps that are asked for, after a look at the firmware."""
        self.firmware()
        found = self.standings()
        self._tell(found)
        return tuple(each for each in found if each.missing)

    def interlock(self, settings: ShotSettings) -> Interlock | None:
        """Return the condition for a shot with these settings; None on a simulated rig."""
        if not self._needed:
            return None
        if self._trial == settings:
            return self._condition(True, "a step of it")
        missing = self.missing()
        return self._condition(not missing, _sentence(missing) if missing else "complete")

    @contextmanager
    def trial(self, settings: ShotSettings | None) -> Iterator[None]:
        """Let shots with exactly these settings through, for the act of one step.

        Raises
        ------
        RefusedError
            Another step is being done.
        """
        if not self._acting.acquire(blocking=False):
            raise RefusedError("another step is being done", todo="wait for its end")
        self._trial = settings
        try:
            yield
        finally:
            self._trial = None
            self._acting.release()

    def require_cut_off(self) -> None:
        """Refuse unless every step of the cut-off was seen: nothing real moves before.

        A simulated rig refuses nothing: a rehearsal has no hands at switches and cables.

        Raises
        ------
        RefusedError
            One was not.
        """
        if not self._needed:
            return
        for each in self.missing():
            if each.step.part is Part.CUT_OFF:
                raise RefusedError(
                    f"nothing moves before the cut-off was seen to work; {_sentence((each,))}",
                    todo="do the steps in their order",
                )

    def _standing(self, step: Step, firmware: Mapping[str, str]) -> Standing:
        answer: Answer | None = None
        missing = "never seen"
        for entry in self._answers.entries:
            if entry.answer == REWIRED and entry.about == step.part:
                missing = f"rewired on {day_of(entry)}: {entry.note}"
            elif entry.about == step.name and entry.answer in {YES, NO}:
                answer, missing = entry, ""
                if entry.answer == NO:
                    missing = f"not as it must be on {day_of(entry)}: {entry.note or 'no reason'}"
        if answer is not None and not missing:
            now = marks_of(step, self._configuration, firmware)
            named = dict.fromkeys((*now, *answer.marks))
            changed = [name for name in named if answer.marks.get(name) != now.get(name)]
            missing = f"changed since {day_of(answer)}: {', '.join(changed)}" if changed else ""
        return Standing(step, missing, answer)

    def _tell(self, found: tuple[Standing, ...]) -> None:
        missing = tuple(each for each in found if each.missing)
        told = self._needed and bool(missing)
        self._said = (f"the rig fires nothing: {_sentence(missing)}; {TODO}",) if told else ()

    def _condition(self, holds: bool, value: str) -> Interlock:
        now = self._clock.monotonic()
        return Interlock(SOURCE, holds, value, "every step seen", "", SOURCE, now, TODO)


def _sentence(missing: tuple[Standing, ...]) -> str:
    first = missing[0]
    text = f"step '{first.step.name}' ({first.step.title}) is {first.missing}"
    return text if len(missing) == 1 else f"{text}, and {len(missing) - 1} more are asked for"
