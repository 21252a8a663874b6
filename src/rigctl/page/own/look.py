"""The first panel of films that were brought: their pictures, and marks to drag on one of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from nicegui import events, ui

from rigctl.documents import Json
from rigctl.jobs import Job, in_process
from rigctl.page.desk import Desk
from rigctl.page.model.state import Question
from rigctl.page.own.brought import Brought
from rigctl.page.own.marks import Marks
from rigctl.page.parts.choosing import Choice
from rigctl.page.parts.waiting import Waiting

FUNCTIONS = "rigctl.measuring.own_film"
SCRIPT = Path(__file__).with_name("marks.js")
LINE = (0.25, 0.9, 0.75, 0.9)
"""Where a line begins to be: columns and rows of its ends, as shares of the picture."""
RING = 0.08
"""Radius of a ring where no ball was found, of the picture's smaller side."""


class LookPanel:
    """Shows one of the films; its marks hold for all of them.

    Attributes
    ----------
    marks
        As they stand, by a person or as they were found.
    """

    def __init__(self, desk: Desk, brought: Brought, on_marks: Callable[[], None]) -> None:
        self._desk, self._brought, self._on_marks = desk, brought, on_marks
        self._seen, self._shown = 0, 0
        self.marks = Marks()
        jobs = desk.daemon.jobs
        self._look = Question(lambda: self._ask("look_job"), jobs.job)
        self._rings = Question(lambda: self._ask("rings_job"), jobs.job)
        self._look.start()
        ui.add_head_html(f"<script>{SCRIPT.read_text('utf-8')}</script>")
        ui.html("1 Is this what you filmed?", sanitize=False, tag="h3").classes("card-heading")
        if len(brought.films) > 1:
            names = {number: film.name for number, film in enumerate(brought.films)}
            Choice("film", names, self._seen, self._see)
        self._head()
        self._picture()
        Waiting(desk, "Looking at the film", lambda: self._look.running or "", "looking")
        Waiting(desk, "Finding the ball", lambda: self._rings.running or "", "ringing")

    @property
    def size(self) -> tuple[int, int] | None:
        """Columns and rows of a picture, once they are known."""
        answer = self._look.answer
        return None if answer is None else (answer["columns"], answer["rows"])

    @property
    def unrated(self) -> bool:
        """Whether the file is known to state no frame rate."""
        return self._look.answer is not None and not self._look.answer["rate_hz"]

    def follow(self) -> None:
        """Show what has been answered since."""
        if self._look.follow():
            answer = self._look.answer
            if answer is not None:
                self._shown = len(answer["pictures"]) // 2
                self._rings.start()
            self._head.refresh()
            self._picture.refresh()
            self._on_marks()
        if self._rings.follow() and self.marks.ring is None:
            self._show(self._nearest())

    def draw_line(self) -> None:
        """Put a line into the picture, or take it away."""
        if self.size is not None:
            ends = tuple(share * self.size[k % 2] for k, share in enumerate(LINE))
            self._mark(replace(self.marks, line=None if self.marks.line else ends))

    def draw_ring(self) -> None:
        """Put a ring into the middle of the picture: none was found."""
        if self.size is not None:
            middle = self.size[0] / 2, self.size[1] / 2
            self._mark(replace(self.marks, ring=(*middle, RING * min(self.size))))

    def take_all(self) -> None:
        """Look at all of the picture again."""
        self._mark(replace(self.marks, part=None))

    @ui.refreshable_method
    def _head(self) -> None:
        name, answer = self._brought.films[self._seen].name, self._look.answer
        if self._look.failure:
            ui.label(self._look.failure).classes("verdict bad").props("data-testid=own-failed")
        if answer is None:
            ui.label(f"{name} …").classes("empty")
            return
        rate = answer["rate_hz"]
        rated = f"{rate:g} frames a second by the file" if rate else "the file states no frame rate"
        ui.label(
            f"{name}: {answer['frames']} frames of {answer['columns']} × {answer['rows']} "
            f"pixels; {rated}."
        ).props("data-testid=own-film")
        with ui.element("div").classes("strip"):
            for number, one in enumerate(answer["pictures"]):
                with ui.element("button").classes("frame") as thumbnail:
                    ui.element("img").props(f'src="{_source(one)}" alt=""')
                    ui.label(f"frame {one['frame']}")
                thumbnail.props(f'aria-label="show frame {one["frame"]}"')
                thumbnail.on("click", lambda number=number: self._show(number))

    @ui.refreshable_method
    def _picture(self) -> None:
        answer = self._look.answer
        if answer is None:
            return
        one, (columns, rows) = answer["pictures"][self._shown], (answer["columns"], answer["rows"])
        root = ui.html(
            f'<svg viewBox="0 0 {columns} {rows}" role="group" aria-label="Frame {one["frame"]} of '
            'the film, with marks to drag"><image href="'
            f'{_source(one)}" width="{columns}" height="{rows}"/></svg>',
            sanitize=False,
        ).classes("marked")
        root.style(f"--share: {columns / rows:.4f}").props("data-testid=own-picture")
        root.on("marked", self._on_marked, args=["detail"])
        given = {"part": self.marks.part, "ring": self.marks.ring, "line": self.marks.line}
        document = json.dumps({"width": columns, "height": rows, **given})
        ui.run_javascript(f"window.filmMarks(getHtmlElement({root.id}), {document})")
        ui.label(
            "Drag the blue border about the part to look at, and the orange ring onto the ball; or "
            "go to a handle with Tab and move it by arrow keys, with Shift ten pixels at once."
        ).classes("note")

    def _on_marked(self, event: events.GenericEventArguments) -> None:
        if self.size is None:
            return
        try:
            self.marks = Marks.from_json(event.args["detail"], self.size)
        except (ValueError, TypeError, KeyError):
            return
        self._on_marks()

    def _mark(self, marks: Marks) -> None:
        self.marks = marks
        self._picture.refresh()
        self._on_marks()

    def _see(self, number: int) -> None:
        self._seen = number
        self.marks = self.marks.without_ring()
        self._look.start()
        self._rings.forget()
        self._head.refresh()
        self._picture.refresh()

    def _show(self, number: int) -> None:
        """Show another picture, with the ball where it was found in it."""
        self._shown = number
        found = self._found().get(number)
        self._mark(self.marks if found is None else replace(self.marks, ring=found))

    def _found(self) -> dict[int, tuple[float, ...]]:
        """Return rings that were found, by the place of their picture."""
        answer, rings = self._look.answer, self._rings.answer
        if answer is None or rings is None:
            return {}
        by_frame = {one["frame"]: tuple(one["ring"]) for one in rings["rings"]}
        frames = [one["frame"] for one in answer["pictures"]]
        return {k: by_frame[frame] for k, frame in enumerate(frames) if frame in by_frame}

    def _nearest(self) -> int:
        """Return the picture with a ring that is nearest to the one that is shown."""
        return min(self._found(), key=lambda k: abs(k - self._shown), default=self._shown)

    def _ask(self, function: str) -> Job:
        film = self._brought.films[self._seen]
        work = in_process(f"{FUNCTIONS}:{function}", {"path": str(film)})
        return self._desk.daemon.jobs.submit("look", film.name, work)


def _source(picture: Json) -> str:
    return f"data:image/jpeg;base64,{picture['jpeg']}"
