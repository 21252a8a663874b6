"""The film of a shot with the outlines that the model predicts over it, scrubbed by frames.

Where the shot's own film is stored, over its pictures; else the spheres are drawn from their
measured places. Everything that a frame needs is sent with it: the server is not asked again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from nicegui import ui

from analysis.figures.palette import SPHERE_A, SPHERE_B
from rigctl.documents import Json
from rigctl.page.desk import Desk
from rigctl.page.model.state import Effects, ModelState, Question
from rigctl.page.parts.choosing import Choice
from rigctl.page.parts.presence import every
from rigctl.page.parts.waiting import Waiting
from rigctl.page.shots.film import frame_address
from rigctl.page.shots.films import Film, Films
from rigctl.store import ShotRecord

SCRIPT = Path(__file__).with_name("ghost.js")
LOOKS = {"a": SPHERE_A, "b": SPHERE_B}
MARGIN_MM = 6.0
"""Around what is drawn from places alone."""
SAME_MS = 0.05
"""A pose and a picture are of one frame where their times differ by less."""
VIEWS = {"front": (1.0, 0), "top": (-1.0, 2)}
"""Of each view, down the picture: the sign and the axis; across it both show Y."""
UNSEEN_MM = 0.01
"""A depth that nobody saw stays at zero, but for what the plate's tilt makes of it."""
DIGITS = 2
LARGER = (100, 30, 10, 3)
MOST_OF_RADIUS = 0.6


@dataclass(frozen=True, slots=True)
class Scene:
    """What `ghost.js` draws: a size, still parts, and frames with rings and their gaps.

    `radii_mm` are those of spheres a and b; a ring's radius over its sphere's is the scale there.
    """

    radii_mm: Sequence[float]
    width: float
    height: float
    stroke: float
    still: list[str]
    frames: list[Json]

    def document(self) -> Json:
        """Return it as the browser takes it."""
        return {
            "width": self.width,
            "height": self.height,
            "stroke": self.stroke,
            "still": self.still,
            "frames": self.frames,
            "looks": LOOKS,
            "radii": dict(zip("ab", self.radii_mm, strict=True)),
            "times": self.times,
        }

    @property
    def times(self) -> int:
        """By how much the gap is drawn larger, so that it is seen and stays below a radius."""
        radius = max((ring[2] for frame in self.frames for ring in frame["rings"]), default=1.0)
        gaps = [
            abs(moved)
            for frame in self.frames
            for ring in frame["rings"]
            for moved in ring[4:]
            if moved is not None
        ]
        most = max(gaps, default=0.0) or 1.0
        return next((k for k in LARGER if k * most <= MOST_OF_RADIUS * radius), 1)

    @property
    def plainest(self) -> int:
        """The frame with the largest gap of those that show most spheres whole."""
        seen = [(sum(map(self._whole, one["rings"])), one["gap"] or 0.0) for one in self.frames]
        return max(range(len(seen)), key=seen.__getitem__)

    def _whole(self, ring: Sequence[float]) -> bool:
        x, y, radius = ring[:3]
        return radius <= x <= self.width - radius and radius <= y <= self.height - radius


def ghost_script() -> None:
    """Have the page draw and scrub films by itself."""
    ui.add_head_html(f"<script>{SCRIPT.read_text('utf-8')}</script>")


def of_film(paths: Json, shot: str, film: Film) -> Scene:
    """Return a stored film's pictures with rings where the analysis found the spheres.

    A ring's radius over that of its sphere is the scale of its view, px/mm.
    """
    columns, rows = film.size
    first = film.times_s[0]
    frames = []
    for k, time_s in enumerate(film.times_s):
        since = 1e3 * (time_s - first) - paths["contact_ms"]
        gaps = _gaps_at(paths, since)
        found = film.overlays.frames[k]["outlines"] if k < len(film.overlays.frames) else []
        if not found:
            continue
        rings = []
        for one in found:
            sphere = "ab".index(one["sphere"])
            scale = one["radius"] / paths["radii_mm"][sphere]
            moved = _moved(gaps[sphere], one.get("view", "front"), scale)
            rings.append(
                [
                    round(one["column"] + 0.5, DIGITS),
                    round(one["row"] + 0.5, DIGITS),
                    round(one["radius"], DIGITS),
                    one["sphere"],
                    *moved,
                ]
            )
        frames.append(_frame(since, rings, gaps) | {"picture": frame_address(shot, k)})
    return Scene(paths["radii_mm"], columns, rows, 0.005 * columns, [], frames)


def of_places(paths: Json) -> Scene:
    """Return both views drawn from the measured places, the view from above on top, in mm.

    Of a sphere on a plate whose depth nobody saw there is no view from above.
    """
    radius = max(paths["radii_mm"])
    placed = [own for both in paths["measured"] for own in both if own is not None]
    spans = [(min(p[k] for p in placed), max(p[k] for p in placed)) for k in range(3)]
    room = radius + MARGIN_MM
    heights = [high - low + 2 * room for low, high in (spans[2], spans[0])]
    views = dict(VIEWS)
    if paths.get("on_plate") and max(map(abs, spans[2])) < UNSEEN_MM:
        heights[0] = 0.0
        del views["top"]
    left = spans[1][0] - room
    width = spans[1][1] + room - left
    tops = {"top": spans[2][1] + room, "front": heights[0] - spans[0][0] + room}
    frames = []
    for since, both, gaps in zip(paths["times_ms"], paths["measured"], paths["gaps"], strict=True):
        rings = []
        for view, (sign, axis) in views.items():
            for sphere, place, gap, own in zip("ab", both, gaps, paths["radii_mm"], strict=True):
                if place is None:
                    continue
                down = tops[view] + sign * place[axis]
                at = [round(place[1] - left, DIGITS), round(down, DIGITS), own, sphere]
                rings.append([*at, *_moved(gap, view, 1.0)])
        frames.append(_frame(since, rings, gaps))
    stroke = 0.004 * width
    size = 0.034 * width
    border = f"M0 {heights[0]:.2f}H{width:.2f}"
    still = [_title("from the front", size, heights[0] + 1.5 * size)]
    if "top" in views:
        still += [
            f'<path class="border" d="{border}" stroke-width="{stroke / 2:.3f}"/>',
            _title("from above, in the mirror", size, 1.5 * size),
        ]
    return Scene(
        paths["radii_mm"], round(width, DIGITS), round(sum(heights), DIGITS), stroke, still, frames
    )


def ghost_film(scene: Scene, shot: int, gap_mm: float) -> None:
    """Place the film with its slider, its button and its two switches."""
    count, start = len(scene.frames), scene.plainest
    text = (
        f"Film of shot {shot} with the model's outlines over the measured ones. After contact they "
        f"are up to {gap_mm:.2g} mm apart."
    )
    root = ui.html(
        f'<svg viewBox="0 0 {scene.width:g} {scene.height:g}" role="img" '
        f'aria-label="{escape(text)}"></svg>'
        '<div class="beside"><button class="plain" type="button" data-testid="ghost-play">Play'
        f'</button><input type="range" class="amount" min="0" max="{count - 1}" value="{start}" '
        'step="1" aria-label="frame of the film" data-testid="ghost-frame"></div>'
        '<p class="ghost-text" data-testid="ghost-text"></p>'
        '<div class="beside"><label><input type="checkbox" checked> model</label>'
        '<label><input type="checkbox" checked data-testid="ghost-large"> '
        f"error × {scene.times}</label>"
        '<span class="note ghost-scale"></span></div>',
        sanitize=False,
    ).classes("ghost-film")
    root.props("data-testid=ghost")
    document = json.dumps(scene.document())
    ui.run_javascript(f"window.ghostFilm(getHtmlElement({root.id}), {document})")


def _gaps_at(paths: Json, since_ms: float) -> list[list[float] | None]:
    times: Sequence[float] = paths["times_ms"]
    nearest = min(range(len(times)), key=lambda k: abs(times[k] - since_ms))
    if abs(times[nearest] - since_ms) > SAME_MS:
        return [None, None]
    gaps: list[list[float] | None] = paths["gaps"][nearest]
    return gaps


def _moved(gap: list[float] | None, view: str, scale: float) -> list[float | None]:
    """Return how far a predicted outline lies from the measured one in a view, across and down."""
    if gap is None:
        return [None, None]
    sign, axis = VIEWS[view]
    return [round(scale * gap[1], 4), round(sign * scale * gap[axis], 4)]


def _frame(since_ms: float, rings: list[Any], gaps: Sequence[list[float] | None]) -> Json:
    sizes = [sum(value**2 for value in gap) ** 0.5 for gap in gaps if gap is not None]
    return {
        "time": round(since_ms, 2),
        "rings": rings,
        "gap": round(max(sizes), 4) if sizes else None,
    }


def _title(words: str, size: float, down: float) -> str:
    return f'<text x="{size:.2f}" y="{down:.2f}" font-size="{size:.2f}">{words}</text>'


FILMED = ("Typical", "Largest error", "Smallest error")
"""As `analysis.model.agreement.freed` orders its shots."""
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
            state.source.without_its_folder,
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
            alone = self._paths[0].get("on_plate")
            ui.label(
                f"Solid: where {'the' if alone else 'each'} sphere was measured. Dashed: where the "
                "model, given the flight before contact, predicts it. The loupe magnifies the true "
                "error as this view shows it; the number of mm is that of all directions that were "
                "measured."
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
            own = None if self._wanted in named else self._wanted
            other = ui.number(value=own, format="%d", min=1, step=1)
            other.props('outlined dense placeholder="another" data-testid=film-other')
            other.props('aria-label="film of the shot with this number"')
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
