"""A law that no catalogue holds: asked for beside `unexplained`, and one click from a sweep.

Once its shots are fired, the same place tests the one form on them; several campaigns are asked
there for what they share. Its sentences have signs, buttons for options and plain names.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import partial

from nicegui import ui

from analysis.model.proposals.words import (
    confirmation_sentence,
    proposal_sentences,
    together_sentences,
)
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.jobs import Job
from rigctl.measuring.measured import others
from rigctl.page.model.source import Source
from rigctl.page.model.state import ModelState, Question
from rigctl.page.model.story.words import COVARIATES
from rigctl.page.parts.tables import RAISED
from rigctl.page.parts.widgets import button
from rigctl.page.sweeps.form import form_address
from rigctl.sweeps.form import Sweep


class ProposedLaw:
    """The button that asks for a law, and what came of it; `refresh` draws the place anew.

    `worded` puts a sentence into the words of the view.
    """

    def __init__(
        self, state: ModelState, refresh: Callable[[], object], worded: Callable[[str], str]
    ) -> None:
        self._state, self._refresh, self._worded = state, refresh, worded
        self._form: Json = {}
        self._beside: list[str] = []
        job = state.source.daemon.jobs.job
        plain = state.source.without_its_folder
        self._asked = Question(self._ask, job, plain)
        self._tested = Question(lambda: self._ask(confirm=self._form), job, plain)
        self._shared = Question(self._ask_together, job, plain)

    @property
    def running(self) -> str:
        """The job that looks for a law or tests one; empty while none does."""
        questions = (self._asked, self._tested, self._shared)
        return next((one.running for one in questions if one.running), "")

    def follow(self) -> bool:
        """Fetch the answers that came; say whether anything ended."""
        ended = [one.follow() for one in (self._asked, self._tested, self._shared)]
        return any(ended)

    def show(self) -> None:
        """Place the buttons, or the answers."""
        if not self.running and self._asked.answer is None:
            placed = button("Propose a law", self._start, testid="propose")
            placed.tooltip("tries what depends on what, with an error rate that holds")
        if self._asked.failure:
            ui.label(self._asked.failure).classes("note")
        if self._asked.answer is not None:
            with ui.element("div").props("data-testid=proposed"):
                for said in proposal_sentences(self._asked.answer):
                    # What is indented belongs to the law above it.
                    ui.label(self._worded(said)).classes("of-law" if said[:1] == " " else "")
                self._into_sweep(self._asked.answer)
        if not self.running:
            self._to_confirm()
            self._to_share()
        self._said(self._tested, lambda found: [confirmation_sentence(found)], "confirmed")
        self._said(self._shared, together_sentences, "shared")

    def _said(
        self, question: Question, sentences: Callable[[Json], list[str]], testid: str
    ) -> None:
        """Place the answer of a further question, or why there is none."""
        if question.failure:
            ui.label(question.failure).classes("note").props(f"data-testid={testid}-not")
        if question.answer is not None:
            with ui.element("div").props(f"data-testid={testid}"):
                for said in sentences(question.answer):
                    ui.label(self._worded(said))

    def _to_confirm(self) -> None:
        """Offer a test of each form that was proposed, on the shots that came after it."""
        for form in self._proposed():
            what = f"{form['slot']} on {'*'.join(form['arguments']) or form['kind']}"
            placed = button(
                f"Confirm {self._worded(what)} on the shots since",
                partial(self._test, form),
                testid="confirm-law",
            )
            placed.tooltip("tests this one form on the shots it was not chosen on")

    def _proposed(self) -> list[Json]:
        """Return the forms of the answer, or of the last one that was given for this campaign."""
        answer = self._asked.answer or last_proposal(self._state.source)
        return [one["form"] for one in answer["proposals"]]

    def _to_share(self) -> None:
        """Offer to ask other campaigns of the store together with this one."""
        source = self._state.source
        names = [one.name for one in source.daemon.store.campaigns.all()]
        names = [name for name in names if name != source.title]
        if not names:
            return
        with ui.element("div").classes("beside"):
            ui.select(names, multiple=True, label="Together with", with_input=True).bind_value(
                self, "_beside"
            ).props("data-testid=together-with")
            button("What do they share?", self._share, testid="share-law")

    def _into_sweep(self, answer: Json) -> None:
        """Offer the next shots as a sweep, unless another laboratory fired this campaign."""
        shots = [shot for one in answer["proposals"] for shot in one["next_shots"]]
        source = self._state.source
        if not shots:
            return
        if (elsewhere := source.elsewhere("rigctl model propose --write")) is not None:
            ui.label(f"Its next shots are {elsewhere}").classes("note")
            return
        note = f"confirms a law proposed after {source.title}"
        sweep = Sweep.model_validate({"note": note, "shots": shots, "campaign": source.title})
        button(
            "Make a sweep of its next shots",
            lambda: ui.navigate.to(form_address(sweep)),
            testid="law-into-sweep",
        )

    def _start(self) -> None:
        self._asked.start()
        self._refresh()

    def _test(self, form: Json) -> None:
        self._form = form
        self._tested.start()
        self._refresh()

    def _share(self) -> None:
        self._shared.start()
        self._refresh()

    def _ask_together(self) -> Job:
        source = self._state.source
        if not self._beside:
            raise AnalysisInputError(
                "no other campaign is chosen", part="Together with", todo="choose one or more"
            )
        return self._ask(together=others(source.daemon.store, source.title, self._beside))

    def _ask(self, **more: object) -> Job:
        limits = self._state.source.daemon.configuration.limits
        return self._state.source.ask(
            "propose",
            self._state.effects,
            limits=[list(limits.pressure_kpa), list(limits.offset_mm)],
            **more,
        )


def last_proposal(source: Source) -> Json:
    """Return the last answer that proposed a law for these shots; none are proposals too."""
    answers: list[Json] = [json.loads(job.result or "{}") for job in source.asked_before("propose")]
    return next((one for one in answers if one.get("proposals")), {"proposals": []})


TINY = re.compile(r"\b1e(-\d+)\b")
POWER = re.compile(r"\b(\d(?:\.\d+)?)e(-\d+)\b")
NAMES = {
    "speed_n": "approach speed",
    "speed_s": "sliding speed",
    "obliquity": "sliding ÷ approach",
    **{name: COVARIATES[name].partition(" (")[0] for name in COVARIATES if "_" in name},
}
"""Of quantities that a law may depend on; those with other names are words already."""
NAMED = re.compile(rf"\b({'|'.join(sorted(NAMES, key=len, reverse=True))})\b")


def on_page(sentence: str) -> str:
    """Return a sentence with the page's signs, and its buttons in the place of options."""
    said = sentence.strip().replace("+-", "±").replace("ask with --confirm", "press Confirm")
    said = TINY.sub(lambda found: f"10{_raised(found[1])}", said)
    return POWER.sub(lambda found: f"{found[1]}·10{_raised(found[2])}", said)


def _raised(power: str) -> str:
    return str(int(power)).translate(RAISED)


def in_story(sentence: str) -> str:
    """Return the same with the names of quantities in plain words."""
    return NAMED.sub(lambda found: NAMES[found[1]], on_page(sentence))
