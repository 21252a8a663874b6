"""Compare, where it fails, what is missing, add: four steps side by side, and the verdict."""

from __future__ import annotations

from datetime import UTC, datetime

from nicegui import ui

from rigctl.jobs import Job
from rigctl.page.desk import Desk
from rigctl.page.model.challenge_panel import ChallengePanel
from rigctl.page.model.next import NextShots
from rigctl.page.model.source import Source
from rigctl.page.model.state import ModelState
from rigctl.page.model.steps import Steps
from rigctl.page.model.verdict import Verdict
from rigctl.page.parts.following import following
from rigctl.page.parts.widgets import button

LOOK_S = 0.05
"""How often the page looks for an answer: who waits for a fit waits for half of it on average."""
WORTH_SAYING_S = 3.0
LEFT_OUT = {"rejected": "left out as too far from the rest", "excluded": "excluded by a person"}


class ModelView:
    """The page of one campaign's model. Long work runs as jobs; the page asks how far they are."""

    def __init__(self, desk: Desk, source: Source) -> None:
        self._desk = desk
        self._state = ModelState(source)
        self._state.take(())
        self._rest = False
        self._head()
        self._verdict = Verdict(self._state)
        self._busy()
        self._failed()
        self._steps = Steps(desk, self._state, self._take)
        with self._steps.last:
            self._next = NextShots(desk, self._state)
            ChallengePanel(source)
        following(LOOK_S, self._follow)

    def _follow(self) -> None:
        if self._rest:
            self._rest = False
            self._steps.rank()
            self._next.show.refresh()
        job = self._state.waits()
        self._working.set_visibility(job is not None)
        if job is not None:
            self._doing.set_text(f"{job.progress or job.state} …{_since(job)}")
        if self._state.follow():
            self._draw()
        self._verdict.follow()
        self._next.follow()

    def _draw(self) -> None:
        self._head.refresh()
        self._verdict.show.refresh()
        self._failed.refresh()
        self._steps.show()
        self._rest = True

    def _take(self, effects: tuple[str, ...]) -> None:
        self._state.take(effects)
        self._draw()

    @ui.refreshable_method
    def _head(self) -> None:
        state = self._state
        with ui.element("div").classes("head"):
            ui.html(f"<h1>{state.source.title}</h1>", sanitize=True)
            if state.present is not None:
                ui.label(_counted(state.present)).classes("aside").props("data-testid=counted")
            ui.space()
            ui.label("model").classes("aside")
            ui.label("gravity").classes("pill").tooltip("free flight between frames")
            ui.label("Walton e, μ, β₀").classes("pill").tooltip(
                "sticking contacts return β₀ of the surface velocity, sliding ones lose μ (1 + e) "
                "of the normal velocity"
            )
            for name in state.effects:
                with ui.element("span").classes("pill added"):
                    ui.label(f"+ {name}")
                    rest = tuple(effect for effect in state.effects if effect != name)
                    undo = ui.element("button").props(f'aria-label="remove {name}"')
                    undo.on("click", lambda rest=rest: self._take(rest))
                    with undo:
                        ui.label("×")

    def _busy(self) -> None:
        self._working = ui.element("div").classes("busy").props("data-testid=busy role=status")
        with self._working:
            ui.spinner(size="sm")
            self._doing = ui.label()
            button("Cancel", self._cancel, look="line tab", testid="cancel-job")

    async def _cancel(self) -> None:
        job = self._state.waits()
        if job is not None:
            await self._desk.act(lambda: self._desk.daemon.jobs.cancel(job.id))

    @ui.refreshable_method
    def _failed(self) -> None:
        if self._state.failure:
            with ui.element("div").classes("verdict bad").props("data-testid=failure"):
                ui.label(self._state.failure)
                button("Ask again", lambda: self._take(self._state.effects))


def _since(job: Job) -> str:
    """Say how long a job runs, once that is worth saying."""
    if job.started_at is None:
        return ""
    seconds = (datetime.now(UTC) - job.started_at).total_seconds()
    return f" {seconds:.0f} s" if seconds >= WORTH_SAYING_S else ""


def _counted(found: dict[str, object]) -> str:
    text = f"{found['shots']} shot{'' if found['shots'] == 1 else 's'} used"
    for key, why in LEFT_OUT.items():
        numbers = found[key]
        if isinstance(numbers, list) and numbers:
            text += f", {why}: {', '.join(map(str, numbers))}"
    return text
