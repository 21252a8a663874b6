"""The story's film: of a typical shot, of an extreme one, or of any whose point was clicked."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from rigctl.documents import Json
from rigctl.page.desk import Desk
from rigctl.page.model.state import Effects, ModelState, Question
from rigctl.page.model.story.ghost import Scene, ghost_film, of_film, of_places
from rigctl.page.parts.choosing import Choice
from rigctl.page.parts.presence import every
from rigctl.page.parts.waiting import Waiting
from rigctl.page.shots.films import Films
from rigctl.store import ShotRecord

FILMED = ("Typical", "Largest gap", "Smallest gap")
"""As `analysis.model.agreement.predicted_paths` orders its shots."""
LOOK_S = 0.1


def scene_of(paths: Json, stored: ShotRecord | None, films: Films) -> Scene:
    """Return a shot's film with the outlines; where it has no frames, both views of its places."""
    if stored is None or not stored.frames:
        return of_places(paths)
    return of_film(paths, stored.id, films.film(stored))


class ShotFilm:
    """The film of one shot with the model's outlines over it; `chosen` hears which is shown."""

    def __init__(self, desk: Desk, state: ModelState, chosen: Callable[[], None]) -> None:
        self._desk, self._state, self._chosen = desk, state, chosen
        self._paths: list[Json] = []
        self._effects: Effects = ()
        self._more: Json | None = None
        self._wanted = 0
        self._said = ""
        self._asked = Question(
            lambda: state.source.ask("path", self._effects, shot=self._wanted),
            desk.daemon.jobs.job,
        )
        every(LOOK_S, self._follow)

    @property
    def shot(self) -> int | None:
        """Number of the shot that is shown; None before one is."""
        return self._wanted if self._shown() else None

    def take(self, paths: list[Json], effects: Effects) -> None:
        """Show the shots of another answer; the one that was chosen last where it is among them."""
        self._paths, self._more, self._said = paths, None, ""
        self._effects = effects
        self._asked.forget()
        if paths and self._wanted not in {own["shot"] for own in paths}:
            self._wanted = paths[0]["shot"]

    def choose(self, shot: int) -> None:
        """Show a shot, by its number; one whose path is not known yet is asked for."""
        self._wanted, self._said = shot, ""
        if self._shown() is None:
            self._asked.start()
            self._said = self._asked.failure
        self._choice.press(shot)
        self._other.set_value(None if shot in self._named else shot)
        self._film.refresh()
        self._chosen()

    def place(self) -> None:
        """Place the film with the choice of its shot."""
        if not self._paths:
            return
        with ui.element("div").classes("stack"):
            self._offer()
            Waiting(self._desk, "Following the shot", lambda: self._asked.running or "", "follows")
            with ui.element("div").classes("stack"):
                self._film()
            ui.label(
                "Solid: where each sphere was measured. Dashed: where the model, given the flight "
                "before contact, predicts it. The loupe magnifies the true gap."
            ).classes("note")

    @ui.refreshable_method
    def _film(self) -> None:
        if self._said:
            ui.label(self._said).classes("note fails")
        if (shown := self._shown()) is not None:
            stored = self._state.source.stored(shown["shot"])
            scene = scene_of(shown, stored, self._desk.films)
            ghost_film(scene, shown["shot"], shown["gap_mm"])

    def _offer(self) -> None:
        named = {
            own["shot"]: f"{name}: {own['shot']}"
            for name, own in zip(FILMED, self._paths, strict=False)
        }
        testids = {shot: f"film-{place}" for place, shot in enumerate(named)}
        with ui.element("div").classes("beside"):
            ui.label("Film of shot").classes("note")
            self._choice = Choice("film of shot", named, self._wanted, self.choose, testids)
            self._named = frozenset(named)
            other = ui.number(value=None if self._wanted in named else self._wanted, format="%d")
            other.props('outlined dense placeholder="another" data-testid=film-other')
            other.props('aria-label="film of the shot with this number" step=1 min=1')
            other.style("width: 96px")
            other.on("change", lambda: self._of_number(other.value))
            self._other = other

    def _of_number(self, number: float | None) -> None:
        if number is not None:
            self.choose(int(number))

    def _shown(self) -> Json | None:
        known = [*self._paths, *([] if self._more is None else [self._more])]
        return next((own for own in known if own["shot"] == self._wanted), None)

    def _follow(self) -> None:
        if not self._asked.follow():
            return
        paths: list[Json] = (self._asked.answer or {}).get("paths", [])
        self._more = paths[0] if paths else None
        self._said = self._asked.failure
        if not paths and not self._said:
            self._said = f"Shot {self._wanted} has no film here: it has no poses, or was left out."
        self._film.refresh()
