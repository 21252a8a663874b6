"""A shot that was not measured: what happened, a picture of it, and what to do."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from html import escape
from typing import Any
from urllib.parse import urlencode

from nicegui import ui

from analysis.figures.palette import FAILS
from rigctl.config import Limits
from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.parts.widgets import button
from rigctl.page.shots.film import frame_address
from rigctl.page.shots.overlay import Overlays
from rigctl.settings import ShotSettings
from rigctl.store import ShotRecord

LATE_US = 5000.0
"""Spheres that start further apart meet beside the middle of the picture, or not in it."""
GRAZING = 0.93
"""Offset in diameters from which spheres graze or miss."""
GOOD_OFFSET = 0.25
"""Offset in diameters of a hit that is seen well."""
UNLIKE = 1.6
"""Ratio of the pressures from which the spheres meet far from the middle."""
SLOW_KPA, GOOD_KPA = 12.0, 40.0
"""Slower shots fall out of the picture before they meet."""
OF_THE_PATHS = frozenset({"contact", "assignment", "outlines"})
"""Steps at which a shot is refused because of where the spheres flew."""
AGAIN = "Fire the same again"
PICTURES = {
    "frames": "The pictures cannot be used: some are lost, mixed up or too bright.",
    "outlines": "The edge of a sphere cannot be seen well enough.",
    "markers": "The dots on a sphere cannot be seen well enough to say how it turns.",
    "rotation": "The turning of a sphere cannot be followed by its dots.",
    "assignment": "The pictures do not show two spheres in both views.",
    "motion": "A sphere jumps from one picture to the next as nothing that flies does.",
    "contact": "The pictures do not show where the spheres met.",
}
LOOK = {
    "frames": "Look at the camera's light and cable, then fire the same again.",
    "outlines": "Wipe the lens and look at the lamp, then fire the same again.",
    "markers": "Turn the spheres so that dots face the camera, and fire the same again.",
    "rotation": "Turn the spheres so that dots face the camera, and fire the same again.",
    "motion": "Look at the camera's cable, then fire the same again.",
}


@dataclass(frozen=True, slots=True)
class Remedy:
    """What happened, what to do, and the settings that do it under the words of a button."""

    happened: str
    todo: str
    button: str
    settings: ShotSettings

    @property
    def address(self) -> str:
        """Where the form of the next shot stands filled in with these settings."""
        return f"/?{urlencode({'fill': self.settings.model_dump_json(exclude_none=True)})}"


def remedy(
    step: str,
    settings: ShotSettings,
    limits: Limits,
    diameter_m: float,
    *,
    ends_apart: bool = False,
) -> Remedy:
    """Return what a refusal at a step means for a shot with these settings.

    Parameters
    ----------
    step
        Of the analysis that refused it, as the result names it.
    diameter_m
        Of the spheres, m.
    ends_apart
        Whether the spheres still come nearer to each other where the film ends.
    """
    if step in OF_THE_PATHS and (found := _of_the_paths(settings, limits, diameter_m)):
        return found
    if ends_apart:
        happened = "The film ends before the spheres meet: they left their tubes late, or slowly."
        return Remedy(
            happened, f"{AGAIN}: the next launch will hardly be as late.", AGAIN, settings
        )
    happened = PICTURES.get(step, "The analysis found nothing that it could measure.")
    return Remedy(
        happened, LOOK.get(step, f"{AGAIN}: such a shot may come by chance."), AGAIN, settings
    )


def _of_the_paths(settings: ShotSettings, limits: Limits, diameter_m: float) -> Remedy | None:
    """Return the first of the settings that keeps spheres from meeting in the picture."""
    diameter_mm = 1e3 * diameter_m
    delay, offset = settings.delay_us, settings.offset_mm
    weak, strong = sorted((settings.pressure_a_kpa, settings.pressure_b_kpa))
    if abs(delay) > LATE_US:
        first, second = ("b", "a") if delay < 0 else ("a", "b")
        return _changed(
            settings,
            f"The spheres did not meet in the picture: {first} started {abs(delay) / 1e3:g} ms "
            f"before {second}.",
            "Set the delay of b to 0",
            delay_us=0.0,
        )
    if abs(offset) > GRAZING * diameter_mm:
        good = _within(round(GOOD_OFFSET * diameter_mm), limits.offset_mm)
        return _changed(
            settings,
            f"The spheres flew past each other: the offset of {offset:g} mm is nearly their "
            f"diameter, {diameter_mm:g} mm.",
            f"Set the offset to {good:g} mm",
            offset_mm=good,
        )
    if strong > UNLIKE * weak:
        return _changed(
            settings,
            f"The spheres met beside the picture: {strong:g} kPa push one of them much harder than "
            f"{weak:g} kPa the other.",
            f"Set both pressures to {strong:g} kPa",
            pressure_a_kpa=strong,
            pressure_b_kpa=strong,
        )
    if strong < SLOW_KPA:
        good = _within(GOOD_KPA, limits.pressure_kpa)
        return _changed(
            settings,
            f"The spheres fell out of the picture before they met: {strong:g} kPa make them slow.",
            f"Set both pressures to {good:g} kPa",
            pressure_a_kpa=good,
            pressure_b_kpa=good,
        )
    return None


def _changed(settings: ShotSettings, happened: str, deed: str, **values: float) -> Remedy:
    return Remedy(happened, f"{deed}.", deed, settings.model_copy(update=values))


def _within(value: float, bounds: tuple[float, float]) -> float:
    return min(max(value, bounds[0]), bounds[1])


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
            ends_apart=result["step"] == "contact" and end_apart(Overlays.of(result)),
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


def end_apart(overlays: Overlays) -> bool:
    """Say whether the spheres come nearer up to the last frame that shows both, and do not touch.

    In the front view, as the view from above hides an offset.
    """
    gaps = [gap for found in overlays.frames if (gap := _gap(found["outlines"])) is not None]
    return len(gaps) > 1 and 0.0 < gaps[-1] == min(gaps)


def _gap(outlines: Sequence[Json]) -> float | None:
    """Return how far apart the two outlines of the front view are, pixels; None: not both seen."""
    front = {one["sphere"]: one for one in outlines if one.get("view", "front") == "front"}
    if len(front) < 2:
        return None
    a, b = front["a"], front["b"]
    between = math.hypot(a["row"] - b["row"], a["column"] - b["column"])
    return float(between - a["radius"] - b["radius"])


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
