"""Step 2: where the model fails, cell by cell, down to the shot."""

from __future__ import annotations

from collections.abc import Sequence

from nicegui import events, ui

from analysis.errors import counted
from analysis.model.structure.findings import ALWAYS
from rigctl.documents import Json
from rigctl.page.desk import Desk
from rigctl.page.model.compare import parsed
from rigctl.page.model.state import ModelState
from rigctl.page.parts.choosing import Choice
from rigctl.page.parts.plots import heat_map, residuals
from rigctl.page.parts.widgets import plot, redraw, save_csv

ALL_DRAWN = 300
"""So few points are drawn each, with their error bars."""
ACROSS, UP = 60, 48
"""Places in a plot, each a little larger than a marker; one point is drawn in each."""
BY_POINT = ("shots", "frames", "x", "residual", "sigma")


def apart(points: Json) -> Json:
    """Return a cell's points without those that a plot would draw upon an earlier one.

    Half of a thousand points lie upon others; a browser takes as long to draw them as all the rest
    of the plot. The running mean keeps what it was made of.
    """
    if len(points["x"]) <= ALL_DRAWN:
        return points
    places = zip(_places(points["x"], ACROSS), _places(points["residual"], UP), strict=True)
    first: dict[tuple[int, int], int] = {}
    for index, place in enumerate(places):
        first.setdefault(place, index)
    return {**points, **{name: [points[name][i] for i in first.values()] for name in BY_POINT}}


def undetermined(points: Json) -> str:
    """Say how many points are not drawn as nothing determines them; empty where none is."""
    count = points.get("undetermined", 0)
    if not count:
        return ""
    return (
        f"{counted(count, 'point')} not drawn: nothing was measured along its direction, such as "
        "that of the sliding where nothing slides."
    )


def _places(values: Sequence[float], count: int) -> list[int]:
    """Return in which of `count` equal places of their range each value lies."""
    low, high = min(values), max(values)
    step = (high - low) / count or 1.0
    return [int((value - low) / step) for value in values]


BLOCKS = {"contact": "Jump at contact", "flight": "Flight", "camera": "Camera"}
HELP = (
    "Column always: the mean of the row, in its standard errors. Other columns: standard "
    "deviations by which smooth functions of a covariate lower χ² beyond chance once that mean is "
    "taken out. Framed: less than 1 % chance with all cells looked at. n: along the normal; t: "
    "along the incident surface velocity; b: across both. relative: b "
    "less a; common: mean of a and b."
)


def named(cell: Json) -> str:
    """Return the name of a finding, its channel against its covariate or its mean, or of a row."""
    if "quantity" in cell:
        return str(cell["quantity"])
    if cell["covariate"] == ALWAYS:
        return f"{cell['channel']}, mean of all shots"
    return f"{cell['channel']} against {cell['covariate']}"


def block_of(cell: Json) -> str:
    """Return the part of the way in which a cell's quantity is disturbed."""
    if cell["channel"].startswith("image "):
        return "camera"
    in_flight = "position" in cell["channel"] or "orientation" in cell["channel"]
    return "flight" if in_flight else "contact"


class Where:
    """The heat map beside the residuals of the cell that was clicked."""

    def __init__(self, desk: Desk, state: ModelState, found: Json) -> None:
        self._desk, self._state = desk, state
        self._take(found)
        with ui.element("div").classes("panel").props("data-testid=where-it-fails"):
            with ui.element("div").classes("title"):
                ui.label("2").classes("step")
                ui.label("Where it fails")
                ui.label("click a cell, then a point").classes("aside").tooltip(HELP)
                ui.space()
                self._blocks()
            with ui.element("div").classes("columns half"):
                self._map = plot(self._heat_map()).props("data-testid=heat-map")
                self._map.on("plotly_click", self._on_cell)
                with ui.element("div").classes("stack").props("data-testid=residuals"):
                    self._heading()
                    self._scatter = plot(self._residuals()).on("plotly_click", self._on_point)
                    self._told = ui.label().classes("note")
        self._tell()

    def show(self, found: Json) -> None:
        """Draw another answer, at the cell that was chosen for it."""
        self._take(found)
        self._blocks.refresh()
        self._redraw()

    def _take(self, found: Json) -> None:
        self._found = found
        self._cells = list(found["findings"])
        self._look_at(self._chosen())

    def _look_at(self, cell: Json) -> None:
        self._cell, self._block = cell, block_of(cell)
        self._points = parsed(cell["points"])
        self._drawn = apart(self._points)

    def _redraw(self) -> None:
        self._heading.refresh()
        redraw(self._map, self._heat_map())
        redraw(self._scatter, self._residuals())
        self._tell()

    @ui.refreshable_method
    def _blocks(self) -> None:
        first = {name: found[0] for name in BLOCKS if (found := self._of(name))}
        words = {name: f"{BLOCKS[name]} {cell['deviation']:.0f} σ" for name, cell in first.items()}
        self._places = Choice("place", words, self._block, lambda name: self._pick(first[name]))

    @ui.refreshable_method
    def _heading(self) -> None:
        points = self._points
        with ui.element("div").classes("title"):
            ui.label(named(self._cell))
            ui.label(f"{self._cell['deviation']:.1f} σ").classes("aside")
            ui.space()
            save_csv(f"{self._found['campaign']}-residuals", lambda: _rows(points))

    def _heat_map(self) -> Json:
        return heat_map(self._of(self._block), self._cell, self._found["campaign"])

    def _residuals(self) -> Json:
        return residuals(self._drawn, self._found["campaign"])

    def _tell(self) -> None:
        drawn, all_points = len(self._drawn["x"]), self._points["of"]
        unsaid = undetermined(self._points)
        few = f"{drawn} of {all_points} points are drawn, none upon another. "
        by_shot = all(frame < 0 for frame in self._points["frames"])
        each = "Each point is a shot" if by_shot else "Each point is a frame of a shot"
        self._told.set_text(
            f"{few if drawn < all_points else ''}{each}; click one to see the shot's film. {unsaid}"
        )

    def _chosen(self) -> Json:
        wanted = self._state.cell
        same = [c for c in self._cells if (c["channel"], c["covariate"]) == wanted]
        chosen: Json = (same or self._cells)[0]
        return chosen

    def _of(self, block: str) -> list[Json]:
        return [cell for cell in self._cells if block_of(cell) == block]

    def _on_cell(self, event: events.GenericEventArguments) -> None:
        point = _point(event)
        names = point.get("customdata")
        for cell in self._cells:
            if names and [cell["channel"], cell["covariate"]] == list(names):
                self._pick(cell)

    def _pick(self, cell: Json) -> None:
        self._state.cell = (cell["channel"], cell["covariate"])
        self._look_at(cell)
        self._places.press(self._block)
        self._redraw()

    def _on_point(self, event: events.GenericEventArguments) -> None:
        names = _point(event).get("customdata")
        if not names:
            return
        number, frame = int(names[0]), int(names[1])
        stored = self._state.source.stored(number)
        shot = None if stored is None else stored.id
        if shot is None:
            self._told.set_text(
                f"Shot {number}{f', frame {frame}' if frame >= 0 else ''}: this folder holds its "
                "poses; a film is kept of the rig's own shots only."
            )
            return
        place = f"&frame={frame}" if frame >= 0 else ""
        ui.navigate.to(f"/shots/{shot}?effects={','.join(self._found['with'])}{place}")


def _point(event: events.GenericEventArguments) -> Json:
    points = event.args.get("points") if isinstance(event.args, dict) else None
    return dict(points[0]) if points else {}


def _rows(points: Json) -> list[list[object]]:
    names = ["shots", "frames", "x", "residual", "sigma"]
    heading = ["shot", "frame", points["x_label"], f"residual, {points['unit']}", "sigma"]
    return [heading, *map(list, zip(*(points[name] for name in names), strict=True))]
