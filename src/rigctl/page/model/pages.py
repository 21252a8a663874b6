"""The model against measurement: which campaign, and the four steps on one page."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from analysis.errors import counted
from analysis.model.verdict.standing import Word
from rigctl.documents import Json
from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.guide.rail import Found, Rail
from rigctl.page.layout import sheet
from rigctl.page.model.challenge_maker import ChallengeMaker
from rigctl.page.model.challenge_panel import ChallengePanel
from rigctl.page.model.law import in_story
from rigctl.page.model.next import NextShots
from rigctl.page.model.source import Source
from rigctl.page.model.state import Effects, ModelState
from rigctl.page.model.steps import Steps
from rigctl.page.model.story.cards import in_plain, slider_script
from rigctl.page.model.story.ghost import ghost_script
from rigctl.page.model.story.view import Story
from rigctl.page.model.story.where import cause_first
from rigctl.page.model.story.words import (
    alarms_in_plain,
    cells_in_plain,
    in_words,
    rejected_in_plain,
)
from rigctl.page.model.verdict import Verdict, Wording, without_numbers
from rigctl.page.parts.following import following
from rigctl.page.parts.plotting import expect_plots
from rigctl.page.parts.presence import kept_page
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button
from rigctl.page.shots.residuals import rejected_of
from rigctl.store import ShotState

LOOK_S = 0.05
"""How often the page looks for an answer: who waits for a fit waits for half of it on average."""
STORY, TABLES = VIEWS = ("story", "tables")


class ModelView:
    """The page of one campaign's model. Long work runs as jobs; the page asks how far they are.

    Effects and view stand in the address, so that a reload keeps them.
    """

    def __init__(
        self, desk: Desk, source: Source, effects: Effects, view: str, guide: Rail
    ) -> None:
        self._desk, self._view, self._guide = desk, view, guide
        self._state = ModelState(source)
        self._state.take(effects)
        self._rest, self._stood = False, self._state.standing
        self._head()
        if view == TABLES:
            self._verdict = Verdict(desk, self._state, self._take)
        else:
            self._verdict = Verdict(desk, self._state, self._take, in_story_of(self._state))
        self._busy()
        self._failed()
        if view == TABLES:
            self._steps: Steps | Story = Steps(desk, self._state, self._take)
        else:
            self._steps = Story(desk, self._state, self._take)
        with self._steps.last:
            self._next = NextShots(desk, self._state)
            told = self._steps.look_at if isinstance(self._steps, Story) else None
            self._challenge = ChallengePanel(self._state, told)
        if self._state.present is not None:
            # Known from before: no answer will come that has it drawn.
            self._rest = True
            self._tell()
        # Heard by the page: the button is drawn anew again and again, and a key could meet none.
        ui.on("undo", self._undo)
        following(LOOK_S, self._follow)

    def _undo(self) -> None:
        if self._state.effects:
            self._take(self._state.effects[:-1])

    def _follow(self) -> None:
        if self._rest:
            self._rest = False
            self._steps.rank()
            self._next.show.refresh()
        answered, tried = self._state.follow()
        if answered or (tried and self._state.standing != self._stood):
            self._draw()
        elif tried:
            self._steps.rank()
        self._verdict.follow()
        self._next.follow()

    def _draw(self) -> None:
        self._stood = self._state.standing
        self._head.refresh()
        self._verdict.show.refresh()
        self._failed.refresh()
        self._steps.show()
        self._challenge.follow()
        self._rest = True
        self._tell()

    def _tell(self) -> None:
        """Have the guide say what the comparison has come to."""
        if self._state.present is not None and self._state.standing is not None:
            self._guide.compared(
                found_of(self._state.standing.word, added=bool(self._state.effects))
            )

    def _take(self, effects: tuple[str, ...]) -> None:
        self._state.take(effects)
        ui.navigate.history.replace(self._address(self._view))
        self._draw()

    def _address(self, view: str) -> str:
        return self._state.source.seen_as(self._state.effects, view)

    @ui.refreshable_method
    def _head(self) -> None:
        state = self._state
        with ui.element("div").classes("head"):
            if self._view == STORY:
                ui.html("<h2>What does the model miss?</h2>", sanitize=True)
                ui.label(state.source.title).classes("pill strong")
            else:
                ui.html(f"<h2>{state.source.title}</h2>", sanitize=True)
            if state.present is not None:
                self._used(state.present)
            ui.space()
            with ui.element("nav").classes("beside views").props('aria-label="view"'):
                for name in VIEWS:
                    link = ui.link(name.capitalize(), self._address(name)).classes("pill")
                    link.props(f"data-testid=view-{name}")
                    if name == self._view:
                        link.classes("here").props('aria-current="page"')
            ui.label("model").classes("aside")
            ui.label("gravity").classes("pill").tooltip("free flight between frames")
            story = self._view == STORY
            law = ui.label("bounce law" if story else "Walton e, μ, β₀").classes("pill")
            law.tooltip(
                "sticking contacts return β₀ of the surface velocity, sliding ones lose μ (1 + e) "
                "of the normal velocity (Walton)"
            )
            for name in state.effects:
                said = in_plain(name) if story else name
                with ui.element("span").classes("pill added"):
                    ui.label(f"+ {said}")
                    rest = tuple(effect for effect in state.effects if effect != name)
                    undo = ui.element("button").props(f"aria-label='remove {said}'")
                    undo.on("click", lambda rest=rest: self._take(rest))
                    with undo:
                        ui.label("×")

    def _used(self, found: Json) -> None:
        """Say how many shots were used, and of each that was not why."""
        why = left_out_of(found, self._state.source)
        used = counted(found["shots"], "shot")
        if not why:
            ui.label(f"{used} used").classes("aside").props("data-testid=counted")
            return
        with ui.element("details").classes("note").props("data-testid=counted"):
            numbers = ", ".join(map(str, why))
            shots = f"{'shot' if len(why) == 1 else 'shots'} {numbers}"
            reasons = "; ".join(
                f"shot {number}: {self._left_out_words(reason)}" for number, reason in why.items()
            )
            summary = f"{used} used, left out: {shots}. Why?"
            # The tooltip of an element: one of raw HTML has no place for it.
            with ui.element("summary").tooltip(reasons):
                ui.html(summary, sanitize=False, tag="span")
            for number, reason in why.items():
                ui.label(f"Shot {number}: {self._left_out_words(reason)}.")

    def _left_out_words(self, reason: str) -> str:
        return rejected_in_plain(reason) if self._view == STORY else reason

    def _busy(self) -> None:
        def look() -> str:
            job = self._state.waits()
            return "" if job is None else job.id

        worded = in_plain if self._view == STORY else str
        Waiting(self._desk, "Comparing model and measurement", look, "busy", worded)

    @ui.refreshable_method
    def _failed(self) -> None:
        if self._state.failure:
            with ui.element("div").classes("verdict bad").props("data-testid=failure"):
                ui.label(self._state.source.without_its_folder(self._state.failure))
                button("Ask again", lambda: self._take(self._state.effects))


def found_of(word: Word, *, added: bool) -> Found:
    """Return what a comparison has come to, by what is said of the model with what was added."""
    if word is Word.MISSING:
        return Found.MORE if added else Found.MISSING
    return Found.EXPLAINED if added and word in {Word.FLOOR, Word.ALIKE} else Found.ENDED


def left_out_of(found: Json, source: Source) -> dict[int, str]:
    """Return why shots were left out of a fit, by number: by the fit, or by whom excluded them."""
    why = rejected_of(found)
    for number in found["excluded"]:
        stored = source.stored(number)
        reason = "" if stored is None or not stored.excluded else f": {stored.excluded}"
        why[number] = f"excluded by a person{reason}"
    return {number: why[number].rstrip(".") for number in sorted(why)}


LEAST_SHOTS = 3


def in_story_of(state: ModelState) -> Wording:
    """Return how the story says things: in plain words, of two spheres or of one on a plate."""

    def plain(verdict: str) -> str:
        on_plate = any(paths.get("on_plate") for one in state.path() for paths in one["paths"])
        return in_plain(cells_in_plain(verdict, on_plate=on_plate))

    return Wording(
        verdict=plain,
        found=without_numbers,
        law=in_story,
        finding=in_words,
        alarms=alarms_in_plain,
        first=cause_first,
    )


def model_pages(desk: Desk) -> None:
    """Register `/model`, where a campaign is chosen, and `/model/{campaign}`."""

    @kept_page("/model")
    def choose(folder: str = "", effects: str = "", view: str = STORY) -> None:
        with sheet(desk, "Model", "/model") as guide:
            if folder:
                _view(lambda: Source.of_folder(desk.daemon, folder), desk, effects, view, guide)
            else:
                _choice(desk)

    @kept_page("/model/{campaign}")
    def model(campaign: str, effects: str = "", view: str = STORY) -> None:
        with sheet(desk, f"Model of {campaign}", "/model") as guide:

            def known() -> Source:
                desk.daemon.store.campaigns.one(campaign)
                return Source(desk.daemon, campaign)

            _view(known, desk, effects, view, guide)


def _view(source: Callable[[], Source], desk: Desk, effects: str, view: str, guide: Rail) -> None:
    try:
        found = source()
    except RigError as error:
        with ui.element("div").classes("panel"):
            ui.label("There is nothing to compare here").classes("title")
            ui.label(error.sentence()).classes("empty")
            ui.link("Choose a campaign", "/model")
        return
    expect_plots()
    slider_script()
    ghost_script()
    ModelView(desk, found, tuple(filter(None, effects.split(","))), view, guide)


def _choice(desk: Desk) -> None:
    with ui.element("div").classes("columns half"):
        ChallengeMaker(desk)
        with ui.element("div").classes("stack"):
            with ui.element("div").classes("panel"):
                ui.label("Campaigns of this rig").classes("title")
                _campaigns(desk)
            with ui.element("div").classes("panel"):
                ui.label("A campaign's folder").classes("title")
                ui.label(
                    "As rigctl challenge new, rigctl analyse --out or another laboratory wrote "
                    "it; it is used as it is."
                ).classes("note")
                path = ui.input("Path of the folder").props("outlined dense data-testid=folder")
                path.classes("wide")
                path.on("keydown.enter", lambda: _open(desk, path.value))
                button("Open", lambda: _open(desk, path.value), testid="open-folder")


def _campaigns(desk: Desk) -> None:
    found = desk.daemon.store.campaigns.all()
    if not found:
        ui.label(
            "No shot was fired under a campaign's name yet. Fire some on the page Rig with the "
            "field Campaign filled in, or run a sweep: the model needs shots at several pressures "
            "and offsets."
        ).classes("empty")
    for campaign in found:
        measured = campaign.states.get(ShotState.ANALYSED, 0)
        with ui.element("div").classes("beside"):
            ui.link(campaign.name, f"/model/{campaign.name}")
            ui.label(f"{counted(campaign.shots, 'shot')}, {measured} measured").classes("aside")


def _open(desk: Desk, path: str | None) -> None:
    try:
        found = Source.of_folder(desk.daemon, (path or "").strip())
    except RigError as error:
        ui.notify(error.sentence(), type="negative", multi_line=True)
        return
    ui.navigate.to(found.address)
