"""A shot that was not measured: what happened, a picture of it, and what to do."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from html import escape
from typing import Any

from nicegui import ui

from analysis.figures.palette import FAILS
from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.parts.widgets import button
from rigctl.page.shots.film import frame_address
from rigctl.page.shots.overlay import Overlays
from rigctl.page.shots.remedy import remedy
from rigctl.store import ShotRecord

Json = Mapping[str, Any]
LAYERS = ("outlines", "tracks")


def refused_card(desk: Desk, shot: ShotRecord, result: Json, why: str) -> None:
    """Place what happened to a shot that was not measured; `why` is the text of the log."""
    with ui.element("section").classes("refused").props("data-testid=refusal"):
        ui.label(f"Shot {shot.number} was not measured").classes("strong")
        if shot.settings is None or result.get("status") != "refused":
            ui.label(f"{why[:1].upper()}{why[1:]}.")
            if shot.frames:
                again = button(
                    "Analyse it again",
                    lambda: desk.daemon.analyse(shot.id),
                    look="fill",
                    testid="do-this",
                )
                again.tooltip("its frames are on disk: nothing is fired")
            return
        configuration = desk.daemon.configuration
        said = remedy(
            str(result["step"]),
            shot.settings,
            configuration.limits,
            configuration.spheres[0].diameter_m,
        )
        ui.label(said.happened)
        with suppress(RigError):
            _picture(desk, shot, result)
        ui.html(f"<b>Do this:</b> {escape(said.todo)}", sanitize=False)
        placed = button(
            said.button, lambda: ui.navigate.to(said.address), look="fill", testid="do-this"
        )
        placed.tooltip("fills the form of the next shot in; nothing moves before you arm")
        ui.label(f"For the log: {why}").classes("note")


def _picture(desk: Desk, shot: ShotRecord, result: Json) -> None:
    """Place the frame that was refused, with what was found in it."""
    film = desk.films.film(shot)
    frame = result.get("frame", telling_frame(film.overlays, film.brightest))
    discs = result.get("discs", [])
    found = film.overlays.drawing(frame, LAYERS) + "".join(map(_disc, discs))
    count = len(discs)
    if frame < len(film.overlays.frames):
        count = len(film.overlays.frames[frame]["outlines"])
    columns, rows = film.size
    text = f"frame {frame}: {count} outline{'' if count == 1 else 's'} of spheres found in it"
    ui.html(
        f'<svg class="evidence" viewBox="0 0 {columns} {rows}" role="img" aria-label="{text}">'
        f'<image href="{frame_address(shot.id, frame)}" width="{columns}" height="{rows}"/>'
        f"{found}</svg>",
        sanitize=False,
    ).classes("wide")
    ui.label(f"F{text[1:]}.").classes("note")


def telling_frame(overlays: Overlays, otherwise: int) -> int:
    """Return the frame that shows most outlines, the last of them: where the paths lead by then."""
    counts = [len(found["outlines"]) for found in overlays.frames]
    if not any(counts):
        return otherwise
    return max(range(len(counts)), key=lambda frame: (counts[frame], frame))


def _disc(found: Json) -> str:
    return (
        f'<circle cx="{found["column"] + 0.5:.1f}" cy="{found["row"] + 0.5:.1f}" '
        f'r="{found["radius"]:.1f}" fill="none" stroke="{FAILS}" stroke-width="1"/>'
    )
