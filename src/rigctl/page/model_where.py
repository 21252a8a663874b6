"""Step 2: where the model fails, cell by cell, down to the shot."""

from __future__ import annotations

from typing import Any

from nicegui import events, ui

from rigctl.page.desk import Desk
from rigctl.page.model_compare import parsed
from rigctl.page.model_state import ModelState
from rigctl.page.plots import heat_map, residuals
from rigctl.page.widgets import button, plot, save_csv

Json = dict[str, Any]
BLOCKS = {"contact": "Jump at contact", "flight": "Flight", "camera": "Camera"}
HELP = (
    "Standard deviations by which smooth functions of a covariate lower χ² beyond chance. Framed: "
    "less than 1 % chance with all cells looked at. n: along the normal; t: along the incident "
    "surface velocity; b: across both. relative: b less a; common: mean of a and b."
)


def block_of(cell: Json) -> str:
    """Return the part of the way in which a cell's quantity is disturbed."""
    if cell["channel"].startswith("image "):
        return "camera"
    return "flight" if cell["covariate"] == "time" else "contact"


class Where:
    """The heat map beside the residuals of the cell that was clicked."""

    def __init__(self, desk: Desk, state: ModelState, found: Json) -> None:
        self._desk, self._state, self._found = desk, state, found
        self._cells = sorted(found["cells"], key=lambda cell: -cell["deviation"])
        self._cell = self._chosen()
        self._block = block_of(self._cell)
        with ui.element("div").classes("panel").props("data-testid=where-it-fails"):
            with ui.element("div").classes("title"):
                ui.label("2").classes("step")
                ui.label("Where it fails")
                ui.label("click a cell, then a point").classes("aside").tooltip(HELP)
                ui.space()
                self._blocks()
            with ui.element("div").classes("columns where"):
                self._map()
                self._residuals()

    @ui.refreshable_method
    def _blocks(self) -> None:
        for name in BLOCKS:
            if self._of(name):
                here = name == self._block
                choice = button(
                    self._named(name), lambda name=name: self._switch(name), look="line tab"
                )
                choice.props(f"aria-pressed={str(here).lower()}")

    @ui.refreshable_method
    def _map(self) -> None:
        shown = self._cell if block_of(self._cell) == self._block else None
        drawn = plot(heat_map(self._of(self._block), shown, self._found["campaign"]))
        drawn.props("data-testid=heat-map").on("plotly_click", self._on_cell)

    @ui.refreshable_method
    def _residuals(self) -> None:
        points = parsed(self._cell["points"])
        with ui.element("div").classes("stack").props("data-testid=residuals"):
            with ui.element("div").classes("title"):
                ui.label(f"{self._cell['channel']} against {self._cell['covariate']}")
                ui.label(f"{self._cell['deviation']:.1f} σ").classes("aside")
                ui.space()
                save_csv(f"{self._found['campaign']}-residuals", lambda: _rows(points))
            plot(residuals(points, self._found["campaign"])).on("plotly_click", self._on_point)
            drawn = len(points["x"])
            if drawn < points["of"]:
                ui.label(f"{drawn} of {points['of']} points are drawn").classes("note")
            self._told = ui.label("Each point is a shot; click one to see its film.").classes(
                "note"
            )

    def _chosen(self) -> Json:
        wanted = self._state.cell
        same = [c for c in self._cells if (c["channel"], c["covariate"]) == wanted]
        chosen: Json = (same or self._cells)[0]
        return chosen

    def _of(self, block: str) -> list[Json]:
        return [cell for cell in self._cells if block_of(cell) == block]

    def _named(self, block: str) -> str:
        return f"{BLOCKS[block]} {self._of(block)[0]['deviation']:.0f} σ"

    def _switch(self, block: str) -> None:
        self._block = block
        self._pick(self._of(block)[0])

    def _on_cell(self, event: events.GenericEventArguments) -> None:
        point = _point(event)
        names = point.get("customdata")
        for cell in self._cells:
            if names and [cell["channel"], cell["covariate"]] == list(names):
                self._pick(cell)

    def _pick(self, cell: Json) -> None:
        self._cell = cell
        self._state.cell = (cell["channel"], cell["covariate"])
        self._blocks.refresh()
        self._map.refresh()
        self._residuals.refresh()

    def _on_point(self, event: events.GenericEventArguments) -> None:
        names = _point(event).get("customdata")
        if not names:
            return
        number, frame = int(names[0]), int(names[1])
        shot = self._stored(number)
        if shot is None:
            self._told.set_text(
                f"Shot {number}{f', frame {frame}' if frame >= 0 else ''}: this folder holds its "
                "poses; a film is kept of the rig's own shots only."
            )
            return
        place = f"&frame={frame}" if frame >= 0 else ""
        ui.navigate.to(f"/shots/{shot}?effects={','.join(self._found['with'])}{place}")

    def _stored(self, number: int) -> str | None:
        source = self._state.source
        if source.folder is not None:
            return None
        store = self._desk.daemon.store
        limit = store.campaigns.one(source.title).shots
        found = store.shots(campaign=source.title, limit=limit)
        return next((shot.id for shot in found if shot.number == number), None)


def _point(event: events.GenericEventArguments) -> Json:
    points = event.args.get("points") if isinstance(event.args, dict) else None
    return dict(points[0]) if points else {}


def _rows(points: Json) -> list[list[object]]:
    names = ["shots", "frames", "x", "residual", "sigma"]
    heading = ["shot", "frame", points["x_label"], f"residual, {points['unit']}", "sigma"]
    return [heading, *map(list, zip(*(points[name] for name in names), strict=True))]
