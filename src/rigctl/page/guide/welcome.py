"""What somebody sees who is here for the first time: the rig drawn, the hit, and the numbers."""

from __future__ import annotations

from functools import cache
from html import escape
from pathlib import Path

from nicegui import ui

from rigctl.page.desk import Desk
from rigctl.page.guide.rail import any_measured

HERE = Path(__file__).parent
MEASURES = (
    (
        "bounce",
        "Bounce e",
        "Speed of parting over speed of approach, along the line of centres. 1 loses nothing; at "
        "0 they do not part.",
    ),
    (
        "spin-back",
        "Spin-back β",
        "How much of the sliding is turned round. 1 reverses all of it, −1 leaves it as it was.",
    ),
    (
        "friction",
        "Friction μ",
        "Push along the surfaces over push along the line of centres, while the surfaces slide. "
        "It comes from all shots together.",
    ),
)
NUMBERS = (
    "A camera takes {rate:.0f} pictures a second, from the front and in a mirror from above.",
    "In each picture the outline and the dots of both spheres are found: where each is, and how "
    "it is turned.",
    "A flight is fitted to the pictures before the hit and another to those after it. Both are "
    "taken to the moment of the hit: the change there is what the hit did.",
    "Each number has its error: 0.740 ± 0.001 means that the truth lies within 0.739 and 0.741 "
    "two times in three.",
)
SIMULATED = (
    "This rig is simulated: a program of its own draws the pictures, with noise. The analysis "
    "knows nothing of its laws and measures the pictures as if they were real."
)


def rig_drawing(desk: Desk) -> None:
    """Place the rig as a drawing that follows the fields of the next shot.

    Only an apparatus with pressure has two tubes that the drawing shows.
    """
    if desk.daemon.configuration.apparatus != "pusher":
        return
    diameter_mm = 1e3 * desk.daemon.configuration.spheres[0].diameter_m
    ui.label("Change a value on the form: the drawing follows.").classes("note")
    ui.html(_drawn("rig") + _drawn("rig-narrow"), sanitize=False).classes("wide").props(
        "data-testid=rig-drawing"
    )
    ui.add_body_html(
        f"<script>{(HERE / 'follow.js').read_text('utf-8')}"
        f'window.addEventListener("load", () => setTimeout(() => followRig({diameter_mm:g}), 300));'
        "</script>"
    )


def welcome(desk: Desk) -> None:
    """Place what a hit is, what is measured and where numbers come from."""
    configuration = desk.daemon.configuration
    with ui.element("div").classes("columns third").props("data-testid=welcome"):
        with ui.element("section").classes("panel"):
            _heading("The hit, close up")
            ui.html(_drawn("hit"), sanitize=False).classes("wide")
            if not any_measured(desk):
                ui.label("Only these speeds and the spin count: not where in the room it was.")
        with ui.element("section").classes("panel"):
            _heading("What you will measure")
            for drawing, name, meaning in MEASURES:
                with ui.element("div").classes("measure"):
                    ui.html(_drawn(drawing), sanitize=False)
                    with ui.element("div"):
                        ui.label(name).classes("strong")
                        ui.label(meaning).classes("note")
        with ui.element("section").classes("panel"):
            _heading("Where the numbers come from")
            with ui.element("ol").classes("chain"):
                for sentence in NUMBERS:
                    said = escape(sentence.format(rate=configuration.camera.picture_rate_hz))
                    ui.html(said, sanitize=False, tag="li")
            if configuration.simulation is not None:
                ui.label(SIMULATED).classes("note")


def _heading(text: str) -> None:
    ui.html(escape(text), sanitize=False, tag="h2").classes("card-heading")


@cache
def _drawn(name: str) -> str:
    return (HERE / "drawings" / f"{name}.svg").read_text("utf-8")
