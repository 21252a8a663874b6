"""What a model page knows: the effects that were added, and the answers that came."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache

from analysis.model.verdict.standing import Standing, standing_of
from analysis.schema.verdict import VerdictReport
from rigctl.documents import Json
from rigctl.errors import RigError
from rigctl.jobs import ENDED, Job, JobState
from rigctl.page.model.source import Source
from rigctl.page.parts.waiting import cancelled_words

Effects = tuple[str, ...]
READ_KEPT = 8


@dataclass(slots=True)
class ModelState:
    """One operator's way through the model of one campaign.

    Attributes
    ----------
    source
        The shots.
    effects
        Added to the base model, in the order of adding.
    cell
        The cell of the heat map whose residuals are shown, as channel and covariate; None: the
        most striking one.
    concluded
        Verdict of the whole way, once it was gone.
    """

    source: Source
    effects: Effects = ()
    cell: tuple[str, str] | None = None
    failure: str = ""
    concluded: VerdictReport | None = None
    _answers: dict[Effects, Json] = field(default_factory=dict)
    _jobs: dict[Effects, str] = field(default_factory=dict)
    _asked: set[Effects] = field(default_factory=set)

    def stages(self) -> list[Effects]:
        """Return the way to the present effects, from the base model on."""
        return [self.effects[:count] for count in range(len(self.effects) + 1)]

    def path(self) -> list[Json]:
        """Return the answers of the stages that have one, in order."""
        return [self._answers[stage] for stage in self.stages() if stage in self._answers]

    @property
    def present(self) -> Json | None:
        """The answer with all present effects; None while it is computed."""
        return self._answers.get(self.effects)

    @property
    def standing(self) -> Standing | None:
        """What the latest fit on the way to the present effects leaves open; None before one."""
        known = self.path()
        return standing_of(known, self.concluded, self.trials()) if known else None

    def trials(self) -> dict[str, Json]:
        """Return the answers with one more effect than the present ones, by its name."""
        more = len(self.effects) + 1
        return {
            stage[-1]: answer
            for stage, answer in self._answers.items()
            if len(stage) == more and stage[:-1] == self.effects
        }

    def take(self, effects: Effects) -> None:
        """Go to other effects, and ask for whatever is not known on the way there."""
        self.effects, self.failure, self.cell = effects, "", None
        for stage in self.stages():
            if stage not in self._answers and stage not in self._jobs:
                try:
                    self._jobs[stage] = self.source.ask("picture", stage).id
                except RigError as error:
                    self.failure = error.sentence()
        self.follow()

    def ask_trial(self, effect: str) -> None:
        """Ask for the fit with one more effect, which is looked at and not yet added."""
        stage = (*self.effects, effect)
        self._asked.add(stage)
        if stage not in self._answers and stage not in self._jobs:
            with suppress(RigError):
                self._jobs[stage] = self.source.ask("picture", stage).id

    def tried(self, effect: str) -> Json | None:
        """Return the answer with one more effect; None while it is computed, or if it cannot be."""
        return self._answers.get((*self.effects, effect))

    def has_tried(self, effect: str) -> bool:
        """Say whether the fit with one more effect was asked for, whatever came of it."""
        return (*self.effects, effect) in self._asked

    def tries(self, effect: str) -> str:
        """Return the job that fits one more effect; empty while none does."""
        return self._jobs.get((*self.effects, effect), "")

    def follow(self) -> tuple[bool, bool]:
        """Fetch what has been answered since.

        Returns
        -------
        Whether the way to the present effects was answered, and whether a trial was: a page that
        draws its buttons anew for a trial loses a click that is under way.
        """
        ended = [
            (stage, job)
            for stage, name in self._jobs.items()
            if (job := self._job(name)) is None or job.state in ENDED
        ]
        for stage, job in ended:
            del self._jobs[stage]
            self._keep(stage, job)
        way = [stage in self.stages() for stage, _ in ended]
        return any(way), not all(way)

    def waits(self) -> Job | None:
        """Return the job that is waited for, as it stands."""
        running = [self._job(name) for stage, name in self._jobs.items() if stage in self.stages()]
        return next((job for job in running if job is not None), None)

    def _keep(self, stage: Effects, job: Job | None) -> None:
        if stage not in self.stages() and (job is None or job.state is not JobState.DONE):
            return
        if job is None:
            self.failure = "The answer was forgotten before it was read; ask again."
        elif job.state is JobState.DONE and job.result is not None:
            self._answers[stage] = _read(job.result)
        else:
            self.failure = job.failure or cancelled_words(job)

    def _job(self, name: str) -> Job | None:
        try:
            return self.source.daemon.jobs.job(name)
        except RigError:
            return None


@lru_cache(maxsize=READ_KEPT)
def _read(text: str) -> Json:
    """Return the answer of a job, read once for all pages that show it; nobody changes it."""
    document: Json = json.loads(text)
    return document


@dataclass(slots=True)
class Question:
    """One further question of a page, as a job: asked, followed, answered.

    Attributes
    ----------
    ask
        Starts it.
    daemon_job
        The job of an identifier.
    worded
        What a reader sees of a failure's sentence.
    answer, failure
        What came; none yet where it is None and empty.
    running
        Identifier of the job while it is under way.
    cancelled
        Whether somebody ended it.
    """

    ask: Callable[[], Job]
    daemon_job: Callable[[str], Job]
    worded: Callable[[str], str] = str
    answer: Json | None = None
    failure: str = ""
    running: str | None = None
    cancelled: bool = False

    def start(self) -> None:
        """Ask; a refusal is the failure."""
        self.answer, self.failure, self.cancelled = None, "", False
        try:
            self.running = self.ask().id
        except RigError as error:
            self.failure = error.sentence()

    def forget(self) -> None:
        """Ask no longer, and know nothing: what is under way is nobody's answer any more."""
        self.answer, self.failure, self.running = None, "", None

    def follow(self) -> bool:
        """Fetch the answer if it came; say whether anything ended."""
        if self.running is None:
            return False
        try:
            job = self.daemon_job(self.running)
        except RigError as error:
            self.running, self.failure = None, error.sentence()
            return True
        if job.state not in ENDED:
            return False
        self.running, self.cancelled = None, job.state is JobState.CANCELLED
        if job.state is JobState.DONE and job.result is not None:
            self.answer = json.loads(job.result)
        else:
            self.failure = self.worded(job.failure or cancelled_words(job))
        return True
