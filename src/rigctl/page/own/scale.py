"""What a person states of a ball and its camera: the scale, and the part that is looked at."""

from __future__ import annotations

from nicegui import ui

from rigctl.documents import Json
from rigctl.page.own.look import LookPanel
from rigctl.page.own.marks import diameter_by_line, scale_words, window_of
from rigctl.page.parts.fields import OptionalNumber
from rigctl.page.parts.widgets import button

Range = tuple[float, float, str]
"""Least, most, and their unit."""
DIAMETERS, MASSES = (0.1, 2000.0, "mm"), (1e-6, 1e6, "g")
RATES, LENGTHS = (0.1, 1e8, ""), (0.1, 1e5, "mm")
"""What may be stated of a ball, its camera and a line over a known length."""


class ScaleForm:
    """Diameter, stated or by a line over a known length; mass and rate; the part, in words.

    Attributes
    ----------
    ready
        Whether the ball's diameter is known, and a frame rate.
    """

    def __init__(self, look: LookPanel) -> None:
        self._look = look
        self.ready = False
        ui.html("2 Scale and part", sanitize=False, tag="h3").classes("card-heading")
        # Mass and rate stand below the words on the marks, and follow when they are there.
        self._fields: list[OptionalNumber] = []
        self._diameter = number(
            "Diameter of the ball, mm", "ball-diameter-mm", "the scale", DIAMETERS
        )
        self._marked()
        self._mass = number(
            "Its mass, g (if known)", "ball-mass-g", "then the air's drag is known", MASSES
        )
        self._rate = number("Frames a second, if not the file's", "fps", "of the camera", RATES)
        self._fields = [self._diameter, self._mass, self._rate]
        ui.label("All speeds follow from the frame rate; the fall of the ball checks it.").classes(
            "note"
        )
        self._diameter.field.on_value_change(self.refresh)
        self._mass.field.on_value_change(self.refresh)
        self._rate.field.on_value_change(self._rated)

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
            "mass_g": self._mass.value,
            "rate_hz": self._rate.value,
            "window": list(window_of(part, size)) if part and size else None,
        }

    _length_mm: float | None = None
    _rate_hz: float | None = None

    @ui.refreshable_method
    def _marked(self) -> None:
        marks = self._look.marks
        by_line = diameter_by_line(marks, self._length_mm)
        known = self._diameter.value
        lacks_rate = self._look.unrated and not self._rate_hz
        valid = all(field.valid for field in self._fields)
        self.ready = bool(known or by_line) and not lacks_rate and valid
        ui.label(scale_words(marks, known, by_line)).classes("note").props(
            "data-testid=scale-words role=status"
        )
        if lacks_rate:
            ui.label("The file states no frame rate: fill in that of the camera.").classes(
                "note"
            ).props("data-testid=no-rate role=status")
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
            length = number(
                "Length of the line, mm", "line-mm", "of what the line lies over", LENGTHS
            )
            length.field.set_value(self._length_mm)
            length.field.on("change", lambda: self._measure_line(length))
        part, size = marks.part, self._look.size
        if size is not None:
            x, y, w, h = window_of(part or (0, 0, *size), size)
            whole = "All of the picture is" if part is None else "Only a part is"
            ui.label(f"{whole} looked at: columns {x} to {x + w}, rows {y} to {y + h}.").classes(
                "note"
            ).props("data-testid=part-words")

    def _rated(self) -> None:
        self._rate_hz = self._rate.value
        self.refresh()

    def _measure_line(self, length: OptionalNumber) -> None:
        if length.valid:
            self._length_mm = length.value
            self.refresh()
        else:
            # It stays in its field, with what is allowed; by the one before nothing is measured.
            self.ready = False


def number(label: str, testid: str, hint: str, within: Range) -> OptionalNumber:
    """Place a field for a number that may be left out."""
    placed = OptionalNumber(label, testid, within[:2], within[2])
    placed.field.classes("wide").tooltip(hint)
    return placed
