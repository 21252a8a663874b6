"""What a model page knows: the effects that were added, and the answers that came."""

from __future__ import annotations

import json
from collections.abc import Callable
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
Asked = tuple[Effects, Effects]
"""Effects that are fitted, and those by which it is judged which shots lie off: often the same."""


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
    _answers: dict[Asked, Json] = field(default_factory=dict)
    _jobs: dict[Asked, str] = field(default_factory=dict)
    _asked: set[Asked] = field(default_factory=set)

    def stages(self) -> list[Effects]:
        """Return the way to the present effects, from the base model on."""
        return [self.effects[:count] for count in range(len(self.effects) + 1)]

    def path(self) -> list[Json]:
        """Return the answers of the stages that have one, in order.

        With an effect some shots fit that were left out before. Once the present model is fitted,
        the stages before it are those of its shots: else their errors would not compare.
        """
        if self.present is None:
            return [self._own(stage) for stage in self.stages()[:-1] if self._has(stage)]
        return [self._beside(stage, self.effects) for stage in self.stages() if self._has(stage)]

    @property
    def present(self) -> Json | None:
        """The answer with all present effects; None while it is computed."""
        waits = any(self.effects == judged for _, judged in self._jobs)
        return None if waits or not self._has(self.effects) else self._own(self.effects)

    @property
    def standing(self) -> Standing | None:
        """What the latest fit on the way to the present effects leaves open; None before one."""
        known = self.path()
        return standing_of(known, self.concluded, self.trials()) if known else None

    def trials(self) -> dict[str, float]:
        """Return by which factor one more effect changes the error on unseen shots, by its name.

        Without it and with it the shots are the same; an effect of which that is not so, as the
        comparison failed or was cancelled, is left out.
        """
        more = len(self.effects) + 1
        tried = [
            stage
            for stage, judged in self._answers
            if stage == judged and len(stage) == more and stage[:-1] == self.effects
        ]
        pairs = {stage[-1]: self.tried(stage[-1]) for stage in tried}
        return {
            name: pair[1]["prediction_error"] / pair[0]["prediction_error"]
            for name, pair in pairs.items()
            if pair is not None and pair[0]["rejected"] == pair[1]["rejected"]
        }

    def take(self, effects: Effects) -> None:
        """Go to other effects, and ask for whatever is not known on the way there."""
        self.effects, self.failure, self.cell = effects, "", None
        for stage in self.stages():
            if failure := self._ask((stage, stage)):
                self.failure = failure
        self._ask_on_its_shots(self.effects)
        self.follow()

    def ask_trial(self, effect: str) -> None:
        """Ask for the fit with one more effect, which is looked at and not yet added."""
        stage = (*self.effects, effect)
        self._ask((stage, stage))
        self._ask_on_its_shots(stage)

    def tried(self, effect: str) -> tuple[Json, Json] | None:
        """Return the answers without one more effect and with it, both of the same shots.

        None while they are computed, or if they cannot be.
        """
        stage = (*self.effects, effect)
        if self.tries(effect) or not (self._has(stage) and self._has(self.effects)):
            return None
        return self._beside(self.effects, stage), self._own(stage)

    def has_tried(self, effect: str) -> bool:
        """Say whether the fit with one more effect was asked for, whatever came of it."""
        stage = (*self.effects, effect)
        return (stage, stage) in self._asked

    def tries(self, effect: str) -> str:
        """Return the job that fits one more effect; empty while none does."""
        stage = (*self.effects, effect)
        return self._jobs.get((stage, stage)) or self._jobs.get((self.effects, stage), "")

    def come_back(self) -> list[int]:
        """Return the shots that were left out before the last effect was added, and fit with it."""
        before = self.effects[:-1]
        if not self.effects or not (self._has(self.effects) and self._has(before)):
            return []
        return sorted(set(self._own(before)["rejected"]) - set(self._own(self.effects)["rejected"]))

    @property
    def is_of_the_same_shots(self) -> bool:
        """Whether before and after the last effect was added the shots are the same."""
        path = self.path()
        return len(path) < 2 or path[-2]["rejected"] == path[-1]["rejected"]

    def follow(self) -> tuple[bool, bool]:
        """Fetch what has been answered since.

        Returns
        -------
        Whether the way to the present effects was answered, and whether a trial was: a page that
        draws its buttons anew for a trial loses a click that is under way.
        """
        way: list[bool] = []
        # What is asked then may have been answered before.
        while ended := self._ended():
            for asked, job in ended:
                del self._jobs[asked]
                self._keep(asked, job)
            for judged in {self.effects, *(judged for (_, judged), _ in ended)}:
                self._ask_on_its_shots(judged)
            way += [self._is_on_the_way(asked) for asked, _ in ended]
        return any(way), not all(way)

    def waits(self) -> Job | None:
        """Return the job that is waited for, as it stands."""
        way = [name for asked, name in self._jobs.items() if self._is_on_the_way(asked)]
        running = [self._job(name) for name in way]
        return next((job for job in running if job is not None), None)

    def _ended(self) -> list[tuple[Asked, Job | None]]:
        """Return what has ended of that which was asked; None for a job that was forgotten."""
        jobs = [(asked, self._job(name)) for asked, name in self._jobs.items()]
        return [(asked, job) for asked, job in jobs if job is None or job.state in ENDED]

    def _has(self, stage: Effects) -> bool:
        return (stage, stage) in self._answers

    def _own(self, stage: Effects) -> Json:
        return self._answers[stage, stage]

    def _beside(self, stage: Effects, judged: Effects) -> Json:
        """Return a stage's answer of the shots of a further one, where these are others."""
        return self._answers.get((stage, judged), self._own(stage))

    def _is_on_the_way(self, asked: Asked) -> bool:
        stage, judged = asked
        return stage in self.stages() and judged in {stage, self.effects}

    def _ask(self, asked: Asked) -> str:
        """Ask unless it is known or asked already; return why it could not be."""
        self._asked.add(asked)
        if asked in self._answers or asked in self._jobs:
            return ""
        stage, judged = asked
        more = {} if judged == stage else {"shots_of": judged}
        try:
            self._jobs[asked] = self.source.ask("picture", stage, **more).id
        except RigError as error:
            return error.sentence()
        return ""

    def _ask_on_its_shots(self, judged: Effects) -> None:
        """Ask for the stages before one of its shots, once, where their own are others."""
        if not self._has(judged):
            return
        shots = self._own(judged)["rejected"]
        for stage in (judged[:count] for count in range(len(judged))):
            other = self._has(stage) and self._own(stage)["rejected"] != shots
            if other and (stage, judged) not in self._asked:
                self._ask((stage, judged))

    def _keep(self, asked: Asked, job: Job | None) -> None:
        done = job is not None and job.state is JobState.DONE
        # What is further known makes up for a trial, or for a comparison, that did not succeed.
        if not done and (asked[0] != asked[1] or not self._is_on_the_way(asked)):
            return
        if job is None:
            self.failure = "The answer was forgotten before it was read; ask again."
        elif done and job.result is not None:
            self._answers[asked] = _read(job.result)
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
