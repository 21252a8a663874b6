"""Shots: the list of all, and one with film, coefficients and what became of it."""

from __future__ import annotations

from nicegui import run, ui

from analysis.motion.frame_notes import gathered
from rigctl.measuring.reanalysing import ENDED
from rigctl.page.desk import Desk, actor
from rigctl.page.layout import TICK_S, sheet
from rigctl.page.parts.asking import ask_reason
from rigctl.page.parts.following import following
from rigctl.page.parts.presence import kept_page
from rigctl.page.parts.remarks import Remarks
from rigctl.page.parts.tables import Cell, Line, facts
from rigctl.page.parts.widgets import button
from rigctl.page.rig.order_form import words
from rigctl.page.shots.residuals import ShotResiduals
from rigctl.page.shots.table import ShotTable, latest, stored
from rigctl.page.shots.view import coefficients, film, read
from rigctl.store import ShotRecord


class Judging:
    """Panel of one shot; whoever placed it draws it anew when the shot has changed."""

    def __init__(self, desk: Desk, shot: ShotRecord) -> None:
        self._desk, self._shot, self._store = desk, shot, desk.daemon.store
        with ui.element("div").classes("panel").props("data-testid=judging"):
            with ui.element("div").classes("title"):
                ui.label("Does it count?")
                ui.space()
                self._switch()
            if shot.excluded is not None:
                with ui.element("div").classes("verdict bad").props("data-testid=excluded"):
                    ui.label("Excluded from every fit.").classes("lead")
                    ui.label(shot.excluded)
            Remarks(
                desk,
                shot.note,
                shot.tags,
                annotate=lambda note, who: self._store.annotate(shot.id, note, who),
                tag=lambda tags, who: self._store.tag(shot.id, tags, who),
            ).place()

    def _switch(self) -> None:
        if self._shot.excluded is None:
            button("Exclude …", self._ask, testid="exclude").tooltip(
                "leaves it out of every fit; nothing of it is deleted"
            )
        else:
            button("Let it count again", self._include, testid="include")

    def _ask(self) -> None:
        async def exclude(why: str) -> bool:
            who = actor()
            done = await self._desk.act(lambda: self._store.exclude(self._shot.id, why, who))
            return done is not None

        ask_reason(
            f"Exclude shot {self._shot.number}",
            "Every fit leaves it out and names it. Frames and results stay; the reason is "
            "journalled.",
            "Exclude",
            exclude,
        )

    async def _include(self) -> None:
        who = actor()
        await self._desk.act(lambda: self._store.include(self._shot.id, who))


def shot_pages(desk: Desk) -> None:
    """Register `/shots` and `/shots/{shot}`."""

    @kept_page("/shots")
    def shots() -> None:
        with sheet(desk, "Shots", "/shots"), ui.element("div").classes("panel"):
            ui.label("Shots").classes("title")
            _Shots(desk)

    @kept_page("/shots/{shot}")
    def one(shot: str, frame: int | None = None, effects: str | None = None) -> None:
        with sheet(desk, f"Shot {shot}", "/shots"):
            if stored(desk, shot) is None:
                return
            added = None if effects is None else tuple(filter(None, effects.split(",")))
            _OneShot(desk, shot, frame, added)


class _Shots:
    """The latest shots; the table grows when something has happened to one."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._heard = -1
        self._table = ShotTable(measured=False)
        following(TICK_S * 5, self._follow)

    async def _follow(self) -> None:
        heard = self._desk.feed.told
        if heard == self._heard:
            return
        found = await run.io_bound(latest, self._desk, None)
        if found is not None:
            self._heard = heard
            self._table.show(found)


class _OneShot:
    """One shot; what of it has changed is drawn anew, so that the film keeps its place."""

    def __init__(
        self, desk: Desk, shot: str, frame: int | None, effects: tuple[str, ...] | None
    ) -> None:
        self._desk, self._frame, self._effects = desk, frame, effects
        self._heard = desk.feed.told
        self._shot = desk.daemon.store.shot(shot)
        with ui.element("div").classes("columns shot"):
            with ui.element("div").classes("panel"):
                self._film()
            with ui.element("div").classes("stack"):
                self._measured()
                self._judged()
                self._compared()
                self._recorded()
        following(TICK_S * 3, self._follow)

    @ui.refreshable_method
    def _film(self) -> None:
        shot = self._shot
        with ui.element("div").classes("title"):
            ui.label(f"Shot {shot.number}")
            ui.label(f"{shot.state}, {words(shot.settings)}").classes("aside")
        film(self._desk, shot, start=self._frame, keys=True)

    @ui.refreshable_method
    def _measured(self) -> None:
        with ui.element("div").classes("panel"):
            ui.label("What was measured").classes("title")
            coefficients(self._desk, self._shot)
            again = button("Analyse again", self._again, testid="analyse-again")
            again.set_enabled(self._shot.state in ENDED)
            again.tooltip("a further result is added; none is replaced")

    @ui.refreshable_method
    def _judged(self) -> None:
        Judging(self._desk, self._shot)

    @ui.refreshable_method
    def _compared(self) -> None:
        ShotResiduals(self._desk, self._shot, self._effects)

    @ui.refreshable_method
    def _recorded(self) -> None:
        _record(self._shot)
        _notes(self._desk.films.result(self._shot).get("notes", []))

    def _again(self) -> None:
        self._desk.daemon.analyse(self._shot.id)
        ui.notify("Its analysis is queued.")

    async def _follow(self) -> None:
        heard = self._desk.feed.told
        if heard == self._heard:
            return
        before, now = self._shot, self._desk.daemon.store.shot(self._shot.id)
        await read(self._desk, now)
        self._heard, self._shot = heard, now
        further = (now.state, now.results) != (before.state, before.results)
        if further:
            self._film.refresh()
            self._measured.refresh()
            self._recorded.refresh()
        if (now.excluded, now.note, now.tags) != (before.excluded, before.note, before.tags):
            self._judged.refresh()
        if further or now.excluded != before.excluded:
            self._compared.refresh()


def _record(shot: ShotRecord) -> None:
    lines = [
        ("fired", str(shot.fired)),
        ("accepted", f"{shot.accepted_at.astimezone():%Y-%m-%d %H:%M:%S}"),
        ("campaign", shot.campaign or "none"),
        ("simulated", "yes" if shot.simulated else "no, real"),
        ("frames", _frames(shot)),
        ("results", str(shot.results)),
        ("by", shot.actor),
    ]
    with ui.element("div").classes("panel"):
        ui.label("Record").classes("title")
        facts([], [Line([name, Cell(said, look="wrap")]) for name, said in lines])


def _frames(shot: ShotRecord) -> str:
    if shot.frames is None:
        return "none"
    return str(shot.frames) if shot.lost is None else f"{shot.frames}, {shot.lost} lost"


def _notes(notes: list[str]) -> None:
    if notes:
        with ui.element("div").classes("panel"):
            ui.label("What the analysis left out").classes("title")
            for note in gathered(notes):
                ui.label(note).classes("note")
