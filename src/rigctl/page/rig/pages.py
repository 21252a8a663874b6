"""The rig: the next shot, what holds it back, and what the last one showed."""

from __future__ import annotations

from datetime import datetime
from html import escape

from nicegui import ui
from pydantic import ValidationError

from rigctl.config import Limits
from rigctl.page.desk import Desk
from rigctl.page.feed import Feed, Happening
from rigctl.page.guide.welcome import rig_drawing, welcome
from rigctl.page.layout import TICK_S, sheet
from rigctl.page.parts.following import following
from rigctl.page.parts.presence import every, kept_page
from rigctl.page.parts.tables import Cell, Line, facts_html, minus
from rigctl.page.rig.commissioning import PLACE as WALK
from rigctl.page.rig.film import PLACE as FILM
from rigctl.page.rig.order_form import OrderForm, words
from rigctl.page.rig.recorder import PLACE as KEYPAD
from rigctl.page.shots.player import Player
from rigctl.page.shots.view import coefficients, film, in_place, read
from rigctl.rig.interlocks import Interlock
from rigctl.rig.status import RigStatus
from rigctl.settings import ShotSettings
from rigctl.store import ShotRecord

SHOWN_EVENTS = 12


def rig_page(desk: Desk) -> None:
    """Register the page at `/`."""

    @kept_page("/")
    def page(fill: str = "") -> None:
        with sheet(desk, "Rig", "/") as guide:
            for warning in desk.daemon.rig.status().warnings:
                ui.label(warning).classes("verdict bad")
            with ui.element("div").classes("columns rig"):
                with ui.element("div").classes("stack"):
                    _order(desk, _filled(fill))
                    _interlocks(desk)
                with ui.element("div").classes("panel"):
                    last = LastShot(desk)
                with ui.element("div").classes("stack"):
                    with ui.element("div").classes("panel"):
                        last.beside()
                    _events(desk.feed)
            guide.with_it(lambda: welcome(desk))


class LastShot:
    """Film and coefficients of the shot fired last; drawn anew whenever it gets further."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._shot = self._filmed = desk.daemon.rig.status().last_shot
        with ui.element("div").classes("title"):
            self._name, self._about = ui.label(), ui.label().classes("aside")
            self._open = ui.link("open").classes("aside")
        self._head()
        self._older = ui.label().classes("note")
        self._player: Player | None = None
        self._say_whose()
        self.film()
        following(TICK_S, self._follow)

    def _head(self) -> None:
        """Say which shot it is; new words cost a tenth of new elements, and firing waits less."""
        shot = self._shot
        self._name.set_text("Last shot" if shot is None else f"Shot {shot.number}")
        self._about.set_text("" if shot is None else f"{shot.state}, {words(shot.settings)}")
        self._open.set_visibility(shot is not None)
        if shot is not None:
            self._open.props(f"href=/shots/{shot.id}")

    @ui.refreshable_method
    def film(self) -> None:
        """Place its film."""
        if self._filmed is None:
            ui.label(
                "No shot has been fired yet. Choose pressure and offset, press Arm, then "
                "Fire: film and coefficients appear here."
            ).classes("empty")
            rig_drawing(self._desk)
            return
        self._player = film(self._desk, self._filmed)

    def _say_whose(self) -> None:
        """Say of which shot the film is while the last one has none."""
        shown = self._filmed
        older = shown is not None and self._shot is not None and shown.id != self._shot.id
        self._older.set_visibility(older)
        if shown is not None and older:
            self._older.set_text(f"Film of shot {shown.number}, until this one has frames.")

    @ui.refreshable_method
    def beside(self) -> None:
        """Place its coefficients."""
        ui.label("What was measured").classes("title")
        if self._shot is None:
            ui.label("Measured a few seconds after the first shot.").classes("empty")
            return
        coefficients(self._desk, self._shot)

    async def _follow(self) -> None:
        before, now = self._shot, self._desk.daemon.rig.status().last_shot
        if now is None or now == before:
            return
        await read(self._desk, now)
        self._shot = now
        self._head()
        await self._desk.draw(self.beside.refresh)
        filmed = now if now.frames or now.outcome or self._filmed is None else self._filmed
        changed = _film_of(filmed) != _film_of(self._filmed)
        self._filmed = filmed
        self._say_whose()
        if changed:
            await self._desk.draw(self._film_anew)

    def _film_anew(self) -> None:
        player, shot = self._player, self._filmed
        if player is None or shot is None or not in_place(self._desk, player, shot):
            self.film.refresh()


def _film_of(shot: ShotRecord | None) -> object:
    """Return what a drawn film depends on: whose it is, and what was found in it."""
    if shot is None:
        return None
    return shot.id, shot.state if shot.frames is None else None, shot.results


def _filled(fill: str) -> ShotSettings | None:
    """Return the settings that an address fills the form with; None: those of the rig."""
    try:
        return ShotSettings.model_validate_json(fill) if fill else None
    except ValidationError:
        return None


def _order(desk: Desk, filled: ShotSettings | None) -> None:
    with ui.element("div").classes("panel"):
        ui.label("Next shot").classes("title")
        form = OrderForm(desk, filled)
    form.show(desk.daemon.rig.status())
    every(TICK_S, lambda: form.show(desk.daemon.rig.status()))


def _interlocks(desk: Desk) -> None:
    limits = desk.daemon.configuration.limits
    with ui.element("div").classes("panel"):
        ui.label("Checks before a fire").classes("title").tooltip("interlocks")
        with ui.element("details").classes("wide").props("data-testid=checks") as listed:
            with ui.element("summary"):
                count = ui.label().classes("strong").props("data-testid=checks-hold")
            table = (
                ui.html("", sanitize=False).props("data-testid=interlocks").classes("wide names")
            )
        said = ui.label().classes("note")
        with ui.element("div").classes("beside"):
            ui.link("Commissioning", WALK).classes("aside").props("data-testid=commissioning")
            if desk.daemon.keypad is not None:
                ui.link("Recorder", KEYPAD).classes("aside").props("data-testid=recorder")
            if desk.daemon.film is not None:
                ui.link("Film", FILM).classes("aside").props("data-testid=film")

    def show() -> None:
        status = desk.daemon.rig.status()
        said.set_text(_read_when(status, limits))
        listed.set_visibility(bool(status.interlocks))
        count.set_text(_hold(status))
        table.set_content(_interlock_table(status) if status.interlocks else "")
        fails = any(not each.holds for each in status.interlocks)
        if fails != ("failing" in listed.classes):
            listed.classes(toggle="failing")
        if fails:
            listed.props("open")

    show()
    every(TICK_S * 5, show)


def _hold(status: RigStatus) -> str:
    """Say how many conditions hold."""
    hold, count = sum(each.holds for each in status.interlocks), len(status.interlocks)
    mark = "✓" if hold == count else "▲"
    return f"{mark} {hold} of {count} hold"


def _read_when(status: RigStatus, limits: Limits) -> str:
    if not status.interlocks:
        return "All conditions that must hold before a fire. They are read when the rig is armed."
    age = max(each.age_s(status.read_at) for each in status.interlocks)
    if age <= limits.reading_max_age_s:
        return "As read just now."
    return "As read at the last arming, not as they stand now; arming reads them anew."


def _interlock_table(status: RigStatus) -> str:
    lines = [_interlock(each, status.read_at) for each in status.interlocks]
    return facts_html(
        [
            Cell("condition", "Each must hold before a fire; point at one for its limit."),
            Cell("found", "What was read, beside what is asked for."),
            Cell("age", "Time since it was read."),
        ],
        lines,
    )


def _interlock(found: Interlock, now: float) -> Line:
    value = _short(found.value) if isinstance(found.value, float) else found.value
    unit = f" {found.unit}" if found.unit else ""
    name = f"{'●' if found.holds else '▲'} {found.name.replace('_', ' ')}"
    hover = f"{found.sentence()}"
    asked = f" of {found.limit}" if "±" in found.limit else ""
    return Line(
        [
            Cell(name, hover),
            Cell(f"{value}{asked}{unit}", look="wrap"),
            Cell(_age(found.age_s(now)), look="dim"),
        ],
        "holds" if found.holds else "fails",
    )


def _short(value: float) -> str:
    """Return a reading with the places that any of them is read for."""
    text = f"{value:.0f}" if abs(value) >= 1000 else f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else minus(text)


def _age(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 3600 else f"{seconds / 3600:.0f} h"


def _events(feed: Feed) -> None:
    with ui.element("div").classes("panel"):
        ui.label("Events").classes("title")
        listed = ui.html("", sanitize=False).classes("wide").props("data-testid=events")
    shown = -1

    def show() -> None:
        nonlocal shown
        if feed.last == shown:
            return
        shown = feed.last
        listed.set_content(_happenings(feed.latest(SHOWN_EVENTS)))

    show()
    every(TICK_S, show)


def _happenings(found: list[Happening]) -> str:
    lines = (
        f'<div class="at">{_clock(one.at)}</div><div class="what">{escape(one.text)}</div>'
        for one in found
    )
    return f'<div class="happenings">{"".join(lines)}</div>'


def _clock(at: datetime) -> str:
    """Return the time of day where the daemon runs."""
    return f"{at.astimezone():%H:%M:%S}"
