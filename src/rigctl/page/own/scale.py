"""The second panel of films that were brought: how large the ball is, and what is looked at."""

from __future__ import annotations

from nicegui import ui

from rigctl.documents import Json
from rigctl.page.own.look import LookPanel
from rigctl.page.own.marks import diameter_by_line, scale_words, window_of
from rigctl.page.parts.widgets import button


class ScaleForm:
    """Diameter, stated or by a line over a known length; mass and rate; the part, in words.

    Attributes
    ----------
    ready
        Whether the ball's diameter is known.
    """

    def __init__(self, look: LookPanel) -> None:
        self._look = look
        self.ready = False
        ui.html("2 Scale and part", sanitize=False, tag="h3").classes("card-heading")
        self._diameter = _number("Diameter of the ball, mm", "ball-diameter-mm", "the scale")
        self._marked()
        self._mass = _number(
            "Its mass, g (if known)", "ball-mass-g", "then the air's drag is known"
        )
        self._rate = _number("Frames a second, if not the file's", "fps", "of the camera")
        ui.label("All speeds follow from the frame rate; the fall of the ball checks it.").classes(
            "note"
        )
        self._diameter.on_value_change(self.refresh)

    def refresh(self) -> None:
        """Follow the marks and the fields."""
        self._marked.refresh()

    def stated(self) -> Json:
        """Return what is stated, as a measurement asks for it."""
        by_line = diameter_by_line(self._look.marks, self._length_mm)
        known = self._diameter.value
        part, size = self._look.marks.part, self._look.size
        return {
            "diameter_mm": known or (by_line.value if by_line else None),
            "diameter_sigma": 0.0 if known or not by_line else by_line.sigma / by_line.value,
            "mass_g": self._mass.value or None,
            "rate_hz": self._rate.value or None,
            "window": list(window_of(part, size)) if part and size else None,
        }

    _length_mm: float | None = None

    @ui.refreshable_method
    def _marked(self) -> None:
        marks = self._look.marks
        by_line = diameter_by_line(marks, self._length_mm)
        known = self._diameter.value or None
        self.ready = bool(known or by_line)
        ui.label(scale_words(marks, known, by_line)).classes("note").props(
            "data-testid=scale-words role=status"
        )
        if by_line is not None and known is None:
            ui.label(f"By the line the ball is {by_line.concise()} mm across.").props(
                "data-testid=by-line"
            )
        with ui.element("div").classes("beside"):
            words = "Take the line away" if marks.line else "Draw a line over a known length"
            button(words, self._look.draw_line, testid="draw-line")
            if marks.ring is None and self._look.size is not None:
                button("Put a ring on the ball", self._look.draw_ring, testid="draw-ring")
            if marks.part is not None:
                button("Look at all of the picture", self._look.take_all, testid="take-all")
        if marks.line is not None:
            length = _number("Length of the line, mm", "line-mm", "of what the line lies over")
            length.set_value(self._length_mm)
            length.on("change", lambda: self._measure_line(length.value))
        part, size = marks.part, self._look.size
        if size is not None:
            x, y, w, h = window_of(part or (0, 0, *size), size)
            whole = "All of the picture is" if part is None else "Only a part is"
            ui.label(f"{whole} looked at: columns {x} to {x + w}, rows {y} to {y + h}.").classes(
                "note"
            ).props("data-testid=part-words")

    def _measure_line(self, length_mm: float | None) -> None:
        self._length_mm = length_mm
        self.refresh()


def _number(label: str, testid: str, hint: str) -> ui.number:
    placed = ui.number(label, min=0.0).props(f"outlined dense data-testid={testid}")
    return placed.classes("wide").tooltip(hint)
